// @ts-check
/** The materials of a glTF, and their textures. */

import { CoreError, brief } from "../core/errors.js";
import { WHITE } from "../tracing/description.js";
import { dataOf } from "./gltf.js";
import { PLAIN, Pictures, half, unit } from "./surface.js";

/**
 * @typedef {import("./surface.js").Picture} Picture
 * @typedef {import("./surface.js").Surface} Surface
 * @typedef {import("./surface.js").Texture} Texture
 */

/** How textures wrap, by the numbers of WebGL. @type {Record<number, number>} */
const WRAPS = { 10497: 0, 33071: 1, 33648: 2 };

/** Of what moves textures. */
const MAX_NUMBER = 1e9;

/** Surfaces by the number of their material. What of one can't be read is left out, with a warning. */
export class GltfSurfaces {
  /** @type {Map<number, Surface>} */
  #surfaces = new Map();
  /** By where their images are: an address, or the start and the length in the buffer. @type {Map<string, Promise<Picture>>} */
  #sources = new Map();
  #pictures = new Pictures();
  /** Numbers of images that were left out. @type {Set<number>} */
  #missing = new Set();
  /** @param {any} json @param {Uint8Array<ArrayBuffer>} buffer the file's own @param {import("./part.js").Warn} warn */
  constructor(json, buffer, warn) {
    this.json = json;
    this.buffer = buffer;
    this.warn = warn;
  }

  /** Begins to decode the pictures of some materials, which other threads do. @param {Iterable<number | undefined>} numbers */
  begin(numbers) {
    for (const number of new Set(numbers)) {
      const info = this.#baseColor(number);
      if ("index" in info) this.#picture(this.#image(info)).catch(() => {}); // `prepare` meets that again
    }
  }

  /** Reads what some materials need, so that `of` can answer. @param {Iterable<number | undefined>} numbers */
  async prepare(numbers) {
    const count = Array.isArray(this.json.materials) ? this.json.materials.length : 0;
    for (const number of new Set(numbers)) {
      if (!(number !== undefined && number < count)) continue;
      const { name, ...material } = this.#material(number), pbr = object(material, "pbrMetallicRoughness");
      const texture = await this.#texture(this.#baseColor(number), material), alphaCutoff = cutoffOf(material, texture);
      this.#surfaces.set(number, {
        material: {
          ...WHITE, color: rgb(pbr.baseColorFactor, 1), emissive: rgb(material.emissiveFactor, 0),
          metallic: unit(pbr.metallicFactor, 1), roughness: unit(pbr.roughnessFactor, 1),
        },
        ...(texture && { texture }),
        ...(alphaCutoff !== undefined && { alphaCutoff }),
        ...(typeof name === "string" && { name }),
      });
    }
  }

  /** @param {number | undefined} number nothing of what has no material */
  of(number) {
    return (number !== undefined && this.#surfaces.get(number)) || PLAIN;
  }

  /** Which places on its texture a material takes. @param {number | undefined} number */
  uvSet(number) {
    const info = this.#baseColor(number), texCoord = moved(info).texCoord ?? info.texCoord ?? 0;
    return Number.isInteger(texCoord) ? texCoord : 0;
  }

  /**
   * Places as the material's KHR_texture_transform moves them, (V, 2): scaled, turned, then shifted.
   *
   * It turns as Khronos' sample viewer and three.js do, clockwise in the extension's own matrices.
   *
   * @param {number | undefined} number
   * @param {Float64Array | undefined} uv
   */
  onTexture(number, uv) {
    const { offset, rotation, scale } = moved(this.#baseColor(number));
    if (!uv) return undefined;
    const [u, v] = pair(offset, 0), [wide, high] = pair(scale, 1), angle = finite(rotation, 0);
    const cos = Math.cos(angle), sin = Math.sin(angle);
    return uv.map((_, i) => {
      const x = uv[i - i % 2] * wide, y = uv[i - i % 2 + 1] * high;
      return i % 2 ? cos * y - sin * x + v : cos * x + sin * y + u;
    });
  }

  /** Whether a material looks at the alphas of vertices. @param {number | undefined} number */
  isMasked(number) {
    return this.#material(number).alphaMode === "MASK";
  }

  /** @param {number | undefined} number */
  #baseColor(number) {
    return object(object(this.#material(number), "pbrMetallicRoughness"), "baseColorTexture");
  }

  /** @param {number | undefined} number */
  #material(number) {
    return item(this.json, "materials", number);
  }

  /** The number of a texture's image, -1 of none. @param {any} info */
  #image(info) {
    const texture = item(this.json, "textures", info.index), { extensions } = texture;
    const source = texture.source ?? object(extensions ?? {}, "EXT_texture_webp").source;
    return Number.isInteger(source) ? source : -1;
  }

  /** @param {any} info @param {any} material @returns {Promise<Texture | undefined>} */
  async #texture(info, material) {
    if (!("index" in info)) return undefined;
    const number = this.#image(info), { wrapS, wrapT } = item(this.json, "samplers", item(this.json, "textures", info.index).sampler);
    try {
      /** @type {Texture} */
      const texture = { picture: await this.#picture(number), wrap: [WRAPS[wrapS] ?? 0, WRAPS[wrapT] ?? 0] };
      this.#pictures.show(texture.picture, cutoffOf(material, texture) !== undefined);
      return texture;
    } catch (error) {
      if (!(error instanceof CoreError)) throw error;
      if (!this.#missing.has(number)) this.warn(`texture ${number} was left out: ${error.message}`);
      this.#missing.add(number);
      return undefined;
    }
  }

  /** @param {number} number of an image */
  #picture(number) {
    const image = item(this.json, "images", number), { byteOffset = 0, byteLength = 0 } = item(this.json, "bufferViews", image.bufferView);
    const source = typeof image.uri === "string" ? image.uri : `${byteOffset} ${byteLength}`;
    const read = async () => this.#pictures.decoded(this.#content(image));
    const picture = this.#sources.get(source) ?? read();
    this.#sources.set(source, picture);
    return picture;
  }

  /** The file of an image. @param {any} image @returns {Uint8Array<ArrayBuffer>} */
  #content({ uri, bufferView }) {
    if (typeof uri === "string") {
      if (!uri.startsWith("data:")) throw new CoreError(`expected its picture within the file or beside it, got ${brief(uri)}`);
      return dataOf(uri);
    }
    const { byteOffset = 0, byteLength = 0 } = item(this.json, "bufferViews", bufferView);
    return this.buffer.slice(byteOffset, byteOffset + byteLength);
  }
}

