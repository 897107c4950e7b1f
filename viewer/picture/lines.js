// @ts-check
/** Lines over a painted picture. Their covered share of each pixel is 0..255, (height, width). */
import { enlargedGray, levelOf } from "./paint.js";

/** @typedef {import("./camera.js").Size} Size */

/** Linear values of sRGB levels. */
const LINEAR = Float64Array.from({ length: 256 }, (_, level) => (level <= 10 ? level / 255 / 12.92 : ((level / 255 + 0.055) / 1.055) ** 2.4));

/** Paints black lines over a picture. @param {Uint8Array} covered @param {ImageData} picture changed */
export function paintLines(covered, { data }) {
  for (let i = 0, at = 0; i < covered.length; ++i, at += 4) {
    if (covered[i] === 0) continue;
    const share = covered[i] / 255, before = data[at + 3] / 255, alpha = before + share * (1 - before);
    for (let k = 0; k < 3; ++k) data[at + k] = Math.round(levelOf(LINEAR[data[at + k]] * before * (1 - share) / alpha));
    data[at + 3] = Math.round(255 * alpha);
  }
}

/** Returns a picture with lines. @param {ImageData} picture unchanged @param {Uint8Array | null} covered null for no lines */
export function withLines(picture, covered) {
  if (!covered) return picture;
  const shown = new ImageData(picture.data.slice(), picture.width);
  paintLines(covered, shown);
  return shown;
}

/** Lines in another size. @param {Uint8Array} covered @param {Size} size theirs @param {Size} wanted @returns {Uint8Array} */
export function enlargedLines(covered, { height, width }, wanted) {
  return new Uint8Array(enlargedGray({ height, width, image: new Float32Array(covered) }, wanted.height, wanted.width));
}
