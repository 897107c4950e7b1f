// @ts-check
/** What is measured of pictures. */

export class Statistics {
  /** So far. */
  pictures = 0;
  /** Share of the pixels that are traced. */
  fraction = 0;
  /** Milliseconds of the network, on `backend`. */
  completing = 0;
  /** The network's name. @type {import("../picture/planner.js").Model} */
  model = "default";
  /** @type {"wasm" | "gpu"} */
  backend = "wasm";
  raysPerSecond = 0;
  /** Whether the picture is the exact one of what is wanted. */
  exact = false;
  /** Of the first completed picture, on average, once the picture is exact; else NaN. */
  error = NaN;
  /** The error that is expected of the picture, on average, where that is shown; else NaN. */
  expected = NaN;
  /** When pictures of the last second were shown, in milliseconds. @type {number[]} */
  #times = [];

  /** @param {number} workers that trace */
  constructor(workers) {
    this.workers = workers;
  }

  /**
   * Takes in a picture that is shown now.
   *
   * @param {import("../workers/completing.js").Picture} picture
   * @param {import("../workers/schedule.js").Schedule} schedule that was told of it
   * @param {boolean} exact whether it is the exact one of what is wanted
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
