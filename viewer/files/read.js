// @ts-check
/** Files: a scene from what they hold, or one line that says why not. */

import { CoreError } from "../core/errors.js";
import { checkFormula, checkScript } from "../shapes/implicit.js";
import { inCanonicalOrder } from "../tracing/canonical.js";
import { sceneOf } from "../tracing/description.js";
import { Beside } from "./beside.js";
import { readBob } from "./bob.js";
import { readInCore } from "./core_files.js";
import { readGeomdl } from "./geomdl.js";
import { meshScene } from "./joined.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../tracing/description.js").SceneDescription} SceneDescription
 * @typedef {(core: Core, bytes: ArrayBuffer, name: string, beside: Beside) => SceneDescription | Promise<SceneDescription>} Reader
 */

/** Readers by the ending of the file's name. @type {Record<string, Reader>} */
const READERS = {
  ".ply": inCore("ply"),
  ".obj": inCore("obj"),
  ".stl": inCore("stl"),
  ".off": inCore("off"),
  ".glb": inCore("glb"),
  ".gltf": inCore("gltf"),
  ".json": (_, bytes, name) => readGeomdl(bytes, name),
  ".sdf": readScript,
  ".vm": readFormula,
  ".bob": readBob,
};

/** What files can be read. */
export const ENDINGS = Object.keys(READERS);

/**
 * Reads a file; in a worker, since a large one takes a while.
 *
 * @param {Core} core
 * @param {string} name whose ending says what it is
 * @param {ArrayBuffer} bytes which arrays of the scene may be views of
 * @param {Beside} [beside] what was opened together with it
 * @returns {Promise<SceneDescription>} its `warnings` say what was left out
 * @throws {CoreError} of one line that starts with the file's name, whatever the bytes are; its `line` is that of a
 *   script
 */
export async function readFile(core, name, bytes, beside = new Beside()) {
  const ending = /\.[^.]*$/.exec(name)?.[0].toLowerCase() ?? "";
  try {
    const read = Object.hasOwn(READERS, ending) ? READERS[ending] : undefined;
    if (!read) throw new CoreError(`expected one of ${ENDINGS.join(" ")}, got ${ending || "no ending"}`);
    if (bytes.byteLength === 0) throw new CoreError("expected a scene, got an empty file");
    return await inCanonicalOrder(core, await read(core, bytes, name, beside));
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
    const parts = await readInCore(core, format, bytes, (text) => told.push(oneLine(`${name}: ${text}`)), beside);
    const { warnings = [], ...scene } = meshScene(core, name, parts);
    return { ...scene, warnings: [...told, ...warnings] };
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

/** @param {string} text at most 200 characters are kept */
function oneLine(text) {
  const line = text.replace(/[\p{C}\s]+/gu, " ").trim();
  return line.length <= 200 ? line : `${line.slice(0, 197)}...`;
}
