// @ts-check
/**
 * Shapes as plain objects, which messages between workers can carry.
 *
 * @typedef {{kind: "mesh", vertices: Float64Array, triangles: Int32Array, normals?: Float32Array, colors?: Float32Array,
 *   face_colors?: Float32Array, uv?: Float32Array, texture?: Uint8Array, texture_layout?: Int32Array, alphas?: Float32Array,
 *   texture_alpha?: Uint8Array, alpha_cutoff?: Float64Array}} MeshDescription
 *   vertices (V, 3), in any unit, finite; triangles (T, 3), anticlockwise seen from outside; normals (V, 3), of any length; colors
 *   (V, 3) and face_colors (T, 3) in linear RGB; uv (V, 2), texture (H * W, 3) in sRGB, and texture_layout: H, W, and
 *   the wrap mode; alphas (V,), texture_alpha (H * W,), and alpha_cutoff (1,), below which there is no surface. Meshes
 *   whose texture and texture_alpha are the same arrays share a picture.
 * @typedef {{kind: "implicit", bounds?: Float64Array} & import("./implicit.js").Nodes} ImplicitDescription
 * @typedef {{kind: "script", source: string}} ScriptDescription of docs/scripts.md
 * @typedef {{kind: "formula", text: string, bounds?: ArrayLike<number>}} FormulaDescription of a .vm file
 * @typedef {{kind: "brep"} & import("./splines.js").BrepTensors} BrepDescription
 * @typedef {{kind: "tube"} & import("./splines.js").TubeTensors} TubeDescription
 * @typedef {MeshDescription | ImplicitDescription | ScriptDescription | FormulaDescription | BrepDescription |
 *   TubeDescription}
 *   ShapeDescription arrays as in scene files (docs/reference/scene-files.md)
 */

export {};
