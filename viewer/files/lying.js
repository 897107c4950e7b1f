// @ts-check
/** Stands up the meshes of files whose formats don't say which axis is up. */

import { as } from "../core/core.js";
import { isSilent } from "../core/endings.js";
import { oneLine } from "../core/errors.js";
import { UPRIGHT } from "../shapes/affine.js";
import { turned } from "../tracing/description.js";

/**
 * @typedef {import("../tracing/description.js").SceneDescription} SceneDescription
 * @typedef {import("../shapes/description.js").MeshDescription} Mesh
 */

/**
 * Turns these meshes if together they seem to lie on their back, as bobrossnet.load with up="auto".
 *
 * @param {import("../core/core.js").Core} core
 * @param {readonly SceneDescription[]} scenes
 * @param {readonly string[]} names of their files
 * @returns {readonly SceneDescription[]}
 */
export function stoodUp(core, scenes, names) {
  const silent = names.map(isSilent), first = silent.indexOf(true), all = scenes.filter((_, i) => silent[i]);
  const shapes = all.flatMap(({ shapes }) => shapes), meshes = /** @type {Mesh[]} */ (shapes);
  if (first < 0 || shapes.some(({ kind }) => kind !== "mesh") || !seemToLie(core, meshes)) return scenes;
  const name = oneLine(names[first]) + (all.length > 1 ? " and others" : "");
  const warning = `${name}: seems to lie on its back, so its y is taken as up; set up to z to keep it as stored`;
  return scenes.map((scene, i) => {
    if (!silent[i]) return scene;
    const { warnings = [] } = scene;
    return { ...turned(scene, UPRIGHT), stoodUp: true, warnings: i === first ? [...warnings, warning] : warnings };
  });
}

/** @param {import("../core/core.js").Core} core @param {Mesh[]} meshes in place @returns {boolean} */
function seemToLie(core, meshes) {
  const { vertices, triangles } = meshes.length === 1 ? meshes[0] : asOne(meshes);
  return core.call("seems_to_lie", as(Float64Array, vertices), vertices.length / 3, as(Int32Array, triangles), triangles.length / 3) !== 0;
}

/** @param {Mesh[]} meshes */
function asOne(meshes) {
  const total = (/** @type {"vertices" | "triangles"} */ array) => meshes.reduce((sum, mesh) => sum + mesh[array].length, 0);
  const vertices = new Float64Array(total("vertices")), triangles = new Int32Array(total("triangles"));
  let corner = 0, first = 0;
  for (const mesh of meshes) {
    vertices.set(mesh.vertices, corner);
    for (let i = 0; i < mesh.triangles.length; ++i) triangles[first + i] = mesh.triangles[i] + corner / 3;
    corner += mesh.vertices.length, first += mesh.triangles.length;
  }
  return { vertices, triangles };
}
