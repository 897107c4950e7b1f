// @ts-check
/** Samples outlive their frame: what a tracer's earlier pictures say about the next one, as core/picture/history.h has it. */
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
  #scene;
  #core;
  #handle;
  #order;
  /** Addresses: what is expected, and over it what was traced, (C, height, width) of the traced layout; and how far from its pixel's
   * centre it was seen, (height, width). */
  #picture;
  #offCenter;
  #isColored;

  /** Of pictures of a size. @param {import("../tracing/scene.js").Scene} scene @param {import("./camera.js").Size} size */
  constructor(scene, { height, width }) {
    const core = this.#core = scene.core, pixels = height * width;
    this.#scene = scene;
    this.size = { height, width };
    this.#isColored = Number(scene.layout === COLORED);
    this.#handle = core.made("make_history", this.#isColored, height, width);
    this.#order = core.made("make_refresh_order", height, width);
    this.#picture = core.allocate(4 * widthOf(tracedLayout(scene.layout)) * pixels);
    this.#offCenter = core.allocate(4 * pixels);
  }

  /**
   * Begins the picture of a camera.
   *
   * @param {Camera} before which traced the one before @param {number} traced the address of that one's planes
   * @param {Camera} camera
   * @param {number} seed
   * @returns {boolean} whether anything is expected: nothing after a jump
   */
  move(before, traced, camera, seed) {
    const core = this.#core;
    core.made("add_to_history", this.#handle, cameraValues(before), traced);
    const [surfaces] = core.filled(new Int32Array(1), (address) => {
      core.made("expect_from_history", this.#handle, cameraValues(camera), this.#picture, this.#offCenter, address);
    });
    if (surfaces === 0) return false;
    this.#scene.shade(this.#picture, this.size, camera);
    core.call("begin_refresh", this.#order, ...halves(seed));
    return true;
  }

  /** @type {RoundOrder["next"]} */
  next(planes, wanted, count) {
    return this.#core.made("next_refresh", this.#order, this.#isColored, planes, this.#picture, this.#offCenter, wanted, count);
  }

  /** @type {RoundOrder["add"]} */
  add(pixels, samples) {
    addSamples(this.#core, this.size, this.#isColored, pixels, samples, this.#picture);
  }

  end() {}

  /**
   * A copy of what is expected, with what was traced over it.
   *
   * @param {Float32Array} [spare] that it may be written to, since new memory takes longer than copying
   * @returns {Float32Array} (C, height, width) of what is shown
   */
  picture(spare) {
    const count = widthOf(this.#scene.layout) * this.size.height * this.size.width;
    const copy = spare?.length === count ? spare : new Float32Array(count);
    copy.set(new Float32Array(this.#core.memory, this.#picture, count));
    return copy;
  }

  free() {
    this.#core.call("free_history", this.#handle);
    this.#core.call("free_refresh_order", this.#order);
    this.#core.release(this.#picture);
    this.#core.release(this.#offCenter);
  }
}
