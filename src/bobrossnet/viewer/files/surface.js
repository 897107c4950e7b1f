// @ts-check
/**
 * Surfaces: what the meshes of a file look like, and the pictures that are laid on them.
 *
 * @typedef {import("../tracing/description.js").Material} Material
 * @typedef {{texels: Uint8Array, height: number, width: number}} Picture texels (H * W, 3) in sRGB, row 0 at the top
 * @typedef {{picture: Picture, wrap: readonly [number, number]}} Texture wrap: across and down, 0 repeated, 1 clamped, 2 mirrored
 * @typedef {{material: Material, texture?: Texture, name?: string}} Surface
 */

import { CoreError } from "../core/errors.js";
import { WHITE } from "../tracing/description.js";

/** Of one texture: 8,192 x 8,192, 0.2 GB. */
const MAX_TEXELS = 2 ** 26;

/** Of parts that have none. @type {Surface} */
export const PLAIN = { material: WHITE };

/** Whether surfaces look alike. @param {Surface} a @param {Surface} b */
export function alike(a, b) {
  const { picture: first, wrap = null } = a.texture ?? {}, { picture: second, wrap: other = null } = b.texture ?? {};
  return first === second && String(wrap) === String(other) && JSON.stringify(a.material) === JSON.stringify(b.material);
}

/** Linear light of an sRGB value, both 0..1, after IEC 61966-2-1. @param {number} value */
export const fromSrgb = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);

/** A number as near to it as 0..1 allows; `otherwise` where it is none. @param {unknown} value @param {number} otherwise */
export function unit(value, otherwise) {
  return typeof value === "number" && Number.isFinite(value) ? Math.min(Math.max(value, 0), 1) : otherwise;
}

/**
 * The texels of a picture's file.
 *
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @returns {Promise<Picture>}
 */
export async function decoded(bytes) {
  const image = await createImageBitmap(new Blob([bytes]), { premultiplyAlpha: "none", colorSpaceConversion: "none" }).catch(() => {
    throw new CoreError("expected a picture in PNG, JPEG or WebP, got none that can be read");
  });
  const { height, width } = image;
  if (height * width > MAX_TEXELS) throw new CoreError(`expected a picture of at most ${MAX_TEXELS} texels, got ${width} x ${height}`);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (
    new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true })
  );
  context.drawImage(image, 0, 0);
  image.close();
  const { data } = context.getImageData(0, 0, width, height), texels = new Uint8Array(3 * height * width);
  for (let from = 0, to = 0; from < data.length; from += 4) {
    texels[to++] = data[from], texels[to++] = data[from + 1], texels[to++] = data[from + 2];
  }
  return { texels, height, width };
}
