// @ts-check
/** OFF: vertices and polygons, as text. */

import { CoreError, brief } from "../core/errors.js";
import { Growing } from "./part.js";
import { textOf, wordsOfLines } from "./text.js";

/** @param {ArrayBuffer} bytes @returns {import("./part.js").Part[]} */
export function readOff(bytes) {
  const text = textOf(bytes), lines = wordsOfLines(text, "#");
  const [word = "", ...rest] = lines.next().value ?? [];
  if (!/^C?OFF$/.test(word)) {
    throw new CoreError(`expected an OFF, which starts with 'OFF', got ${brief(text.slice(0, 8))}`);
  }
  const next = (/** @type {string} */ what) => {
    const { value, done } = lines.next();
    if (done) throw new CoreError(`expected ${what}, but the file ends before them`);
    return value.map(Number);
  };
  const [count, faces] = rest.length ? rest.map(Number) : next("counts of vertices and faces");
  if (!(count >= 0 && faces >= 0 && 2 * (3 * count + faces) <= text.length + 1)) {
    throw new CoreError(`expected counts of vertices and faces that the file can hold, got ${count} and ${faces}`);
  }
  const vertices = new Float64Array(3 * count), triangles = new Growing(Int32Array, 3 * faces);
  for (let i = 0; i < count; ++i) vertices.set([...next(`${count} vertices`), NaN, NaN, NaN].slice(0, 3), 3 * i);
  for (let i = 0; i < faces; ++i) {
    const [size, ...corners] = next(`${faces} faces`);
    if (!(corners.length >= size)) {
      throw new CoreError(`face ${i + 1}: expected ${size} corners, got ${corners.length}`);
    }
    for (let corner = 2; corner < size; ++corner) {
      for (const index of [corners[0], corners[corner - 1], corners[corner]]) triangles.push(index);
    }
  }
  return [{ vertices, triangles: triangles.whole() }];
}
