// @ts-check
/**
 * Surfaces: what the meshes of a file look like, and the pictures that are laid on them.
 *
 * @typedef {import("../tracing/description.js").Material} Material
 * @typedef {{texels: Uint8Array, height: number, width: number, alpha?: Uint8Array}} Picture
 *   texels (H * W, 3) in sRGB, row 0 at the top, alpha (H * W,), without which all is opaque
 * @typedef {{picture: Picture, wrap: readonly [number, number]}} Texture wrap: across and down, 0 repeated, 1 clamped, 2 mirrored
 * @typedef {{material: Material, texture?: Texture, name?: string, alphaCutoff?: number}} Surface
 *   alphaCutoff: where alpha is below it, there is no surface; without, alpha does not matter
 */

import { CoreError } from "../core/errors.js";
import { WHITE } from "../tracing/description.js";
import { sizeOfPicture } from "./picture_size.js";

const UNREADABLE = "expected a picture in PNG, JPEG or WebP, got none that can be read";

/** Of one texture: 8,192 x 8,192, 0.2 GB. */
const MAX_TEXELS = 2 ** 26;

/** Of all pictures of a file, as bobrossnet.adapters.surface.MAX_FILE_TEXELS. */
const MAX_FILE_TEXELS = 2 ** 27;

/** The pictures of a file: each is decoded once, whatever it is called. */
export class Pictures {
  #left = MAX_FILE_TEXELS;
  /** By their files' lengths and hashes. @type {Map<string, {bytes: Uint8Array, picture: Promise<Picture>}>} */
  #decoded = new Map();
  /** Whether with their alpha, without it, or both. @type {Map<Picture, Set<boolean>>} */
  #shown = new Map();

  /**
   * The texels of a picture's file.
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
   * The mean of a picture's red, green and blue, 0..1. Neither the picture is kept, nor are its texels counted.
   *
   * @param {Uint8Array<ArrayBuffer>} bytes
   * @returns {Promise<number[]>}
   */
  async mean(bytes) {
    const { texels, height, width } = await decoded(bytes), sums = [0, 0, 0];
    for (let i = 0; i < texels.length; i += 3) sums[0] += texels[i], sums[1] += texels[i + 1], sums[2] += texels[i + 2];
    return sums.map((sum) => sum / (255 * height * width));
  }

  /** Takes the texels of a picture from what is left for the file, before there is any memory for them. @param {number} height @param {number} width */
  count(height, width) {
    if (height * width > this.#left) {
      throw new CoreError(`expected textures of at most ${MAX_FILE_TEXELS.toLocaleString("en")} texels in all, got more`);
    }
    this.#left -= height * width;
  }

  /**
   * Counts a picture again where others need its alpha and this surface not, or the other way round.
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

/** FNV-1a of some thousand bytes among them. @param {Uint8Array} bytes */
function hashOf(bytes) {
  const step = Math.ceil(bytes.length / 4096);
  let hash = 0x811c9dc5 | 0;
  for (let i = 0; i < bytes.length; i += step) hash = Math.imul(hash ^ bytes[i], 0x01000193);
  return hash;
}

/** Of parts that have none. @type {Surface} */
export const PLAIN = { material: WHITE };

/** Numbers of surfaces, from 0 on, equal where they look alike. */
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
 * The cutoff for what is transparent by degrees, of which a ray sees what is seen most: half; none where nothing is opaque
 * by more, as of glass, which is shown as if it were.
 *
 * @param {Picture | undefined} picture
 */
export const half = (picture) => (picture?.alpha?.some((alpha) => alpha >= 128) ? 0.5 : undefined);

/** @param {Uint8Array<ArrayBuffer>} bytes @param {Pictures} [pictures] of the file, which count it @returns {Promise<Picture>} */
async function decoded(bytes, pictures) {
  const size = sizeOfPicture(bytes);
  if (!size) throw new CoreError(UNREADABLE);
  const texels = size.height * size.width;
  if (texels > MAX_TEXELS) throw new CoreError(`expected a picture of at most ${MAX_TEXELS.toLocaleString("en")} texels, got more`);
  pictures?.count(size.height, size.width);
  const image = await createImageBitmap(new Blob([bytes]), { premultiplyAlpha: "none", colorSpaceConversion: "none" }).catch(() => {
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

/** Pixels (H, W, 4) as a canvas has them, which forgets the colours of what is transparent. @param {ImageBitmap} image */
function drawnPixels(image) {
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (
    new OffscreenCanvas(image.width, image.height).getContext("2d", { willReadFrequently: true })
  );
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height).data;
}

/**
 * Pixels (H, W, 4) as the file has them, the colours of what is transparent too, which bleed into what is next to it; nothing
 * without WebGL, or where it takes no picture of that size.
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
  gl.getExtension("WEBGL_lose_context")?.loseContext();  // browsers allow few at a time
  return isRead ? pixels : undefined;
}
