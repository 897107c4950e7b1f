// @ts-check
/** Surfaces of formulas: from scripts, .vm files, and the arrays of scene files. */
import { as } from "../core/core.js";
import { placedErrors } from "../core/errors.js";
import { Shape } from "./shape.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {{ops: Uint8Array, operands: Uint32Array, values: Float64Array, mesh_sizes?: Uint32Array, mesh_vertices?: Float32Array,
 *   mesh_triangles?: Uint32Array, color_ops?: Uint8Array, color_operands?: Uint32Array, color_values?: Float64Array,
 *   color_roots?: Uint32Array, color_mesh_sizes?: Uint32Array, color_mesh_vertices?: Float32Array,
 *   color_mesh_triangles?: Uint32Array}} Nodes of a formula, (n,), (n, 3) and (n,), and its meshes; optionally the same
 *   for its surface's colour, with its roots (3,), as in scene files (docs/reference/scene-files.md)
 */

/** The shape of a script (docs/scripts.md). @param {Core} core @param {string} source */
export function scriptShape(core, source) {
  return withExpression(core, run(core, source), (expression) => shapeOf(core, expression));
}

/**
 * The surface of a .vm formula. A bounded surface is complete; an unbounded one is cut by the cube from -1 to 1. A
 * formula without z is extruded to a height of 0.1 (docs/reference/formulas.md).
 *
 * @param {Core} core
 * @param {string} text
 * @param {ArrayLike<number>} [bounds] (2, 3), to search there
 */
export function formulaShape(core, text, bounds) {
  return withExpression(core, parse(core, text), (expression) => {
    return new Shape(core, core.made("make_vm_solid", expression, bounds ? as(Float64Array, bounds) : 0));
  });
}

/**
 * The surface of a formula.
 *
 * @param {Core} core
 * @param {Nodes} nodes
 * @param {ArrayLike<number>} [bounds] (2, 3)
 */
export function implicitShape(core, nodes, bounds) {
  return withExpression(core, make(core, nodes), (expression) => shapeOf(core, expression, bounds));
}

/** Throws if a script is invalid, without finding its surface. @param {Core} core @param {string} source */
export const checkScript = (core, source) => withExpression(core, run(core, source), () => undefined);

/** Throws if a .vm formula is invalid. @param {Core} core @param {string} text */
export const checkFormula = (core, text) => withExpression(core, parse(core, text), () => undefined);

/** Throws if the arrays of a scene file are invalid. @param {Core} core @param {Nodes} nodes */
export const checkNodes = (core, nodes) => withExpression(core, make(core, nodes), () => undefined);

// ---- Expressions -----------------------------------------------------------------------------------------

/** @param {Core} core @param {string} source */
const run = (core, source) => core.made("run_script", source);

/** @param {Core} core @param {string} text */
const parse = (core, text) => core.made("parse_vm", text);

/** @param {Core} core @param {Nodes} nodes */
function make(core, nodes) {
  const { ops, operands, values, color_ops, color_operands, color_values, color_roots } = nodes;
  const expression = placedErrors("formula", () => {
    return withMeshes(core, nodes.mesh_sizes, nodes.mesh_vertices, nodes.mesh_triangles, (meshes) => {
      return core.made("make_expression", ops, operands, values, ops.length, meshes);
    });
  });
  try {
    if (color_ops && color_operands && color_values && color_roots) {
      placedErrors("color", () => {
        withMeshes(core, nodes.color_mesh_sizes, nodes.color_mesh_vertices, nodes.color_mesh_triangles, (meshes) => {
          core.made("color_expression", expression, color_ops, color_operands, color_values, color_ops.length, color_roots, meshes);
        });
      });
    }
    return expression;
  } catch (error) {
    core.call("free_expression", expression);
    throw error;
  }
}

/**
 * Calls f with the meshes of arrays; with 0 if there are no meshes.
 *
 * @template T
 * @param {Core} core
 * @param {Uint32Array | undefined} sizes (m, 2)
 * @param {Float32Array | undefined} vertices (v, 3)
 * @param {Uint32Array | undefined} triangles (t, 3)
 * @param {(meshes: number) => T} f
 * @returns {T}
 */
function withMeshes(core, sizes, vertices, triangles, f) {
  if (!sizes || !vertices || !triangles) return f(0);
  const meshes = core.made("make_meshes", sizes, sizes.length / 2, vertices, vertices.length / 3, triangles, triangles.length / 3);
  try {
    return f(meshes);
  } finally {
    core.call("free_meshes", meshes);
  }
}

/** @template T @param {Core} core @param {number} expression @param {(expression: number) => T} f @returns {T} */
function withExpression(core, expression, f) {
  try {
    return f(expression);
  } finally {
    core.call("free_expression", expression);
  }
}

/** @param {Core} core @param {number} expression @param {ArrayLike<number>} [bounds] (2, 3), found if omitted */
function shapeOf(core, expression, bounds) {
  return new Shape(core, core.made("make_implicit", expression, bounds ? as(Float64Array, bounds) : 0));
}
