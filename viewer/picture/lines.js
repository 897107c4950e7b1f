// @ts-check
/** Lines over a painted picture. */

/** Linear values of sRGB levels. */
const LINEAR = Float64Array.from({ length: 256 }, (_, level) => (level <= 10 ? level / 255 / 12.92 : ((level / 255 + 0.055) / 1.055) ** 2.4));

/** @param {number} value linear, 0..1 */
const levelOf = (value) => Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));

/**
 * Paints black lines over rows of a picture.
 *
 * @param {{begin: number, covered: Uint8Array}} band the first row, and the share of pixels that lines cover, 0..255
 * @param {{data: Uint8ClampedArray, width: number}} picture changed
 */
export function paintLines({ begin, covered }, { data, width }) {
  for (let i = 0, at = 4 * begin * width; i < covered.length; ++i, at += 4) {
    if (covered[i] === 0) continue;
    const share = covered[i] / 255, before = data[at + 3] / 255, alpha = before + share * (1 - before);
    for (let k = 0; k < 3; ++k) data[at + k] = levelOf(LINEAR[data[at + k]] * before * (1 - share) / alpha);
    data[at + 3] = Math.round(255 * alpha);
  }
}
