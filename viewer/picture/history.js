// @ts-check
/** Samples outlive their frame: what a tracer's earlier pictures say about the next one, as core/reprojection/history.h has it. */
import { cameraValues } from "./camera.js";
import { COLORED, tracedLayout, widthOf } from "./channels.js";
import { addSamples, halves } from "./order.js";

/**
 * What is expected of a picture, and the order in which rays go where that may be wrong.
 *
 * @typedef {import("./order.js").RoundOrder} RoundOrder
 * @typedef {import("./camera.js").Camera} Camera
 * @implements {RoundOrder}
 */
export class History {
  #core;
  #layout;
  #handle;
  #order;
  /** The address of how far from its pixel's centre each was seen, (height, width). */
  #offCenter;
  #isColored;

  /** @param {import("../core/core.js").Core} core @param {import("./camera.js").Size} size @param {import("./channels.js").Layout} layout that is shown */
  constructor(core, { height, width }, layout) {
    const pixels = height * width;
    this.#core = core;
    this.#layout = layout;
    this.size = { height, width };
    this.#isColored = Number(layout === COLORED);
    this.#handle = core.made("make_history", this.#isColored, height, width);
    this.#order = core.made("make_refresh_order", height, width);
    /** The address of what is expected, and over it what was traced, (C, height, width) of the traced layout. */
    this.planes = core.allocate(4 * widthOf(tracedLayout(layout)) * pixels);
    this.#offCenter = core.allocate(4 * pixels);
  }

  /**
   * Begins the picture of a camera, with what is expected, shaded anew.
   *
   * @param {number} scene its handle in the core
   * @param {Camera} before which traced the one before @param {number} traced the address of that one's planes
   * @param {Camera} camera
   * @param {number} seed
   * @returns {number} at how many pixels a surface is expected: none after a jump
   */
  move(scene, before, traced, camera, seed) {
    const core = this.#core;
    core.made("add_to_history", this.#handle, cameraValues(before), traced);
    const [surfaces] = core.filled(new Int32Array(1), (address) => {
      core.made("expect_from_history", this.#handle, scene, cameraValues(camera), this.planes, this.#offCenter, address);
    });
    core.call("begin_refresh", this.#order, ...halves(seed));
    return surfaces;
  }

  /** @type {RoundOrder["next"]} */
  next(planes, wanted, count) {
    return this.#core.made("next_refresh", this.#order, this.#isColored, planes, this.planes, this.#offCenter, wanted, count);
  }

  /** @type {RoundOrder["add"]} */
  add(pixels, samples) {
    addSamples(this.#core, this.size, this.#isColored, pixels, samples, this.planes);
  }

  end() {}

  /**
   * A copy of what is expected, with what was traced over it.
   *
   * @param {Float32Array} [spare] that it may be written to, since new memory takes longer than copying
   * @returns {Float32Array} (C, height, width) of what is shown
   */
  picture(spare) {
    const count = widthOf(this.#layout) * this.size.height * this.size.width;
    const copy = spare?.length === count ? spare : new Float32Array(count);
    copy.set(new Float32Array(this.#core.memory, this.planes, count));
    return copy;
  }

  free() {
    this.#core.call("free_history", this.#handle);
    this.#core.call("free_refresh_order", this.#order);
    this.#core.release(this.planes);
    this.#core.release(this.#offCenter);
  }
}
