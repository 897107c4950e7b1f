// @ts-check
/** Pixel orders: the sequence in which the pixels of a picture are traced. */
import { COLORED, GBUFFER, widthOf } from "./channels.js";

/** @typedef {{height: number, width: number, seed?: number | bigint}} Which */

/** A seed in halves, as the core takes it. @param {number | bigint} seed @returns {[number, number]} low and high */
function halves(seed) {
  const bits = BigInt.asUintN(64, BigInt(seed));
  return [Number(bits & 0xffffffffn), Number(bits >> 32n)];
}

/**
 * Pixels in an order that does not depend on what they show.
 *
 * @param {import("../core/core.js").Core} core
 * @param {string} order its name, as in bobrossnet.pixel_order, but for "default"
 * @param {Which & {start?: number, count?: number}} which
 * @returns {Int32Array} (count, 2), row and column
 */
export function pixelOrder(core, order, { height, width, seed = 0, start = 0, count = height * width - start }) {
  return core.filled(new Int32Array(2 * count), (address) => {
    core.made("pixel_order", order, ...halves(seed), height, width, start, address, count);
  });
}

/**
 * The pixels of a picture in the order "adaptive", piece by piece as they are traced. It goes round by round: what all pixels
 * of the rounds before show decides which are the next.
 */
export class PixelSequence {
  #core;
  #order;
  /** Of planes (C, height, width), in which pixels that were not traced have any values. */
  #planes;
  #size;
  #round = new Int32Array(0);
  /** How many pixels of the round are handed out. */
  #taken = 0;
  /** Of how many pixels it is known what they show. */
  #known = 0;
  #isColored;
  /** How many pixels are handed out. */
  done = 0;

  /** @param {import("../core/core.js").Core} core @param {Which} which @param {import("./channels.js").Layout} [layout] of samples */
  constructor(core, { height, width, seed = 0 }, layout = GBUFFER) {
    this.#core = core;
    this.#isColored = Number(layout === COLORED);
    this.#size = { height, width };
    this.#order = core.made("make_adaptive_order", ...halves(seed), height, width);
    this.#planes = core.allocate(4 * widthOf(layout) * height * width);
  }

  /** How many pixels can be handed out now: none where what comes next depends on some that were not added yet. */
  available() {
    const { height, width } = this.#size;
    if (2 * this.#taken === this.#round.length && this.#known === this.done && this.done < height * width) {
      let address = 0;
      const [count] = this.#core.filled(new Int32Array(1), (written) => {
        address = this.#core.made("next_round", this.#order, this.#isColored, this.#planes, written) >>> 0;
      });
      this.#round = new Int32Array(this.#core.memory, address, 2 * count).slice();
      this.#taken = 0;
    }
    return this.#round.length / 2 - this.#taken;
  }

  /** The next pixels. @param {number} count at most as many as are available @returns {Int32Array} (count, 2) */
  next(count) {
    const first = this.#taken;
    this.#taken += count, this.done += count;
    return this.#round.slice(2 * first, 2 * this.#taken);
  }

  /** Takes what pixels show that were handed out, once each. @param {Int32Array} pixels (n, 2) @param {Float32Array} samples (n, C) */
  add(pixels, samples) {
    const { height, width } = this.#size, count = pixels.length / 2;
    this.#core.filled(new Int32Array(1), (added) => {
      this.#core.made("add_samples", this.#isColored, pixels, samples, count, this.#planes, height, width, added);
    });
    this.#known += count;
  }

  free() {
    this.#core.call("free_adaptive_order", this.#order);
    this.#core.release(this.#planes);
  }
}
