// @ts-check
/** Joins the parts of a mesh file, and makes shapes of their valid triangles. */

import { CoreError } from "../core/errors.js";
import { IDENTITY } from "../shapes/affine.js";
import { meshShape } from "../shapes/mesh.js";
import { Looks, PLAIN } from "./surface.js";

/**
 * @typedef {import("./part.js").Part} Part
 * @typedef {import("./surface.js").Surface} Surface
 * @typedef {import("../tracing/description.js").SceneDescription} SceneDescription
 * @typedef {{part: Part, surfaces: Surface[], surface: Int32Array | null, paths: string[][], path: Int32Array | null}} Joined
 *   surfaces: one per appearance; surface: (T,) index of each triangle's surface, null if there is one; paths: in the tree of
 *   parts; path: (T,) of each triangle, null if there is at most one
 */

/** Beyond this, squares and products of coordinates leave float64. */
const MAX_COORDINATE = 1e100;

/** Maximum number of repetitions of a texture from its origin. */
const MAX_TILES = 2 ** 12;

/**
 * Makes one mesh per surface from all parts. Triangles with a missing or non-finite vertex are left out, as are unused vertices.
 *
 * @param {import("../core/core.js").Core} core
 * @param {string} name of the file
 * @param {Part[]} parts
 * @returns {SceneDescription}
 */
export function meshScene(core, name, parts) {
  const read = joined(parts), total = read.part.triangles.length / 3;
  if (total === 0) {
    const points = read.part.vertices.length / 3;
    throw new CoreError(`expected triangles, got ${points ? `a point cloud of ${grouped(points)} points` : "none"}`);
  }
  const shown = chosen(read, usable(read.part)), left = shown.part.triangles.length / 3;
  if (left === 0) throw new CoreError(`expected triangles, got ${grouped(total)} that all touch a missing or non-finite vertex`);
  if (!anyArea(shown.part.vertices, shown.part.triangles)) {
    throw new CoreError(`expected triangles with an area, got ${grouped(left)} of zero area`);
  }
  const scene = sceneOfSurfaces(core, name, shown);
  if (left === total) return scene;
  const warning = `${name}: left out ${grouped(total - left)} of ${grouped(total)} triangles that touch a missing or non-finite vertex`;
  return { ...scene, warnings: [warning] };
}

/** @param {import("../core/core.js").Core} core @param {string} name @param {Joined} read @returns {SceneDescription} */
function sceneOfSurfaces(core, name, read) {
  const { surfaces, surface } = read, whole = surface ? { ...read, part: withNormals(core, read.part) } : read;
  /** @type {SceneDescription} */
  const scene = { shapes: [], instances: [] };
  const triangles = surface && rowsOf(surface, surfaces.length), places = new Int32Array(surface ? whole.part.vertices.length / 3 : 0);
  surfaces.forEach((own, number) => {
    const part = triangles ? someOf(whole.part, triangles[number], places) : read.part;
    if (!part.triangles.length) return;
    const label = surface ? own.name || name : name, pieces = piecesOf(read, triangles?.[number]);
    scene.instances.push({ shape: scene.shapes.length, transform: IDENTITY, material: own.material, name: label, pieces });
    scene.shapes.push(meshOf(part, own));
  });
  return scene;
}

/** The runs of triangles with one path. @param {Joined} read @param {Int32Array} [rows] of the triangles; if omitted, all */
function piecesOf({ paths, path }, rows) {
  if (!path) return paths.map((one) => /** @type {[string[], null]} */ ([one, null]));
  /** @type {[string[], number][]} */
  const pieces = [];
  let last = -1;
  for (let i = 0; i < (rows ?? path).length; ++i) {
    const number = path[rows ? rows[i] : i];
    if (number !== last) pieces.push([paths[number], 0]);
    ++pieces[pieces.length - 1][1];
    last = number;
  }
  return pieces;
}

/** Ascending rows with each of the numbers 0 to `count` - 1. @param {Int32Array} numbers @param {number} count */
function rowsOf(numbers, count) {
  const sizes = new Int32Array(count), at = new Int32Array(count);
  for (const number of numbers) ++sizes[number];
  const rows = Array.from(sizes, (size) => new Int32Array(size));
  for (let row = 0; row < numbers.length; ++row) rows[numbers[row]][at[numbers[row]]++] = row;
  return rows;
}

