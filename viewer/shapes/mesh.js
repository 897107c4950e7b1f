// @ts-check
/** Triangle meshes. */
import { as } from "../core/core.js";
import { Shape } from "./shape.js";

/**
 * A triangle mesh.
 *
 * @param {import("../core/core.js").Core} core
 * @param {import("./description.js").MeshDescription} description
 * @param {number} [picture] in the core
 */
export function meshShape(core, description, picture = 0) {
  const { vertices, triangles, normals, colors, face_colors, uv, texture_layout, alphas, alpha_cutoff } = description;
  const [, , across, down] = texture_layout ?? [0, 0, 0, 0];
  /** @param {ArrayLike<number> | undefined} array */
  const floats = (array) => (array ? as(Float32Array, array) : 0);
  return new Shape(core, core.made("make_mesh", as(Float64Array, vertices), vertices.length / 3, as(Int32Array, triangles),
                                   triangles.length / 3, floats(normals), floats(colors), floats(face_colors), floats(uv),
                                   picture, across, down, floats(alphas), alpha_cutoff?.[0] ?? 0));
}
