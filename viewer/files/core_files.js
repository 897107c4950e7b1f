// @ts-check
/**
 * Mesh files and 3MF are read by the core (core/files). This module fetches files that they name, and decodes their images, as does
 * bobrossnet.adapters.core_files.
 *
 * @typedef {import("./beside.js").Beside} Beside
 * @typedef {import("./part.js").Part} Part
 * @typedef {import("./part.js").Warn} Warn
 * @typedef {import("./surface.js").Picture} Picture
 * @typedef {import("./surface.js").Surface} Surface
 * @typedef {import("./surface.js").Texture} Texture
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {{image: number, wrap: string[], uv: number}} Layer
 * @typedef {{name: string, layers: {color?: Layer, mask?: Layer, metallic_roughness?: Layer}, replaces_color: number, opacity: string, color: number[], ambient: number, diffuse: number, specular: number, shininess: number, metallic: number,
 *   roughness: number, emissive: number[], clearcoat: number, clearcoat_roughness: number, transmission: number, ior: number, attenuation: number[], distance: number, thin: boolean,
 *   alphaCutoff: number}} Described a surface, as in core/files/read.h
 * @typedef {{parts: {runs: number[], surface: number, uv: number}[], labels: {name: string, parent: number}[],
 *   surfaces: Described[], images: {name: string, label: string}[], shapes: {kind: "tube" | "implicit", name: string}[],
 *   placements: [number, number][], warnings: string[], unit: string}} Contents
 * @typedef {{parts: Part[], scene: import("../tracing/description.js").SceneDescription}} Read scene: of shapes other than meshes
 */

import { CoreError, oneLine } from "../core/errors.js";
import { isSingular } from "../shapes/affine.js";
import { WHITE } from "../tracing/description.js";
import { Pictures, half } from "./surface.js";

const WRAPS = ["repeat", "clamp", "mirror"];

/** Numbers of a part's arrays; further sets of uv follow the last. */
const [VERTICES, NORMALS, COLORS, FACE_COLORS, ALPHAS, UV] = [0, 1, 2, 3, 4, 5];

/** Maximum depth of trees of parts, as bobrossnet.adapters.part.MAX_DEPTH. */
const MAX_DEPTH = 32;

/** Name for an unnamed thing next to named ones. */
const UNNAMED = "unnamed";

/** Numbers of a surface, a shape and a placement. */
const OF_SURFACE = 22, OF_SHAPE = 3, OF_PLACEMENT = 12;

/** The arrays of other shapes, in the order of bindings/wasm_3mf.cpp. */
const ARRAYS = {
  tube: { control_points: Float64Array, knots: Float64Array, radii: Float64Array },
  implicit: {
    bounds: Float64Array, ops: Uint8Array, operands: Uint32Array, values: Float64Array, mesh_sizes: Uint32Array,
    mesh_vertices: Float32Array, mesh_triangles: Uint32Array, color_ops: Uint8Array, color_operands: Uint32Array,
    color_values: Float64Array, color_mesh_sizes: Uint32Array, color_mesh_vertices: Float32Array,
    color_mesh_triangles: Uint32Array, color_roots: Uint32Array,
  },
};

/**
 * @param {Core} core
 * @param {string} format the ending of the file's name, without its point
 * @param {ArrayBuffer} bytes
 * @param {string} name of the file
 * @param {Warn} warn
 * @param {Beside} beside
 * @returns {Promise<Read>}
 */
