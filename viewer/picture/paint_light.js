// @ts-check
/** Conversion of pictures with lights to screen pixels: their values have any range, and shadows cover the background. */
import { UNTRACED, borderOf, encode, expose, pack } from "./paint.js";

/**
 * @param {{mode: import("./paint.js").Mode, divider: number, isTransparent: boolean, exposure?: number}} look as in `paint`; the
 *   modes "difference" and "uncertain" show the completed picture
 * @param {Float32Array} planes (4, height, width): linear RGB times coverage, and coverage
 * @param {Float32Array} mask (height, width): above 0 where a pixel is traced
 * @param {ImageData} painted replaced entirely
 */
export function paintLight({ mode, divider, isTransparent, exposure = 1 }, planes, mask, { data, height, width }) {
  const pixels = new Uint32Array(data.buffer), size = pixels.length;
  expose(1); // its table ends at 1, which values times an exposure below 1 may reach
  for (let i = 0; i < size; ++i) {
    const coverage = isTransparent ? planes[3 * size + i] : 1, factor = exposure / Math.max(coverage, 1 / 255);
    const color = pack(encode(factor * planes[i]), encode(factor * planes[size + i]), encode(factor * planes[2 * size + i]));
    pixels[i] = (color & 0xffffff | Math.round(255 * coverage) << 24) >>> 0;
  }
  const border = borderOf(mode, divider, width);
  for (let row = 0; row < height; ++row) {
    for (let column = 0, i = row * width; column < border; ++column, ++i) if (!(mask[i] > 0)) pixels[i] = UNTRACED;
  }
}
