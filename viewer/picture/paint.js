// @ts-check
/** Conversion of G-buffers and completed pictures to screen pixels. */

/** @typedef {"completed" | "traced" | "split" | "difference" | "uncertain"} Mode */

/** Green for untraced pixels, different from every gray; as in bobrossnet/picture/files.py. */
const UNTRACED = pack(0, 150, 70);

/** Magnification of errors. */
export const ERROR_GAIN = 4;

/**
 * @param {number} red @param {number} green @param {number} blue each 0..255 @returns {number} in ImageData's format,
 *   little-endian
 */
function pack(red, green, blue) {
  return (0xff000000 | blue << 16 | green << 8 | red) >>> 0;
}

/** Rounds as numpy does, halves to even, and clamps. */
const byte = new Uint8ClampedArray(1);

/** The pixel of a map's value, such as an error. @param {number} value 0..1 */
function level(value) {
  byte[0] = 255 * value;
  return (0xff000000 | byte[0] * 0x010101) >>> 0;
}

/** sRGB by a table of linear values, fine enough for each of its 256 steps. @param {number} exposure factor of the values */
const tableOf = (exposure) => Uint8ClampedArray.from({ length: 2 ** 14 + 1 }, (_, i) => {
  const value = exposure * i / 2 ** 14;
  return 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);
});

let exposed = 1, SRGB = tableOf(exposed);

/** @param {number} value linear, 0..1, or slightly more by rounding */
const encode = (value) => SRGB[Math.max(0, Math.min(2 ** 14, Math.round(2 ** 14 * value)))];

/** The pixel of a gray value. @param {number} gray linear, 0..1 */
const shade = (gray) => (0xff000000 | encode(gray) * 0x010101) >>> 0;

/**
 * The pixel of linear RGB, (3, height, width), at index i.
 *
 * @param {Float32Array} color @param {number} size @param {number} i @param {number} [coverage] factor to divide out
 */
function tint(color, size, i, coverage = 1) {
  return pack(encode(color[i] / coverage), encode(color[size + i] / coverage), encode(color[2 * size + i] / coverage));
}

// Loops over whole pictures, one per kind of arrays. Calling a chosen function in the loop takes three times as long.

/** @param {Float32Array} grays @param {Uint32Array} pixels */
function shadeAll(grays, pixels) {
  for (let i = 0; i < pixels.length; ++i) pixels[i] = shade(grays[i]);
}

/** @param {Float32Array} color @param {Uint32Array} pixels */
function tintAll(color, pixels) {
  const size = pixels.length;
  for (let i = 0; i < size; ++i) {
    pixels[i] = 0xff000000 | encode(color[2 * size + i]) << 16 | encode(color[size + i]) << 8 | encode(color[i]);
  }
}

/**
 * For a transparent picture; colours are divided by their coverage, as ImageData expects.
 *
 * @param {Float32Array} image @param {Float32Array | null | undefined} color @param {Float32Array} alpha @param {Uint32Array} pixels
 */
function coverAll(image, color, alpha, pixels) {
  for (let i = 0; i < pixels.length; ++i) {
    const coverage = Math.min(1, Math.max(0, alpha[i])), whole = Math.max(coverage, 1 / 255);
    const shown = color ? tint(color, pixels.length, i, whole) : shade(image[i] / whole);
    pixels[i] = shown & 0xffffff | Math.round(255 * coverage) << 24;
  }
}

/**
 * @param {{
 *   mode: Mode, divider: number, mask: Float32Array, gray: Float32Array, image: Float32Array, first: Float32Array,
 *   expected: Float32Array | null, exact: boolean, color?: Float32Array | null, completedColor?: Float32Array | null,
 *   alpha?: Float32Array | null, exposure?: number
 * }} look
 *   arrays (height, width), 0..1; color, completedColor: gray and image in linear RGB, (3, height, width), if there are
 *   colours; first: the first completed picture; expected: predicted errors of `image`; divider: 0..1, a split picture
 *   has traced pixels to the left of it; alpha: coverage of each completed pixel, if the picture is transparent; until
 *   the picture is exact, a difference shows the completed picture
 * @param {ImageData} painted replaced entirely
 */
export function paint(look, painted) {
  const { mode, divider, mask, gray, image, first, expected, exact, color, completedColor, alpha, exposure = 1 } = look, { height, width } = painted;
  const pixels = new Uint32Array(painted.data.buffer);
  if (exposure !== exposed) SRGB = tableOf(exposed = exposure);
  if (mode === "difference" && exact) {
    for (let i = 0; i < pixels.length; ++i) pixels[i] = level(ERROR_GAIN * Math.abs(first[i] - image[i]));
    return;
  }
  if (mode === "uncertain" && expected) {
    for (let i = 0; i < pixels.length; ++i) pixels[i] = level(ERROR_GAIN * expected[i]);
    return;
  }
  if (alpha) coverAll(image, completedColor, alpha, pixels);
  else if (completedColor) tintAll(completedColor, pixels);
  else shadeAll(image, pixels);
  const border = mode === "traced" ? width : mode === "split" ? Math.round(divider * width) : 0;
  for (let row = 0; row < height; ++row) {
    for (let column = 0, i = row * width; column < border; ++column, ++i) {
      pixels[i] = !(mask[i] > 0) ? UNTRACED : color ? tint(color, pixels.length, i) : shade(gray[i]);
    }
  }
}