export async function readInCore(core, format, bytes, name, warn, beside) {
  const address = core.put(new Uint8Array(bytes));
  let reading = 0;
  try {
    reading = core.made("make_reading", format, address, bytes.byteLength);
    for (let wanted = readOn(core, reading); wanted; wanted = readOn(core, reading)) await answer(core, reading, wanted, beside);
    core.made("describe_reading", reading);
    /** @type {Contents} */
    const contents = JSON.parse(textOf(core, reading));
    contents.warnings.forEach(warn);
    const numbers = copied(core, Float64Array, "reading_numbers", reading) ?? new Float64Array(0);
    let taken = 0;
    const take = (/** @type {number} */ count) => Array.from(numbers.subarray(taken, taken += count));
    contents.surfaces.forEach((surface) => addNumbers(surface, take(OF_SURFACE)));
    const colors = contents.shapes.map(() => take(OF_SHAPE)), places = contents.placements.map(() => take(OF_PLACEMENT));
    const surfaces = await new Images(core, reading, contents, warn, beside).surfaces();
    const paths = pathsOf(contents.labels);
    const parts = contents.parts.map((part, number) => ({
      ...partOf(core, reading, number, part, surfaces[part.surface], contents.surfaces[part.surface]), runs: runsOf(part.runs, paths),
    }));
    const shapes = contents.shapes.map(({ kind }, number) => shapeOf(core, reading, number, kind));
    const instances = contents.placements.map(([shape, label], i) => {
      const transform = [...places[i], 0, 0, 0, 1];
      if (isSingular(core, transform)) throw new CoreError("transform: expected a map that keeps all three dimensions, got one that is singular");
      return {
        shape, transform, material: { ...WHITE, color: colors[shape] }, name: oneLine(contents.shapes[shape].name) || name,
        pieces: /** @type {[string[], null][]} */ ([[paths[label], null]]),
      };
    });
    return { parts, scene: { shapes, instances, unit: contents.unit || null } };
  } finally {
    if (reading) core.call("free_reading", reading);
    core.release(address);
  }
}

/** @param {Core} core @param {number} reading @param {number} number @param {keyof typeof ARRAYS} kind */
function shapeOf(core, reading, number, kind) {
  core.made("read_shape", reading, number);
  const arrays = Object.entries(ARRAYS[kind]).map(([name, type], i) => [name, copied(core, /** @type {any} */ (type), "shape_array", reading, i)]);
  return { kind, ...Object.fromEntries(arrays.filter(([, array]) => array)) };
}

/** The path of each label; at its end, the path of no label. @param {Contents["labels"]} labels */
function pathsOf(labels) {
  /** @type {string[][]} */
  const paths = [];
  for (const { name, parent } of labels) paths.push([...(paths[parent] ?? []).slice(0, MAX_DEPTH - 1), oneLine(name) || UNNAMED]);
  return [...paths, [UNNAMED]];
}

/** @param {number[]} runs labels and numbers of triangles @param {string[][]} paths @returns {[string[], number][]} */
const runsOf = (runs, paths) => Array.from({ length: runs.length / 2 }, (_, i) => [/** @type {string[]} */ (paths.at(runs[2 * i])), runs[2 * i + 1]]);

/** @param {Described} surface @param {number[]} numbers of it */
function addNumbers(surface, numbers) {
  const [ambient, diffuse, specular, shininess, metallic, roughness] = numbers.slice(3, 9);
  const color = numbers.slice(0, 3), emissive = numbers.slice(9, 12), attenuation = numbers.slice(16, 19), thin = Boolean(numbers[20]);
  const [clearcoat, clearcoat_roughness, transmission, ior] = numbers.slice(12, 16), distance = numbers[19], alphaCutoff = numbers[21];
  Object.assign(surface, { color, ambient, diffuse, specular, shininess, metallic, roughness, emissive });
  Object.assign(surface, { clearcoat, clearcoat_roughness, transmission, ior, attenuation, distance, thin, alphaCutoff });
}

/** @param {Core} core @param {number} reading @returns {string} the name of a file that is needed first, empty at the end */
function readOn(core, reading) {
  core.made("read_on", reading);
  return textOf(core, reading);
}

/** @param {Core} core @param {number} reading */
function textOf(core, reading) {
  const size = core.call("reading_text_size", reading), at = core.call("reading_text", reading) >>> 0;
  return new TextDecoder().decode(new Uint8Array(core.memory, at, size).slice());
}

/** Supplies a requested file, or the reason for its absence. @param {Core} core @param {number} reading @param {string} wanted @param {Beside} beside */
async function answer(core, reading, wanted, beside) {
  try {
    const bytes = await beside.read(wanted);
    core.made("answer_reading", reading, bytes, bytes.byteLength, 1);
  } catch (error) {
    if (!(error instanceof CoreError)) throw error;
    core.made("answer_reading", reading, error.message, 0);
  }
}

