// @ts-check
/**
 * The canonical order of a scene's instances, required by the core. Sorts by SHA-256 of their contents, as in Python,
 * so that pictures do not depend on the order in a file. Scripts and .vm formulas are hashed as texts.
 */

import { sha256 } from "../core/sha256.js";
import { IDENTITY } from "../shapes/affine.js";
import { OfPictures } from "../shapes/picture.js";
import { WHITE, materialValues } from "./description.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("./description.js").SceneDescription} SceneDescription
 * @typedef {import("../shapes/description.js").ShapeDescription} ShapeDescription
 */

/** numpy's names of array types. */
const DTYPES = new Map(/** @type {[Function, string][]} */ ([
  [Float64Array, "<f8"], [Float32Array, "<f4"], [Int32Array, "<i4"], [Uint32Array, "<u4"], [Uint8Array, "|u1"],
]));

/** Columns of two-dimensional arrays. @type {Record<string, Record<string, number>>} */
const COLUMNS = {
  mesh: { vertices: 3, triangles: 3, normals: 3, colors: 3, face_colors: 3, uv: 2 },
  picture: { texels: 3 },
  implicit: { operands: 3, bounds: 3, color_operands: 3 },
  brep: { faces: 5, control_points: 4, trims: 2, trim_control_points: 3, face_colors: 3 },
  tube: { control_points: 3 },
};

/**
 * The scene with its instances in canonical order.
 *
 * @param {Core} core @param {SceneDescription} scene @returns {Promise<SceneDescription>}
 */
export async function inCanonicalOrder(core, scene) {
  const { shapes, instances } = scene, count = instances.length;
  if (count < 2) return scene;
  /** @type {OfPictures<Promise<Uint8Array>>} */
  const pictures = new OfPictures();
  const digests = await Promise.all(shapes.map((shape) => shapeDigest(core, shape, pictures)));
  const digest = instances.flatMap(({ shape }) => Array.from(digests[shape]));
  const transform = instances.flatMap(({ transform = IDENTITY }) => Array.from(transform));
  const material = instances.flatMap(({ material = WHITE }) => materialValues(material));
  const order = core.filled(new Int32Array(count), (address) => {
    core.made("canonical_order", Uint8Array.from(digest), Float64Array.from(transform), Float64Array.from(material), count, address);
  });
  return { ...scene, instances: Array.from(order, (i) => ({ number: i, ...instances[i] })) };
}

/**
 * The digest of core/tracing/canonical.h. A picture is hashed separately, as in bobrossnet.shapes.mesh.
 *
 * @param {Core} core
 * @param {ShapeDescription} description
 * @param {OfPictures<Promise<Uint8Array>>} pictures
 * @returns {Promise<Uint8Array>} (32,)
 */
async function shapeDigest(core, description, pictures) {
  if (description.kind !== "mesh" || !description.texture) return digestOf(core, description);
  const { texture: texels, texture_alpha: alpha, ...apart } = description;
  const picture = pictures.get(description, () => digestOf(core, { kind: "picture", texels, ...(alpha && { alpha }) }));
  return digestOf(core, { ...apart, picture: await picture });
}

/** @param {Core} core @param {{kind: string} & Record<string, any>} description @returns {Promise<Uint8Array>} (32,) */
function digestOf(core, { kind, ...fields }) {
  const encoder = new TextEncoder(), parts = [encoder.encode(kind)];
  for (const [name, value] of Object.entries(fields).sort(([a], [b]) => (a < b ? -1 : 1))) {
    if (ArrayBuffer.isView(value)) {
      const array = /** @type {Float64Array<ArrayBuffer>} */ (value), columns = COLUMNS[kind]?.[name];
      const shape = columns ? `(${array.length / columns}, ${columns})` : `(${array.length},)`;
      parts.push(encoder.encode(`${name} ${DTYPES.get(array.constructor)} ${shape}`));
      parts.push(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    } else {
      parts.push(encoder.encode(`${name} ${value}`));
    }
  }
  return sha256(core, ...parts);
}
