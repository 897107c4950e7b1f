// @ts-check
/**
 * OBJ: points, their colours, normals, places on textures and polygons, and materials of files beside it; curves are passed over.
 *
 * It is read here because the loader of three.js (r187) makes three vertices for each triangle, which takes five times
 * as long and three times the memory, gives normals to faces that have none, and takes comments behind faces for
 * corners.
 */

import { readMtl } from "./mtl.js";
import { Growing } from "./part.js";
import { CoreError } from "../core/errors.js";
import { PLAIN, fromSrgb } from "./surface.js";
import { numberOf, textOf } from "./text.js";

const TAB = 9, RETURN = 13, SPACE = 32, PLUS = 43, MINUS = 45, SLASH = 47, ZERO = 48, NINE = 57, F = 102, N = 110, T = 116, V = 118;
const USEMTL = Array.from("usemtl", (letter) => letter.charCodeAt(0));

/** @typedef {import("./part.js").Part} Part @typedef {import("./surface.js").Surface} Surface */

/**
 * @param {ArrayBuffer} bytes
 * @param {import("./part.js").Warn} warn
 * @param {import("./beside.js").Beside} beside
 * @returns {Promise<Part[]>} one for each material
 */
export async function readObj(bytes, warn, beside) {
  const text = textOf(bytes).replaceAll("\\\n", " "), words = new Words(text);
  const points = new Growing(Float64Array), normals = new Growing(Float64Array), triangles = new Growing(Int32Array);
  const colors = new Growing(Float64Array), places = new Growing(Float64Array), materials = new Growing(Int32Array);
  const libraries = Array.from(text.matchAll(/^[ \t]*mtllib[ \t]+(.*)/gm), ([, line]) => line);
  /** @type {Map<string, Surface>} */
  const surfaces = libraries.length && text.includes("usemtl") ? await readMtl(libraries, beside, warn) : new Map();
  const isTextured = [...surfaces.values()].some(({ texture }) => texture);
  const pairs = /^[ \t]*vn[ \t]/m.test(text) || isTextured ? new Vertices(isTextured) : null;
  /** Of materials, in the order in which faces have them. @type {Map<string, number>} */
  const names = new Map([["", 0]]);
  let material = 0;
  while (words.nextLine()) {
    if (words.are(V)) pushPoint(words, points, colors);
    else if (words.are(V, N)) pushVector(words, normals);
    else if (isTextured && words.are(V, T)) pushPlace(words, places);
    else if (surfaces.size && words.are(...USEMTL)) {
      const name = words.rest();
      material = names.get(name) ?? names.size;
      names.set(name, material);
    } else if (words.are(F)) {
      pushPolygon(words, points.length / 3, normals.length / 3, places.length / 2, pairs, triangles);
      if (surfaces.size) while (materials.length < triangles.length / 3) materials.push(material);
    }
  }
  const at = pairs?.points.whole(), part = { vertices: points.whole(), triangles: triangles.whole(), colors: linear(colors, points.length) };
  /** @type {Part} */
  const whole = !pairs || !at || !part.triangles.length ? part : {
    ...part, vertices: picked(part.vertices, at), normals: normals.length ? picked(normals.whole(), pairs.normals.whole()) : undefined,
    colors: part.colors && picked(part.colors, at),
  };
  if (!surfaces.size) return [whole];
  const uv = pairs && isTextured ? picked(places.whole(), pairs.places.whole(), 2).map((value, i) => (i % 2 ? 1 - value : value)) : undefined;
  const groups = cornersOf(whole.triangles, materials.whole(), names.size);
  return Array.from(names).flatMap(([name, number]) => ofSurface(whole, groups[number], uv, surfaces.get(name) ?? PLAIN));
}

/**
 * The corners of the triangles that have each material.
 *
 * @param {Int32Array} triangles (T, 3)
 * @param {Int32Array} materials (T,)
 * @param {number} count of the materials
 */
function cornersOf(triangles, materials, count) {
  const sizes = new Int32Array(count), at = new Int32Array(count);
  for (const material of materials) ++sizes[material];
  const groups = Array.from(sizes, (size) => new Int32Array(3 * size));
  for (let i = 0; i < triangles.length; ++i) {
    const material = materials[Math.floor(i / 3)];
    groups[material][at[material]++] = triangles[i];
  }
  return groups;
}

