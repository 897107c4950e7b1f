// @ts-check
/**
 * PLY, text and binary: vertices, their normals, polygons and triangle strips, and their colours.
 *
 * It is read here because the loader of three.js (r187) leaves out polygons of more than four corners and strips,
 * rounds coordinates to float32, and takes about five times as long.
 *
 * @typedef {{name: string, type: string, length: string | null, full?: number}} Property
 *   length: the type of a list's length; null of a scalar; full: how much of a colour is all of it
 * @typedef {{name: string, rows: number, properties: Property[]}} Element
 * @typedef {"getInt8" | "getUint8" | "getInt16" | "getUint16" | "getInt32" | "getUint32" | "getBigInt64" |
 *   "getBigUint64" | "getFloat32" | "getFloat64"} Getter the method of a DataView that reads a number
 */

import { CoreError, brief } from "../core/errors.js";
import { Growing } from "./part.js";
import { fromSrgb } from "./surface.js";
import { numberOf, textOf, wordsOfLines } from "./text.js";

/** @typedef {import("./part.js").Part} Part */

/** Bytes, and how they are read. @type {Record<string, [number, Getter]>} */
const KINDS = {
  i1: [1, "getInt8"], u1: [1, "getUint8"], i2: [2, "getInt16"], u2: [2, "getUint16"], i4: [4, "getInt32"],
  u4: [4, "getUint32"], i8: [8, "getBigInt64"], u8: [8, "getBigUint64"], f4: [4, "getFloat32"], f8: [8, "getFloat64"],
};
/** @type {Record<string, string>} */
const TYPES = {
  char: "i1", int8: "i1", uchar: "u1", uint8: "u1", short: "i2", int16: "i2", ushort: "u2", uint16: "u2",
  int: "i4", int32: "i4", uint: "u4", uint32: "u4", int64: "i8", uint64: "u8",
  float: "f4", float32: "f4", double: "f8", float64: "f8",
};
const FORMATS = ["ascii", "binary_little_endian", "binary_big_endian"];
const CORNERS = ["vertex_indices", "vertex_index"];
const SRGB = [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"]];
/** As Mitsuba writes its attributes. */
const LINEAR = ["color_0", "color_1", "color_2"];
const PLACES_OF_VERTICES = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
const HEADER = 1 << 20, MOST_HEADERS = 1 << 14; // bytes
/** Bytes of a row that is a triangle, in nearly all files. */
const TRIANGLE = 13;

/**
 * @param {ArrayBuffer} bytes
 * @param {import("./part.js").Warn} warn
 * @returns {Part[]} colours of vertices stand for those of faces
 */
export function readPly(bytes, warn) {
  const header = readHeader(bytes), little = header.format !== "binary_big_endian";
  // Whatever comes after the last of these, edges or materials, is of no use here.
  const last = header.elements.findLastIndex(({ name }) => ["vertex", "face", "tristrips"].includes(name));
  const elements = header.elements.slice(0, last + 1);
  // Text becomes binary in which every number is a double, so that one reader does for both.
  const view = header.format === "ascii" ? binary(bytes, header.end, elements) : new DataView(bytes, header.end);
  /** @type {Float64Array | undefined} */
  let vertices;
  /** @type {Float64Array | undefined} */
  let normals;
  const triangles = new Growing(Int32Array, 3 * (elements.find(({ name }) => name === "face")?.rows ?? 0));
  const cuts = new Growing(Int32Array);  // triangles of each face
  /** @type {Colors | undefined} */
  let colors;
  /** @type {Colors | undefined} */
  let faceColors;
  let at = 0;
  for (const element of elements) {
    try {
      if (element.name === "vertex" && has(element, "x", "y", "z")) {
        const own = has(element, "nx", "ny", "nz") ? new Float64Array(3 * element.rows) : undefined;
        vertices = new Float64Array(3 * element.rows), normals = own, colors = colorsOf(element);
        at = readRows(view, at, little, element, { x: [vertices, 0], y: [vertices, 1], z: [vertices, 2],
          ...(own && { nx: [own, 0], ny: [own, 1], nz: [own, 2] }), ...colors?.columns }, () => undefined);
      } else if (element.name === "face") {
        faceColors = colorsOf(element);
        const done = readTriangles(view, at, little, element, triangles);
        at = readRows(view, at + done * TRIANGLE, little, element, faceColors?.columns ?? {}, (corners, count) => {
          if (faceColors) cuts.push(Math.max(count - 2, 0));
          addFan(triangles, corners, count);
        }, done);
      } else {
        const isStrips = element.name === "tristrips";
        at = readRows(view, at, little, element, {}, (corners, count) => isStrips && addStrips(triangles, corners, count));
      }
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
      throw new CoreError(`expected ${element.rows} ${element.name}, but the file ends before them`);
    }
  }
  if (!vertices) throw new CoreError("expected a PLY with vertices x, y, z, got none");
  if (header.texture && elements.some(hasPlaces)) {
    warn(`texture ${header.texture.trim()} was left out: it is in another file`);
  }
  return [{
    vertices, triangles: triangles.whole(), normals, colors: colors?.linear(),
    faceColors: colors ? undefined : faceColors && repeated(faceColors.linear(), cuts.whole()),
  }];
}

/** Whether vertices or corners have places on a texture. @param {Element} element */
function hasPlaces(element) {
  const onCorners = element.name === "face" && element.properties.some(({ name, length }) => name === "texcoord" && length !== null);
  return onCorners || (element.name === "vertex" && PLACES_OF_VERTICES.some((names) => has(element, ...names)));
}

/** @typedef {{columns: Record<string, [Float64Array, number]>, linear: () => Float64Array}} Colors columns: see readRows */

/** Where an element's colours are read to; nothing if it has none. @param {Element} element @returns {Colors | undefined} */
function colorsOf(element) {
  const srgb = SRGB.find((names) => has(element, ...names)), names = srgb ?? (has(element, ...LINEAR) ? LINEAR : undefined);
  if (!names) return undefined;
  const values = new Float64Array(3 * element.rows);
  const full = names.map((name) => element.properties.find((own) => own.name === name)?.full ?? 1);
  return {
    columns: Object.fromEntries(names.map((name, axis) => [name, [values, axis]])),
    linear: () => values.map((value, i) => (srgb ? fromSrgb(Math.min(Math.max(value / full[i % 3], 0), 1)) : value)),
  };
}

/** Rows, (n, 3), each as often as `times` says. @param {Float64Array} rows @param {Int32Array} times */
function repeated(rows, times) {
  const result = new Float64Array(3 * times.reduce((sum, count) => sum + count, 0));
  let at = 0;
  times.forEach((count, row) => {
    for (let i = 0; i < count; ++i, at += 3) result.set(rows.subarray(3 * row, 3 * row + 3), at);
  });
  return result;
}

/** @param {Element} element @param {...string} names */
function has(element, ...names) {
  return names.every((name) => element.properties.some((own) => own.name === name && own.length === null));
}

// ---- Header ----------------------------------------------------------------------------------------------

/**
 * @param {ArrayBuffer} bytes
 * @returns {{format: string, elements: Element[], end: number, texture?: string}} end: where the body starts; texture: its file
 */
function readHeader(bytes) {
  // One character a byte, so that places in the text are places in the file.
  const textOfFirst = (/** @type {number} */ size) => new TextDecoder("latin1").decode(new Uint8Array(bytes, 0, Math.min(bytes.byteLength, size)));
  const short = textOfFirst(MOST_HEADERS), text = /[\r\n]end_header[ \t]*[\r\n]./s.test(short) ? short : textOfFirst(HEADER);
  if (!text.startsWith("ply")) {
    throw new CoreError(`expected a PLY, which starts with 'ply', got ${brief(text.slice(0, 8))}`);
  }
  const found = /[\r\n]end_header[ \t]*(\r\n|\n|\r|$)/.exec(text);
  if (!found) throw new CoreError("expected a PLY header that ends in end_header, got none");
  let format = "";
  /** @type {Element[]} */
  const elements = [];
  for (const [word, ...words] of wordsOfLines(text.slice(0, found.index).replace(/\r\n?/g, "\n"))) {
    if (word === "format") format = words[0];
    else if (word === "element" && words.length === 2) {
      elements.push({ name: words[0], rows: integerOf(words[1]), properties: [] });
    } else if (word === "property" && elements.length) {
      const [name, type, length, list] = words.toReversed(), { properties } = elements[elements.length - 1];
      if (words.length === 4 && list === "list") {
        properties.push({ name, type: typeOf(type, format), length: typeOf(length, format) });
      } else if (words.length === 2) {
        properties.push({ name, type: typeOf(type, format), length: null, full: fullOf(TYPES[type]) });
      }
    }
  }
  if (!FORMATS.includes(format)) {
    throw new CoreError(`expected a PLY of format ascii or binary, got ${format || "none"}`);
  }
  const used = elements.filter(({ properties }) => properties.length), end = found.index + found[0].length;
  checkSize(used, bytes.byteLength - end, format === "ascii");
  const [, texture] = /[\r\n]comment[ \t]+TextureFile[ \t]+([^\r\n]+)/.exec(text.slice(0, found.index)) ?? [];
  return { format, elements: used, end, texture };
}

/** The largest value of a type of whole numbers; 1 of others. @param {string} kind */
function fullOf(kind) {
  return kind.startsWith("f") ? 1 : 2 ** (8 * KINDS[kind][0] - Number(kind.startsWith("i"))) - 1;
}

/** @param {string} word @param {string} format */
function typeOf(word, format) {
  if (!Object.hasOwn(TYPES, word)) throw new CoreError(`expected a PLY type such as float or int, got ${word}`);
  return format === "ascii" ? "f8" : TYPES[word];
}

/**
 * A list takes at least its length; a number in a text at least a digit and a space, but for the last.
 *
 * @param {Element[]} elements
 * @param {number} left bytes
 * @param {boolean} text
 */
function checkSize(elements, left, text) {
  const size = (/** @type {Property} */ { type, length }) => (text ? 2 : KINDS[length ?? type][0]);
  const sum = (/** @type {number[]} */ numbers) => numbers.reduce((a, b) => a + b, 0);
  const smallest = sum(elements.map(({ rows, properties }) => rows * sum(properties.map(size))));
  if (!(smallest <= left + Number(text)) || elements.some(({ rows }) => !(rows >= 0))) {
    const declared = elements.map(({ rows, name }) => `${rows} ${name}`).join(", ");
    throw new CoreError(`expected ${declared}, got only ${left} bytes to hold them`);
  }
}

// ---- Body ------------------------------------------------------------------------------------------------

/**
 * The numbers that the header declares, as doubles. A line may hold more.
 *
 * @param {ArrayBuffer} bytes
 * @param {number} start
 * @param {Element[]} elements
 */
function binary(bytes, start, elements) {
  const lines = wordsOfLines(textOf(new Uint8Array(bytes, start)));
  const numbers = new Growing(Float64Array);
  for (const { name, rows, properties } of elements) {
    for (let row = 0; row < rows; ++row) {
      const { value: words = [] } = lines.next();
      let count = 0;
      for (const { length } of properties) count += 1 + (length === null ? 0 : Math.max(0, integerOf(words[count] ?? "0")));
      if (!(words.length >= count)) throw new CoreError(`expected ${rows} ${name}, got ${row} and a bit`);
      for (let i = 0; i < count; ++i) numbers.push(numberOf(words[i]));
    }
  }
  const { buffer, byteLength } = numbers.whole();
  return new DataView(buffer, 0, byteLength);
}

/** @param {string} word */
function integerOf(word) {
  if (!/^[-+]?[0-9]{1,18}$/.test(word)) throw new CoreError(`expected a whole number, got '${word.slice(0, 40)}'`);
  return Number(word);
}

/**
 * Reads an element's rows: scalars to where `columns` says, [array, axis of 3], and hands over the corners of each list
 * of indices, which are good until the next.
 *
 * @param {DataView} view @param {number} at where they start @param {boolean} little @param {Element} element
 * @param {Record<string, [Float64Array, number]>} columns
 * @param {(corners: Int32Array, count: number) => void} onList
 * @param {number} [begin] of the rows that are left
 * @returns {number} where they end
 */
function readRows(view, at, little, element, columns, onList, begin = 0) {
  if (element.properties.every(({ length }) => length === null)) return readScalars(view, at, little, element, columns);
  let corners = new Int32Array(64);
  const lists = element.properties.filter(({ length }) => length !== null).map(({ name }) => name);
  const ofCorners = CORNERS.find((name) => lists.includes(name));
  const plan = element.properties.map(({ name, type, length }) => {
    const [size, get] = KINDS[type], [lengthSize, getLength] = length ? KINDS[length] : [0, get];
    const [array, axis] = Object.hasOwn(columns, name) ? columns[name] : [null, 0];
    const isList = length !== null, wanted = name === ofCorners;
    return { size, get, array, axis, isList, lengthSize, getLength, wanted };
  });
  for (let row = begin; row < element.rows; ++row) {
    for (const { size, get, array, axis, isList, lengthSize, getLength, wanted } of plan) {
      if (!isList) {
        if (array) array[3 * row + axis] = Number(view[get](at, little));
        at += size;
        continue;
      }
      const count = Number(view[getLength](at, little));
      if (!(count >= 0 && count <= view.byteLength)) {
        throw new CoreError(`expected a list no longer than the file, got one of ${count}`);
      }
      at += lengthSize;
      if (wanted) {
        if (count > corners.length) corners = new Int32Array(2 * count);
        for (let i = 0; i < count; ++i) corners[i] = Number(view[get](at + i * size, little));
        onList(corners, count);
      }
      at += count * size;
    }
  }
  if (at > view.byteLength) throw new RangeError("rows end beyond the file");
  return at;
}

/**
 * Reads faces that have nothing but corners, as far as they are triangles: as readRows does, in a third of the time.
 *
 * @param {DataView} view @param {number} at where they start @param {boolean} little @param {Element} element
 * @param {Growing<Int32Array>} triangles
 * @returns {number} how many
 */
function readTriangles(view, at, little, { properties: [{ name, type, length }, other], rows }, triangles) {
  if (other || !CORNERS.includes(name) || !["i4", "u4"].includes(type) || !["i1", "u1"].includes(length ?? "")) return 0;
  const most = Math.min(rows, Math.floor((view.byteLength - at) / TRIANGLE));
  triangles.reserve(3 * most);
  const { values, length: start } = triangles;
  let row = 0;
  for (let i = start; row < most && view.getUint8(at) === 3; ++row, at += TRIANGLE, i += 3) {
    values[i] = view.getInt32(at + 1, little), values[i + 1] = view.getInt32(at + 5, little), values[i + 2] = view.getInt32(at + 9, little);
  }
  triangles.length += 3 * row;
  return row;
}

/**
 * The same of rows without lists: column by column.
 *
 * @type {(...of: [DataView, number, boolean, Element, Record<string, [Float64Array, number]>]) => number}
 */
function readScalars(view, at, little, { rows, properties }, columns) {
  const stride = properties.reduce((sum, { type }) => sum + KINDS[type][0], 0);
  let offset = at;
  for (const { name, type } of properties) {
    const [size, get] = KINDS[type];
    if (Object.hasOwn(columns, name)) {
      const [array, axis] = columns[name];
      readColumn(view, get, little, offset, stride, array, axis);
    }
    offset += size;
  }
  if (at + rows * stride > view.byteLength) throw new RangeError("rows end beyond the file");
  return at + rows * stride;
}

/**
 * @param {DataView} view
 * @param {Getter} get
 * @param {boolean} little
 * @param {number} at
 * @param {number} stride
 * @param {Float64Array} array
 * @param {number} axis
 */
function readColumn(view, get, little, at, stride, array, axis) {
  if (get === "getFloat32") {  // nearly all files'; named, it is fast
    for (let i = axis; i < array.length; i += 3, at += stride) array[i] = view.getFloat32(at, little);
  } else {
      for (let i = axis; i < array.length; i += 3, at += stride) array[i] = Number(view[get](at, little));
  }
}

// ---- Polygons --------------------------------------------------------------------------------------------

/**
 * Cuts a polygon into a fan.
 *
 * @param {Growing<Int32Array>} triangles
 * @param {Int32Array} corners
 * @param {number} count
 */
function addFan(triangles, corners, count) {
  for (let i = 2; i < count; ++i) {
    triangles.reserve(3);
    const { values, length } = triangles;
    values[length] = corners[0], values[length + 1] = corners[i - 1], values[length + 2] = corners[i];
    triangles.length += 3;
  }
}

/**
 * Triangle strips, which end with their list or at a -1 within it.
 *
 * @param {Growing<Int32Array>} triangles
 * @param {Int32Array} corners
 * @param {number} count
 */
function addStrips(triangles, corners, count) {
  let start = 0;
  for (let i = 0; i < count; ++i) {
    if (corners[i] < 0) start = i + 1;
    if (i < start + 2) continue;
    const a = corners[i - 2], b = corners[i - 1], c = corners[i];
    if (a === b || b === c || c === a) continue;  // these steer a strip round a bend; they are not meant to be seen
    const odd = (i - start) % 2;  // every second triangle of a strip turns the other way
    for (const index of odd ? [b, a, c] : [a, b, c]) triangles.push(index);
  }
}