/**
 * Of the texture's alpha times the vertices'. The material's own divides what their product is compared with; above 1, nothing
 * is seen.
 *
 * @param {any} material
 * @param {Texture | undefined} texture
 */
function cutoffOf(material, texture) {
  if (material.alphaMode !== "MASK") return material.alphaMode === "BLEND" ? half(texture?.picture) : undefined;
  const { baseColorFactor } = object(material, "pbrMetallicRoughness"), cutoff = Math.max(finite(material.alphaCutoff, 0.5), 0);
  const alpha = Array.isArray(baseColorFactor) && baseColorFactor.length === 4 ? unit(baseColorFactor[3], 1) : 1;
  return alpha || cutoff ? cutoff / alpha : undefined;
}

/** An item of a list; without anything in it if there is none. @param {any} json @param {string} name @param {unknown} number @returns {any} */
function item(json, name, number) {
  const found = Array.isArray(json[name]) && Number.isInteger(number) ? json[name][/** @type {number} */ (number)] : undefined;
  return isObject(found) ? found : {};
}

/** @param {any} of @param {string} name @returns {any} */
function object(of, name) {
  const value = of[name];
  return isObject(value) ? value : {};
}

/** @param {any} info */
const moved = (info) => object(object(info, "extensions"), "KHR_texture_transform");

/** @param {unknown} value @param {number} otherwise */
const finite = (value, otherwise) => (typeof value === "number" && Math.abs(value) <= MAX_NUMBER ? value : otherwise);

/** @param {unknown} values @param {number} otherwise */
function pair(values, otherwise) {
  const [first, second] = Array.isArray(values) && values.length === 2 ? values : [];
  return [finite(first, otherwise), finite(second, otherwise)];
}

/** @param {unknown} value */
const isObject = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/** Linear RGB of a factor, which may have an alpha. @param {unknown} values @param {number} otherwise */
function rgb(values, otherwise) {
  const given = Array.isArray(values) ? values : [];
  return [0, 1, 2].map((channel) => unit(given[channel], otherwise));
}
