// @ts-check
/**
 * NURBS as shapes: checks the tensors of breps and tubes in scene files. Names and symbols as in Piegl and Tiller, *The
 * NURBS Book*.
 *
 * @typedef {{faces: Int32Array, control_points: Float64Array, knots: Float64Array, loops: Int32Array, trims:
 *   Int32Array,
 *            trim_control_points: Float64Array, trim_knots: Float64Array, tolerance?: Float64Array, face_colors?: Float32Array,
 *            face_numbers?: Int32Array}} BrepTensors
 * @typedef {{control_points: Float64Array, knots: Float64Array, radii: Float64Array, weights?: Float64Array}}
 *   TubeTensors
 */

import { CoreError, checkFinite, checkInteger, checkNumber, placedErrors } from "../core/errors.js";
import { Shape } from "./shape.js";

/** @typedef {import("../core/core.js").Core} Core */

const MAX_DEGREE = 9;
const MAX_COORDINATE = 1e100;
const MAX_WEIGHT_RATIO = 1e10;

/**
 * The shape of a brep's tensors.
 *
 * @param {Core} core
 * @param {BrepTensors} tensors
 */
export function brepShape(core, tensors) {
  checkBrep(tensors);
  const { faces, control_points, knots, loops, trims, trim_control_points, trim_knots, tolerance, face_colors } = tensors;
  return new Shape(core, core.made("make_brep", faces, faces.length / 5, control_points, knots, loops, trims,
                                   trim_control_points, trim_knots, tolerance?.[0] ?? 0, face_colors ?? 0));
}

/**
 * The shape of a tube's tensors.
 *
 * @param {Core} core
 * @param {TubeTensors} tensors
 */
export function tubeShape(core, tensors) {
  checkTube(tensors);
  const { control_points: points, knots, radii, weights } = tensors, count = radii.length;
  const balls = new Float64Array(5 * count); // x, y, z, radius and weight
  radii.forEach((radius, i) => balls.set([...points.subarray(3 * i, 3 * i + 3), radius, weights?.[i] ?? 1], 5 * i));
  return new Shape(core, core.made("make_tube", balls, count, knots, knots.length - count - 1));
}

// ---- Checks ----------------------------------------------------------------------------------------------

/** Throws a CoreError unless the tensors form a brep. @param {BrepTensors} tensors */
export function checkBrep(tensors) {
  const { faces, loops, trims, tolerance, face_colors, face_numbers } = tensors;
  const takeLoops = pieces("loops", loops), takeTrims = pieces("trims", trims, 2);
  const takeKnots = pieces("knots", tensors.knots), takePoints = pieces("control_points", tensors.control_points, 4);
  const takeTrimKnots = pieces("trim_knots", tensors.trim_knots);
  const takeTrimPoints = pieces("trim_control_points", tensors.trim_control_points, 3);
  if (faces.length === 0 || faces.length % 5) {
    throw new CoreError(`faces: expected rows of five, at least one, got ${faces.length} numbers`);
  }
  for (let i = 0; i < faces.length / 5; ++i) {
    const [n, m, p, q, loopCount] = faces.subarray(5 * i, 5 * i + 5);
    placedErrors(`faces[${i}]`, () => {
      checkSize(n, p), checkSize(m, q), checkInteger("loops", loopCount, 0, loops.length);
      checkPoints("control_points", takePoints(n * m), 4);
      checkKnots("knots_u", takeKnots(n + p + 1), n, p);
      checkKnots("knots_v", takeKnots(m + q + 1), m, q);
      for (let loop = 0; loop < loopCount; ++loop) {
        for (let curve = 0, curves = takeLoops(1)[0]; curve < curves; ++curve) {
          placedErrors(`trims[${loop}][${curve}]`, () => {
            const [count, degree] = takeTrims(1);
            checkSize(count, degree);
            checkPoints("control_points", takeTrimPoints(count), 3);
            checkKnots("knots", takeTrimKnots(count + degree + 1), count, degree);
          });
        }
      }
    });
  }
  for (const take of [takeLoops, takeTrims, takeKnots, takePoints, takeTrimKnots, takeTrimPoints]) take(0, true);
  if (tolerance && tolerance.length !== 1) {
    throw new CoreError(`tolerance: expected one number, got ${tolerance.length}`);
  }
  if (tolerance) checkNumber("tolerance", tolerance[0], 0, Number.MAX_VALUE);
  if (face_colors && 5 * face_colors.length !== 3 * faces.length) {
    throw new CoreError(`face_colors: expected one for each of ${faces.length / 5} faces, got ${face_colors.length / 3}`);
  }
  if (face_numbers && 5 * face_numbers.length !== faces.length) {
    throw new CoreError(`face_numbers: expected one for each of ${faces.length / 5} faces, got ${face_numbers.length}`);
  }
  if (face_numbers?.some((number) => number < 0)) throw new CoreError("face_numbers: expected integers of at least 0");
  if (face_colors?.some((value) => !(value >= 0 && value <= 1))) throw new CoreError("face_colors: expected numbers in 0..1");
}

