// @ts-check
/**
 * Which pixels are traced next: while the camera moves, as many of a new view as the budget has time for; while it rests, more
 * of the same view, until every pixel is exact.
 *
 * Batch n + 1 is traced while batch n is completed, so that the slower of the two sets the pace. Where completing alone would take
 * longer than the budget, moving pictures are smaller.
 *
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/camera.js").Size} Size
 */
import { Pace } from "./pace.js";
import { plan } from "./plan.js";

const REST_MS = 80; // without a change, until a view is refined: less, and moving on would often have to end that first
const LONGEST_MS = 250; // of tracing between two pictures at rest
const SHARE = 0.8; // of a picture's time that is for tracing: with more, the page itself and messages make all pictures late
const LEAST = 32; // pixels for each tracer
const AMPLE = 4; // times the pixels of squares that are expected
/**
 * Of a moving view's time, for what those before have seen: more where the one before had it too, since pictures that have it and such that
 * have not flicker. What was too slow is tried again, soon at first, when all code is slow; so is the order of squares.
 */
const LONGEST_CARRYING = { begins: 0.6, goesOn: 0.75 }, FADE = { first: 0.8, later: 0.97, squares: 0.99 }, FIRST = 3;
const RISE = 1.15; // by which one slow view lets the next be taken for slower
/** A new picture of a smaller share of its pixels would be so blurred that one that comes late is better. */
const SPARSE = 0.01, LONGER_IF_SPARSE = 5 / 3;
/** Beside what is carried along: so much of the time is for rays, which may trace so many of the pixels, since few rays seem slower than they are. */
const LEAST_TRACING = 0.25, LEAST_NEW = 0.002;
const MARGIN = 1.5; // times its planned time, after which a batch ends that takes longer than was measured
const SCALES = [1, 1.25, 1.5, 2, 2.5, 3, 4]; // by which moving pictures are smaller
const UNMEASURED_MS = 1e-4; // to complete a pixel, before that is measured

/**
 * What completes pictures: how long the others take beside the default network, before that is measured.
 *
 * @typedef {"default" | "small" | "filling"} Model
 * @type {Record<Model, number>}
 */
const MODELS = { default: 1, small: 0.5, filling: 0.3 };

export class Schedule {
  /** Milliseconds between two pictures while the camera moves. */
  budget = 33;
  /** Whether resting views are refined. */
  refines = true;
  /** Rays a second, as last traced by all workers. */
  raysPerSecond = 0;

  /** @type {import("./pool.js").Pool | undefined} */
  #pool;
  #pace = new Pace();
  #carries = false; // whether the view brings along what those before have seen
  #carryingMs = 0; // for a pixel of it, before the first ray
  #carried = 0; // how many views did so
  #wentOn = false; // whether the view before did as well
  #squares = false; // whether the view is traced in their order
  #squaresViews = 0; // so far
  #squaresPace = new Pace();
  /** Of a view's first round. */
  #firstPace = new Pace();
  /** Milliseconds to complete a pixel, where measured. @type {Partial<Record<Model, number>>} */
  #pixelMs = {};
  /** What completed the last picture. @type {Model} */
  #model = "default";
  /** @type {Camera} */
  #camera;
  /** @type {Size} at rest */
  #size = { height: 480, width: 640 };
  #scales;
  #scale = 1; // of moving pictures
  #stale = true; // whether the view is of another camera, size or scene than is wanted
  #changedAt = -Infinity;

  #view = 0;
  /** @type {Size} of the view */
  #viewSize = this.#size;
  #reached = 0; // pixels of its sequence that the view has
  #step = 0; // milliseconds of the last refinement; 0 while the camera moves

  #batch = 0;
  #tracing = false;
  /** Numbers of batches that are traced but not completed. @type {number[]} */
  #waiting = [];
  #timer = 0;

  /** @param {Camera} camera @param {boolean} scales whether moving pictures may be smaller than resting ones */
  constructor(camera, scales) {
    this.#camera = camera;
    this.#scales = scales;
  }

  get camera() {
    return this.#camera;
  }

