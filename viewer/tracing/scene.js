// @ts-check
/** Scenes in the core: construction from descriptions, and tracing. */

import { CoreError, placedErrors } from "../core/errors.js";
import { cameraValues } from "../picture/camera.js";
import { COLORED, GBUFFER, tracedLayout, widthOf } from "../picture/channels.js";
import { IDENTITY } from "../shapes/affine.js";
import { formulaShape, implicitShape, scriptShape } from "../shapes/implicit.js";
import { meshShape } from "../shapes/mesh.js";
import { OfPictures, pictureOf } from "../shapes/picture.js";
import { brepShape, tubeShape } from "../shapes/splines.js";
import { WHITE, checkCount, materialValues } from "./description.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../shapes/shape.js").Shape} Shape
 * @typedef {import("../shapes/description.js").ShapeDescription} ShapeDescription
 * @typedef {import("./description.js").SceneDescription} SceneDescription
 * @typedef {{address: number, top: number, rows: number}} Planes in the core's memory: (C, rows, width), from the image's row `top` on
 * @typedef {{shape: Shape, transform: ArrayLike<number>, material: ArrayLike<number>}} Instance
 *   transform (4, 4): from the shape's units to the scene's; material (12): as materialValues
 * @typedef {{center: [number, number, number], radius: number}} Sphere
 * @typedef {{samples: Float32Array, names: Map<number, string | null>, sphere: Sphere}} Probe
 *   samples (n, 4): depth, NaN for a miss, normal x and y, instance; names: of the instances that were hit
 */

/** Numbers of a probe's sample. */
const PROBED = 4;
const FINE = 64; // parts of a pixel that `probe` distinguishes

export class Scene {
  /**
   * @param {Core} core
   * @param {Instance[]} instances of coinciding surfaces, the first is visible
   * @param {string[]} [warnings] about the shapes
   * @param {(string | null)[]} [names] of the instances
   */
  constructor(core, instances, warnings = [], names = []) {
    const joined = (/** @type {"transform" | "material"} */ name) => instances.flatMap((i) => Array.from(i[name]));
    const shapes = Uint32Array.from(instances, (i) => i.shape.handle);
    this.core = core;
    this.warnings = warnings;
    this.names = names;
    this.handle = 0;
    const [x, y, z, radius] = core.filled(new Float64Array(4), (sphere) => {
      this.handle = core.made("make_scene", shapes, instances.length, Float64Array.from(joined("transform")),
                              Float64Array.from(joined("material")), sphere);
    });
    /** The bounding sphere, in the scene's units. @type {Sphere} */
    this.sphere = { center: [x, y, z], radius };
    /** The displayed channels. @type {import("../picture/channels.js").Layout} */
    this.layout = core.call("scene_is_colored", this.handle) ? COLORED : GBUFFER;
  }