/**
 * Selects triangles of a part and their vertices, in time proportional to these.
 *
 * @param {Part} part
 * @param {Int32Array} rows of the triangles
 * @param {Int32Array} places scratch: a zero per vertex of the part, reset at the end
 * @returns {Part}
 */
function someOf({ vertices, triangles, normals, colors, faceColors, alphas, uv }, rows, places) {
  const corners = rowsAt(triangles, rows, 3);
  let count = 0;
  const used = corners.filter((vertex) => !places[vertex] && (places[vertex] = ++count)).sort();
  used.forEach((vertex, i) => places[vertex] = i + 1);
  const renumbered = corners.map((vertex) => places[vertex] - 1);
  for (const vertex of used) places[vertex] = 0;
  return {
    vertices: rowsAt(vertices, used, 3), triangles: renumbered,
    normals: normals && rowsAt(normals, used, 3), colors: colors && rowsAt(colors, used, 3),
    faceColors: faceColors && rowsAt(faceColors, rows, 3), alphas: alphas && rowsAt(alphas, used, 1), uv: uv && rowsAt(uv, used, 2),
  };
}

/**
 * @template {Float64Array | Int32Array} T
 * @param {T} values (n, width)
 * @param {Int32Array} rows
 * @param {number} width
 * @returns {T}
 */
function rowsAt(values, rows, width) {
  const length = width * rows.length, result = /** @type {T} */ (values instanceof Int32Array ? new Int32Array(length) : new Float64Array(length));
  for (let i = 0; i < rows.length; ++i) {
    for (let axis = 0; axis < width; ++axis) result[width * i + axis] = values[width * rows[i] + axis];
  }
  return result;
}

/** @param {Part} part @param {Surface} surface @returns {import("../shapes/description.js").MeshDescription} */
function meshOf({ vertices, triangles, normals, colors, faceColors, alphas, uv }, { texture, alphaCutoff }) {
  const directions = normals && units(normals), cut = alphaCutoff !== undefined;
  const ofVertices = cut ? alphas : undefined, ofTexture = cut && uv ? texture?.picture.alpha : undefined;
  if (ofVertices) colors ??= new Float64Array(vertices.length).fill(1);
  return {
    kind: "mesh", vertices, triangles,
    ...(directions && { normals: directions }),
    ...(colors && { colors: Float32Array.from(colors) }),
    ...(faceColors && { face_colors: Float32Array.from(faceColors) }),
    ...(uv && texture && {
      uv: Float32Array.from(uv), texture: texture.picture.texels,
      texture_layout: Int32Array.of(texture.picture.height, texture.picture.width, ...texture.wrap),
    }),
    ...(ofVertices && { alphas: Float32Array.from(ofVertices) }),
    ...(ofTexture && { texture_alpha: ofTexture }),
    ...(cut && (ofVertices || ofTexture) && { alpha_cutoff: Float64Array.of(alphaCutoff) }),
  };
}

/**
 * Adds computed normals where the file lacks them, so that shading stays smooth where materials meet. Each corner then becomes a
 * separate vertex.
 *
 * @param {import("../core/core.js").Core} core
 * @param {Part} part
 * @returns {Part}
 */
function withNormals(core, part) {
  const { vertices, triangles, colors, alphas, uv } = part, normals = part.normals && units(part.normals);
  const isWhole = normals?.every((_, i) => i % 3 || normals[i] || normals[i + 1] || normals[i + 2]);
  if (isWhole) return part;
  const shape = meshShape(core, { kind: "mesh", vertices, triangles, normals });
  try {
    const computed = core.filled(new Float32Array(3 * triangles.length), (address) => {
      core.made("corner_normals", shape.handle, address);
    });
    /** @param {Float64Array} values @param {number} width */
    const ofCorners = (values, width) => {
      const result = new Float64Array(width * triangles.length);
      for (let i = 0; i < result.length; ++i) result[i] = values[width * triangles[Math.floor(i / width)] + i % width];
      return result;
    };
    return {
      ...part, vertices: ofCorners(vertices, 3), triangles: Int32Array.from(triangles.keys()), normals: Float64Array.from(computed),
      colors: colors && ofCorners(colors, 3), alphas: alphas && ofCorners(alphas, 1), uv: uv && ofCorners(uv, 2),
    };
  } finally {
    shape.free();
  }
}

