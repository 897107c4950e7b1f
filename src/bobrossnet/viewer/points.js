// @ts-check
/**
 * How far points reach, (n, 3), as numbers one after the other: in loops without functions, since meshes have millions.
 */

/** @typedef {import("./affine.js").Matrix} Matrix */

/**
 * The vertices that a triangle uses.
 *
 * @param {ArrayLike<number>} vertices (V, 3)
 * @param {ArrayLike<number>} triangles (T, 3)
 * @returns {ArrayLike<number>} (n, 3)
 */
export function usedPoints(vertices, triangles) {
  const used = new Uint8Array(vertices.length / 3);
  for (let i = 0; i < triangles.length; ++i) used[triangles[i]] = 1;
  let count = 0;
  for (let i = 0; i < used.length; ++i) count += used[i];
  if (count === used.length) return vertices;
  const points = new Float64Array(3 * count);
  for (let i = 0, at = 0; i < used.length; ++i) {
    if (!used[i]) continue;
    for (let axis = 0; axis < 3; ++axis) points[at++] = vertices[3 * i + axis];
  }
  return points;
}

/**
 * The lowest and highest coordinates of points, (n, 3), moved by a matrix.
 *
 * @param {ArrayLike<number>} points
 * @param {Matrix} matrix
 */
export function pointBounds(points, matrix) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let axis = 0; axis < 3; ++axis) {
    const a = matrix[4 * axis], b = matrix[4 * axis + 1], c = matrix[4 * axis + 2], d = matrix[4 * axis + 3];
    let lowest = Infinity, highest = -Infinity;
    for (let i = 0; i < points.length; i += 3) {
      const value = a * points[i] + b * points[i + 1] + c * points[i + 2] + d;
      if (value < lowest) lowest = value;
      if (value > highest) highest = value;
    }
    low[axis] = lowest, high[axis] = highest;
  }
  return { low, high };
}

/**
 * The distance from a place to the farthest of points, (n, 3), moved by a matrix; not finite where one of them is not.
 *
 * @param {ArrayLike<number>} points @param {number[]} about @param {Matrix} matrix
 */
export function pointRadius(points, about, matrix) {
  const [a, b, c, d, e, f, g, h, i, j, k, l] = Array.from(matrix), [x, y, z] = about;
  const { low, high } = pointBounds(points, matrix);
  const largest = Math.max(...about.flatMap((value, axis) => [high[axis] - value, value - low[axis]]));
  // In units of about the largest coordinate, so that squares stay within float64; a power of two rounds nothing.
  const unit = 2 ** Math.max(-1000, Math.ceil(Math.log2(largest)));
  let farthest = 0;
  for (let n = 0; n < points.length; n += 3) {
    const p = points[n], q = points[n + 1], r = points[n + 2];
    const right = (a * p + b * q + c * r + d - x) / unit, back = (e * p + f * q + g * r + h - y) / unit;
    const up = (i * p + j * q + k * r + l - z) / unit, square = right * right + back * back + up * up;
    if (!(square <= farthest)) farthest = square;  // NaN as well
  }
  return Math.sqrt(farthest) * unit;
}
