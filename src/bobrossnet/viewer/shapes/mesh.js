// @ts-check
/** Triangle meshes. */
import { as } from "../core/core.js";
import { CoreError } from "../core/errors.js";
import { IDENTITY } from "./affine.js";
import { Shape } from "./shape.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("./affine.js").Matrix} Matrix
 */

/** Radius of a shape, in its own units, whose reciprocal float64 can hold. */
const SMALLEST = 1e-307;

/** A mesh, whose extents are those of the vertices that its triangles use. */
export class Mesh extends Shape {
  #vertices;

  /**
   * @param {Core} core
   * @param {ArrayLike<number>} vertices (V, 3), in any unit, finite
   * @param {ArrayLike<number>} triangles (T, 3), anticlockwise seen from outside
   * @param {ArrayLike<number>} [normals] (V, 3), of any length
   */
  constructor(core, vertices, triangles, normals) {
    const corners = as(Int32Array, triangles), all = new Vertices(core, as(Float64Array, vertices), corners);
    try {
      const { low, high } = all.bounds(IDENTITY);
      const center = low.map((value, axis) => value / 2 + high[axis] / 2), radius = all.radius(center, IDENTITY);
      if (!Number.isFinite(radius)) throw new CoreError("vertices: expected finite numbers, got NaN or infinite ones");
      const size = radius > SMALLEST ? radius : 1;
      super(core, core.made("make_mesh", all.address, all.count, ...center, size, corners, corners.length / 3,
                            normals ? as(Float32Array, normals) : 0), center, size);
    } catch (error) {
      all.free();
      throw error;
    }
    this.#vertices = all;
  }

  /** @override @param {Matrix} matrix */
  bounds(matrix) {
    return this.#vertices.bounds(matrix);
  }

  /** @override @param {number[]} about @param {Matrix} matrix */
  radius(about, matrix) {
    return this.#vertices.radius(about, matrix);
  }

  /** @override */
  free() {
    super.free();
    this.#vertices.free();
  }
}

/** The vertices of a mesh in its own units, in the core. */
class Vertices {
  /** @param {Core} core @param {Float64Array} vertices (V, 3) @param {Int32Array} triangles (T, 3) */
  constructor(core, vertices, triangles) {
    this.core = core;
    this.count = vertices.length / 3;
    this.address = core.put(vertices);
    this.used = core.allocate(this.count);
    try {
      core.made("mark_used", triangles, triangles.length / 3, this.used, this.count);
    } catch (error) {
      this.free();
      throw error;
    }
  }

  /** @param {Matrix} matrix @returns {{low: number[], high: number[]}} of those that a triangle uses, moved by a matrix */
  bounds(matrix) {
    const box = Array.from(this.core.filled(new Float64Array(6), (address) => {
      this.core.call("point_bounds", this.address, this.used, this.count, Float64Array.from(matrix), address);
    }));
    return { low: box.slice(0, 3), high: box.slice(3) };
  }

  /** @param {number[]} about @param {Matrix} matrix @returns {number} the distance to the farthest, not finite where one is not */
  radius(about, matrix) {
    return this.core.call("point_radius", this.address, this.used, this.count, Float64Array.from(matrix), Float64Array.from(about));
  }

  free() {
    this.core.release(this.address);
    this.core.release(this.used);
  }
}
