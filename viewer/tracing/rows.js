// @ts-check
/** The rows of a picture, all traced, from top to bottom, and its pixels at edges. */
import { widthOf } from "../picture/channels.js";

const BEFORE = 2; // rows kept: whether the last row has edges depends on the next one

/** Only the rows traced last are in the core's memory, however large the picture. */
export class Rows {
  /** Number of rows traced. */
  done = 0;
  /** Pixels at edges, (n, 2), in pieces. @type {Int32Array[]} */
  edges = [];
  #scene;
  #size;
  #components;
  /** The last rows, (C, BEFORE, width). @type {Float32Array} */
  #last;

  /** @param {import("./scene.js").Scene} scene @param {import("../picture/camera.js").Size} size */
  constructor(scene, size) {
    this.#scene = scene;
    this.#size = size;
    this.#components = scene.sampleWidth;
    this.#last = new Float32Array(this.#components * BEFORE * size.width);
  }

  /**
   * Adds the next rows.
   *
   * @param {number} end the row after them
   * @param {import("../picture/camera.js").Camera} camera
   * @param {Float32Array} [traced] (C, rows, width) of the traced layout, if another tracer has traced them
   * @param {number} [whole] address of the picture's planes, (C, height, width) of the traced layout, which get the rows, too
   * @returns {Float32Array} (C, rows, width) of the displayed layout
   */
  add(end, camera, traced, whole) {
    const { core, layout } = this.#scene, { height, width } = this.#size, begin = this.done, components = this.#components;
    const top = Math.max(0, begin - BEFORE), rows = end - top, size = rows * width, before = (begin - top) * width;
    const address = core.allocate(4 * components * size), planes = () => new Float32Array(core.memory, address, components * size);
    try {
      for (let c = 0, all = planes(), kept = BEFORE * width; c < components; ++c) {
        all.set(this.#last.subarray((c + 1) * kept - before, (c + 1) * kept), c * size);
        if (traced) all.set(traced.subarray(c * (size - before), (c + 1) * (size - before)), c * size + before);
      }
      if (!traced) this.#scene.traceRows(begin, end, this.#size, camera, { address, top, rows });
      const firstSure = Math.max(0, begin - 1), lastSure = end === height ? end : end - 1;
      this.edges.push(this.#scene.edges(firstSure, lastSure, width, { address, top, rows }));
      const shown = new Float32Array(widthOf(layout) * (size - before));
      for (let c = 0, all = planes(), kept = BEFORE * width; c < components; ++c) {
        const plane = all.subarray(c * size, (c + 1) * size), last = plane.subarray(Math.max(0, size - kept));
        this.#last.set(last, (c + 1) * kept - last.length);
        const added = plane.subarray(before);
        if (c < widthOf(layout)) shown.set(added, c * added.length);
        if (whole) new Float32Array(core.memory, whole + 4 * width * (c * height + begin), added.length).set(added);
      }
      this.done = end;
      return shown;
    } finally {
      core.release(address);
    }
  }
}
