// @ts-check
/**
 * The schedule of pictures. While the camera moves, each new view gets one picture, within the budget. At rest, all
 * pixels are traced and lines drawn, then edges are smoothed, in few large steps: steps cost time. If all pixels take long, the picture
 * is refined before.
 *
 * Under lights, the tracers complete pictures themselves. At rest, all pixels get light paths, and the picture is
 * completed again after each step.
 *
 * Batch n + 1 is traced while batch n is completed, so that the slower of the two determines the frame rate. The leading
 * tracer chooses the size of moving pictures (docs/frame.md).
 *
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/camera.js").Size} Size
 * @typedef {import("./tracer.js").Phase} Phase
 */
import { WHOLE } from "../tracing/cutaway.js";

const REST_MS = 40; // without a change, before a view is refined: sooner, further movement would often have to cancel it
const STEPS_MS = [250, 1000]; // tracing between two pictures at rest: the first, and the longest
const SHARE_REFINED = 0.1; // of the time for all pixels, for refining before
const LONG_MS = 800; // for all pixels: only then a picture is refined before
const SHARE = 0.8; // share of a picture's time for tracing: with more, the page and messages make all pictures late
const LIT_TIMES = 2; // times the budget, of a moving picture under lights
const LIT_STEPS = { longest: 8000, share: 4 }; // milliseconds of a step at rest under lights; times completing, at least
const MOST_REFINED = 2 ** 21; // pixels of pictures that are completed: beyond, only traced pixels need memory

/** Numbers of the newest batch and view of the page, whose elements share workers: these drop older ones. */
const newest = { batch: 0, view: 0 };

export class Schedule {
  /** Milliseconds between two pictures while the camera moves. */
  budget = 33;
  /** Whether resting views are refined. */
  refines = true;
  /** Whether other elements wait: then no batch of a moving view is begun before `next`, since their turn may come. */
  isShared = false;
  /** Side of the grid of rays in pixels at edges of a resting view; 1 leaves edges as they are. */
  side = 2;
  /** The lights that replace the headlight. @type {"studio" | "own" | null} */
  lights = null;
  /** Thickness of lines at visible edges, in pixels of the picture at rest; 0 for no lines. */
  thickness = 0;
  /** Rays per second, as last traced by all workers. */
  raysPerSecond = 0;

  /** @type {import("./pool.js").Pool | undefined} */
  #pool;
  /** Completing times since the last batch. @type {import("./tracer.js").Completed[]} */
  #completed = [];
  /** @type {Camera} */
  #camera;
  #cutaway = WHOLE;
  /** @type {Size} at rest */
  #size = { height: 480, width: 640 };
  #scales;
  /** Azimuth of the camera that the lights are set up for: the first one of a scene. @type {number | null} */
  #azimuth = null;
  /** Of the view; null until time has decided. @type {number | null} */
  #scale = 1;
  #stale = true; // whether the view has another camera, size or scene than requested
  #changedAt = -Infinity;

  #before = 0; // newest view of the page when the workers got the scene
  #previous = 0; // newest batch of the page when the scene came
  #view = 0;
  #left = 0; // pixels left in the phase
  /** @type {Phase} of the view */
  #phase = "some";
  #step = 0; // milliseconds of the last step at rest; 0 while the camera moves
  #spent = 0; // milliseconds for refining
  #completing = 0; // milliseconds to complete the last picture under lights
  /** Rays of the rows of the scene's last picture at rest: those of one batch can be few. */
  #rows = { rays: 0, milliseconds: 0 };

  #tracing = false;
  /** Numbers of batches traced but not completed. @type {number[]} */
  #waiting = [];
  #shown = 0; // newest batch completed, which may be reported before it is traced
  #timer = 0;

  /** @param {Camera} camera @param {boolean} scales whether moving pictures may be smaller than resting ones */
  constructor(camera, scales) {
    this.#camera = camera;
    this.#scales = scales;
  }

  get camera() {
    return this.#camera;
  }

  /** Size of the picture at rest. */
  get size() {
    return this.#size;
  }

  /** Shows a scene. @param {import("./pool.js").Pool} pool has the scene */
  show(pool) {
    const isOther = pool !== this.#pool;
    if (isOther) this.#tracing = false, this.#before = newest.view;
    this.#pool = pool;
    this.#rows = { rays: 0, milliseconds: 0 };
    this.#waiting = [];
    this.#previous = newest.batch;
    this.change({});
    if (isOther) this.#changedAt = -Infinity; // nothing moves
  }

