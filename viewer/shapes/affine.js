// @ts-check
/**
 * Affine maps of space: 4x4 matrices as 16 numbers row by row, applied to column vectors.
 *
 * @typedef {ArrayLike<number>} Matrix 16 numbers, the last four 0, 0, 0, 1
 */

/** @type {readonly number[]} */
export const IDENTITY = Object.freeze([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

/** Rotates y up to z up: (x, y, z) becomes (x, -z, y). @type {readonly number[]} */
export const UPRIGHT = Object.freeze([1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]);

/** @param {number} factor @returns {number[]} */
export const scaling = (factor) => [factor, 0, 0, 0, 0, factor, 0, 0, 0, 0, factor, 0, 0, 0, 0, 1];

/** The composition: first b, then a. @param {Matrix} a @param {Matrix} b @returns {number[]} */
export function product(a, b) {
  const result = [];
  for (let row = 0; row < 16; row += 4) {
    for (let column = 0; column < 4; ++column) {
      let sum = 0;
      for (let i = 0; i < 4; ++i) sum += a[row + i] * b[4 * i + column];
      result.push(sum);
    }
  }
  return result;
}

/** The rotation about an axis, 0 to 2. @param {number} axis @param {number} degrees @returns {number[]} */
export function rotation(axis, degrees) {
  const angle = degrees * Math.PI / 180, [i, j] = [(axis + 1) % 3, (axis + 2) % 3], result = [...IDENTITY];
  result[5 * i] = result[5 * j] = Math.cos(angle);
  result[4 * j + i] = Math.sin(angle), result[4 * i + j] = -Math.sin(angle);
  return result;
}

/** Threshold of singular maps, as bobrossnet.shapes.affine.FLATTEST. */
const FLATTEST = 1e-10;

/** Whether a map is singular. @param {import("../core/core.js").Core} core @param {Matrix} map */
export function isSingular(core, map) {
  const [largest, , smallest] = core.filled(new Float64Array(3), (address) => {
    core.call("singular_values", Float64Array.from(map), address);
  });
  return !(smallest > FLATTEST * largest);
}
