// @ts-check
/** NURBS surfaces as JSON, as geomdl's `exchange.export_json` writes them. */

import { CoreError, brief, checkInteger, checkList, placedErrors } from "../core/errors.js";
import { IDENTITY } from "../shapes/affine.js";
import { WHITE } from "../tracing/description.js";
import { checkBrep } from "../shapes/splines.js";
import { jsonOf } from "./text.js";

/**
 * @typedef {{size: number[], degrees: number[], knots: number[][], points: number[][], loops: Curve[][]}} Face
 *   points: x, y, z, weight, v fastest
 * @typedef {{degree: number, knots: number[], points: number[][]}} Curve points: u, v, weight
 */

const MAX_DEGREE = 9, MOST = 2 ** 31 - 1;

/**
 * Reads the surfaces of a file: faces of one brep, or of one brep per name. As in geomdl, the inside of a trim is cut away, or the
 * outside if it is `reversed`. Surfaces that are `trimmed` but have no trims in the file are shown whole.
 *
 * @param {ArrayBuffer} bytes
 * @param {string} file its name
 * @returns {import("../tracing/description.js").SceneDescription}
 */
export function readGeomdl(bytes, file) {
  const shape = field(jsonOf(bytes), "shape");
  const kind = field(shape, "type"), data = list(shape, "data");
  if (kind === "curve") throw new CoreError("expected surfaces, got curves, which have no radius");
  if (kind !== "surface") throw new CoreError(`type: expected surface, got ${brief(kind)}`);
  if (!data.length) throw new CoreError("data: expected surfaces, got none");
  if (shape.count !== undefined && shape.count !== data.length) {
    throw new CoreError(`count: expected ${data.length}, the surfaces in data, got ${brief(shape.count)}`);
  }
  /** @type {Map<string, Face[]>} */
  const named = new Map();
  let untrimmed = 0;
  data.forEach((surface, i) => placedErrors(`surface ${i + 1}`, () => {
    const face = readFace(surface), name = surface.name ? text(surface, "name") : file;
    named.set(name, [...(named.get(name) ?? []), face]);
    untrimmed += Number(Boolean(surface.trimmed) && !face.loops.length);
    checkBrep(tensors([face]));
  }));
  const scene = {
    shapes: [...named.values()].map((faces) => ({ kind: /** @type {const} */ ("brep"), ...tensors(faces) })),
    instances: [...named.keys()].map((name, shape) => ({ shape, transform: IDENTITY, material: WHITE, name })),
  };
  if (!untrimmed) return scene;
  const which = `${untrimmed} of ${data.length} faces are trimmed, but the file has no trim curves`;
  return { ...scene, warnings: [`${file}: ${which}: they are shown whole`] };
}

/** @param {any} surface @returns {Face} */
function readFace(surface) {
  const size = ["size_u", "size_v"].map((name) => checkInteger(name, field(surface, name), 2, MOST));
  const degrees = ["degree_u", "degree_v"].map((name) => checkInteger(name, field(surface, name), 1, MAX_DEGREE));
  const knots = ["u", "v"].map((axis, i) => readKnots(surface, `knotvector_${axis}`, size[i] + degrees[i] + 1));
  return { size, degrees, knots, points: readPoints(surface, size[0] * size[1], 3), loops: readLoops(surface, knots) };
}

/**
 * Loops; an odd number of them encloses each kept point.
 *
 * @param {any} surface
 * @param {number[][]} knots
 * @returns {Curve[][]}
 */
function readLoops(surface, knots) {
  if (!surface.trims || (typeof surface.trims === "object" && !Object.keys(surface.trims).length)) return [];
  const trims = list(surface.trims, "data");
  const loops = trims.map((trim, i) => {
    const pieces = placedErrors(`trims[${i}]`, () => {
      return text(trim, "type") === "container" ? list(trim, "data") : [trim];
    });
    return pieces.map((piece, j) => placedErrors(`trims[${i}][${j}]`, () => readCurve(piece)));
  });
  if (loops.length && !trims.some((trim) => trim.reversed)) {
    // Holes need an outer loop, wider than the surface, so that rounding does not matter at its border.
    const [[u0, u1], [v0, v1]] = knots.map((of) => {
      const low = of[0], high = of[of.length - 1];
      return [2 * low - high, 2 * high - low];
    });
    loops.push([polyline([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])]);
  }
  return loops;
}