/**
 * @param {Core} core
 * @param {number} reading
 * @param {number} number of the part
 * @param {Contents["parts"][0]} part
 * @param {Surface | undefined} surface
 * @param {Described | undefined} described
 * @returns {Part}
 */
function partOf(core, reading, number, part, surface, described) {
  const field = (/** @type {number} */ which) => copied(core, Float64Array, "part_field", reading, number, which);
  const layer = described?.layers.color ?? described?.layers.mask, texture = surface?.texture;
  const isReplaced = described?.replaces_color && texture;
  return {
    vertices: field(VERTICES) ?? new Float64Array(0), triangles: copied(core, Int32Array, "part_triangles", reading, number) ?? new Int32Array(0),
    normals: field(NORMALS), alphas: field(ALPHAS),
    colors: isReplaced ? undefined : field(COLORS), faceColors: isReplaced ? undefined : field(FACE_COLORS),
    uv: texture && layer && layer.uv < part.uv ? field(UV + layer.uv) : undefined, surface,
  };
}

/**
 * A copy of an array of the core; undefined if it is empty.
 *
 * @template {Float64Array | Int32Array | Uint8Array<ArrayBuffer>} T
 * @param {Core} core
 * @param {{new (buffer: ArrayBuffer, start: number, length: number): T}} type
 * @param {string} name of the function that returns its address
 * @param {...number} of
 * @returns {T | undefined}
 */
function copied(core, type, name, ...of) {
  const size = core.call(`${name}_size`, ...of);
  return size ? /** @type {T} */ (new type(core.memory, core.call(name, ...of) >>> 0, size).slice()) : undefined;
}

/** The images of a file; each is decoded once. Unreadable ones are left out, with a warning. */
class Images {
  #pictures = new Pictures();
  /** @type {Map<number, Promise<Picture>>} */
  #decoded = new Map();
  /** Means of images of numbers. @type {Map<number, number[]>} */
  #means = new Map();
  /** Warnings already given. @type {Set<string>} */
  #failed = new Set();
  /** Masked pictures by picture and mask. @type {Map<Picture | undefined, Map<Picture, Picture>>} */
  #masked = new Map();

  /** @param {Core} core @param {number} reading @param {Contents} contents @param {Warn} warn @param {Beside} beside */
  constructor(core, reading, contents, warn, beside) {
    this.core = core, this.reading = reading, this.contents = contents, this.warn = warn, this.beside = beside;
  }

  async surfaces() {
    const surfaces = [];
    // All together, since other threads decode them.
    for (const { layers } of this.contents.surfaces) for (const layer of [layers.color, layers.mask]) if (layer) this.#picture(layer.image).catch(() => {});
    for (const described of this.contents.surfaces) surfaces.push(await this.#surface(described));
    return surfaces;
  }

  /** @param {Described} described @returns {Promise<Surface>} */
  async #surface(described) {
    const { layers, name } = described, laid = await this.#texture(layers.color), mask = await this.#texture(layers.mask);
    const cutOut = mask && await this.#attempt(
      async () => ({ wrap: (laid ?? mask).wrap, picture: this.#withMask(laid?.picture, mask.picture) }), `the mask of ${name} was left out`,
    );
    if (layers.metallic_roughness) {
      const [, green, blue] = await this.#mean(layers.metallic_roughness.image);
      described.metallic *= blue, described.roughness *= green;
    }
    const surface = surfaceOf(described, laid, cutOut ?? laid);
    if (!surface.texture) return surface;
    const { picture } = surface.texture, isCutOut = surface.alphaCutoff !== undefined, { image } = layers.color ?? layers.mask ?? { image: 0 };
    const isShown = await this.#read(image, async () => (this.#pictures.show(picture, isCutOut), true));
    return isShown ? surface : surfaceOf(described, undefined, undefined);
  }

  /** @param {Layer} [layer] @returns {Promise<Texture | undefined>} */
  async #texture(layer) {
    if (!layer) return undefined;
    const { image, wrap } = layer, picture = await this.#read(image, () => this.#picture(image));
    const [across, down] = wrap.map((own) => WRAPS.indexOf(own));
    return picture && { picture, wrap: [across, down] };
  }

