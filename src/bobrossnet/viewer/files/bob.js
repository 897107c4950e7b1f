// @ts-check
/** Scene files, .bob (CONVENTIONS.md has their fields): whatever is not as written by bobrossnet is refused. */

import {
  CoreError, brief, checkFields, checkFinite, checkInteger, checkList, checkNumber, placedErrors,
} from "../errors.js";
import { checkBrep, checkTube } from "../splines.js";

/**
 * @typedef {import("../core.js").Core} Core
 * @typedef {import("../scene.js").SceneDescription} SceneDescription
 * @typedef {import("../scene.js").ShapeDescription} ShapeDescription
 * @typedef {import("../scene.js").InstanceDescription} InstanceDescription
 */

const FORMAT = "bobrossnet-scene", VERSION = "1";

/** The checksum comes first: of the whole file, with its own digits taken as zeros. */
const START = '{"__metadata__":{"sha256":"', DIGITS = 8 + START.length, BODY = DIGITS + 64;

/** What is singular, as bobrossnet.shapes.affine.FLATTEST. */
const FLATTEST = 1e-10;

/** @type {Record<string, {new (buffer: ArrayBuffer): any, BYTES_PER_ELEMENT: number}>} */
const TYPES = { F64: Float64Array, F32: Float32Array, I32: Int32Array, U32: Uint32Array, U8: Uint8Array };

/**
 * What a tensor is: dtype, and the length of each axis; those that may be left out end in "?".
 *
 * @type {Record<string, Record<string, [string, ...(number | null)[]]>>}
 */
const KINDS = {
  mesh: { vertices: ["F64", null, 3], triangles: ["I32", null, 3], "normals?": ["F32", null, 3] },
  implicit: { ops: ["U8", null], operands: ["U32", null, 3], values: ["F64", null], "bounds?": ["F64", 2, 3] },
  brep: {
    faces: ["I32", null, 5], control_points: ["F64", null, 4], knots: ["F64", null], loops: ["I32", null],
    trims: ["I32", null, 2], trim_control_points: ["F64", null, 3], trim_knots: ["F64", null], "tolerance?": ["F64", 1],
  },
  tube: { control_points: ["F64", null, 3], knots: ["F64", null], radii: ["F64", null], "weights?": ["F64", null] },
};

/**
 * @param {Core} core that checks what it knows best
 * @param {ArrayBuffer} bytes which the scene's arrays are views of, and which is no whole file afterwards
 * @returns {SceneDescription}
 */
export function readBob(core, bytes) {
  const all = new Uint8Array(bytes), text = new TextDecoder();
  if (text.decode(all.subarray(8, DIGITS)) !== START) {
    const start = brief(text.decode(all.subarray(0, 32)));
    throw new CoreError(`expected a ${FORMAT} file, got one that starts with ${start}`);
  }
  const checksum = text.decode(all.subarray(DIGITS, BODY));
  all.fill("0".charCodeAt(0), DIGITS, BODY);
  if (checksum !== hex(core.sha256(all))) {
    throw new CoreError("expected a whole file, got one that was damaged or cut short: its checksum differs");
  }
  const size = Number(new DataView(bytes).getBigUint64(0, true));
  const { __metadata__: metadata, ...tensors } = JSON.parse(text.decode(all.subarray(8, 8 + size)));
  if (metadata.format !== FORMAT) throw new CoreError(`expected the format ${FORMAT}, got ${brief(metadata.format)}`);
  if (metadata.version !== VERSION) {
    const got = brief(metadata.version);
    throw new CoreError(`expected version ${VERSION}, got ${got}; was it written by a newer release?`);
  }
  const content = checkFields("scene", JSON.parse(metadata.scene), "shapes", "instances");
  const kinds = checkList("shapes", content.shapes);
  const shapes = kinds.map((kind, i) => placedErrors(`shapes[${i}]`, () => {
    return readShape(core, kind, ownTensors(i, tensors), bytes, 8 + size);
  }));
  checkNames(tensors, kinds.length);
  const instances = checkList("instances", content.instances);
  return { shapes, instances: instances.map((item, i) => readInstance(core, `instances[${i}]`, item, shapes.length)) };
}

/** @param {Record<string, any>} tensors @param {number} count */
function checkNames(tensors, count) {
  for (const name of Object.keys(tensors)) {
    const number = /^(\d+)\../.exec(name)?.[1];
    if (number === undefined || Number(number) >= count) {
      throw new CoreError(`${name}: expected tensors of ${count} shapes, named NUMBER.NAME, got this one`);
    }
  }
}

/**
 * Those of a shape, by their own names.
 *
 * @param {number} number
 * @param {Record<string, any>} tensors
 * @returns {Record<string, any>}
 */
function ownTensors(number, tensors) {
  const prefix = `${number}.`, own = Object.entries(tensors).filter(([name]) => name.startsWith(prefix));
  return Object.fromEntries(own.map(([name, entry]) => [name.slice(prefix.length), entry]));
}

/**
 * @param {Core} core
 * @param {any} kind
 * @param {Record<string, any>} entries
 * @param {ArrayBuffer} bytes
 * @param {number} start of the tensors
 * @returns {ShapeDescription}
 */
