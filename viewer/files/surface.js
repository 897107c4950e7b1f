// @ts-check
/**
 * Surfaces of mesh files: materials and textures.
 *
 * @typedef {import("../tracing/description.js").Material} Material
 * @typedef {{texels: Uint8Array, height: number, width: number, alpha?: Uint8Array}} Picture
 *   texels (H * W, 3) in sRGB, row 0 at the top, alpha (H * W,); opaque if omitted
 * @typedef {{picture: Picture, wrap: readonly [number, number]}} Texture wrap: across and down, 0 repeated, 1 clamped, 2 mirrored
 * @typedef {{material: Material, texture?: Texture, name?: string, alphaCutoff?: number}} Surface
 *   alphaCutoff: there is no surface where alpha is below it; if omitted, alpha is ignored
 */

import { CoreError } from "../core/errors.js";
import { WHITE } from "../tracing/description.js";
import { sizeOfPicture, withoutExif } from "./picture_head.js";

const UNREADABLE = "expected a picture in PNG, JPEG, WebP or AVIF, got none that can be read";

/** Maximum size of one texture: 8,192 x 8,192 texels, 0.2 GB. */
const MAX_TEXELS = 2 ** 26;

/** Maximum size of all pictures of a file, as bobrossnet.adapters.surface.MAX_FILE_TEXELS. */
const MAX_FILE_TEXELS = 2 ** 27;

/** The pictures of a file; each is decoded once, even under several names. */
export class Pictures {
  #left = MAX_FILE_TEXELS;
  /** Decoded pictures by length and hash of their files. @type {Map<string, {bytes: Uint8Array, picture: Promise<Picture>}>} */
  #decoded = new Map();
  /** Whether pictures are used with alpha, without it, or both. @type {Map<Picture, Set<boolean>>} */
  #shown = new Map();

  /**
   * Decodes a picture's file.
   *
   * @param {Uint8Array<ArrayBuffer>} bytes
   * @returns {Promise<Picture>} rejected before it is decoded if it is too large
   */
  decoded(bytes) {
    const key = `${bytes.length} ${hashOf(bytes)}`, known = this.#decoded.get(key);
    if (known && bytes.every((byte, i) => byte === known.bytes[i])) return known.picture;
    const picture = decoded(bytes, this);
    this.#decoded.set(key, { bytes, picture });
    return picture;
  }

  /**
   * The mean of a picture's red, green and blue, 0..1. The picture is neither kept nor counted.
   *
   * @param {Uint8Array<ArrayBuffer>} bytes
   * @returns {Promise<number[]>}
   */
  async mean(bytes) {
    const { texels, height, width } = await decoded(bytes), sums = [0, 0, 0];
    for (let i = 0; i < texels.length; i += 3) sums[0] += texels[i], sums[1] += texels[i + 1], sums[2] += texels[i + 2];
    return sums.map((sum) => sum / (255 * height * width));
  }

  /** Subtracts a picture's texels from the file's budget, before memory is allocated. @param {number} height @param {number} width */
  count(height, width) {
    if (height * width > this.#left) {
      throw new CoreError(`expected textures of at most ${MAX_FILE_TEXELS.toLocaleString("en")} texels in all, got more`);
    }
    this.#left -= height * width;
  }

  /**
   * Counts a picture twice if one surface uses its alpha and another ignores it.
   *
   * @param {Picture} picture
   * @param {boolean} isCutOut
   */
  show(picture, isCutOut) {
    const shown = this.#shown.get(picture) ?? new Set();
    if (picture.alpha && shown.size && !shown.has(isCutOut)) this.count(picture.height, picture.width);
    this.#shown.set(picture, shown.add(isCutOut));
  }
}

/** FNV-1a of a sample of some thousand bytes. @param {Uint8Array} bytes */
function hashOf(bytes) {
  const step = Math.ceil(bytes.length / 4096);
  let hash = 0x811c9dc5 | 0;
  for (let i = 0; i < bytes.length; i += step) hash = Math.imul(hash ^ bytes[i], 0x01000193);
  return hash;
}

/** The surface of parts without one. @type {Surface} */
export const PLAIN = { material: WHITE };