  /** @param {number} image */
  #picture(image) {
    const read = async () => this.#pictures.decoded(await this.#file(image));
    const picture = this.#decoded.get(image) ?? read();
    this.#decoded.set(image, picture);
    return picture;
  }

  /** The mean of an image of numbers, in 0..1; if unreadable, as of a rough non-metal. @param {number} image */
  async #mean(image) {
    const mean = this.#means.get(image) ?? await this.#read(image, async () => this.#pictures.mean(await this.#file(image))) ?? [0, 1, 0];
    this.#means.set(image, mean);
    return mean;
  }

  /** @param {number} image */
  async #file(image) {
    const { name } = this.contents.images[image];
    return name ? this.beside.read(name) : this.#embedded(image);
  }

  /** @param {number} image @returns {Uint8Array<ArrayBuffer>} */
  #embedded(image) {
    return copied(this.core, /** @type {any} */ (Uint8Array), "reading_image", this.reading, image) ?? new Uint8Array(0);
  }

  /** The result of `masked` for two pictures, made and counted once. @param {Picture | undefined} picture @param {Picture} mask */
  #withMask(picture, mask) {
    /** @type {Map<Picture, Picture>} */
    const of = this.#masked.get(picture) ?? new Map(), known = of.get(mask), { height, width } = picture ?? mask;
    if (known) return known;
    this.#pictures.count(height, width);
    const made = masked(picture, mask);
    this.#masked.set(picture, of.set(mask, made));
    return made;
  }

  /** @template T @param {number} image @param {() => Promise<T>} read uses the image */
  #read(image, read) {
    return this.#attempt(read, `texture ${this.contents.images[image].label} was left out`);
  }

  /** @template T @param {() => Promise<T>} read @param {string} failed @returns {Promise<T | undefined>} */
  async #attempt(read, failed) {
    try {
      return await read();
    } catch (error) {
      if (!(error instanceof CoreError)) throw error;
      if (!this.#failed.has(failed)) this.warn(`${failed}: ${error.message}`);
      this.#failed.add(failed);
      return undefined;
    }
  }
}

/** @param {Described} described @param {Texture | undefined} laid @param {Texture | undefined} texture that with a mask @returns {Surface} */
function surfaceOf(described, laid, texture) {
  const { name, ambient, diffuse, specular, shininess, metallic, roughness, emissive } = described;
  const color = laid && described.replaces_color ? [1, 1, 1] : described.color;
  const reflecting = roughness < 0 ? { ambient, diffuse, specular, shininess } : { metallic, roughness };
  const { clearcoat, clearcoat_roughness, transmission, ior, attenuation, distance, thin } = described;
  const glass = transmission > 0 && { metallic: 0, transmission, ior, attenuation, distance, thin };
  const coat = clearcoat > 0 && !glass && { clearcoat, clearcoat_roughness };
  const alphaCutoff = cutoffOf(described, texture);
  return {
    material: { ...WHITE, color, emissive, ...reflecting, ...coat, ...glass }, ...(texture && { texture }), ...(name && { name }),
    ...(alphaCutoff !== undefined && { alphaCutoff }),
  };
}

/** @param {Described} described @param {Texture | undefined} texture */
function cutoffOf({ opacity, alphaCutoff }, texture) {
  if (opacity === "translucent") return half(texture?.picture);
  return opacity === "opaque" ? undefined : alphaCutoff;
}

/**
 * The picture, or a white one, with the alpha of a mask, or the mask's red if it has no alpha. A mask of another size is sampled at
 * the texels' centres.
 *
 * @param {Picture | undefined} picture
 * @param {Picture} mask
 * @returns {Picture}
 */
function masked(picture, mask) {
  const { texels, height, width } = picture ?? { ...mask, texels: new Uint8Array(mask.texels.length).fill(255) };
  const alpha = new Uint8Array(height * width);
  for (let row = 0, to = 0; row < height; ++row) {
    const start = Math.floor((2 * row + 1) * mask.height / (2 * height)) * mask.width;
    for (let column = 0; column < width; ++column, ++to) {
      const from = start + Math.floor((2 * column + 1) * mask.width / (2 * width));
      alpha[to] = mask.alpha ? mask.alpha[from] : mask.texels[3 * from];
    }
  }
  return { texels, height, width, alpha };
}
