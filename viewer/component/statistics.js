// @ts-check
/** Statistics of the displayed pictures. */

export class Statistics {
  /** Number so far. */
  pictures = 0;
  /** Fraction of traced pixels. */
  fraction = 0;
  /** Milliseconds of the network, on `backend`. */
  completing = 0;
  /** The network's name. @type {import("../picture/planner.js").Model} */
  model = "default";
  /** @type {"wasm" | "gpu"} */
  backend = "wasm";
  raysPerSecond = 0;
  /** Whether the picture is exact, with the current camera and size. */
  exact = false;
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
   * @param {boolean} exact whether it is exact, with the current camera and size
   */
  count({ batch, traced, completing, model, backend, error }, { raysPerSecond }, exact) {
    ++this.pictures;
    this.fraction = traced / (batch.height * batch.width);
    this.#times = [...this.#lastSecond(), performance.now()];
    Object.assign(this, { completing, model, backend, error, exact, raysPerSecond });
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
