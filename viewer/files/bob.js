// @ts-check
/** Scene files, .bob (docs/reference/scene-files.md has their fields): whatever is not as written by bobrossnet is refused. */

import {
  CoreError, brief, checkFields, checkFinite, checkInteger, checkList, checkNumber, placedErrors,
} from "../core/errors.js";
import { sha256 } from "../core/sha256.js";
import { isSingular } from "../shapes/affine.js";
import { checkNodes } from "../shapes/implicit.js";
import { checkBrep, checkCoordinates, checkTube } from "../shapes/splines.js";
import { WHITE } from "../tracing/description.js";
import { ENVIRONMENT, readLights } from "./lights.js";
import { readContainer, readTensor } from "./safetensors.js";
import { Pictures } from "./surface.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../shapes/description.js").ShapeDescription} ShapeDescription
 * @typedef {import("../tracing/description.js").SceneDescription} SceneDescription
 * @typedef {import("../tracing/description.js").InstanceDescription} InstanceDescription
 * @typedef {import("./safetensors.js").Container} Container
 */

const FORMAT = "bobrossnet-scene", VERSIONS = ["1", "2", "3", "4", "5", "6", "7", "8"];

/** Bytes of JSON that readers of safetensors take, as bobrossnet.adapters.container.MAX_HEADER. */
const MAX_HEADER = 100_000_000;

/** As bob::max_ior in core/tracing/material.h. */
const MAX_IOR = 100;

/** The checksum comes first: of the whole file, with its own digits taken as zeros. */
const START = '{"__metadata__":{"sha256":"', DIGITS = 8 + START.length, BODY = DIGITS + 64;

/**
 * A tensor's type: dtype, and the length of each axis; optional ones end in "?".
 *
 * @type {Record<string, Record<string, [string, ...(number | null)[]]>>}
 */
const KINDS = {
  mesh: {
    vertices: ["F64", null, 3], triangles: ["I32", null, 3], "normals?": ["F32", null, 3], "colors?": ["F32", null, 3],
    "face_colors?": ["F32", null, 3], "uv?": ["F32", null, 2], "texture?": ["U8", null, 3], "texture_layout?": ["I32", 4],
    "alphas?": ["F32", null], "texture_alpha?": ["U8", null], "alpha_cutoff?": ["F64", 1],
    "texture_of?": ["I32", 1],
  },
  implicit: {
    ops: ["U8", null], operands: ["U32", null, 3], values: ["F64", null], "bounds?": ["F64", 2, 3],
    "color_ops?": ["U8", null], "color_operands?": ["U32", null, 3], "color_values?": ["F64", null], "color_roots?": ["U32", 3],
    "mesh_sizes?": ["U32", null, 2], "mesh_vertices?": ["F32", null, 3], "mesh_triangles?": ["U32", null, 3],
    "color_mesh_sizes?": ["U32", null, 2], "color_mesh_vertices?": ["F32", null, 3], "color_mesh_triangles?": ["U32", null, 3],
  },
  brep: {
    faces: ["I32", null, 5], control_points: ["F64", null, 4], knots: ["F64", null], loops: ["I32", null],
    trims: ["I32", null, 2], trim_control_points: ["F64", null, 3], trim_knots: ["F64", null], "tolerance?": ["F64", 1],
    "face_colors?": ["F32", null, 3], "face_numbers?": ["I32", null],
  },
  tube: { control_points: ["F64", null, 3], knots: ["F64", null], radii: ["F64", null], "weights?": ["F64", null] },
};

/**
 * @param {Core} core checks shapes and instances
 * @param {ArrayBuffer} bytes which the scene's arrays are views of, and which are not a valid file afterwards
 * @returns {Promise<SceneDescription>}
 */
