// @ts-check
/** Statistics of the displayed pictures. */

const ALMOST = 0.999; // of a picture that is not exact yet

export class Statistics {
  /** Number so far. */
  pictures = 0;
  /** Fraction of traced pixels. */
  fraction = 0;
  /** Fraction of the resting picture's pixels that were traced since the last change; 1 only if it is exact. */
  progress = 0;
  /** Milliseconds of the network, on `backend`; 0 without one: exact pictures and lit ones need none. */
  completing = 0;
  /** The network's name. @type {import("../picture/planner.js").Model} */
  model = "default";
  /** @type {"wasm" | "gpu"} */
  backend = "wasm";
  raysPerSecond = 0;
  /** Whether the picture is exact, with the current camera and size. */
  exact = false;
  /** Whether no other picture follows until something changes: it is exact, and its edges are smoothed if that is wanted. */
  final = false;
  /** Whether all its edges are smoothed. */
  isSmoothed = false;
  /** The size of a picture that is displayed enlarged, such as "475x400"; else null. @type {string | null} */
  enlarged = null;
  /** Mean error of the first completed picture, once the picture is exact; else NaN. */
  error = NaN;
  /** Predicted mean error of the picture, if displayed; else NaN. */
  expected = NaN;
  /** Display times of the last second's pictures, in milliseconds. @type {number[]} */
  #times = [];

  /** @param {number} workers number of tracing workers */
  constructor(workers) {
    this.workers = workers;
  }

  /**
   * Adds a picture that is displayed now.
   *
   * @param {import("../workers/completing.js").Picture} picture
   * @param {import("../workers/schedule.js").Schedule} schedule the schedule it was reported to
   * @param {{exact: boolean, final: boolean}} state whether it is exact, with the current camera and size, and whether
   *   it is the last one
   */
  count({ batch, traced, isSmoothed, completing, model, backend, error }, { raysPerSecond, size }, { exact, final }) {
    ++this.pictures;
    this.fraction = traced / (batch.height * batch.width);
    this.#times = [...this.#lastSecond(), performance.now()];
    this.progress = exact ? 1 : Math.max(this.progress, Math.min(traced / (size.width * size.height), ALMOST));
    this.enlarged = batch.width < size.width || batch.height < size.height ? `${batch.width}x${batch.height}` : null;
    Object.assign(this, { completing, model, backend, error, exact, final, isSmoothed, raysPerSecond });
  }

  /** Forgets the picture: something has changed. */
  change() {
    this.exact = this.final = false;
    this.progress = 0;
  }

  get framesPerSecond() {
    this.#times = this.#lastSecond();
    return this.#times.length;
  }

  #lastSecond() {
    const now = performance.now();
    return this.#times.filter((time) => time > now - 1000);
  }
}
