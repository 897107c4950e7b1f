// @ts-check
/**
 * Parts: what readers of mesh files make, as the file stores it.
 *
 * @typedef {{vertices: Float64Array, triangles: Int32Array, normals?: Float64Array, colors?: Float64Array,
 *   faceColors?: Float64Array, alphas?: Float64Array, uv?: Float64Array, surface?: import("./surface.js").Surface}} Part
 *   (V, 3), (T, 3), (V, 3): indices unchecked, numbers perhaps not finite; a missing normal is NaN. colors (V, 3) and
 *   faceColors (T, 3) are linear RGB, they and alphas (V,) 1 where they are not finite; uv (V, 2) from the texture's top left on
 * @typedef {(text: string) => void} Warn told what of a file was left out
 */

/** Numbers that are added one after the other, in memory that grows. @template {Int32Array | Float64Array} T */
export class Growing {
  length = 0;

  /** @param {{new (length: number): T}} type @param {number} [capacity] */
  constructor(type, capacity = 1024) {
    this.type = type;
    this.values = new type(capacity);
  }

  /** Makes room for more; `values` may be another array afterwards. @param {number} count */
  reserve(count) {
    if (this.length + count <= this.values.length) return;
    const larger = new this.type(Math.max(2 * this.values.length, this.length + count));
    larger.set(this.values);
    this.values = larger;
  }

  /** @param {number} value */
  push(value) {
    if (this.length === this.values.length) this.reserve(1);
    this.values[this.length++] = value;
  }

  /** @returns {T} */
  whole() {
    return /** @type {T} */ (this.length === this.values.length ? this.values : this.values.slice(0, this.length));
  }
}