/** Numbers of surfaces from 0 on, equal for equal appearance. */
export class Looks {
  /** @type {Map<string, number>} */
  #looks = new Map();
  /** @type {Map<Picture | undefined, number>} */
  #pictures = new Map();

  /** @param {Surface} surface */
  number({ texture, material, alphaCutoff }) {
    const { picture, wrap = null } = texture ?? {}, own = this.#pictures.get(picture) ?? this.#pictures.size;
    this.#pictures.set(picture, own);
    const look = `${own} ${wrap} ${alphaCutoff} ${JSON.stringify(material)}`, number = this.#looks.get(look) ?? this.#looks.size;
    this.#looks.set(look, number);
    return number;
  }
}

/**
 * The cutoff of a translucent picture: half, so a ray meets the more visible surface. Undefined if all of it is less opaque, like
 * glass; it is then shown as opaque.
 *
 * @param {Picture | undefined} picture
 */
export const half = (picture) => (picture?.alpha?.some((alpha) => alpha >= 128) ? 0.5 : undefined);

/** @param {Uint8Array<ArrayBuffer>} bytes @param {Pictures} [pictures] of the file, for its budget @returns {Promise<Picture>} */
async function decoded(bytes, pictures) {
  const size = sizeOfPicture(bytes);
  if (!size) throw new CoreError(UNREADABLE);
  const texels = size.height * size.width;
  if (texels > MAX_TEXELS) throw new CoreError(`expected a picture of at most ${MAX_TEXELS.toLocaleString("en")} texels, got more`);
  pictures?.count(size.height, size.width);
  const image = await createImageBitmap(new Blob([withoutExif(bytes)]), { premultiplyAlpha: "none", colorSpaceConversion: "none" }).catch(() => {
    throw new CoreError(UNREADABLE);
  });
  const { height, width } = image;
  if (height * width !== texels) throw new CoreError(UNREADABLE);
  const drawn = drawnPixels(image), isOpaque = !hasClearPixels(drawn), pixels = (!isOpaque && storedPixels(image)) || drawn;
  image.close();
  return { texels: colorsOf(pixels), height, width, ...(!isOpaque && { alpha: alphaOf(pixels) }) };
}

/** Whether any pixel is not opaque. @param {Uint8Array | Uint8ClampedArray} pixels (n, 4) */
function hasClearPixels(pixels) {
  for (let i = 3; i < pixels.length; i += 4) if (pixels[i] !== 255) return true;
  return false;
}

/** @param {Uint8Array | Uint8ClampedArray} pixels (n, 4) @returns {Uint8Array} (n, 3) */
function colorsOf(pixels) {
  const colors = new Uint8Array(pixels.length / 4 * 3);
  for (let from = 0, to = 0; from < pixels.length; from += 4, to += 3) {
    colors[to] = pixels[from], colors[to + 1] = pixels[from + 1], colors[to + 2] = pixels[from + 2];
  }
  return colors;
}

/** @param {Uint8Array | Uint8ClampedArray} pixels (n, 4) @returns {Uint8Array} (n,) */
function alphaOf(pixels) {
  const alpha = new Uint8Array(pixels.length / 4);
  for (let i = 0; i < alpha.length; ++i) alpha[i] = pixels[4 * i + 3];
  return alpha;
}

/** Pixels (H, W, 4) from a canvas, which loses the colours of transparent pixels. @param {ImageBitmap} image */
function drawnPixels(image) {
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (
    new OffscreenCanvas(image.width, image.height).getContext("2d", { willReadFrequently: true })
  );
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height).data;
}

/**
 * Pixels (H, W, 4) of the file, including colours of transparent pixels, which filtering mixes into their neighbours. Undefined
 * without WebGL, or beyond its maximum size.
 *
 * @param {ImageBitmap} image
 */
function storedPixels(image) {
  const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
  if (!gl) return undefined;
  const { width, height } = image, pixels = new Uint8Array(4 * width * height);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, gl.getParameter(gl.TEXTURE_BINDING_2D), 0);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const isRead = gl.getError() === gl.NO_ERROR;
  gl.getExtension("WEBGL_lose_context")?.loseContext();  // browsers limit the number of contexts
  return isRead ? pixels : undefined;
}
