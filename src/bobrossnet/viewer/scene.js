// @ts-check
/**
 * Scenes as plain objects, which messages between workers can carry, and what the core makes of them.
 *
 * @typedef {{kind: "mesh", vertices: Float64Array, triangles: Int32Array, normals?: Float32Array}} MeshDescription
 *   (V, 3), (T, 3) and (V, 3)
 * @typedef {{kind: "implicit", ops: Uint8Array, operands: Uint32Array, values: Float64Array, bounds?: Float64Array}}
 *   ImplicitDescription
 * @typedef {{kind: "script", source: string}} ScriptDescription of docs/scripts.md
 * @typedef {{kind: "formula", text: string, bounds?: ArrayLike<number>}} FormulaDescription of a .vm file
 * @typedef {{kind: "brep"} & import("./splines.js").BrepTensors} BrepDescription
 * @typedef {{kind: "tube"} & import("./splines.js").TubeTensors} TubeDescription
 * @typedef {MeshDescription | ImplicitDescription | ScriptDescription | FormulaDescription | BrepDescription |
 *   TubeDescription}
 *   ShapeDescription arrays as in scene files (CONVENTIONS.md)
 *
 * @typedef {{color: ArrayLike<number>, ambient: number, diffuse: number, specular: number, shininess: number}} Material
 *   linear RGB
 * @typedef {{shape: number, transform?: ArrayLike<number>, material?: Material, name?: string | null}}
 *   InstanceDescription
 *   shape: which of the shapes; transform: (4, 4), from its units to the scene's, by default where it is; white by
 *   default
 * @typedef {{shapes: ShapeDescription[], instances: InstanceDescription[], warnings?: string[]}} SceneDescription
 *   warnings: what of a file was left out or is not shown as it is, a line each
 */

import { IDENTITY, UPRIGHT, product } from "./affine.js";
import { CoreError, placedErrors } from "./errors.js";
import { brep, tube } from "./splines.js";

/**
 * @typedef {import("./core.js").Core} Core
 * @typedef {import("./core.js").Shape} Shape
 * @typedef {ReturnType<Core["scene"]>} BuiltScene whoever asked for it frees it
 */

/** Numbers in a row of an array, where these are not single. @type {Record<string, Record<string, number>>} */
const COLUMNS = {
  mesh: { vertices: 3, triangles: 3, normals: 3 },
  implicit: { operands: 3, bounds: 3 },
  brep: { faces: 5, control_points: 4, trims: 2, trim_control_points: 3 },
  tube: { control_points: 3 },
};

/** As bobrossnet.Material(). @type {Material} */
export const WHITE = { color: [1, 1, 1], ambient: 0.1, diffuse: 0.7, specular: 0.2, shininess: 32 };

/**
 * A scene of one shape, where its own coordinates say.
 *
 * @param {ShapeDescription} shape
 * @param {string | null} [name]
 * @returns {SceneDescription}
 */
export function sceneOf(shape, name = null) {
  return { shapes: [shape], instances: [{ shape: 0, transform: IDENTITY, material: WHITE, name }] };
}

/**
 * The same scene with what is stored as y up turned to z up, as bobrossnet.Scene.turned_upright.
 *
 * @param {SceneDescription} scene
 * @returns {SceneDescription}
 */
export function turnedUpright(scene) {
  const instances = scene.instances.map((instance) => ({
    ...instance, transform: product(UPRIGHT, instance.transform ?? IDENTITY),
  }));
  return { ...scene, instances };
}

/**
 * Red, green, blue, ambient, diffuse, specular and shininess.
 *
 * @param {Material} material
 */
export function materialValues({ color, ambient, diffuse, specular, shininess }) {
  return [...Array.from(color), ambient, diffuse, specular, shininess];
}

/**
 * The same scene with its instances in the order in which the core must get them, so that pictures do not depend on that in a
 * file. Scripts and .vm formulas count by their texts.
 *
 * @param {Core} core
 * @param {SceneDescription} scene
 * @returns {SceneDescription}
 */
export function inCanonicalOrder(core, scene) {
  const { shapes, instances } = scene;
  if (instances.length < 2) return scene;
  const digests = shapes.map(({ kind, ...fields }) => {
    return core.shapeDigest(kind, Object.entries(fields).map(([name, value]) => [name, value, COLUMNS[kind]?.[name] ?? 0]));
  });
  const order = core.canonicalOrder(instances.map(({ shape, transform = IDENTITY, material = WHITE }) => {
    return { digest: digests[shape], transform, material: materialValues(material) };
  }));
  return { ...scene, instances: order.map((i) => instances[i]) };
}

/**
 * The scene in the core. Where surfaces coincide, the first of the instances is seen.
 *
 * @param {Core} core
 * @param {SceneDescription} description
 * @returns {BuiltScene}
 * @throws {CoreError} of one line, if a shape has no surface, is not bounded, or is none
 */
export function buildScene(core, { shapes: descriptions, instances }) {
  if (!instances.length) throw new CoreError("shapes: expected at least one shape, got none");
  /** @type {Shape[]} */
  const shapes = [];
  try {
    descriptions.forEach((description, i) => {
      const make = () => makeShape(core, description);
      shapes.push(descriptions.length > 1 ? placedErrors(`shapes[${i}]`, make) : make());
    });
    return core.scene(instances.map(({ shape, transform = IDENTITY, material = WHITE }) => {
      return { shape: shapes[shape], transform, material: materialValues(material) };
    }));
  } finally {
    for (const shape of shapes) shape.free();
  }
}

/** @param {Core} core @param {ShapeDescription} description @returns {Shape} */
function makeShape(core, description) {
  switch (description.kind) {
    case "mesh": return core.mesh(description.vertices, description.triangles, description.normals);
    case "implicit": {
      const { ops, operands, values, bounds } = description;
      return core.implicit(ops, operands, values, bounds);
    }
    case "script": return core.script(description.source);
    case "formula": return core.formula(description.text, description.bounds);
    case "brep": return brep(core, description);
    case "tube": return tube(core, description);
  }
}
