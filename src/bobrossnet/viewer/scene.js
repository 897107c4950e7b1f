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

import { IDENTITY, UPRIGHT, fromUnitSphere, inverse, product, toUnitSphere } from "./affine.js";
import { CoreError, placedErrors } from "./errors.js";
import { brep, tube } from "./splines.js";

/**
 * @typedef {import("./core.js").Core} Core
 * @typedef {import("./core.js").Shape} Shape
 * @typedef {ReturnType<Core["scene"]>} BuiltScene whoever asked for it frees it
 */

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
 * The scene in the core, moved and scaled to the unit sphere as Python's Scene does it, so that pictures are equal.
 * Where surfaces coincide, the first of the instances is seen.
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
    const placed = instances.map(({ shape, transform = IDENTITY, material = WHITE }) => {
      return { shape: shapes[shape], transform, material, box: shapes[shape].bounds(transform) };
    });
    const { center, radius } = boundingSphere(placed);
    return core.scene(placed.map(({ shape, transform, material, box: { low, high } }) => ({
      shape,
      toShape: toShape(shape, transform, center, radius).slice(0, 12),
      box: [low, high].flatMap((corner) => corner.map((value, axis) => (value - center[axis]) / radius)),
      material: materialValues(material),
    })));
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

/**
 * The sphere about the centre of the common bounding box that reaches to the farthest point.
 *
 * @param {{shape: Shape, transform: ArrayLike<number>, box: {low: number[], high: number[]}}[]} placed
 */
function boundingSphere(placed) {
  const center = [0, 1, 2].map((axis) => {
    const low = Math.min(...placed.map(({ box }) => box.low[axis]));
    const high = Math.max(...placed.map(({ box }) => box.high[axis]));
    return low / 2 + high / 2;
  });
  const radius = Math.max(...placed.map(({ shape, transform }) => shape.radius(center, transform)));
  if (!(radius > 0)) throw new CoreError("shapes: expected an extent above zero, got all vertices in one point");
  if (!(radius < Infinity && radius > 1e-307)) {
    throw new CoreError(`shapes: expected a radius that float64 holds with its reciprocal, got ${radius}`);
  }
  return { center, radius };
}

/**
 * From the unit sphere to the core's coordinates of a shape.
 *
 * @param {Shape} shape
 * @param {ArrayLike<number>} transform
 * @param {number[]} center
 * @param {number} radius
 */
function toShape(shape, transform, center, radius) {
  const fromScene = product(shape.toCore, inverse(transform)), toSphere = toUnitSphere(center, radius);
  const same = fromScene.every((value, i) => value === toSphere[i]);
  if (same) return [...IDENTITY];  // to the bit, which the product is not
  return product(fromScene, fromUnitSphere(center, radius));
}
