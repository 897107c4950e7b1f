// @ts-check
/** Conversion of G-buffers and completed pictures to screen pixels. */
import { COLORED, GBUFFER, placeOf } from "./channels.js";

/** @typedef {"completed" | "traced" | "split" | "difference" | "uncertain"} Mode */

/** Green for untraced pixels, different from every gray; as in bobrossnet/picture/files.py. */
export const UNTRACED = pack(0, 150, 70);

/** Magnification of errors. */
export const ERROR_GAIN = 4;

/**
 * @param {number} red @param {number} green @param {number} blue each 0..255 @returns {number} in ImageData's format,
 *   little-endian
 */
export function pack(red, green, blue) {
  return (0xff000000 | blue << 16 | green << 8 | red) >>> 0;
}

/** Rounds as numpy does, halves to even, and clamps. */
const byte = new Uint8ClampedArray(1);

/** The pixel of a map's value, such as an error. @param {number} value 0..1 */
function level(value) {
  byte[0] = 255 * value;
  return (0xff000000 | byte[0] * 0x010101) >>> 0;
}

/** The level of sRGB, 0..255, not rounded. @param {number} value linear, 0..1 */
export const levelOf = (value) => 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);

/** sRGB by a table of linear values, fine enough for each of its 256 steps. @param {number} exposure factor of the values */
const tableOf = (exposure) => Uint8ClampedArray.from({ length: 2 ** 14 + 1 }, (_, i) => levelOf(exposure * i / 2 ** 14));

let exposed = 1, SRGB = tableOf(exposed);

/** Sets the factor of the values to encode. @param {number} exposure */
export function expose(exposure) {
  if (exposure !== exposed) SRGB = tableOf(exposed = exposure);
}

/** @param {number} value linear, 0..1, or slightly more by rounding */
export const encode = (value) => SRGB[Math.max(0, Math.min(2 ** 14, Math.round(2 ** 14 * value)))];

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
  expose(exposure);
  if (mode === "difference" && exact) {
    differ(first, image, pixels);
    return;
  }
  if (mode === "uncertain" && expected) {
    for (let i = 0; i < pixels.length; ++i) pixels[i] = level(ERROR_GAIN * expected[i]);
    return;
  }
  if (alpha) coverAll(image, completedColor, alpha, pixels);
  else if (completedColor) tintAll(completedColor, pixels);
  else shadeAll(image, pixels);
  const border = borderOf(mode, divider, width);
  for (let row = 0; row < height; ++row) {
    for (let column = 0, i = row * width; column < border; ++column, ++i) {
      pixels[i] = !(mask[i] > 0) ? UNTRACED : color ? tint(color, pixels.length, i) : shade(gray[i]);
    }
  }
}

/** Columns of a picture that show traced pixels alone. @param {Mode} mode @param {number} divider @param {number} width */
export const borderOf = (mode, divider, width) => (mode === "traced" ? width : mode === "split" ? Math.round(divider * width) : 0);

/** Shows the differences of two pictures. @param {Float32Array} first @param {Float32Array} image @param {Uint32Array} pixels */
function differ(first, image, pixels) {
  for (let i = 0; i < pixels.length; ++i) pixels[i] = level(ERROR_GAIN * Math.abs(first[i] - image[i]));
}

// ---- Pictures at rest, row by row ------------------------------------------------------------------------

/**
 * A picture in another size.
 *
 * @param {ImageData} picture @param {number} height @param {number} width
 */
export function enlarged(picture, height, width) {
  if (picture.height === height && picture.width === width) return new ImageData(picture.data.slice(), width);
  const [from, to] = [picture, { height, width }].map((size) => {
    return /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(size.width, size.height).getContext("2d"));
  });
  from.putImageData(picture, 0, 0);
  to.imageSmoothingQuality = "high";
  to.drawImage(from.canvas, 0, 0, width, height);
  return to.getImageData(0, 0, width, height);
}

/**
 * The same for gray levels, bilinearly.
 *
 * @param {{height: number, width: number, image: Float32Array}} picture @param {number} height @param {number} width
 */
