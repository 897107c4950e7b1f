// @ts-check
/** What every shape can do. */

/** A surface, in units of its own. */
export class Shape {
  /** @param {import("../core/core.js").Core} core @param {number} handle */
  constructor(core, handle) {
    this.core = core;
    this.handle = handle;
  }

  /** Scenes that have it keep it. */
  free() {
    this.core.call("free_shape", this.handle);
  }
}
