// @ts-check
/** The interface of all shapes. */

/** A surface in any units. */
export class Shape {
  /** @param {import("../core/core.js").Core} core @param {number} handle */
  constructor(core, handle) {
    this.core = core;
    this.handle = handle;
  }

  /** Whether construction reached its work budget: rays are as exact, but slow. */
  get isCoarse() {
    return this.core.call("is_coarse", this.handle) !== 0;
  }

  /** Scenes that use it keep it alive. */
  free() {
    this.core.call("free_shape", this.handle);
  }
}
