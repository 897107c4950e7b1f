// @ts-check
/**
 * The canonical order of a scene's instances, in which the core must get them: by SHA-256 of what they are, as Python's
 * Scene has it, so that pictures do not depend on the order in a file. Scripts and .vm formulas count by their texts.
 */

import { IDENTITY } from "../shapes/affine.js";
import { WHITE, materialValues } from "./description.js";
import { Sha256 } from "./sha256.js";

/**
 * @typedef {import("./description.js").SceneDescription} SceneDescription
 * @typedef {import("../shapes/description.js").ShapeDescription} ShapeDescription
 */

/** How arrays are called in Python. */
const TYPES = new Map(/** @type {[Function, string][]} */ ([
  [Float64Array, "<f8"], [Float32Array, "<f4"], [Int32Array, "<i4"], [Uint32Array, "<u4"], [Uint8Array, "|u1"],
]));

/** Numbers in a row of an array, where these are not single. @type {Record<string, Record<string, number>>} */
const WIDTHS = {
  mesh: { vertices: 3, triangles: 3, normals: 3 },
  implicit: { operands: 3, bounds: 3 },
  brep: { faces: 5, control_points: 4, trims: 2, trim_control_points: 3 },
  tube: { control_points: 3 },
};

/** The same scene with its instances in their order. @param {SceneDescription} scene @returns {SceneDescription} */
export function inCanonicalOrder(scene) {
  const { shapes, instances } = scene;
  if (instances.length < 2) return scene;
  const digests = shapes.map(shapeDigest);
  const keyed = instances.map((instance) => {
    const { shape, transform = IDENTITY, material = WHITE } = instance;
    const seen = Float64Array.of(...Array.from(transform), ...materialValues(material));
    return { instance, key: new Sha256().update(digests[shape]).update(new Uint8Array(seen.buffer)).digest() };
  });
  keyed.sort((a, b) => compare(a.key, b.key));
  return { ...scene, instances: keyed.map(({ instance }) => instance) };
}

/** @param {ShapeDescription} description @returns {Uint8Array} */
function shapeDigest({ kind, ...fields }) {
  const text = new TextEncoder(), hash = new Sha256().update(text.encode(kind));
  for (const [name, value] of Object.entries(fields).sort(([a], [b]) => (a < b ? -1 : 1))) {
    if (!ArrayBuffer.isView(value)) {
      hash.update(text.encode(`${name} ${value}`));
      continue;
    }
    const array = /** @type {Float64Array} */ (value), width = WIDTHS[kind]?.[name];
    const shape = width ? `(${array.length / width}, ${width})` : `(${array.length},)`;
    hash.update(text.encode(`${name} ${TYPES.get(array.constructor)} ${shape}`));
    hash.update(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
  }
  return hash.digest();
}

/** @param {Uint8Array} a @param {Uint8Array} b */
function compare(a, b) {
  const at = a.findIndex((byte, i) => byte !== b[i]);
  return at < 0 ? 0 : a[at] - b[at];
}
