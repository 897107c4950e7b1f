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
import { WHOLE } from "./cutaway.js";
import { WHITE, materialValues } from "./description.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../shapes/shape.js").Shape} Shape
 * @typedef {import("../shapes/description.js").ShapeDescription} ShapeDescription
 * @typedef {import("./description.js").SceneDescription} SceneDescription
 * @typedef {{address: number, top: number, rows: number}} Planes in the core's memory: (C, rows, width), from the image's row `top` on
 * @typedef {{shape: Shape, transform: ArrayLike<number>, material: ArrayLike<number>}} Instance
 *   transform (4, 4): from the shape's units to the scene's; material: as materialValues
 * @typedef {{center: [number, number, number], radius: number}} Sphere
 * @typedef {{depths: Float32Array, sphere: Sphere}} Probe depths (n,): NaN for a miss
 * @typedef {import("./cutaway.js").Cutaway} Cutaway
 * @typedef {{number: number, name: string | null, kind: string, count: number, pieces: [string[], number | null][]}} Label
 *   of an instance; number: in the order of the file; kind: as in Python; count: of its primitives; pieces: paths in the tree of parts, and numbers of
 *   consecutive primitives, null for all
 * @typedef {{sphere: Sphere, box: Float32Array, unit: string | null, labels: Label[], open: number}} About
 *   box (6,): lowest, then highest coordinates, in the scene's units; open: the first instance that a section shows without
 *   caps, or -1
 * @typedef {{instance: number, primitive: number, section: number | null, point: number[], normal: number[], sphere: Sphere}} Hit
 *   section: the section whose cap was hit, or null; point: in radii from the centre
 * @typedef {{kind: "corner" | "center" | "middle" | "edge", radius: number | null, point: number[], place: {x: number, y: number}, sphere: Sphere}} Snap
 *   radius: of the circle, in radii from the centre, as point is; place: where the surface next to it is visible, in pixels
 * @typedef {{low: number[], high: number[], area: number | null, volume: number | null}} Measures
 *   in the scene's units; area: null unless all are triangles and faces of NURBS, at most 1000 of a shape; volume: null unless they are closed
 */

const FINE = 64; // parts of a pixel that `probe` distinguishes
const PICKED = 9; // numbers of a pick
const LINE_MS = 3e-3; // before the first measurement: the gear's
const SNAPPED = 7; // numbers of a snap
const SNAPS = /** @type {const} */ (["corner", "center", "middle", "edge"]); // as bob::SnapKind
const MEASURED = 8; // numbers of a measure
const HIGHLIGHT = [1, 0.2622507, 0.0103298]; // bobrossnet.tracing.parts.HIGHLIGHT, in linear RGB

export class Scene {
  /**
   * @param {Core} core
   * @param {Instance[]} instances of coinciding surfaces, the first is visible
   * @param {string[]} [warnings] about the shapes
   * @param {Label[]} [labels] of the instances
   * @param {string | null} [unit]
   * @param {import("./light.js").SceneLights | null} [lights] its own
   */
  constructor(core, instances, warnings = [], labels = [], unit = null, lights = null) {
    const joined = (/** @type {"transform" | "material"} */ name) => instances.flatMap((i) => Array.from(i[name]));
    const shapes = Uint32Array.from(instances, (i) => i.shape.handle);
    this.core = core;
    this.warnings = warnings;
    this.labels = labels;
    this.unit = unit;
    this.lights = lights;
    let whole = 0;
    const [x, y, z, radius] = core.filled(new Float64Array(4), (sphere) => {
      whole = core.made("make_scene", shapes, instances.length, Float64Array.from(joined("transform")),
                        Float64Array.from(joined("material")), sphere);
    });
    /** Scenes in the core, each made of the one before: the whole, the selected parts, and these with sections. */
    this.handles = [whole, whole, whole];
    /** The bounding sphere, in the scene's units. @type {Sphere} */
    this.sphere = { center: [x, y, z], radius };
  }

  /** The scene that is displayed. */
  get handle() {
    return this.handles[2];
  }