/**
 * The triangles of one surface, and what they use; nothing if there are none.
 *
 * @param {Part} whole
 * @param {Int32Array} corners of its triangles
 * @param {Float64Array | undefined} uv of its vertices, from the top down
 * @param {Surface} surface
 * @returns {Part[]}
 */
function ofSurface({ vertices, normals, colors }, corners, uv, surface) {
  if (!corners.length) return [];
  const used = Int32Array.from(new Set(corners)).sort(), places = new Map(Array.from(used, (vertex, i) => [vertex, i]));
  return [{
    vertices: picked(vertices, used), triangles: corners.map((corner) => places.get(corner) ?? -1),
    normals: normals && picked(normals, used), colors: colors && picked(colors, used),
    uv: uv && surface.texture && picked(uv, used, 2), surface,
  }];
}

/** @param {number} character */
const isSpace = (character) => character === SPACE || (character >= TAB && character <= RETURN);

/** The words of a text, line by line; none is stored. */
class Words {
  #text;
  #at = 0;
  #end = -1;  // of the line
  #stop = 0;  // where its comment begins, or it ends
  #hash = -1;  // the first beyond where the line begins

  /** @param {string} text */
  constructor(text) {
    this.#text = text;
  }

  /** Goes to the first word of the next line. @returns {boolean} whether there is such a line */
  nextLine() {
    this.#at = this.#end + 1;
    if (this.#at >= this.#text.length) return false;
    const end = this.#text.indexOf("\n", this.#at);
    this.#end = end < 0 ? this.#text.length : end;
    if (this.#hash < this.#at) {
      const hash = this.#text.indexOf("#", this.#at);
      this.#hash = hash < 0 ? Infinity : hash;
    }
    this.#stop = Math.min(this.#end, this.#hash);
    this.#skipSpace();
    return true;
  }

  /** Whether the word is made of these characters; if it is, goes to the next. @param {...number} characters */
  are(...characters) {
    for (let i = 0; i < characters.length; ++i) if (this.#text.charCodeAt(this.#at + i) !== characters[i]) return false;
    const after = this.#text.charCodeAt(this.#at + characters.length);
    if (!isSpace(after)) return false;
    this.#at += characters.length;
    this.#skipSpace();
    return true;
  }

  /** Whether a comment or the line's end comes next. */
  get ended() {
    return this.#at >= this.#stop;
  }

  /** The word that comes next, empty if there is none. */
  word() {
    const start = this.#at;
    this.#skipWord();
    const word = this.#text.slice(start, this.#at);
    this.#skipSpace();
    return word;
  }

  /** All that is left of the line. */
  rest() {
    const rest = this.#text.slice(this.#at, this.#end).trim();
    this.#at = this.#stop;
    return rest;
  }

  /** The digits that come next as an index, from 0 on; -1 if there is no such item. @param {number} count */
  index(count) {
    const start = this.#at, first = this.#text.charCodeAt(start), negative = first === MINUS;
    if (negative || first === PLUS) ++this.#at;
    const digits = this.#at;
    let number = 0;
    for (; this.#at < this.#stop; ++this.#at) {
      const digit = this.#text.charCodeAt(this.#at);
      if (digit < ZERO || digit > NINE) break;
      number = 10 * number + digit - ZERO;
    }
    if (digits === this.#at || !this.#ends(this.#at)) {
      this.#skipWord();
      const word = this.#text.slice(start, this.#at).split("/", 1)[0];
      throw new CoreError(`expected corners of faces such as 3, 3/1 or 3//2, got '${word.slice(0, 40)}'`);
    }
    const index = negative ? count - number : number - 1;
    return number > 0 && index < 2 ** 31 ? Math.max(index, -1) : -1;
  }

  /** Whether the part of a corner that comes next is empty. */
  get empty() {
    return this.#ends(this.#at);
  }

  /** Goes behind the next slash of the word. @returns {boolean} whether it has one */
  slash() {
    while (this.#at < this.#stop) {
      const character = this.#text.charCodeAt(this.#at);
      if (isSpace(character)) return false;
      ++this.#at;
      if (character === SLASH) return true;
    }
    return false;
  }

  /** Goes to the next word. */
  next() {
    this.#skipWord();
    this.#skipSpace();
  }

  /** Whether a part of a corner ends at a place. @param {number} at */
  #ends(at) {
    const character = this.#text.charCodeAt(at);
    return at >= this.#stop || character === SLASH || isSpace(character);
  }

  #skipWord() {
    for (; this.#at < this.#stop; ++this.#at) {
      const character = this.#text.charCodeAt(this.#at);
      if (isSpace(character)) return;
    }
  }