  /**
   * Traces pixels of an image.
   *
   * @param {Int32Array} pixels (n, 2), row and column
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {Partial<import("../picture/camera.js").Camera>} [camera]
   * @param {Float32Array} [samples] array for the result
   * @returns {Float32Array} samples, (n, C), in the order of the traced layout
   */
  trace(pixels, { height, width }, camera = {}, samples = new Float32Array(this.sampleWidth * pixels.length / 2)) {
    const count = pixels.length / 2;
    return this.core.filled(samples, (address) => {
      this.core.made("trace", this.handle, cameraValues(camera), height, width, pixels, count, this.#isColored, address);
    });
  }

  /**
   * Traces places of an image, between its pixels, too.
   *
   * @param {ArrayLike<number>} places (n, 2), x and y in pixels from the upper left corner
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @returns {Probe}
   */
  probe(places, { height, width }, camera) {
    const fine = FINE / Math.max(1, Math.hypot(height, width) / 2 ** 14); // far from the limit of 32 bits
    const at = (/** @type {number} */ place, /** @type {number} */ most) => Math.max(0, Math.min(most - 1, Math.floor(place * fine)));
    const size = { height: Math.ceil(height * fine), width: Math.ceil(width * fine) };
    const pixels = Int32Array.from({ length: places.length }, (_, i) => i % 2 ? at(places[i - 1], size.width) : at(places[i + 1], size.height));
    const traced = this.trace(pixels, size, camera), wide = this.sampleWidth, samples = new Float32Array(places.length / 2 * PROBED);
    const names = new Map();
    for (let i = 0; i < places.length / 2; ++i) {
      const [hit, , depth, x, y] = traced.subarray(i * wide), instance = traced[(i + 1) * wide - 1];
      samples.set(hit ? [depth, x, y, instance] : [NaN, 0, 0, -1], i * PROBED);
      if (hit) names.set(instance, this.names[instance] ?? null);
    }
    return { samples, names, sphere: this.sphere };
  }

  /**
   * Traces the rows from `begin` to `end` of an image.
   *
   * @param {number} begin @param {number} end
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @param {Planes} planes of the traced layout
   */
  traceRows(begin, end, { height, width }, camera, { address, top, rows }) {
    this.core.made("trace_rows", this.handle, cameraValues(camera), height, width, begin, end, this.#isColored, address, top, rows);
  }

  /**
   * The same rows as an array.
   *
   * @param {number} begin @param {number} end
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @returns {Float32Array} (C, end - begin, width) of the traced layout
   */
  rows(begin, end, size, camera) {
    const rows = end - begin, planes = new Float32Array(this.sampleWidth * rows * size.width);
    return this.core.filled(planes, (address) => this.traceRows(begin, end, size, camera, { address, top: begin, rows }));
  }

  /**
   * The pixels at edges in the rows from `begin` to `end`, as in core/tracing/antialiasing.h.
   *
   * @param {number} begin @param {number} end @param {number} width of the image
   * @param {Planes} planes of the traced layout, with the rows above and below, except at the image's borders
   * @returns {Int32Array} (n, 2)
   */
  edges(begin, end, width, { address, top, rows }) {
    let first = 0;
    const [count] = this.core.filled(new Int32Array(1), (written) => {
      first = this.core.made("pixels_at_edges", this.#isColored, address, rows, width, begin - top, end - top, written) >>> 0;
    });
    const pixels = new Int32Array(this.core.memory, first, 2 * count).slice();
    for (let i = 0; i < pixels.length; i += 2) pixels[i] += top;
    return pixels;
  }

  /**
   * Means over side x side rays in pixels of an image.
   *
   * @param {Int32Array} pixels (n, 2)
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @param {number} side
   * @returns {Float32Array} (n, 5), 1 where they need more, linear RGB and coverage
   */
  means(pixels, { height, width }, camera, side) {
    const count = pixels.length / 2;
    return this.core.filled(new Float32Array(5 * count), (address) => {
      this.core.made("trace_means", this.handle, cameraValues(camera), height, width, pixels, count, side, address);
    });
  }

  get #isColored() {
    return Number(this.layout === COLORED);
  }

  /** Number of components of a sample. */
  get sampleWidth() {
    return widthOf(tracedLayout(this.layout));
  }

  free() {
    this.core.call("free_scene", this.handle);
  }
}

/**
 * The scene in the core. Of coinciding surfaces, the first instance's is visible.
 *
 * @param {Core} core
 * @param {SceneDescription} description
 * @returns {Scene} the caller frees it
 * @throws {CoreError} of one line, if a shape has no surface, is unbounded, or is invalid
 */
export function buildScene(core, { shapes: descriptions, instances }) {
  if (!instances.length) throw new CoreError("shapes: expected at least one shape, got none");
  checkCount("shapes", instances.length);
  /** @type {Shape[]} */
  const shapes = [];
  /** @type {OfPictures<number>} */
  const pictures = new OfPictures();
  /** @type {Set<string>} */
  const warnings = new Set();
  try {
    descriptions.forEach((description, i) => {
      const make = () => makeShape(core, description, pictures);
      const shape = descriptions.length > 1 ? placedErrors(`shapes[${i}]`, make) : make();
      shapes.push(shape);
      if (shape.isCoarse) warnings.add(coarse(description.kind === "brep" ? "surface" : "formula"));
    });
    return new Scene(core, instances.map(({ shape, transform = IDENTITY, material = WHITE }) => {
      return { shape: shapes[shape], transform, material: materialValues(material) };
    }), [...warnings], instances.map(({ name }) => name ?? null));
  } finally {
    for (const shape of shapes) shape.free();
    for (const picture of pictures.all) core.call("free_picture", picture);
  }
}

/** As bobrossnet.support.errors.warn_coarse. @param {string} what */
const coarse = (what) => `shape: its ${what} is too intricate to prepare in a few seconds: as exact, but tracing is slow`;

/** @param {Core} core @param {ShapeDescription} description @param {OfPictures<number>} pictures @returns {Shape} */
function makeShape(core, description, pictures) {
  switch (description.kind) {
    case "mesh": return meshShape(core, description, pictures.get(description, () => pictureOf(core, description)));
    case "implicit": return implicitShape(core, description, description.bounds);
    case "script": return scriptShape(core, description.source);
    case "formula": return formulaShape(core, description.text, description.bounds);
    case "brep": return brepShape(core, description);
    case "tube": return tubeShape(core, description);
  }
}
