/**
 * What the loaders of three.js take from it: all as it is, but coordinates stay in float64. Rounded to float32 far from
 * the origin, meshes would turn to steps.
 */

import { BufferAttribute } from "./package/build/three.core.js";

export * from "./package/build/three.core.js";

export class Float32BufferAttribute extends BufferAttribute {
  /** @param {ArrayLike<number>} values @param {number} itemSize @param {boolean} [normalized] */
  constructor(values, itemSize, normalized) {
    super(Float64Array.from(values), itemSize, normalized);
  }
}
