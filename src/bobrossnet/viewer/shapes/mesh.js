// @ts-check
/** Triangle meshes. */
import { as } from "../core/core.js";
import { Shape } from "./shape.js";

/**
 * A triangle mesh.
 *
 * @param {import("../core/core.js").Core} core
 * @param {ArrayLike<number>} vertices (V, 3), in any unit, finite
 * @param {ArrayLike<number>} triangles (T, 3), anticlockwise seen from outside
 * @param {ArrayLike<number>} [normals] (V, 3), of any length
 */
export function meshShape(core, vertices, triangles, normals) {
  return new Shape(core, core.made("make_mesh", as(Float64Array, vertices), vertices.length / 3, as(Int32Array, triangles),
                                   triangles.length / 3, normals ? as(Float32Array, normals) : 0));
}