  #skipSpace() {
    for (; this.#at < this.#stop; ++this.#at) {
      const character = this.#text.charCodeAt(this.#at);
      if (!isSpace(character)) return;
    }
  }
}

/** A vertex for each pair of point and normal that some corner names, or where there are textures, with a place on one. */
class Vertices {
  points = new Growing(Int32Array);
  normals = new Growing(Int32Array);
  places = new Growing(Int32Array);
  /** @type {Map<number, number>} */
  #pairs = new Map();
  /** @type {Map<number, number>} */
  #known = new Map();

  /** @param {boolean} withPlaces */
  constructor(withPlaces) {
    this.withPlaces = withPlaces;
  }

  /** @param {number} point or -1 @param {number} normal or -1 @param {number} place or -1 @returns {number} the vertex */
  vertex(point, normal, place) {
    let key = (point + 1) * 2 ** 26 + normal + 1;
    if (this.withPlaces) {
      const pair = this.#pairs.get(key) ?? this.#pairs.size;
      this.#pairs.set(key, pair);
      key = pair * 2 ** 26 + place + 1;
    }
    let vertex = this.#known.get(key);
    if (vertex === undefined) {
      vertex = this.points.length;
      this.#known.set(key, vertex);
      this.points.push(point);
      this.normals.push(normal);
      this.places.push(place);
    }
    return vertex;
  }
}

/** @param {Words} words @param {Growing<Float64Array>} vectors */
function pushVector(words, vectors) {
  const x = words.word(), y = words.word(), z = words.word();
  for (const word of [x, y, z]) vectors.push(z ? numberOf(word) : NaN);
}

/**
 * A point, and the three numbers behind it, if there are so many: its colour, in sRGB.
 *
 * @param {Words} words
 * @param {Growing<Float64Array>} points
 * @param {Growing<Float64Array>} colors of the points up to the last that has one; NaN where there is none
 */
function pushPoint(words, points, colors) {
  const point = points.length;
  pushVector(words, points);
  if (words.ended) return;
  const red = words.word(), green = words.word(), blue = words.word();
  if (!blue) return;
  while (colors.length < point) colors.push(NaN);
  for (const word of [red, green, blue]) colors.push(numberOf(word));
}

/**
 * Linear RGB of points; nothing if their numbers are no colours, which are in 0..1.
 *
 * @param {Growing<Float64Array>} srgb
 * @param {number} length
 */
function linear(srgb, length) {
  const own = srgb.whole();
  if (!own.length || own.some((value) => value < 0 || value > 1)) return undefined;
  const result = new Float64Array(length).fill(NaN);
  result.set(own.map(fromSrgb));
  return result;
}

/**
 * Cuts a polygon into a fan.
 *
 * @param {Words} words its corners
 * @param {number} points so far
 * @param {number} normals so far
 * @param {number} places on textures so far
 * @param {Vertices | null} vertices null where points are vertices
 * @param {Growing<Int32Array>} triangles
 */
function pushPolygon(words, points, normals, places, vertices, triangles) {
  for (let corner = 0, first = 0, previous = 0; !words.ended; ++corner, words.next()) {
    const point = words.index(points), hasPlace = words.slash();
    const place = vertices?.withPlaces && hasPlace && !words.empty ? words.index(places) : -1;
    const normal = hasPlace && words.slash() && !words.empty ? words.index(normals) : -1;
    const vertex = vertices ? vertices.vertex(point, normal, place) : point;
    if (corner > 1) triangles.push(first), triangles.push(previous), triangles.push(vertex);
    if (corner === 0) first = vertex;
    previous = vertex;
  }
}

/** @param {Words} words @param {Growing<Float64Array>} places */
function pushPlace(words, places) {
  for (let axis = 0; axis < 2; ++axis) {
    const word = words.word();
    places.push(word ? numberOf(word) : NaN);
  }
}

/**
 * Rows as numbers, (n, width); NaN where there is no such row.
 *
 * @param {Float64Array} rows (m, width)
 * @param {Int32Array} at (n,)
 * @param {number} [width]
 */
function picked(rows, at, width = 3) {
  const result = new Float64Array(width * at.length);
  for (let i = 0; i < at.length; ++i) {
    for (let axis = 0; axis < width; ++axis) result[width * i + axis] = rows[width * at[i] + axis];  // NaN outside
  }
  return result;
}