  /** The displayed channels. @returns {import("../picture/channels.js").Layout} */
  get layout() {
    this.#layout ??= this.core.call("scene_is_colored", this.handle) ? COLORED : GBUFFER;
    return this.#layout;
  }

  /** Milliseconds for coarse lines, for each of their first hits, as measured last. */
  lineMs = LINE_MS;
  /** @type {import("../picture/channels.js").Layout | undefined} */
  #layout;
  #cutaway = WHOLE;

  /** Displays a cutaway from now on. @param {Cutaway} cutaway @returns {boolean} whether it is another one */
  cut(cutaway) {
    const { id, planes, hidden, highlighted } = cutaway, before = this.#cutaway, { core, handles } = this;
    if (id === before.id) return false;
    const areSame = String(hidden) === String(before.hidden) && String(highlighted) === String(before.highlighted);
    if (!areSame) {
      const parts = (/** @type {number[]} */ of) => [Uint32Array.from(of), of.length / 3];
      const isWhole = hidden.length + highlighted.length === 0;
      const selected = isWhole ? handles[0] : core.made("select_scene", handles[0], .../** @type {any} */ ([...parts(hidden), ...parts(highlighted)]), Float32Array.from(HIGHLIGHT));
      this.#replace(1, selected);
    }
    const { center, radius } = this.sphere, unit = Float64Array.from(planes, (value, i) =>
      (i % 4 < 3 ? value : (value - center.reduce((sum, of, axis) => sum + of * planes[i - 3 + axis], 0)) / radius));
    this.#replace(2, planes.length ? core.made("section_scene", handles[1], unit, planes.length / 4) : handles[1]);
    this.#layout = undefined;
    this.#cutaway = cutaway;
    return true;
  }

