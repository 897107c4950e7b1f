// @ts-check
/** Reprojection: samples of a tracer's earlier pictures reused for the next one, as in core/reprojection/history.h. */
import { cameraValues } from "./camera.js";
import { COLORED, tracedLayout, widthOf } from "./channels.js";
import { addSamples, halves } from "./order.js";

/**
 * Reprojected samples of a picture, and the order of rays that refreshes the most doubtful ones.
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
  /** Address of the distances of samples from their pixels' centres, (height, width). */
  #offCenter;
  #isColored;

  /**
   * @param {import("../core/core.js").Core} core @param {import("./camera.js").Size} size
   *   @param {import("./channels.js").Layout} layout displayed
   */
  constructor(core, { height, width }, layout) {
    const pixels = height * width;
    this.#core = core;
    this.#layout = layout;
    this.size = { height, width };
    this.#isColored = Number(layout === COLORED);
    this.#handle = core.made("make_history", this.#isColored, height, width);
    this.#order = core.made("make_refresh_order", height, width);
    /** Address of the reprojected samples, overwritten by traced ones, (C, height, width) of the traced layout. */
    this.planes = core.allocate(4 * widthOf(tracedLayout(layout)) * pixels);
    this.#offCenter = core.allocate(4 * pixels);
  }

  /**
   * Begins a camera's picture with reprojected samples, shaded again.
   *
   * @param {number} scene its handle in the core
   * @param {Camera} before of the last picture @param {number} traced the address of its planes
   * @param {Camera} camera
   * @param {number} seed
   * @returns {number} number of pixels with a reprojected surface; 0 after a jump
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
   * A copy of the reprojected samples, overwritten by traced ones.
   *
   * @param {Float32Array} [spare] for the result, since allocation takes longer than copying
   * @returns {Float32Array} (C, height, width) of the displayed channels
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