/** Throws a CoreError unless the tensors form a tube. @param {TubeTensors} tensors */
export function checkTube({ control_points: points, knots, radii, weights }) {
  const count = points.length / 3, degree = knots.length - count - 1;
  for (const [name, array, size] of /** @type {const} */ ([["radii", radii, count], ["weights", weights, count]])) {
    if (array && array.length !== size) {
      throw new CoreError(`${name}: expected ${size}, one for each control point, got ${array.length}`);
    }
    if (array) checkAboveZero(name, array);
  }
  checkSize(count, degree);
  checkCoordinates("control_points", points);
  if (points.every((value, i) => value === points[i % 3])) {
    throw new CoreError(`control_points: expected at least two that differ, got one place ${count} times`);
  }
  if (weights) checkWeights(weights);
  checkKnots("knots", knots, count, degree);
}

/** @param {number} count of control points @param {number} degree */
function checkSize(count, degree) {
  if (!(count >= 2)) throw new CoreError(`control_points: expected at least 2, got ${count}`);
  checkInteger("degree", degree, 1, Math.min(MAX_DEGREE, count - 1));
}

/** Checks points whose last number is a weight. @param {string} name @param {Float64Array} points @param {number} width */
function checkPoints(name, points, width) {
  checkCoordinates(name, points);
  checkWeights(points.filter((_, i) => i % width === width - 1));
}

/** @param {Float64Array} weights */
function checkWeights(weights) {
  checkAboveZero("weights", weights);
  const low = weights.reduce((a, b) => Math.min(a, b)), high = weights.reduce((a, b) => Math.max(a, b));
  if (high / MAX_WEIGHT_RATIO > low) {
    throw new CoreError(`weights: expected weights within a factor of ${MAX_WEIGHT_RATIO}, got ${low} to ${high}`);
  }
}

/** @param {string} name @param {Float64Array} values */
function checkAboveZero(name, values) {
  checkCoordinates(name, values);
  const wrong = values.find((value) => !(value > 0));
  if (wrong !== undefined) throw new CoreError(`${name}: expected numbers above 0, got ${wrong}`);
}

/** @param {string} name @param {Float64Array} values finite, with finite products */
export function checkCoordinates(name, values) {
  checkFinite(name, values);
  const wrong = values.find((value) => Math.abs(value) > MAX_COORDINATE);
  if (wrong !== undefined) {
    throw new CoreError(`${name}: expected numbers of at most ${MAX_COORDINATE} in size, got ${wrong}`);
  }
}

/**
 * @param {string} name
 * @param {Float64Array} knots (count + degree + 1,)
 * @param {number} count
 * @param {number} degree
 */
function checkKnots(name, knots, count, degree) {
  checkCoordinates(name, knots);
  for (let i = 1; i < knots.length; ++i) {
    if (knots[i] < knots[i - 1]) {
      throw new CoreError(`${name}: expected numbers that never decrease, got ${knots[i - 1]}, then ${knots[i]}`);
    }
    if (i > degree && knots[i] === knots[i - degree - 1]) {
      const most = `at most degree + 1 = ${degree + 1} times`;
      throw new CoreError(`${name}: expected a knot ${most}, got ${knots[i]} more often`);
    }
  }
  if (knots[degree] === knots[count]) {
    throw new CoreError(`${name}: expected a domain, ${name}[${degree}] to ${name}[${count}], that is not empty`);
  }
}

/**
 * Splits an array into pieces, from its beginning to its end.
 *
 * @template {Int32Array | Float64Array} T
 * @param {string} name @param {T} array @param {number} [width] of a row
 * @returns {(count: number, last?: boolean) => T} the next rows; `last` requires that no rows remain
 */
function pieces(name, array, width = 1) {
  let at = 0;
  return (count, last = false) => {
    const end = at + count * width;
    if (end > array.length || (last && end < array.length)) {
      throw new CoreError(`${name}: expected ${end}${last ? "" : " and more"} numbers, got ${array.length}`);
    }
    const piece = array.subarray(at, end);
    at = end;
    return /** @type {T} */ (piece);
  };
}
