// @ts-check
/**
 * Affine maps of space: 4x4 matrices as 16 numbers row by row, multiplied from the left to column vectors.
 *
 * @typedef {ArrayLike<number>} Matrix 16 numbers, the last four 0, 0, 0, 1
 */

/** @type {readonly number[]} */
export const IDENTITY = Object.freeze([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

/** Turns y up to z up: (x, y, z) becomes (x, -z, y). @type {readonly number[]} */
export const UPRIGHT = Object.freeze([1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]);

/** What is singular, as bobrossnet.shapes.affine.FLATTEST. */
const FLATTEST = 1e-10;

/** The map that does b first, then a. @param {Matrix} a @param {Matrix} b @returns {number[]} */
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

/** @param {Matrix} m not singular @returns {number[]} */
export function inverse(m) {
  const [a, b, c, x, d, e, f, y, g, h, i, z] = Array.from(m);
  const determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
  const rows = [
    [e * i - f * h, c * h - b * i, b * f - c * e],
    [f * g - d * i, a * i - c * g, c * d - a * f],
    [d * h - e * g, b * g - a * h, a * e - b * d],
  ].map((row) => row.map((value) => value / determinant));
  return [...rows.flatMap(([p, q, r]) => [p, q, r, -(p * x + q * y + r * z)]), 0, 0, 0, 1];
}

/** The map that takes a sphere to the unit sphere. @param {Iterable<number>} center @param {number} radius */
export function toUnitSphere([x, y, z], radius) {
  const s = 1 / radius;
  return [s, 0, 0, -x / radius, 0, s, 0, -y / radius, 0, 0, s, -z / radius, 0, 0, 0, 1];
}

/** The map that takes the unit sphere to a sphere. @param {Iterable<number>} center @param {number} radius */
export function fromUnitSphere([x, y, z], radius) {
  return [radius, 0, 0, x, 0, radius, 0, y, 0, 0, radius, z, 0, 0, 0, 1];
}

/**
 * How much longer vectors become, at most and at least: the singular values of a map's linear part, by one-sided Jacobi
 * rotations, which find small ones as exactly as large ones.
 *
 * @param {Matrix} m
 * @returns {number[]} 3, the largest first
 */
export function singularValues(m) {
  const columns = [0, 1, 2].map((column) => [m[column], m[column + 4], m[column + 8]]);
  const dot = (/** @type {number[]} */ a, /** @type {number[]} */ b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  for (let sweep = 0; sweep < 30; ++sweep) {
    let turned = false;
    for (const [i, j] of [[0, 1], [0, 2], [1, 2]]) {
      const p = columns[i], q = columns[j], pp = dot(p, p), qq = dot(q, q), pq = dot(p, q);
      if (!(Math.abs(pq) > 1e-16 * Math.sqrt(pp * qq))) continue;
      turned = true;
      const half = (qq - pp) / (2 * pq), tangent = (half < 0 ? -1 : 1) / (Math.abs(half) + Math.hypot(1, half));
      const cosine = 1 / Math.hypot(1, tangent), sine = cosine * tangent;
      columns[i] = p.map((value, k) => cosine * value - sine * q[k]);
      columns[j] = p.map((value, k) => sine * value + cosine * q[k]);
    }
    if (!turned) break;
  }
  return columns.map((column) => Math.hypot(...column)).sort((a, b) => b - a);
}

/** Whether a map presses space flat. @param {Matrix} m */
export function isSingular(m) {
  const [largest, , smallest] = singularValues(m);
  return !(smallest > FLATTEST * largest);
}
