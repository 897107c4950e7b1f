// @ts-check
/**
 * The schedule of pictures. While the camera moves, each new view gets one picture, within the budget; while it rests,
 * the view is refined until every pixel is exact.
 *
 * Batch n + 1 is traced while batch n is completed, so that the slower of the two determines the frame rate. If
 * completing alone takes longer than the budget, moving pictures are smaller.
 *
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/camera.js").Size} Size
 */

const REST_MS = 80; // without a change, before a view is refined: sooner, further movement would often have to cancel it
const LONGEST_MS = 250; // tracing between two pictures at rest
const SHARE = 0.8; // share of a picture's time for tracing: with more, the page and messages make all pictures late
const SCALES = [1, 1.25, 1.5, 2, 2.5, 3, 4]; // divisors of the size of moving pictures
const SMALLER = 0.8; // a picture grows only below this share of the budget: else two sizes would alternate

export class Schedule {
  /** Milliseconds between two pictures while the camera moves. */
  budget = 33;
  /** Whether resting views are refined. */
  refines = true;
  /** Rays per second, as last traced by all workers. */
  raysPerSecond = 0;

  /** @type {import("./pool.js").Pool | undefined} */
  #pool;
  /** Whether a picture of the scene was traced. */
  #isKnown = false;
  /** Minimum milliseconds to complete a pixel; 0 before the first measurement. */
  #pixelMs = 0;
  /** Completing times since the last batch. @type {import("./tracer.js").Completed[]} */
  #completed = [];
  /** @type {Camera} */
  #camera;
  /** @type {Size} at rest */
  #size = { height: 480, width: 640 };
  #scales;
  #scale = 1; // of moving pictures
  #stale = true; // whether the view has another camera, size or scene than requested
  #changedAt = -Infinity;

  #view = 0;
  /** @type {Size} of the view */
  #viewSize = this.#size;
  #reached = 0; // traced pixels of the view's sequence
  #step = 0; // milliseconds of the last refinement; 0 while the camera moves

  #batch = 0;
  #before = 0; // the last batch of the previous scene
  #tracing = false;
  /** Numbers of batches traced but not completed. @type {number[]} */
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

  /** Shows a scene. @param {import("./pool.js").Pool} pool has the scene */
  show(pool) {
    if (pool !== this.#pool) this.#tracing = false;
    this.#pool = pool;
    this.#isKnown = false;
    this.#waiting = [];
    this.#before = this.#batch;
    this.change({});
  }

  /** @param {{camera?: Partial<Camera>, size?: Size}} what */
  change({ camera, size = this.#size }) {
    this.#camera = { ...this.#camera, ...camera };
    this.#size = size;
    this.#stale = true;
    this.#changedAt = performance.now();
    // A batch of a moving view is short and continues: otherwise a movement would show nothing.
    if (this.#tracing && this.#step > 0) this.#pool?.cancel();
    this.next();
  }

  /** @param {import("./pool.js").Traced} traced */
  traced({ batch, cancelled, reached, rays, milliseconds, completing }) {
    this.#tracing = false;
    if (!cancelled) {
      this.#isKnown = true;
      this.#pixelMs = completing / (batch.height * batch.width);
      this.#waiting.push(batch.id);
      this.#reached = reached;
      this.raysPerSecond = 1000 * rays / milliseconds;
    }
    this.next();
  }

  /** @param {import("./completing.js").Picture} picture @returns {boolean} whether it is the exact picture requested */
  completed({ batch, traced, total, model }) {
    const pixels = batch.height * batch.width;
    if (traced < pixels) this.#completed.push({ model, pixels, milliseconds: total });
    this.#waiting = this.#waiting.filter((id) => id > batch.id);
    this.next();
    return !this.#stale && batch.view === this.#view && traced === this.#size.height * this.#size.width;
  }

  /** Whether a picture is of the current scene. @param {import("./completing.js").Picture} picture */
  isCurrent({ batch }) {
    return batch.id > this.#before;
  }

  /** Starts the next batch, if it is time. */
  next() {
    clearTimeout(this.#timer);
    const ready = this.#pool?.threads ?? 0;
    if (ready === 0 || this.#tracing || this.#waiting.length > 1) return;
    if (this.#stale) {
      this.#stale = false;
      this.#scale = this.#scales ? this.#movingScale() : 1;
      this.#begin(this.#scale);
      this.#step = 0;
      // One core completes the previous picture meanwhile, except during a scene's first.
      this.#trace(SHARE * this.budget, Math.max(1, this.#isKnown ? ready - 1 : ready));
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

  /** The minimum scale for completing within the budget; a picture grows only if that is certain. */
  #movingScale() {
    const { height, width } = this.#size;
    return SCALES.find((scale) => {
      const completing = this.#pixelMs * height * width / scale ** 2;
      return completing < (scale < this.#scale ? SMALLER : 1) * this.budget;
    }) ?? SCALES[SCALES.length - 1];
  }

  /** A new view. @param {number} scale */
  #begin(scale) {
    const { height, width } = this.#size;
    ++this.#view;
    this.#viewSize = { height: Math.round(height / scale), width: Math.round(width / scale) };
    this.#reached = 0;
  }

  /** @param {number} milliseconds for tracing @param {number} parts threads */
  #trace(milliseconds, parts) {
    this.#tracing = true;
    const completed = this.#completed.splice(0);
    this.#pool?.trace({ id: ++this.#batch, view: this.#view, parts, camera: this.#camera, ...this.#viewSize, milliseconds, completed });
  }
}