function readShape(core, kind, entries, bytes, start) {
  if (!Object.hasOwn(KINDS, kind)) {
    throw new CoreError(`expected a kind among ${Object.keys(KINDS).join(", ")}, got ${brief(kind)}`);
  }
  /** @type {Record<string, any>} */
  const shape = { kind };
  for (const [key, [dtype, ...axes]] of Object.entries(KINDS[kind])) {
    const name = key.replace("?", ""), entry = entries[name];
    delete entries[name];
    if (entry) shape[name] = readTensor(name, entry, dtype, axes, bytes, start);
    else if (name === key) throw new CoreError(`${name}: expected an array of ${dtype}, got none`);
  }
  const [unknown] = Object.keys(entries);
  if (unknown) throw new CoreError(`${unknown}: expected only the arrays of a ${kind}, got this as well`);
  checkShape(core, /** @type {ShapeDescription} */ (shape));
  return /** @type {ShapeDescription} */ (shape);
}

/**
 * @param {string} name
 * @param {any} entry
 * @param {string} dtype
 * @param {(number | null)[]} axes
 * @param {ArrayBuffer} bytes
 * @param {number} start
 */
function readTensor(name, entry, dtype, axes, bytes, start) {
  if (entry.dtype !== dtype) throw new CoreError(`${name}: expected ${dtype}, got ${brief(entry.dtype)}`);
  const shape = checkList(name, entry.shape), [begin, end] = checkList(name, entry.data_offsets);
  if (shape.length !== axes.length || !axes.every((want, axis) => want === null || want === shape[axis])) {
    const wanted = axes.map((want) => want ?? "n").join(", ");
    throw new CoreError(`${name}: expected shape (${wanted}), got (${shape.join(", ")})`);
  }
  const type = TYPES[dtype], count = shape.reduce((product, size) => product * size, 1);
  if (!(begin >= 0 && end - begin === count * type.BYTES_PER_ELEMENT && start + end <= bytes.byteLength)) {
    throw new CoreError(`${name}: expected ${count} items within the file, got bytes ${begin} to ${end}`);
  }
  const at = start + begin;
  return at % type.BYTES_PER_ELEMENT ? new type(bytes.slice(at, start + end))
    : new /** @type {any} */ (type)(bytes, at, count);
}

/** Throws a CoreError unless numbers are those of a shape. @param {Core} core @param {ShapeDescription} shape */
function checkShape(core, shape) {
  switch (shape.kind) {
    case "mesh": {
      checkFinite("vertices", shape.vertices);
      if (!shape.triangles.length) throw new CoreError("triangles: expected at least one triangle, got none");
      const count = shape.vertices.length / 3, wrong = shape.triangles.find((index) => !(index >= 0 && index < count));
      if (wrong !== undefined) throw new CoreError(`triangles: expected indices in 0..${count - 1}, got ${wrong}`);
      if (shape.normals && shape.normals.length !== shape.vertices.length) {
        throw new CoreError(`normals: expected one for each of ${count} vertices, got ${shape.normals.length / 3}`);
      }
      return;
    }
    case "implicit": {
      const { ops, operands, values, bounds } = shape;
      if (operands.length !== 3 * ops.length || values.length !== ops.length) {
        throw new CoreError("formula: expected ops, operands and values of one length");
      }
      if (bounds && !(checkFinite("bounds", bounds) && [0, 1, 2].every((axis) => bounds[axis] < bounds[axis + 3]))) {
        throw new CoreError(`bounds: expected each low below its high, got ${bounds.join(", ")}`);
      }
      return placedErrors("formula", () => core.checkNodes(ops, operands, values));
    }
    case "brep": return checkBrep(shape);
    case "tube": return checkTube(shape);
  }
}

/**
 * @param {Core} core
 * @param {string} place
 * @param {any} item
 * @param {number} shapes how many there are
 * @returns {InstanceDescription}
 */
function readInstance(core, place, item, shapes) {
  const { shape, transform, material, name } = checkFields(place, item, "shape", "transform", "material", "name");
  checkInteger(`${place}.shape`, shape, 0, shapes - 1);
  const rows = checkList(`${place}.transform`, transform).flatMap((row) => checkList(`${place}.transform`, row));
  if (rows.length !== 16) {
    throw new CoreError(`${place}.transform: expected four rows of four numbers, got ${rows.length}`);
  }
  checkFinite(`${place}.transform`, rows);
  if (rows.slice(12).join() !== "0,0,0,1") {
    const last = rows.slice(12).join(", ");
    throw new CoreError(`${place}.transform: expected an affine map, whose last row is (0, 0, 0, 1), got (${last})`);
  }
  const [largest, , smallest] = core.singularValues(rows);
  if (!(smallest > FLATTEST * largest)) {
    throw new CoreError(`${place}.transform: expected a map that keeps all three dimensions, got one that is singular`);
  }
  const of = `${place}.material`;
  checkFields(of, material, "color", "ambient", "diffuse", "specular", "shininess");
  const { color, ambient, diffuse, specular, shininess } = material;
  if (checkList(`${of}.color`, color).length !== 3) {
    throw new CoreError(`${of}.color: expected 3 numbers, got ${color.length}`);
  }
  for (const value of color) checkNumber(`${of}.color`, value, 0, 1);
  for (const [field, value] of Object.entries({ ambient, diffuse, specular })) {
    checkNumber(`${of}.${field}`, value, 0, 1);
  }
  checkNumber(`${of}.shininess`, shininess, 0, 10_000);
  if (name !== null && typeof name !== "string") {
    throw new CoreError(`${place}.name: expected a string, got ${brief(name)}`);
  }
  return { shape, transform: rows, material: { color, ambient, diffuse, specular, shininess }, name };
}

/** @param {Uint8Array} bytes */
function hex(bytes) {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
