// @ts-check
/** How many rays fit into a time, from what rays took: a mean that fades, since cameras and machines change. */

const FADE = 0.7; // weight of all that was measured before, against the last measurement

export class Pace {
  #rays = 0;
  #milliseconds = 0;

  /** @param {number} rays @param {number} milliseconds that they took one thread */
  measured(rays, milliseconds) {
    this.#rays = FADE * this.#rays + rays;
    this.#milliseconds = FADE * this.#milliseconds + Math.max(milliseconds, 1e-3);
  }

  /** Takes all rays so far for faster. @param {number} share of their time */
  fade(share) {
    this.#milliseconds *= share;
  }

  get known() {
    return this.#rays > 0;
  }

  /** Rays a millisecond in one thread; NaN while nothing is known. */
  get rate() {
    return this.#rays / this.#milliseconds;
  }
}
