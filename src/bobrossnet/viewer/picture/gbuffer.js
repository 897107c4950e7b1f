// @ts-check
/** What is known of a picture, in the core's memory. */
import { GBUFFER, WIDTH, placeOf } from "./channels.js";

/** @typedef {import("../core/core.js").Core} Core */

/** What was traced, and the picture completed from it. Its arrays are views of the core's memory. */
export class GBuffer {
  /** How many pixels are known, of those that were added. */
  traced = 0;

  /** @param {Core} core @param {number} height @param {number} width */
  constructor(core, height, width) {
    this.core = core;
    this.height = height;
    this.width = width;
    this.address = core.allocate((WIDTH + 1) * 4 * height * width);
    this.clear();
  }

  /** (C, height, width), in the order of GBUFFER */
  get planes() {
    return new Float32Array(this.core.memory, this.address, WIDTH * this.height * this.width);
  }

  /** (height, width) of a channel's first component. @param {string} channel */
  plane(channel) {
    const size = this.height * this.width;
    return new Float32Array(this.core.memory, this.address + 4 * placeOf(GBUFFER, channel) * size, size);
  }

  /** (height, width), 0..1, once a network has completed it */
  get image() {
    return new Float32Array(this.core.memory, this.imageAddress, this.height * this.width);
  }

  get imageAddress() {
    return this.address + 4 * WIDTH * this.height * this.width;
  }

  /** Forgets all pixels. */
  clear() {
    this.planes.fill(0);
    this.traced = 0;
  }

  /** Takes what was traced. @param {Int32Array} pixels (n, 2) @param {Float32Array} samples (n, C), as Scene.trace returns them */
  add(pixels, samples) {
    const count = pixels.length / 2;
    const [added] = this.core.filled(new Int32Array(1), (address) => {
      this.core.made("add_samples", pixels, samples, count, this.address, this.height, this.width, address);
    });
    this.traced += added;
  }

  free() {
    this.core.release(this.address);
  }
}
