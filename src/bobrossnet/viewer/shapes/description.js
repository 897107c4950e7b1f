// @ts-check
/**
 * Shapes as plain objects, which messages between workers can carry.
 *
 * @typedef {{kind: "mesh", vertices: Float64Array, triangles: Int32Array, normals?: Float32Array}} MeshDescription
 *   (V, 3), (T, 3) and (V, 3)
 * @typedef {{kind: "implicit", bounds?: Float64Array} & import("./implicit.js").Nodes} ImplicitDescription
 * @typedef {{kind: "script", source: string}} ScriptDescription of docs/scripts.md
 * @typedef {{kind: "formula", text: string, bounds?: ArrayLike<number>}} FormulaDescription of a .vm file
 * @typedef {{kind: "brep"} & import("./splines.js").BrepTensors} BrepDescription
 * @typedef {{kind: "tube"} & import("./splines.js").TubeTensors} TubeDescription
 * @typedef {MeshDescription | ImplicitDescription | ScriptDescription | FormulaDescription | BrepDescription |
 *   TubeDescription}
 *   ShapeDescription arrays as in scene files (CONVENTIONS.md)
 */

export {};