/** @param {Part[]} parts @returns {Joined} an index beyond its own part's vertices becomes -1 */
function joined(parts) {
  const count = (/** @type {"vertices" | "triangles"} */ of) => parts.reduce((sum, part) => sum + part[of].length, 0);
  /** @type {Part} */
  const whole = parts.length === 1 ? parts[0] : { vertices: new Float64Array(count("vertices")), triangles: new Int32Array(count("triangles")) };
  let vertex = 0, corner = 0;
  for (const part of parts) {
    if (whole === part) break;
    const start = vertex / 3, size = part.vertices.length / 3, { triangles } = part;
    whole.vertices.set(part.vertices, vertex);
    for (let i = 0; i < triangles.length; ++i) {
      const index = triangles[i];
      whole.triangles[corner++] = index >= 0 && index < size ? index + start : -1;
    }
    vertex += part.vertices.length;
  }
  const part = {
    ...whole,
    normals: field(parts, "normals", "vertices", 3, NaN),
    colors: shownColors(field(parts, "colors", "vertices", 3, 1)),
    faceColors: shownColors(field(parts, "faceColors", "triangles", 3, 1)),
    alphas: shownColors(field(parts, "alphas", "vertices", 1, 1)),
    uv: onTexture(field(parts, "uv", "vertices", 2, 0)),
  };
  /** @type {Surface[]} */
  const surfaces = [], looks = new Looks();
  const numbers = parts.map(({ surface = PLAIN, uv }) => {
    const shown = uv ? surface : { ...surface, texture: undefined }, number = looks.number(shown);
    if (number === surfaces.length) surfaces.push(shown);
    return number;
  });
  const named = pathsOf(parts);
  if (surfaces.length < 2) return { part, surfaces: surfaces.length ? surfaces : [PLAIN], surface: null, ...named };
  const surface = new Int32Array(part.triangles.length / 3);
  let triangle = 0;
  parts.forEach(({ triangles }, i) => surface.fill(numbers[i], triangle, triangle += triangles.length / 3));
  return { part, surfaces, surface, ...named };
}

/** The different paths of all parts, and the path of each triangle. @param {Part[]} parts @returns {Pick<Joined, "paths" | "path">} */
function pathsOf(parts) {
  const shown = parts.filter(({ triangles }) => triangles.length > 0);
  if (!shown.length || !shown.every(({ runs }) => runs?.length)) return { paths: [], path: null };
  /** @type {Map<string, number>} */
  const numbers = new Map();
  /** @type {string[][]} */
  const paths = [];
  const runs = shown.flatMap(({ runs = [] }) => runs.map(([path, count]) => {
    const key = JSON.stringify(path), number = numbers.get(key) ?? paths.push(path) - 1;
    numbers.set(key, number);
    return { number, count };
  }));
  if (paths.length < 2) return { paths, path: null };
  const path = new Int32Array(runs.reduce((sum, { count }) => sum + count, 0));
  let at = 0;
  for (const { number, count } of runs) path.fill(number, at, at += count);
  return { paths, path };
}

/**
 * A field of all parts, with `missing` in parts without it; undefined if all lack it.
 *
 * @param {Part[]} parts
 * @param {"normals" | "colors" | "faceColors" | "alphas" | "uv"} name
 * @param {"vertices" | "triangles"} like the array with an equal number of rows
 * @param {number} width
 * @param {number} missing
 */
function field(parts, name, like, width, missing) {
  const sizes = parts.map((part) => part[like].length / 3 * width);
  if (parts.every((part, i) => part[name]?.length !== sizes[i])) return undefined;
  if (parts.length === 1) return parts[0][name];
  const result = new Float64Array(sizes.reduce((sum, size) => sum + size, 0)).fill(missing);
  let at = 0;
  parts.forEach(({ [name]: own }, i) => {
    if (own?.length === sizes[i]) result.set(own, at);
    at += sizes[i];
  });
  return result;
}

