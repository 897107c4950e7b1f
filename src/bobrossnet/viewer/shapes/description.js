// @ts-check
/**
 * Shapes as plain objects, which messages between workers can carry, and what the core makes of them.
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

import { formulaShape, implicitShape, scriptShape } from "./implicit.js";
import { Mesh } from "./mesh.js";
import { brep, tube } from "./splines.js";

/**
 * @param {import("../core/core.js").Core} core
 * @param {ShapeDescription} description
 * @returns {import("./shape.js").Shape} whoever asked for it frees it
 * @throws {CoreError} of one line, if it has no surface, or is not bounded
 */
export function makeShape(core, description) {
  switch (description.kind) {
    case "mesh": return new Mesh(core, description.vertices, description.triangles, description.normals);
    case "implicit": return implicitShape(core, description, description.bounds);
    case "script": return scriptShape(core, description.source);
    case "formula": return formulaShape(core, description.text, description.bounds);
    case "brep": return brep(core, description);
    case "tube": return tube(core, description);
  }
}