  /** Frees the scenes from a stage on, which are then this one. @param {number} stage @param {number} handle */
  #replace(stage, handle) {
    const { handles } = this, kept = handles.slice(0, stage);
    for (const old of new Set(handles.slice(stage))) if (!kept.includes(old)) this.core.call("free_scene", old);
    handles.fill(handle, stage);
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
    const at = (/** @type {number} */ place, /** @type {number} */ count) => Math.max(0, Math.min(count - 1, Math.floor(place * fine)));
    const size = { height: Math.ceil(height * fine), width: Math.ceil(width * fine) };
    const pixels = Int32Array.from({ length: places.length }, (_, i) => i % 2 ? at(places[i - 1], size.width) : at(places[i + 1], size.height));
    const traced = this.trace(pixels, size, camera), wide = this.sampleWidth;
    const depths = Float32Array.from({ length: places.length / 2 }, (_, i) => (traced[i * wide] ? traced[i * wide + 2] : NaN));
    return { depths, sphere: this.sphere };
  }

  /**
   * The first surface at a place of an image.
   *
   * @param {{x: number, y: number}} place in pixels from the upper left corner
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @returns {Hit | null} null for a miss
   */
  pick({ x, y }, { height, width }, camera) {
    const [instance, primitive, section, ...vectors] = this.core.filled(new Float64Array(PICKED), (found) => {
      this.core.call("pick", this.handle, cameraValues(camera), height, width, y - 0.5, x - 0.5, found);
    });
    if (instance < 0) return null;
    return { instance, primitive, section: section < 0 ? null : section, point: vectors.slice(0, 3), normal: vectors.slice(3), sphere: this.sphere };
  }

  /**
   * The corner, centre, middle or edge of a shape near a place of an image. Only for modules that draw edges.
   *
   * @param {{x: number, y: number}} place in pixels from the upper left corner
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @param {number} reach pixels
   * @returns {Snap | null} null if there is none within reach
   */
  snap({ x, y }, { height, width }, camera, reach) {
    const [kind, radius, ...rest] = this.core.filled(new Float64Array(SNAPPED), (found) => {
      this.core.made("snap", this.handle, cameraValues(camera), height, width, y - 0.5, x - 0.5, reach, found);
    });
    if (kind < 0) return null;
    const [row, column] = rest.slice(3);
    return { kind: SNAPS[kind], radius: radius === radius ? radius : null, point: rest.slice(0, 3), place: { x: column + 0.5, y: row + 0.5 }, sphere: this.sphere };
  }

  /** Facts that pages show with pictures. @returns {About} */
  about() {
    const { core, sphere, unit, labels } = this, { center, radius } = sphere;
    const box = core.filled(new Float32Array(6), (address) => void core.call("scene_box", this.handles[0], address));
    return {
      sphere, box: box.map((value, i) => center[i % 3] + radius * value), unit, labels,
      open: core.call("first_open_instance", this.handle),
    };
  }

  /** @param {number[]} primitives (n, 3), as of a cutaway @returns {Measures} */
  measure(primitives) {
    const { core, sphere: { center, radius } } = this, sphere = Float64Array.of(...center, radius);
    const of = (/** @type {number[]} */ some) => core.filled(new Float64Array(MEASURED), (address) => {
      core.made("measure", this.handles[0], Uint32Array.from(some), some.length / 3, sphere, address);
    });
    const [x, y, z, u, v, w, ...whole] = of(primitives), ranges = Array.from({ length: primitives.length / 3 }, (_, i) => primitives.slice(3 * i, 3 * i + 3));
    const kindOfRange = (/** @type {number[]} */ [instance]) => this.labels[instance]?.kind, breps = ranges.filter((range) => kindOfRange(range) === "brep");
    const meshes = ranges.filter((range) => kindOfRange(range) === "mesh").flat();
    const amounts = breps.length === 0 || 3 * breps.length + meshes.length < primitives.length ? [whole] : breps.map((range) => Array.from(
      core.filled(new Float64Array(2), (address) => void core.made("measure_brep", this.handles[0], ...range, sphere, address))));
    if (amounts[0] !== whole && meshes.length > 0) amounts.push(Array.from(of(meshes).slice(6)));
    const [area, volume] = [0, 1].map((i) => amounts.reduce((sum, amount) => sum + amount[i], 0)).map((value) => (Number.isNaN(value) ? null : value));
    return { low: [x, y, z], high: [u, v, w], area, volume };
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

  /**
   * The share of each pixel that visible edges cover, in the rows from `begin` to `end` of an image. Only for modules that draw edges.
   *
   * @param {number} begin @param {number} end
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @param {number} thickness of lines, in pixels
   * @returns {Uint8Array} (end - begin, width), 0..255
   */
  lines(begin, end, { height, width }, camera, thickness) {
    return this.core.filled(new Uint8Array((end - begin) * width), (address) => {
      this.core.made("draw_edges", this.handle, cameraValues(camera), height, width, begin, end, thickness, address);
    });
  }

  /**
   * The same of a whole image, from first hits some pixels apart.
   *
   * @param {import("../picture/camera.js").Size} size of the image
   * @param {import("../picture/camera.js").Camera} camera
   * @param {number} thickness @param {number} step pixels between first hits
   * @returns {Uint8Array} (height, width), 0..255
   */
  coarseLines({ height, width }, camera, thickness, step) {
    return this.core.filled(new Uint8Array(height * width), (address) => {
      this.core.made("draw_coarse_edges", this.handle, cameraValues(camera), height, width, step, thickness, address);
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
    this.#replace(0, 0);
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
export function buildScene(core, { shapes: descriptions, instances, unit, lights }) {
  if (!instances.length) throw new CoreError("shapes: expected at least one shape, got none");
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
    }), [...warnings], instances.map(({ number, name = null, pieces = [], shape }, i) => ({ number: number ?? i, name, pieces, ...kindOf(descriptions[shape]) })), unit, lights);
  } finally {
    for (const shape of shapes) shape.free();
    for (const picture of pictures.all) core.call("free_picture", picture);
  }
}

/** A shape's kind in Python, and the number of its primitives. @param {ShapeDescription} shape */
function kindOf(shape) {
  if (shape.kind === "mesh") return { kind: "mesh", count: shape.triangles.length / 3 };
  if (shape.kind === "brep") return { kind: "brep", count: shape.faces.length / 5 };
  return { kind: shape.kind === "tube" ? "tube" : "implicit", count: 1 };
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