/** Colours or alphas, clamped and finite; undefined if all are 1. @param {Float64Array | undefined} values */
function shownColors(values) {
  if (!values) return undefined;
  const shown = values.map((value) => (Number.isNaN(value) ? 1 : Math.min(Math.max(value, 0), 1)));
  return shown.every((value) => value === 1) ? undefined : shown;
}

/**
 * Replaces texture coordinates by 0, 0 if they are not finite, or too large for float32 to resolve texels.
 *
 * @param {Float64Array | undefined} uv
 */
function onTexture(uv) {
  const near = (/** @type {number} */ value) => Math.abs(value) <= MAX_TILES;  // false for NaN
  return uv?.map((value, i) => (near(value) && near(uv[i ^ 1]) ? value : 0));
}

/** For each triangle, 1 if all of its vertices exist and are finite. @param {Part} part */
function usable({ vertices, triangles }) {
  const size = vertices.length / 3, fine = new Uint8Array(size), shown = new Uint8Array(triangles.length / 3);
  for (let i = 0, at = 0; at < vertices.length; ++i, at += 3) {
    const largest = Math.max(Math.abs(vertices[at]), Math.abs(vertices[at + 1]), Math.abs(vertices[at + 2]));
    fine[i] = Number(largest <= MAX_COORDINATE);  // false for NaN
  }
  for (let i = 0; i < shown.length; ++i) {
    const a = triangles[3 * i], b = triangles[3 * i + 1], c = triangles[3 * i + 2];
    const areThere = a >= 0 && b >= 0 && c >= 0 && a < size && b < size && c < size;
    shown[i] = Number(areThere && fine[a] & fine[b] & fine[c]);
  }
  return shown;
}

/**
 * Selects triangles and their vertices.
 *
 * @param {Joined} read
 * @param {Uint8Array} which 1 for each selected triangle
 * @returns {Joined}
 */
function chosen({ part, surfaces, surface, paths, path }, which) {
  const rows = new Int32Array(which.length);
  let count = 0;
  for (let i = 0; i < rows.length; ++i) rows[i] = which[i] ? count++ : -1;
  const triangles = picked(part.triangles, rows, count, 3);
  const places = new Int32Array(part.vertices.length / 3);
  for (let i = 0; i < triangles.length; ++i) places[triangles[i]] = 1;
  let vertices = 0;
  for (let i = 0; i < places.length; ++i) places[i] = places[i] ? vertices++ : -1;
  if (vertices < places.length) for (let i = 0; i < triangles.length; ++i) triangles[i] = places[triangles[i]];
  return {
    part: {
      vertices: picked(part.vertices, places, vertices, 3),
      triangles,
      normals: part.normals && picked(part.normals, places, vertices, 3),
      colors: part.colors && picked(part.colors, places, vertices, 3),
      faceColors: part.faceColors && picked(part.faceColors, rows, count, 3),
      alphas: part.alphas && picked(part.alphas, places, vertices, 1),
      uv: part.uv && picked(part.uv, places, vertices, 2),
    },
    surfaces,
    surface: surface && picked(surface, rows, count, 1),
    paths,
    path: path && picked(path, rows, count, 1),
  };
}

/**
 * Reordered rows; the same array if all are kept.
 *
 * @template {Float64Array | Int32Array} T
 * @param {T} values (n, width)
 * @param {Int32Array} places new row of each, or -1
 * @param {number} count
 * @param {number} width
 * @returns {T}
 */
function picked(values, places, count, width) {
  if (count === places.length) return values;
  const result = /** @type {T} */ (values instanceof Int32Array ? new Int32Array(width * count) : new Float64Array(width * count));
  for (let i = 0; i < places.length; ++i) {
    if (places[i] < 0) continue;
    for (let axis = 0; axis < width; ++axis) result[width * places[i] + axis] = values[width * i + axis];
  }
  return result;
}

/**
 * Unit normals, zero for unusable ones; undefined if all are unusable.
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

/** A count with commas between its thousands. @param {number} count */
const grouped = (count) => count.toLocaleString("en");