/** @param {any} piece @returns {Curve} */
function readCurve(piece) {
  const kind = text(piece, "type");
  if (kind === "freeform") {
    const points = list(piece, "points");
    if (points.length < 2) throw new CoreError(`points: expected at least 2, got ${points.length}`);
    points.forEach((point) => checkPoint(point, 2));
    return polyline(points);
  }
  if (kind !== "spline") {
    throw new CoreError(`type: expected spline, freeform or a container of these, got ${brief(kind)}`);
  }
  const count = list(field(piece, "control_points"), "points").length;
  const degree = checkInteger("degree", field(piece, "degree"), 1, MAX_DEGREE);
  return { degree, knots: readKnots(piece, "knotvector", count + degree + 1), points: readPoints(piece, count, 2) };
}

/** Straight lines from point to point. @param {number[][]} points @returns {Curve} */
function polyline(points) {
  const last = points.length - 1;
  return { degree: 1, knots: [0, ...points.keys(), last], points: points.map(([u, v]) => [u, v, 1]) };
}

/** Control points with their weights. @param {any} spline @param {number} count @param {number} dimension */
function readPoints(spline, count, dimension) {
  const fields = field(spline, "control_points"), points = list(fields, "points");
  const weights = fields.weights === undefined ? points.map(() => 1) : numbers(fields, "weights");
  for (const [name, values] of Object.entries({ points, weights })) {
    if (values.length !== count) throw new CoreError(`${name}: expected ${count}, got ${values.length}`);
  }
  return points.map((point, i) => [...checkPoint(point, dimension), weights[i]]);
}

/** @param {any} point @param {number} dimension @returns {number[]} */
function checkPoint(point, dimension) {
  const numbers = checkList("points", point).filter((x) => typeof x === "number");
  if (point.length !== dimension || numbers.length !== dimension) {
    throw new CoreError(`points: expected lists of ${dimension} numbers, got ${brief(JSON.stringify(point))}`);
  }
  return point;
}

/** @param {any} spline @param {string} name @param {number} count */
function readKnots(spline, name, count) {
  const knots = numbers(spline, name);
  if (knots.length !== count) throw new CoreError(`${name}: expected ${count} knots, got ${knots.length}`);
  return knots;
}

/** The arrays of a scene file. @param {Face[]} faces @returns {import("../shapes/splines.js").BrepTensors} */
function tensors(faces) {
  const loops = faces.flatMap((face) => face.loops), curves = loops.flat();
  const integers = (/** @type {number[]} */ values) => Int32Array.from(values);
  const doubles = (/** @type {number[]} */ values) => Float64Array.from(values);
  return {
    faces: integers(faces.flatMap(({ size, degrees, loops }) => [...size, ...degrees, loops.length])),
    control_points: doubles(faces.flatMap(({ points }) => points.flat())),
    knots: doubles(faces.flatMap(({ knots }) => knots.flat())),
    loops: integers(loops.map((loop) => loop.length)),
    trims: integers(curves.flatMap(({ points, degree }) => [points.length, degree])),
    trim_control_points: doubles(curves.flatMap(({ points }) => points.flat())),
    trim_knots: doubles(curves.flatMap(({ knots }) => knots)),
  };
}

/** @param {any} value @param {string} name @returns {any} */
function field(value, name) {
  if (typeof value !== "object" || value === null || Array.isArray(value)) {
    throw new CoreError(`expected an object with ${name}, got ${brief(value)}`);
  }
  if (value[name] === undefined) throw new CoreError(`${name}: expected one, got none`);
  return value[name];
}

/** @param {any} value @param {string} name @returns {any[]} */
const list = (value, name) => checkList(name, field(value, name));

/** @param {any} value @param {string} name @returns {number[]} */
function numbers(value, name) {
  const found = list(value, name), other = found.find((each) => typeof each !== "number");
  if (other !== undefined) throw new CoreError(`${name}: expected lists of numbers, got ${brief(other)}`);
  return found;
}

/** @param {any} value @param {string} name @returns {string} */
function text(value, name) {
  const found = field(value, name);
  if (typeof found !== "string") throw new CoreError(`${name}: expected a string, got ${brief(found)}`);
  return found;
}
