// @ts-check
/** The G-buffer of a picture, in the core's memory. */
import { COLORED, GBUFFER, placeOf, widthOf } from "./channels.js";

/**
 * @typedef {{begin: number, end: number, planes: Float32Array}} Strip rows, (C, end - begin, width) of the displayed layout
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("./channels.js").Layout} Layout
 */

/** The traced pixels, and the picture completed from them. Its arrays are views of the core's memory. */
export class GBuffer {
  /** Number of traced pixels. */
  traced = 0;

  /** @param {Core} core @param {number} height @param {number} width @param {Layout} [layout] GBUFFER or COLORED */
  constructor(core, height, width, layout = GBUFFER) {
    this.core = core;
    this.height = height;
    this.width = width;
    this.layout = layout;
    const completed = this.isColored ? 4 : 1;
    this.address = core.allocate((widthOf(layout) + completed) * 4 * height * width);
    this.clear();
  }

  get isColored() {
    return this.layout === COLORED;
  }

  /** (C, height, width), in the order of GBUFFER, which begins every layout */
  get planes() {
    return this.#floats(0, widthOf(GBUFFER));
  }

  /** The planes `first` to `first + count - 1`. @param {number} first @param {number} count */
  #floats(first, count) {
    const size = this.height * this.width;
    return new Float32Array(this.core.memory, this.address + 4 * first * size, count * size);
  }

  /** (height, width) of a channel's first component. @param {string} channel */
  plane(channel) {
    return this.#floats(placeOf(this.layout, channel), 1);
  }

  /** (height, width), 0..1, once completed by a network */
  get image() {
    return this.#floats(widthOf(this.layout), 1);
  }

  get imageAddress() {
    return this.image.byteOffset;
  }

  /** Completes linear RGB, (3, height, width), along the completed image; null for white scenes. */
  completeColor() {
    if (!this.isColored) return null;
    const place = widthOf(this.layout) + 1, address = this.#floats(place, 3).byteOffset;
    this.core.made("complete_color", this.address, this.imageAddress, this.height, this.width, address);
    return this.#floats(place, 3); // the call may have moved the memory
  }

  /** Traced linear RGB, (3, height, width); null without colours. */
  get color() {
    return this.isColored ? this.#floats(placeOf(this.layout, "color"), 3) : null;
  }

  /** Copies another G-buffer of this size, with coverage in place of gray: 1 for a hit. @param {GBuffer} other */
  takeCoverage(other) {
    this.planes.set(other.planes);
    this.traced = other.traced;
    const gray = this.plane("gray"), depth = this.plane("depth");
    for (let i = 0; i < gray.length; ++i) gray[i] = Number(depth[i] > 0);
  }

  /** Clears all pixels. */
  clear() {
    this.#floats(0, widthOf(this.layout)).fill(0);
    this.traced = 0;
  }

  /** Replaces all pixels. @param {Float32Array} planes (C, height, width) */
  set(planes) {
    this.#floats(0, widthOf(this.layout)).set(planes);
    let traced = 0;
    for (let i = 0; i < this.height * this.width; ++i) traced += planes[i]; // the mask
    this.traced = traced;
  }

  /** Copies the traced pixels of another G-buffer of this size and layout, all of them. @param {GBuffer} other */
  copy(other) {
    this.#floats(0, widthOf(this.layout)).set(other.#floats(0, widthOf(this.layout)));
    this.traced = other.traced;
  }

  /** Adds rows that were not traced before. @param {Strip} strip */
  setRows({ begin, end, planes }) {
    const size = (end - begin) * this.width;
    for (let c = 0; c < widthOf(this.layout); ++c) {
      this.#floats(c, 1).set(planes.subarray(c * size, (c + 1) * size), begin * this.width);
    }
    this.traced += size;
  }

  /** Adds traced pixels. @param {Int32Array} pixels (n, 2) @param {Float32Array} samples (n, C), from Scene.trace */
  add(pixels, samples) {
    const count = pixels.length / 2;
    const [added] = this.core.filled(new Int32Array(1), (address) => {
      this.core.made("add_samples", Number(this.isColored), 1, pixels, samples, count, this.address, this.height, this.width, address);
    });
    this.traced += added;
  }

  free() {
    this.core.release(this.address);
  }
}