export async function readBob(core, bytes) {
  const all = new Uint8Array(bytes), text = new TextDecoder();
  if (text.decode(all.subarray(8, DIGITS)) !== START) {
    const start = brief(text.decode(all.subarray(0, 32)));
    throw new CoreError(`expected a ${FORMAT} file, got one that starts with ${start}`);
  }
  const size = new DataView(bytes).getBigUint64(0, true);
  if (size > MAX_HEADER) {
    const most = MAX_HEADER.toLocaleString("en");
    throw new CoreError(`expected at most ${most} bytes of places, materials, names and shapes' entries, got ${size.toLocaleString("en")}`);
  }
  const checksum = text.decode(all.subarray(DIGITS, BODY));
  all.fill("0".charCodeAt(0), DIGITS, BODY);
  if (checksum !== hex(await sha256(core, all))) {
    throw new CoreError("expected a whole file, got one that was damaged or cut short: its checksum differs");
  }
  const container = readContainer(bytes), { metadata, entries } = container;
  if (metadata.format !== FORMAT) throw new CoreError(`expected the format ${FORMAT}, got ${brief(metadata.format)}`);
  if (!VERSIONS.includes(metadata.version)) {
    const got = brief(metadata.version);
    throw new CoreError(`expected version ${VERSIONS.slice(0, -1).join(", ")} or ${VERSIONS.at(-1)}, got ${got}; was it written by a newer release?`);
  }
  const content = checkFields("scene", JSON.parse(metadata.scene), "shapes", "instances");
  const instances = checkList("instances", content.instances);
  core.made("check_instances", "instances", instances.length);
  const kinds = checkList("shapes", content.shapes), { [ENVIRONMENT]: image, ...ofShapes } = entries;
  const { lights, warnings } = readLights(metadata.light, image && checkedTensor(container, ENVIRONMENT, image, "F32", [null, null, 3]), image?.shape);
  /** @type {ShapeDescription[]} */
  const shapes = [], pictures = new Pictures();
  kinds.forEach((kind, i) => placedErrors(`shapes[${i}]`, () => {
    const shape = readTensors(kind, ownTensors(i, ofShapes), container);
    if (kind === "mesh") share(shape, shapes, pictures);
    checkShape(core, shape);
    shapes.push(shape);
  }));
  checkNames(ofShapes, kinds.length);
  const { unit, hasFront, pieces } = readParts(metadata.parts, instances.length);
  return {
    shapes, unit, hasFront, lights, warnings, instances: instances.map((item, i) => ({ ...readInstance(core, `instances[${i}]`, item, shapes.length), pieces: pieces[i] })),
  };
}

/**
 * The unit, and the pieces of each instance.
 *
 * @param {string | undefined} text
 * @param {number} count of instances
 * @returns {{unit: string | null, hasFront: boolean, pieces: import("../tracing/scene.js").Label["pieces"][]}}
 */
function readParts(text, count) {
  if (text === undefined) return { unit: null, hasFront: false, pieces: Array.from({ length: count }, () => []) };
  const content = checkFields("parts", JSON.parse(text), "unit", "has_front", "pieces"), pieces = checkList("parts.pieces", content.pieces);
  if (pieces.length !== count) throw new CoreError(`parts.pieces: expected one entry for each of ${count} instances, got ${pieces.length}`);
  if (content.unit !== null && typeof content.unit !== "string") throw new CoreError(`parts.unit: expected a string, got ${brief(content.unit)}`);
  for (const own of pieces) checkList("parts.pieces", own).forEach(checkPiece);
  if (typeof content.has_front !== "boolean") throw new CoreError(`parts.has_front: expected true or false, got ${brief(content.has_front)}`);
  return { unit: content.unit, hasFront: content.has_front, pieces };
}

/** @param {any} piece */
function checkPiece(piece) {
  const [path, count] = checkList("parts.pieces", piece);
  if (piece.length !== 2 || !checkList("parts.pieces", path).length || !path.every((/** @type {unknown} */ name) => typeof name === "string")) {
    throw new CoreError("parts.pieces: expected pairs of a path and a count");
  }
  if (count !== null) checkInteger("parts.pieces", count, 1, 2 ** 31 - 1);
}

