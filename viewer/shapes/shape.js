// @ts-check
/** What every shape can do. */

/** A surface, in units of its own. */
export class Shape {
  /** @param {import("../core/core.js").Core} core @param {number} handle */
  constructor(core, handle) {
    this.core = core;
    this.handle = handle;
  }

  /** Whether building it reached its budget of work: rays are as exact, but take long. */
  get isCoarse() {
    return this.core.call("is_coarse", this.handle) !== 0;
  }

  /** Scenes that have it keep it. */
  free() {
    this.core.call("free_shape", this.handle);
  }
}