export function enlargedGray(picture, height, width) {
  if (picture.height === height && picture.width === width) return picture.image.slice();
  const { image } = picture, gray = new Float32Array(height * width);
  const places = (/** @type {number} */ to, /** @type {number} */ from) => Array.from({ length: to }, (_, i) => {
    const place = Math.max(0, Math.min(from - 1, (i + 0.5) * from / to - 0.5)), first = Math.floor(place);
    return { first, second: Math.min(from - 1, first + 1), share: place - first };
  });
  const columns = places(width, picture.width);
  places(height, picture.height).forEach(({ first, second, share }, row) => {
    const above = first * picture.width, below = second * picture.width;
    for (let column = 0; column < width; ++column) {
      const { first: left, second: right, share: across } = columns[column];
      const upper = image[above + left] + across * (image[above + right] - image[above + left]);
      const lower = image[below + left] + across * (image[below + right] - image[below + left]);
      gray[row * width + column] = upper + share * (lower - upper);
    }
  });
  return gray;
}

/**
 * Paints traced rows.
 *
 * @param {import("./gbuffer.js").Strip} strip @param {boolean} isColored
 * @param {{isTransparent: boolean, exposure?: number}} look as in `paint`
 * @param {ImageData} painted
 */
export function paintStrip({ begin, end, planes }, isColored, { isTransparent, exposure = 1 }, { data, width }) {
  expose(exposure);
  const layout = isColored ? COLORED : GBUFFER, size = (end - begin) * width;
  const plane = (/** @type {string} */ channel, count = 1) => planes.subarray(placeOf(layout, channel) * size, (placeOf(layout, channel) + count) * size);
  const pixels = new Uint32Array(data.buffer, 4 * begin * width, size);
  if (isColored) tintAll(plane("color", 3), pixels);
  else shadeAll(plane("gray"), pixels);
  if (!isTransparent) return;
  const depth = plane("depth");
  for (let i = 0; i < size; ++i) if (!(depth[i] > 0)) pixels[i] = 0;
}

/**
 * Paints means over pixels.
 *
 * @param {{pixels: Int32Array, means: Float32Array}} means as in workers/tracer.js
 * @param {{isTransparent: boolean, exposure?: number}} look as in `paint`
 * @param {ImageData} painted
 */
export function paintMeans({ pixels, means }, { isTransparent, exposure = 1 }, { data, width }) {
  expose(exposure);
  const painted = new Uint32Array(data.buffer);
  for (let i = 0; 2 * i < pixels.length; ++i) {
    const alpha = isTransparent ? means[5 * i + 4] : 1, whole = Math.max(alpha, 1 / 255);
    painted[pixels[2 * i] * width + pixels[2 * i + 1]] = (tint(means, 1, 5 * i + 1, whole) & 0xffffff | Math.round(255 * alpha) << 24) >>> 0;
  }
}

/**
 * A resting picture in a display mode.
 *
 * @param {{mode: Mode, divider: number, rows: number, gray: Float32Array | null, first: Float32Array | null}} look
 *   rows: number of traced ones; gray, first: (height, width), as in `paint`; null if unknown
 * @param {ImageData} picture in the mode "completed"
 * @returns {ImageData} the same, or another one
 */
export function paintRest({ mode, divider, rows, gray, first }, picture) {
  const { height, width } = picture, isWhole = rows === height;
  const border = borderOf(mode, divider, width);
  const differs = mode === "difference" && isWhole && gray && first;
  if (!differs && !(mode === "uncertain" && isWhole) && (border === 0 || isWhole)) return picture;
  const shown = new ImageData(picture.data.slice(), width), pixels = new Uint32Array(shown.data.buffer);
  if (differs) {
    differ(first, gray, pixels);
  } else if (mode === "uncertain") {
    pixels.fill(level(0));
  }
  for (let row = rows; row < height; ++row) pixels.fill(UNTRACED, row * width, row * width + border);
  return shown;
}
