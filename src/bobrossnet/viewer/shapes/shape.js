// @ts-check
/** What every shape can do. */
import { fromUnitSphere, product, singularValues, toUnitSphere } from "./affine.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("./affine.js").Matrix} Matrix
 */

/** A surface. The core knows it in coordinates of its own, in which it is about 1 in size. */
export class Shape {
  /**
   * @param {Core} core @param {number} handle
   * @param {number[]} center @param {number} size of the core's unit sphere
   */
  constructor(core, handle, center, size) {
    this.core = core;
    this.handle = handle;
    this.center = center;
    this.size = size;
  }

  /** From the shape's own units to the core's coordinates. */
  get toCore() {
    return toUnitSphere(this.center, this.size);
  }

  /** @param {Matrix} matrix @returns {number[]} from the core's coordinates to where a matrix places the shape */
  #fromCore(matrix) {
    return product(matrix, fromUnitSphere(this.center, this.size));
  }

  /**
   * The lowest and highest coordinates, placed by a matrix.
   *
   * @param {Matrix} matrix @returns {{low: number[], high: number[]}}
   */
  bounds(matrix) {
    const map = Float64Array.from(this.#fromCore(matrix).slice(0, 12));
    const box = Array.from(this.core.filled(new Float64Array(6), (address) => {
      this.core.made("placed_bounds", this.handle, map, address);
    }));
    return { low: box.slice(0, 3), high: box.slice(3) };
  }

  /**
   * The distance from a point to the farthest one of the shape placed by a matrix.
   *
   * @param {number[]} about @param {Matrix} matrix
   */
  radius(about, matrix) {
    const whole = this.#fromCore(matrix), [largest] = singularValues(whole), map = Float64Array.from(whole.slice(0, 12));
    return this.core.made("placed_radius", this.handle, map, Float64Array.from(about), largest);
  }

  /** Scenes that have it keep it. */
  free() {
    this.core.call("free_shape", this.handle);
  }
}
