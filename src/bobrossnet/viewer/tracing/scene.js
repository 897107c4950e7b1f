// @ts-check
/** Scenes in the core: how they are made of their descriptions, and traced. */

import { CoreError, placedErrors } from "../core/errors.js";
import { cameraValues } from "../picture/camera.js";
import { WIDTH } from "../picture/channels.js";
import { IDENTITY, fromUnitSphere, inverse, product, toUnitSphere } from "../shapes/affine.js";
import { formulaShape, implicitShape, scriptShape } from "../shapes/implicit.js";
import { Mesh } from "../shapes/mesh.js";
import { brep, tube } from "../shapes/splines.js";
import { WHITE, materialValues } from "./description.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../shapes/shape.js").Shape} Shape
 * @typedef {import("../shapes/description.js").ShapeDescription} ShapeDescription
 * @typedef {import("./description.js").SceneDescription} SceneDescription
 * @typedef {{shape: Shape, toShape: ArrayLike<number>, box: ArrayLike<number>, material: ArrayLike<number>}} Instance
 *   toShape (3, 4): from the scene's unit sphere to the shape's own coordinates; box (2, 3): low and high in the unit sphere;
 *   material (7): linear RGB, ambient, diffuse, specular, shininess
 */

export class Scene {
  /** @param {Core} core @param {Instance[]} instances */
  constructor(core, instances) {
    const joined = (/** @type {"toShape" | "box" | "material"} */ name) => instances.flatMap((i) => Array.from(i[name]));
    const shapes = Uint32Array.from(instances, (i) => i.shape.handle);
    this.core = core;
    this.handle = core.made("make_scene", shapes, instances.length, Float64Array.from(joined("toShape")),
                            Float32Array.from(joined("box")), Float32Array.from(joined("material")));
  }

  /**
   * Traces pixels of an image.
   *
   * @param {Int32Array} pixels (n, 2), row and column
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {Partial<import("../picture/camera.js").Camera>} [camera]
   * @param {Float32Array} [samples] where to write them
   * @returns {Float32Array} samples, (n, C), in the order of GBUFFER
   */
  trace(pixels, { height, width }, camera = {}, samples = new Float32Array(WIDTH * pixels.length / 2)) {
    const count = pixels.length / 2;
    return this.core.filled(samples, (address) => {
      this.core.made("trace", this.handle, cameraValues(camera), height, width, pixels, count, address);
    });
  }

  free() {
    this.core.call("free_scene", this.handle);
  }
}

/**
 * The scene in the core, moved and scaled to the unit sphere as Python's Scene does it, so that pictures are equal.
 * Where surfaces coincide, the first of the instances is seen.
 *
 * @param {Core} core
 * @param {SceneDescription} description
 * @returns {Scene} whoever asked for it frees it
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
    return new Scene(core, placed.map(({ shape, transform, material, box: { low, high } }) => ({
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
    case "mesh": return new Mesh(core, description.vertices, description.triangles, description.normals);
    case "implicit": return implicitShape(core, description, description.bounds);
    case "script": return scriptShape(core, description.source);
    case "formula": return formulaShape(core, description.text, description.bounds);
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
