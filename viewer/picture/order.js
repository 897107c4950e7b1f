// @ts-check
/** Pixel orders: sequences of a picture's pixels for tracing. */
import { COLORED, GBUFFER, tracedLayout, widthOf } from "./channels.js";

/** @typedef {{height: number, width: number, seed?: number | bigint}} Which */

/** A seed in halves, as the core expects it. @param {number | bigint} seed @returns {[number, number]} low and high */
export function halves(seed) {
  const bits = BigInt.asUintN(64, BigInt(seed));
  return [Number(bits & 0xffffffffn), Number(bits >> 32n)];
}

/**
 * Chooses the pixels of a picture round by round, from the samples of all earlier rounds.
 *
 * @typedef {object} RoundOrder
 * @property {(planes: number, wanted: number, count: number) => number} next returns the address of the next round's
 *   pixels and writes their number to `count`; wanted: number of pixels there is time for; planes: address of the
 *   traced planes, (C, height, width) of the traced layout
 * @property {(pixels: Int32Array, samples: Float32Array) => void} add adds samples
 * @property {() => void} end ends the picture
 *
 * @implements {RoundOrder}
 */
class OrderOfCore {
  #core;
  #handle;
  #isColored;

  /**
   * @param {import("../core/core.js").Core} core @param {number} handle @param {import("./channels.js").Layout} layout
   *   displayed
   */
  constructor(core, handle, layout) {
    this.#core = core;
    this.#isColored = Number(layout === COLORED);
    this.#handle = handle;
  }

  /** @type {RoundOrder["next"]} */
  next(planes, _, count) {
    return this.#core.made("next_round", this.#handle, this.#isColored, planes, count);
  }

  add() {}

  end() {
    this.#core.call("free_round_order", this.#handle);
  }
}

/** Adaptive refinement, as in core/sampling/adaptive.h. */
export class AdaptiveOrder extends OrderOfCore {
  /**
   * @param {import("../core/core.js").Core} core @param {Which} which @param {import("./channels.js").Layout} [layout]
   *   displayed
   */
  constructor(core, { height, width, seed = 0 }, layout = GBUFFER) {
    super(core, core.made("make_adaptive_order", ...halves(seed), height, width), layout);
  }
}

/** Division of squares by contrast, row by row, for fast rays, as in core/sampling/squares.h. */
export class SquaresOrder extends OrderOfCore {
  /**
   * @param {import("../core/core.js").Core} core @param {Which} which @param {import("./channels.js").Layout} [layout]
   *   displayed
   */
  constructor(core, { height, width }, layout = GBUFFER) {
    super(core, core.made("make_squares_order", height, width), layout);
  }
}

/** The pixels of a picture in some order, in pieces as they are traced. */
export class PixelSequence {
  #core;
  #order;
  #size;
  #isColored;
  #round = new Int32Array(0);
  /** Number of pixels of the round already returned. */
  #taken = 0;
  /** Number of pixels with known samples. */
  #known = 0;
  /** Number of pixels already returned. */
  done = 0;
  /** Number of rounds begun. */
  rounds = 0;

  /**
   * @param {import("../core/core.js").Core} core
   * @param {import("./camera.js").Size} size
   * @param {import("./channels.js").Layout} [layout] displayed
   * @param {RoundOrder} [order]
   */
  constructor(core, { height, width }, layout = GBUFFER, order = new AdaptiveOrder(core, { height, width }, layout)) {
    this.#core = core;
    this.#order = order;
    this.#size = { height, width };
    this.#isColored = Number(layout === COLORED);
    /** Address of the traced planes, (C, height, width) of the traced layout; where the mask is 0, the rest is undefined. */
    this.planes = core.allocate(4 * widthOf(tracedLayout(layout)) * height * width);
    new Float32Array(core.memory, this.planes, height * width).fill(0);
  }

  /**
   * Number of pixels available now: 0 if the next ones depend on samples not added yet.
   *
   * @param {number} [wanted] number of pixels there is time for
   */
  available(wanted = Infinity) {
    const { height, width } = this.#size, left = height * width - this.done;
    if (2 * this.#taken === this.#round.length && this.#known === this.done && left > 0) {
      let address = 0;
      const [count] = this.#core.filled(new Int32Array(1), (written) => {
        address = this.#order.next(this.planes, Math.min(left, Math.max(1, wanted)), written) >>> 0;
      });
      this.#round = new Int32Array(this.#core.memory, address, 2 * count).slice();
      this.#taken = 0;
      ++this.rounds;
    }
    return this.#round.length / 2 - this.#taken;
  }

  /** The next pixels. @param {number} count at most `available` @returns {Int32Array} (count, 2) */
  next(count) {
    const first = this.#taken;
    this.#taken += count, this.done += count;
    return this.#round.slice(2 * first, 2 * this.#taken);
  }

  /** Adds the samples of returned pixels, once each. @param {Int32Array} pixels (n, 2) @param {Float32Array} samples (n, C) */
  add(pixels, samples) {
    addSamples(this.#core, this.#size, this.#isColored, pixels, samples, this.planes);
    this.#order.add(pixels, samples);
    this.#known += pixels.length / 2;
  }

  /** Reports that all pixels are in `planes`. */
  finish() {
    const { height, width } = this.#size;
    this.done = this.#known = height * width;
    this.#taken = this.#round.length / 2;
  }

  free() {
    this.#order.end();
    this.#core.release(this.planes);
  }
}

/** All pixels of a picture, in the order of the lattice, as in core/sampling/whole.h. */
export class WholeOrder extends OrderOfCore {
  /**
   * @param {import("../core/core.js").Core} core @param {Which} which @param {import("./channels.js").Layout} [layout]
   *   displayed
   */
  constructor(core, { height, width }, layout = GBUFFER) {
    super(core, core.made("make_whole_order", height, width), layout);
  }
}

/**
 * Scatters samples to planes, (C, height, width) of the traced layout.
 *
 * @param {import("../core/core.js").Core} core @param {import("./camera.js").Size} size @param {number} isColored 0 or 1
 * @param {Int32Array} pixels (n, 2) @param {Float32Array} samples (n, C) @param {number} planes their address
 */
export function addSamples(core, { height, width }, isColored, pixels, samples, planes) {
  core.filled(new Int32Array(1), (added) => {
    core.made("add_samples", isColored, 0, pixels, samples, pixels.length / 2, planes, height, width, added);
  });
}