  /** Shows a scene. @param {import("./pool.js").Pool} pool that has it */
  show(pool) {
    if (pool !== this.#pool) this.#tracing = false;
    this.#pool = pool;
    this.#pace = new Pace();
    this.#squaresPace = new Pace();
    this.#firstPace = new Pace();
    this.#waiting = [];
    this.change({});
  }

  /** @param {{camera?: Partial<Camera>, size?: Size}} what */
  change({ camera, size = this.#size }) {
    this.#camera = { ...this.#camera, ...camera };
    this.#size = size;
    this.#stale = true;
    this.#changedAt = performance.now();
    // A batch of a moving view is short, and goes on: else nothing would be seen of a movement.
    if (this.#tracing && this.#step > 0) this.#pool?.cancel();
    this.next();
  }

  /** @param {import("./pool.js").Traced} traced */
  traced({ batch, cancelled, reached, rays, preparing, milliseconds, first }) {
    this.#tracing = false;
    if (batch.carries && this.#step === 0) {
      this.#carryingMs = Math.min(preparing / (batch.height * batch.width), this.#wentOn ? RISE * this.#carryingMs : Infinity);
      ++this.#carried;
    }
    if (first.rays > 0) this.#firstPace.measured(first.rays, batch.parts * first.milliseconds);
    // At rest, the last pixels of squares are the fastest.
    if (!batch.squares) this.#pace.measured(rays, batch.parts * milliseconds);
    else if (this.#step === 0) this.#squaresPace.measured(rays, batch.parts * milliseconds);
    if (!cancelled) {
      this.#waiting.push(batch.id);
      this.#reached = reached;
      this.raysPerSecond = 1000 * rays / milliseconds;
    }
    this.next();
  }

  /** @param {import("./completing.js").Picture} picture @returns {boolean} whether it is the exact one of what is wanted */
  completed({ batch, traced, total, model }) {
    this.#pixelMs[model] = total / (batch.height * batch.width);
    this.#model = model;
    this.#waiting = this.#waiting.filter((id) => id > batch.id);
    this.next();
    return !this.#stale && batch.view === this.#view && traced === this.#size.height * this.#size.width;
  }

  /** Starts what is to be traced next, if it is time. */
  next() {
    clearTimeout(this.#timer);
    const ready = this.#pool?.threads ?? 0;
    if (ready === 0 || this.#tracing || this.#waiting.length > 1) return;
    if (this.#stale) {
      this.#stale = false;
      this.#scale = this.#scales ? this.#movingScale() : 1;
      this.#begin(this.#scale);
      this.#step = 0;
      this.#traceMoving(ready);
    } else if (this.refines && (this.#reached < this.#viewSize.height * this.#viewSize.width || this.#scale > 1)) {
      const left = this.#changedAt + REST_MS - performance.now();
      if (left > 0) {
        this.#timer = setTimeout(() => this.next(), left);
      } else {
        if (this.#scale > 1) this.#begin(this.#scale = 1);
        this.#step = Math.min(2 * (this.#step || this.budget), LONGEST_MS);
        this.#trace(this.#step, ready);
      }
    }
  }

  /** Milliseconds that completing takes. @param {Model} model @param {Size} size */
  #completing(model, { height, width }) {
    const measured = Object.entries(this.#pixelMs).map(([other, ms]) => ms / MODELS[/** @type {Model} */ (other)]);
    return (this.#pixelMs[model] ?? Math.max(UNMEASURED_MS, ...measured) * MODELS[model]) * height * width;
  }

  /** What completes the view while little of it is known. */
  #sparse() {
    // Where rays are fast, what the others take longer is worth more in rays.
    return this.#squares ? "filling" : this.#completing("default", this.#viewSize) < this.budget ? "default" : "small";
  }

  /** Milliseconds between two moving pictures in which one thread can trace. */
  #movingTime() {
    const completing = this.#completing(this.#model, this.#viewSize);
    if (!this.#pace.known) return this.budget; // of a scene's first picture: soon
    // One core completes meanwhile; where there is only one, both share it.
    if (navigator.hardwareConcurrency === 1) return Math.max(this.budget - completing, completing / 4);
    return Math.max(this.budget, completing);
  }

  /** The least scale at which completing takes no longer than the budget; a picture grows only where that is sure. */
  #movingScale() {
    const { height, width } = this.#size;
    return SCALES.find((scale) => {
      const completing = this.#completing("small", { height: height / scale, width: width / scale });
      return completing < (scale < this.#scale ? 0.8 : 1) * this.budget;
    }) ?? SCALES[SCALES.length - 1];
  }

  /** A new view. @param {number} scale */
  #begin(scale) {
    const { height, width } = this.#size;
    ++this.#view;
    this.#viewSize = { height: Math.round(height / scale), width: Math.round(width / scale) };
    this.#reached = 0;
  }

  /** The first batch of a view. @param {number} ready how many threads can trace */
  #traceMoving(ready) {
    // One core completes the picture before meanwhile, but for a scene's first.
    const parts = Math.max(1, this.#pace.known ? ready - 1 : ready), pixels = this.#viewSize.height * this.#viewSize.width;
    const time = SHARE * this.#movingTime(), carrying = this.#carryingMs * pixels;
    const rates = { squares: this.#squaresPace.rate, others: this.#pace.rate, first: this.#firstPace.rate };
    const { isFast, share, showsMore } = plan(pixels, rates, time, parts, carrying, this.#carries);
    const takesTooLong = carrying > LONGEST_CARRYING[this.#carries ? "goesOn" : "begins"] * (share < SPARSE ? LONGER_IF_SPARSE : 1) * time;
    if (takesTooLong) this.#carryingMs *= FADE[this.#carried < FIRST ? "first" : "later"];
    this.#wentOn = this.#carries && this.#carried > 0;
    this.#carries = this.#pace.known && showsMore && !takesTooLong;
    this.#squares = !this.#carries && isFast;
    if (this.#squares) ++this.#squaresViews;
    else {
      this.#squaresPace.fade(FADE[this.#squaresViews < FIRST ? "first" : "squares"]);
      this.#firstPace.fade(FADE.squares);
    }
    if (this.#carries) {
      const tracing = Math.max(time - carrying, LEAST_TRACING * time);
      this.#trace(tracing, parts, Math.round(Math.max(this.#pace.rate * tracing * parts, LEAST_NEW * pixels)));
    } else this.#trace(time, parts);
  }

  /** @param {number} time milliseconds for tracing @param {number} parts @param {number} [count] of pixels, as far as that is known */
  #trace(time, parts, count = Math.round(this.#pace.rate * time * parts)) {
    const total = this.#viewSize.height * this.#viewSize.width, isTimed = this.#squares || !this.#pace.known;
    // Where time alone ends it, memory is for more than will fit.
    if (this.#squares) count = Math.ceil(AMPLE * (this.#squaresPace.known ? this.#squaresPace : this.#firstPace).rate * time * parts);
    this.#tracing = true;
    this.#pool?.trace({
      id: ++this.#batch, view: this.#view, parts, camera: this.#camera, ...this.#viewSize, carries: this.#carries,
      squares: this.#squares, sparse: this.#sparse(),
      to: this.#pace.known ? Math.min(total, this.#reached + Math.max(LEAST * parts, count)) : total,
      milliseconds: isTimed ? time : MARGIN * time,
    });
  }
}
