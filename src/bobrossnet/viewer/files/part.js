// @ts-check
/**
 * Parts: what readers of mesh files make, as the file stores it, and the one mesh that becomes of them.
 *
 * @typedef {{vertices: Float64Array, triangles: Int32Array, normals?: Float64Array}} Part
 *   (V, 3), (T, 3), (V, 3): indices unchecked, numbers perhaps not finite; a missing normal is NaN
 */

import { CoreError } from "../core/errors.js";
import { sceneOf } from "../tracing/description.js";

/** @typedef {import("../tracing/description.js").SceneDescription} SceneDescription */

/** Beyond this, squares and products of coordinates leave float64. */
const MAX_COORDINATE = 1e100;

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

/**
 * All parts as one mesh: triangles that touch a missing or non-finite vertex are left out, and vertices that no
 * triangle uses.
 *
 * @param {string} name of the file
 * @param {Part[]} parts
 * @returns {SceneDescription}
 */
export function meshScene(name, parts) {
  const { vertices, triangles, normals } = joined(parts), total = triangles.length / 3;
  if (total === 0) {
    const got = vertices.length ? `a point cloud of ${vertices.length / 3} points` : "none";
    throw new CoreError(`expected triangles, got ${got}`);
  }
  const shown = usable(vertices, triangles), left = shown.length / 3;
  if (left === 0) throw new CoreError(`expected triangles, got ${total} that all touch a missing or non-finite vertex`);
  const mesh = compact(vertices, shown, normals);
  if (!anyArea(mesh.vertices, mesh.triangles)) {
    throw new CoreError(`expected triangles with an area, got ${left} of zero area`);
  }
  const scene = sceneOf({ kind: "mesh", ...mesh }, name);
  if (left === total) return scene;
  const warning = `${name}: left out ${total - left} of ${total} triangles that touch a missing or non-finite vertex`;
  return { ...scene, warnings: [warning] };
}

/** @param {Part[]} parts @returns {Part} an index that misses its own part's vertices becomes -1 */
function joined(parts) {
  const count = (/** @type {"vertices" | "triangles"} */ of) => parts.reduce((sum, part) => sum + part[of].length, 0);
  if (!parts.length) return { vertices: new Float64Array(), triangles: new Int32Array() };
  const whole = parts.length === 1 ? parts[0] : {
    vertices: new Float64Array(count("vertices")), triangles: new Int32Array(count("triangles")),
    normals: parts.some((part) => part.normals) ? new Float64Array(count("vertices")).fill(NaN) : undefined,
  };
  let vertex = 0, corner = 0;
  for (const part of parts) {
    const start = vertex / 3, size = part.vertices.length / 3, { triangles } = part;
    if (whole !== part) {
      whole.vertices.set(part.vertices, vertex);
      if (part.normals) whole.normals?.set(part.normals, vertex);
    }
    for (let i = 0; i < triangles.length; ++i) {
      const index = triangles[i];
      whole.triangles[corner++] = index >= 0 && index < size ? index + start : -1;
    }
    vertex += part.vertices.length;
  }
  return whole;
}

/**
 * Triangles all of whose vertices are there and finite.
 *
 * @param {Float64Array} vertices
 * @param {Int32Array} triangles
 * @returns {Int32Array}
 */
function usable(vertices, triangles) {
  const fine = new Uint8Array(vertices.length / 3 + 1);
  for (let i = 0, at = 0; at < vertices.length; ++i, at += 3) {
    const largest = Math.max(Math.abs(vertices[at]), Math.abs(vertices[at + 1]), Math.abs(vertices[at + 2]));
    fine[i] = Number(largest <= MAX_COORDINATE);  // NaN is not
  }
  let kept = 0;
  for (let i = 0; i < triangles.length; i += 3) {
    const a = triangles[i], b = triangles[i + 1], c = triangles[i + 2];
    if (a < 0 || b < 0 || c < 0 || !(fine[a] & fine[b] & fine[c])) continue;
    if (kept < i) triangles[kept] = a, triangles[kept + 1] = b, triangles[kept + 2] = c;
    kept += 3;
  }
  return kept === triangles.length ? triangles : triangles.slice(0, kept);
}

/**
 * A mesh without the vertices that no triangle uses.
 *
 * @param {Float64Array} vertices @param {Int32Array} triangles @param {Float64Array | undefined} normals
 * @returns {{vertices: Float64Array, triangles: Int32Array, normals?: Float32Array}}
 */
function compact(vertices, triangles, normals) {
  const places = new Int32Array(vertices.length / 3);
  for (let i = 0; i < triangles.length; ++i) places[triangles[i]] = 1;
  let count = 0;
  for (let i = 0; i < places.length; ++i) places[i] = places[i] ? count++ : -1;
  if (count < places.length) {
    for (let i = 0; i < triangles.length; ++i) triangles[i] = places[triangles[i]];
    vertices = picked(vertices, places, count);
    normals = normals && picked(normals, places, count);
  }
  const directions = normals && units(normals);
  return directions ? { vertices, triangles, normals: directions } : { vertices, triangles };
}

/** @param {Float64Array} rows (n, 3) @param {Int32Array} places where each goes, or -1 @param {number} count */
function picked(rows, places, count) {
  const result = new Float64Array(3 * count);
  for (let i = 0; i < places.length; ++i) {
    if (places[i] < 0) continue;
    for (let axis = 0; axis < 3; ++axis) result[3 * places[i] + axis] = rows[3 * i + axis];
  }
  return result;
}

/**
 * Normals at length 1, zero where one is unusable; nothing if all are.
 *
 * @param {Float64Array} normals
 * @returns {Float32Array | undefined}
 */
function units(normals) {
  const result = new Float32Array(normals.length);
  let any = false;
  for (let i = 0; i < normals.length; i += 3) {
    const x = normals[i], y = normals[i + 1], z = normals[i + 2], length = Math.sqrt(x * x + y * y + z * z);
    if (!(length > 0 && length < Infinity)) continue;
    any = true;
    result[i] = x / length, result[i + 1] = y / length, result[i + 2] = z / length;
  }
  return any ? result : undefined;
}

/** Whether a triangle has an area. @param {Float64Array} vertices @param {Int32Array} triangles */
function anyArea(vertices, triangles) {
  let largest = 0;
  for (let i = 0; i < vertices.length; ++i) largest = Math.max(largest, Math.abs(vertices[i] - vertices[i % 3]));
  const scale = 1 / largest, edge = [0, 0, 0, 0, 0, 0];
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i], b = 3 * triangles[i + 1], c = 3 * triangles[i + 2];
    for (let axis = 0; axis < 3; ++axis) {
      edge[axis] = (vertices[b + axis] - vertices[a + axis]) * scale;
      edge[axis + 3] = (vertices[c + axis] - vertices[a + axis]) * scale;
    }
    const [p, q, r, s, t, u] = edge;
    if (q * u - r * t || r * s - p * u || p * t - q * s) return true;
  }
  return false;
}