/** @param {Record<string, any>} tensors @param {number} count */
function checkNames(tensors, count) {
  for (const name of Object.keys(tensors)) {
    const number = /^(\d+)\../.exec(name)?.[1];
    if (number === undefined || Number(number) >= count) {
      throw new CoreError(`${name}: expected tensors of ${count} shapes, named NUMBER.NAME, got another name`);
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
 * Shares an earlier mesh's texture with a mesh that refers to it. Counts the texels of an own texture.
 *
 * @param {any} mesh
 * @param {ShapeDescription[]} before
 * @param {Pictures} pictures
 */
function share(mesh, before, pictures) {
  const { texture_of, texture, texture_alpha, texture_layout } = mesh;
  delete mesh.texture_of;
  if (!texture_of) return texture && pictures.count(texture.length / 3, 1);
  const of = before[texture_of[0]];
  if (of?.kind !== "mesh" || !of.texture) {
    throw new CoreError(`texture_of: expected the number of an earlier shape with a texture, got ${texture_of[0]}`);
  }
  if (texture || texture_alpha) throw new CoreError("texture: expected only that of an earlier shape, got an extra one");
  if (texture_layout && [0, 1].some((axis) => texture_layout[axis] !== of.texture_layout?.[axis])) {
    throw new CoreError(`texture_layout: expected height, width and two of 0, 1, 2, got ${texture_layout.join(", ")}`);
  }
  Object.assign(mesh, { texture: of.texture }, of.texture_alpha && { texture_alpha: of.texture_alpha });
}

/**
 * @param {any} kind
 * @param {Record<string, any>} entries
 * @param {Container} container
 * @returns {ShapeDescription} unchecked
 */
function readTensors(kind, entries, container) {
  if (!Object.hasOwn(KINDS, kind)) {
    throw new CoreError(`expected a kind among ${Object.keys(KINDS).join(", ")}, got ${brief(kind)}`);
  }
  /** @type {Record<string, any>} */
  const shape = { kind };
  for (const [key, [dtype, ...axes]] of Object.entries(KINDS[kind])) {
    const name = key.replace("?", ""), entry = entries[name];
    delete entries[name];
    if (entry) shape[name] = checkedTensor(container, name, entry, dtype, axes);
    else if (name === key) throw new CoreError(`${name}: expected an array of ${dtype}, got none`);
  }
  const [unknown] = Object.keys(entries);
  if (unknown) throw new CoreError(`${unknown}: expected only the arrays of a ${kind}, got an extra one`);
  return /** @type {ShapeDescription} */ (shape);
}

/**
 * @param {Container} container
 * @param {string} name
 * @param {any} entry
 * @param {string} dtype
 * @param {(number | null)[]} axes
 */
function checkedTensor(container, name, entry, dtype, axes) {
  if (entry.dtype !== dtype) throw new CoreError(`${name}: expected ${dtype}, got ${brief(entry.dtype)}`);
  const shape = checkList(name, entry.shape);
  if (shape.length !== axes.length || !axes.every((want, axis) => want === null || want === shape[axis])) {
    const wanted = axes.map((want) => want ?? "n").join(", ");
    throw new CoreError(`${name}: expected shape (${wanted}), got (${shape.join(", ")})`);
  }
  return readTensor(container, name, entry);
}

/** Throws a CoreError unless numbers describe a shape. @param {Core} core @param {ShapeDescription} shape */
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
      checkColors(shape);
      return checkAlphas(shape);
    }
    case "implicit": {
      const { ops, operands, values, bounds, color_ops, color_operands, color_values, color_roots } = shape;
      checkNodeCounts("formula", ops, operands, values);
      if (color_ops || color_operands || color_values || color_roots) {
        if (!color_ops || !color_operands || !color_values || !color_roots) {
          throw new CoreError("color: expected color_ops, color_operands, color_values and color_roots together");
        }
        checkNodeCounts("color", color_ops, color_operands, color_values);
      } else if (shape.color_mesh_sizes) throw new CoreError("color: expected a formula with its meshes, got these alone");
      for (const of of /** @type {const} */ (["", "color_"])) {
        if (new Set([shape[`${of}mesh_sizes`], shape[`${of}mesh_vertices`], shape[`${of}mesh_triangles`]].map(Boolean)).size > 1) {
          throw new CoreError(`${of}mesh_sizes: expected ${of}mesh_sizes, ${of}mesh_vertices and ${of}mesh_triangles together`);
        }
      }
      if (bounds) checkCoordinates("bounds", bounds);
      if (bounds && ![0, 1, 2].every((axis) => bounds[axis] < bounds[axis + 3])) {
        throw new CoreError(`bounds: expected each low below its high, got ${bounds.join(", ")}`);
      }
      return checkNodes(core, shape);
    }
    case "brep": return checkBrep(shape);
    case "tube": return checkTube(shape);
  }
}

/** @param {string} name @param {Uint8Array} ops @param {Uint32Array} operands @param {Float64Array} values */
function checkNodeCounts(name, ops, operands, values) {
  if (operands.length !== 3 * ops.length || values.length !== ops.length) {
    throw new CoreError(`${name}: expected ops, operands and values of one length`);
  }
}

/** Throws a CoreError unless a mesh has as many colours as it needs. @param {import("../shapes/description.js").MeshDescription} mesh */
function checkColors({ vertices, triangles, colors, face_colors, uv, texture, texture_layout }) {
  for (const [name, values, of] of /** @type {const} */ ([["colors", colors, vertices], ["face_colors", face_colors, triangles]])) {
    if (values && values.length !== of.length) throw new CoreError(`${name}: expected ${of.length / 3}, got ${values.length / 3}`);
    if (values?.some((value) => !(value >= 0 && value <= 1))) throw new CoreError(`${name}: expected numbers in 0..1`);
  }
  if (!uv && !texture && !texture_layout) return;
  if (!uv || !texture || !texture_layout) throw new CoreError("uv: expected uv, texture and texture_layout together");
  checkFinite("uv", uv);
  if (3 * uv.length !== 2 * vertices.length) throw new CoreError(`uv: expected one for each vertex, got ${uv.length / 2}`);
  const [height, width, ...wraps] = texture_layout;
  if (!(height > 0 && width > 0 && 3 * height * width === texture.length && wraps.every((wrap) => wrap >= 0 && wrap <= 2))) {
    throw new CoreError(`texture_layout: expected height, width and two of 0, 1, 2, got ${texture_layout.join(", ")}`);
  }
}