  /** Pauses until workers have the scene again. */
  stop() {
    clearTimeout(this.#timer);
    this.#stale = !this.isDone;
    this.#pool = undefined;
    this.#tracing = false;
    this.#waiting = [];
  }

  /** Whether there is nothing to trace or complete. */
  get isDone() {
    return !this.#stale && !this.#tracing && this.#waiting.length === 0 && (this.#isFinal || !this.refines);
  }

  /** Whether the camera, the size or the scene has just changed. */
  get isMoving() {
    return performance.now() < this.#changedAt + REST_MS;
  }

  /** Whether a batch is of the current workers and scene. @param {import("./tracer.js").Batch} batch */
  owns(batch) {
    return batch.view > this.#before;
  }

  /** @param {{camera?: Partial<Camera>, size?: Size, cutaway?: import("../tracing/cutaway.js").Cutaway}} what */
  change({ camera, size = this.#size, cutaway = this.#cutaway }) {
    this.#cutaway = cutaway;
    this.#camera = { ...this.#camera, ...camera };
    this.#size = size;
    this.#stale = true;
    this.#changedAt = performance.now();
    // A batch of a moving view is short and continues: otherwise a movement would show nothing.
    if (this.#tracing && this.#step > 0) this.#pool?.cancel();
    this.next();
  }

  /** @param {import("./pool.js").Traced} traced */
  traced({ batch, cancelled, left, rays, milliseconds }) {
    this.#tracing = false;
    if (!cancelled) {
      if (batch.id > this.#shown) this.#waiting.push(batch.id);
      this.#scale = batch.scale;
      this.#left = left;
      this.raysPerSecond = 1000 * rays / milliseconds;
      if (batch.phase === "rows") {
        this.#rows.rays += rays;
        this.#rows.milliseconds += milliseconds;
      }
    } else if (this.#step > 0) {
      this.isLit ? this.#begin(this.#litScale, "light") : this.#begin(1, "rows"); // its tracer may have ended, with its pixels
    }
    this.next();
  }

  /**
   * @param {import("./completing.js").Picture} picture
   * @returns {{exact: boolean, final: boolean}} whether it is the exact picture requested, and whether no other follows
   */
  completed({ batch, traced, total, model, isSmoothed, isLined }) {
    const pixels = batch.height * batch.width;
    this.#completing = total;
    if (batch.phase === "some" && traced < pixels) this.#completed.push({ model, pixels, milliseconds: total });
    this.#shown = batch.id;
    this.#waiting = this.#waiting.filter((id) => id > batch.id);
    if (!this.isShared) this.next();
    const isWhole = batch.phase === "light" ? isSmoothed : traced === this.#size.height * this.#size.width;
    const exact = !this.#stale && batch.view === this.#view && isWhole;
    return { exact, final: exact && (isLined || this.thickness === 0) && (isSmoothed || this.side === 1) };
  }

  /** Sets the lights up for the current camera: the scene or they are new. */
  relight() {
    this.#azimuth = null;
  }

  /** Whether a picture is of the current scene. @param {import("./completing.js").Picture} picture */
  isCurrent({ batch }) {
    return batch.id > this.#previous;
  }

  /** Starts the next batch, if it is time. */
  next() {
    clearTimeout(this.#timer);
    const ready = this.#pool?.threads ?? 0;
    if (ready === 0 || this.#tracing || this.#waiting.length > (this.isShared && this.#step === 0 ? 0 : 1)) return;
    if (this.#stale) {
      this.#stale = false;
      this.#begin(this.#scales ? null : 1, this.isLit ? "light" : "some");
      this.#step = this.#spent = 0;
      this.#trace((this.isLit ? LIT_TIMES : SHARE) * this.budget, ready);
    } else if (this.refines && !this.#isFinal) {
      const left = this.#changedAt + REST_MS - performance.now();
      if (left > 0) {
        this.#timer = setTimeout(() => this.next(), left);
      } else {
        this.#trace(this.#nextStep(), ready);
      }
    }
  }

  get isLit() {
    return this.lights !== null;
  }

  /** Whether nothing is left to trace of a view. */
  get #isFinal() {
    if (this.isLit) return this.#left === 0 && this.#step > 0;
    return this.#isWhole && (this.#phase === "edges" || this.side === 1);
  }

  /** Whether all pixels are traced; lines are exact only if that was row by row. */
  get #isWhole() {
    return this.#left === 0 && this.#scale === 1 && (this.thickness === 0 || this.#phase !== "some");
  }

  /** Begins the next step at rest. @returns {number} milliseconds */
  #nextStep() {
    const { height, width } = this.#size, [first, longest] = STEPS_MS;
    if (this.isLit) {
      if (this.#scale !== this.#litScale) this.#begin(this.#litScale, "light");
      return this.#step = Math.min(Math.max(2 * this.#step, LIT_STEPS.share * this.#completing, first), this.isShared ? longest : LIT_STEPS.longest);
    }
    const { rays, milliseconds } = this.#rows, rayMs = rays > 0 ? milliseconds / rays : 1000 / this.raysPerSecond, all = rayMs * height * width;
    const refining = all > LONG_MS ? SHARE_REFINED * all - this.#spent : 0;
    if (this.#phase === "some" && refining > this.budget && this.#left > 0) {
      const scale = Math.max(1, Math.sqrt(height * width / MOST_REFINED));
      if (this.#scale !== scale) this.#begin(scale, "some");
      this.#spent += this.#step = Math.min(2 * (this.#step || this.budget), refining, longest);
      return this.#step;
    }
    if (this.#isWhole) {
      this.#phase = "edges";
    } else if (this.#phase === "some") {
      if (this.#scale !== 1) this.#begin(1, "rows");
      this.#phase = "rows";
      this.#rows = { rays: 0, milliseconds: 0 };
      this.#step = 0;
    }
    this.#step = Math.min(Math.max(2 * this.#step, first), longest);
    return this.#step;
  }

  /** Scale of pictures at rest under lights: larger ones would need too much memory. */
  get #litScale() {
    const { height, width } = this.#size;
    return Math.max(1, Math.sqrt(height * width / MOST_REFINED));
  }

  /** A new view. @param {number | null} scale @param {Phase} phase */
  #begin(scale, phase) {
    this.#view = ++newest.view;
    this.#scale = scale;
    this.#phase = phase;
    this.#left = Infinity;
  }

  /** @param {number} milliseconds for tracing @param {number} parts threads */
  #trace(milliseconds, parts) {
    this.#tracing = true;
    const completed = this.#completed.splice(0);
    const lights = this.isLit ? { isOwn: this.lights === "own", azimuth: this.#azimuth ??= this.#camera.azimuth } : null;
    this.#pool?.trace({
      id: ++newest.batch, view: this.#view, phase: this.#phase, parts, camera: this.#camera, ...this.#size, scale: this.#scale, side: this.side, milliseconds,
      completed, lights, rests: this.#step > 0, cutaway: this.#cutaway, thickness: this.thickness,
    });
  }
}
