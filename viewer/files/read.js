// @ts-check
/** Files: a scene from their contents, or one line with the reason. */

import { CONVERTED, ENDINGS, endingOf, isMesh, isModel } from "../core/endings.js";
import { CoreError, oneLine } from "../core/errors.js";
import { checkFormula, checkScript } from "../shapes/implicit.js";
import { inCanonicalOrder } from "../tracing/canonical.js";
import { sceneOf, together } from "../tracing/description.js";
import { Beside } from "./beside.js";
import { readBob } from "./bob.js";
import { readInCore } from "./core_files.js";
import { readGeomdl } from "./geomdl.js";
import { meshScene } from "./joined.js";
import { stoodUp } from "./lying.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../tracing/description.js").SceneDescription} SceneDescription
 * @typedef {(core: Core, bytes: ArrayBuffer, name: string, beside: Beside) => SceneDescription | Promise<SceneDescription>} Reader
 */

/** Formats whose front is known. */
const GLTF = ["glb", "gltf"];

/** Readers by the ending of the file's name; the core reads the others. @type {Record<string, Reader>} */
const READERS = {
  ".json": (_, bytes, name) => readGeomdl(bytes, name),
  ".sdf": readScript,
  ".vm": readFormula,
  ".bob": readBob,
};

/** Maximum length of all file names in a suggested command; longer ones are replaced by FILE. */
const MOST_NAMED = 40;

/** The command that packs files for this page. @param {...string} names */
function packing(...names) {
  if (names.join("").length > MOST_NAMED) return "bobrossnet pack scene.bob FILE";
  const packed = `${names[0].replace(/\.[^.]*$/, "")}.bob`;
  return ["bobrossnet pack", ...[packed, ...names].map((path) => (/[^\w.-]/.test(path) ? `'${path}'` : path))].join(" ");
}

/**
 * Checks that files of this name can be read.
 *
 * @param {string} name
 * @throws {CoreError} of one line, with the remedy
 */
export function checkFormat(name) {
  const ending = endingOf(name);
  if (ENDINGS.includes(ending)) return;
  const problem = CONVERTED.includes(ending)
    ? `expected a format that this page reads, got ${ending}; convert it: ${packing(name)}`
    : `expected one of ${ENDINGS.join(" ")}, got ${ending || "no ending"}; ${ending ? "convert it to one" : "add one, as in #part.glb after an address"}`;
  throw new CoreError(oneLine(`${name}: ${problem}`));
}

/**
 * Reads a file, and the models opened together with it, as one scene; in a worker, since a large one takes a while.
 *
 * @param {Core} core
 * @param {string} name its ending gives the format
 * @param {ArrayBuffer} bytes which arrays of the scene may be views of
 * @param {Beside} [beside] files opened together with it
 * @param {Core} [other] reads meshes if `core` does not, or all else
 * @param {boolean} [isUpKnown] if not, meshes that seem to lie on their back are stood up
 * @returns {Promise<SceneDescription>} its `warnings` name the parts left out
 * @throws {CoreError} of one line that starts with the file's name, whatever the bytes are; `line` is the line of a
 *   script
 */
export async function readFile(core, name, bytes, beside = new Beside(), other, isUpKnown = true) {
  const models = beside.files.filter((file) => isModel(file.name));
  for (const file of models) checkFormat(file.name);
  const names = [name, ...models.map((file) => file.name)], further = models.find((file) => isMesh(file.name) !== isMesh(name));
  if (further && !other) {
    throw new CoreError(oneLine(`${further.name}: expected only meshes, or none, got ${name} too; open one, or pack both: ${packing(name, further.name)}`));
  }
  const scenes = [await readOne(core, name, bytes, beside)];
  for (const file of models) {
    const able = further && isMesh(file.name) !== isMesh(name) ? /** @type {Core} */ (other) : core;
    scenes.push(await readOne(able, file.name, await file.arrayBuffer(), beside));
  }
  const scene = together(core, isUpKnown ? scenes : stoodUp(core, scenes, names), names.map(oneLine));
  core.made("check_instances", "instances", scene.instances.length);
  return inCanonicalOrder(core, scene);
}

/** @param {Core} core @param {string} name @param {ArrayBuffer} bytes @param {Beside} beside */
async function readOne(core, name, bytes, beside) {
  checkFormat(name);
  const ending = endingOf(name), read = READERS[ending] ?? inCore(ending.slice(1));
  try {
    if (bytes.byteLength === 0) throw new CoreError(`expected a ${isMesh(name) ? "mesh" : "scene"}, got an empty file`);
    return await read(core, bytes, name, beside);
  } catch (error) {
    const [what, line] = error instanceof CoreError ? [error.message, error.line] : [reason(ending, error), null];
    throw new CoreError(oneLine(`${name}: ${what}`), line);
  }
}

/** @param {string} format the ending without its point @returns {Reader} */
function inCore(format) {
  return async (core, bytes, name, beside) => {
    /** @type {string[]} */
    const told = [];
    const { parts, scene } = await readInCore(core, format, bytes, name, (text) => told.push(oneLine(`${name}: ${text}`)), beside);
    if (scene.instances.length && !parts.some(({ triangles }) => triangles.length)) return { ...scene, warnings: told };
    const { shapes, instances, warnings = [] } = meshScene(core, name, parts), before = shapes.length;
    const others = scene.instances.map((instance) => ({ ...instance, shape: before + instance.shape }));
    return {
      shapes: shapes.concat(scene.shapes), instances: instances.concat(others), warnings: [...told, ...warnings], unit: scene.unit,
      hasFront: GLTF.includes(format),
    };
  };
}

/** @type {Reader} */
function readScript(core, bytes, name) {
  const source = decoded(bytes);
  checkScript(core, source);
  return sceneOf({ kind: "script", source }, name);
}

/** @type {Reader} */
function readFormula(core, bytes, name) {
  const text = decoded(bytes);
  checkFormula(core, text);
  return sceneOf({ kind: "formula", text }, name);
}

/** @param {ArrayBuffer} bytes */
function decoded(bytes) {
  return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
}

/** Readers throw all kinds of errors on foreign bytes. @param {string} ending @param {unknown} error */
function reason(ending, error) {
  if (error instanceof RangeError && /allocation|length/i.test(error.message)) {
    return "expected a scene that fits into memory, got a larger one";
  }
  return `expected a ${ending} file, could not read it (${error})`;
}