/** Throws a CoreError unless a mesh's alphas belong to its colours. @param {import("../shapes/description.js").MeshDescription} mesh */
function checkAlphas({ colors, texture, alphas, texture_alpha, alpha_cutoff }) {
  if (!alpha_cutoff !== !(alphas || texture_alpha)) throw new CoreError("alpha_cutoff: expected alphas or texture_alpha together with it");
  if (alphas && 3 * alphas.length !== (colors?.length ?? 0)) throw new CoreError(`alphas: expected one for each colour, got ${alphas.length}`);
  if (texture_alpha && 3 * texture_alpha.length !== (texture?.length ?? 0)) {
    throw new CoreError(`texture_alpha: expected one for each texel, got ${texture_alpha.length}`);
  }
  for (const [name, values] of Object.entries({ alphas, alpha_cutoff })) {
    if (values?.some((/** @type {number} */ value) => !(value >= 0 && value <= 1))) throw new CoreError(`${name}: expected numbers in 0..1`);
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
  if (isSingular(core, rows)) {
    throw new CoreError(`${place}.transform: expected a map that keeps all three dimensions, got one that is singular`);
  }
  const checked = checkMaterial(`${place}.material`, material);
  if (name !== null && typeof name !== "string") {
    throw new CoreError(`${place}.name: expected a string, got ${brief(name)}`);
  }
  return { shape, transform: rows, material: checked, name };
}

/** @param {string} of @param {any} material @returns {import("../tracing/description.js").Material} */
function checkMaterial(of, material) {
  const has = (/** @type {string} */ field) => material && typeof material === "object" && field in material;
  if (has("transmission")) return checkGlass(of, material);
  const physical = has("roughness") ? ["metallic", "roughness", "emissive"] : [];
  const coat = physical.length && has("clearcoat") ? ["clearcoat", "clearcoat_roughness"] : [];
  checkFields(of, material, "color", "ambient", "diffuse", "specular", "shininess", ...physical, ...coat);
  const { color, ambient, diffuse, specular, shininess, metallic, roughness, emissive = [0, 0, 0] } = material;
  checkLinear(of, { color, emissive });
  const shares = roughness == null && metallic == null ? { ambient, diffuse, specular } : { ambient, diffuse, specular, metallic, roughness };
  for (const [field, value] of Object.entries(shares)) checkNumber(`${of}.${field}`, value, 0, 1);
  for (const field of coat) checkNumber(`${of}.${field}`, material[field], 0, 1);
  checkNumber(`${of}.shininess`, shininess, 0, 10_000);
  return material;
}

/** @param {string} of @param {any} glass @returns {import("../tracing/description.js").Material} */
function checkGlass(of, glass) {
  checkFields(of, glass, "color", "roughness", "emissive", "transmission", "ior", "attenuation", "distance", "thin");
  const { color, roughness, emissive, transmission, ior, attenuation, distance, thin } = glass;
  checkLinear(of, { color, emissive, attenuation });
  for (const [field, value] of Object.entries({ roughness, transmission })) checkNumber(`${of}.${field}`, value, 0, 1);
  checkNumber(`${of}.ior`, ior, 1, MAX_IOR);
  if (distance !== null) checkNumber(`${of}.distance`, distance, Number.MIN_VALUE, Number.MAX_VALUE);
  if (typeof thin !== "boolean") throw new CoreError(`${of}.thin: expected true or false, got ${brief(thin)}`);
  return { ...WHITE, ...glass, metallic: 0, distance: distance ?? Infinity };
}

/** @param {string} of @param {Record<string, any>} colors linear RGB */
function checkLinear(of, colors) {
  for (const [field, rgb] of Object.entries(colors)) {
    if (checkList(`${of}.${field}`, rgb).length !== 3) throw new CoreError(`${of}.${field}: expected 3 numbers, got ${rgb.length}`);
    for (const value of rgb) checkNumber(`${of}.${field}`, value, 0, 1);
  }
}

/** @param {Uint8Array} bytes */
function hex(bytes) {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
