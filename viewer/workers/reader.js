// @ts-check
/**
 * A worker that reads one file and passes its scene to the tracers. A large scene never passes through the page.
 *
 * The first tracer gets it first; once that can show it, the others do. Then the worker ends, which frees the memory of
 * the reader.
 *
 * @typedef {{script: string | null, warnings: string[]}} Summary
 *   script: the text of a file that is one shape script; warnings: parts left out or shown differently, a line each
 * @typedef {{kind: "read", name: string, source: Blob | string, beside: File[], yUp: boolean, port: MessagePort, module: WebAssembly.Module}
 *   | {kind: "share", ports: MessagePort[]}} Request
 *   source: a file, or its address; beside: files opened together with it; yUp: whether y is up in the file, to rotate
 *   to z up; port: to a tracer; ports: to the others; a large scene may not fit all of them
 * @typedef {{kind: "read", summary: Summary} | {kind: "failed", message: string} | {kind: "shared", tracers: number}} Reply
 *   "read" is answered by "read" or "failed", "share" by "shared", with the number of all tracers that got the scene
 */
import { Core } from "../core/core.js";
import { fetched } from "../core/fetching.js";
import { Beside } from "../files/beside.js";
import { checkFormat, readFile } from "../files/read.js";
import { inCanonicalOrder } from "../tracing/canonical.js";
import { turnedUpright } from "../tracing/description.js";

/** Maximum bytes of scenes in all tracers together. */
const MOST = 400e6;

/** @param {Reply} message */
const reply = (message) => postMessage(message);

/** @param {string} name @param {Blob | string} source */
async function bytesOf(name, source) {
  checkFormat(name);
  if (source instanceof Blob) return source.arrayBuffer();
  const response = await fetched(name, source);
  return (await response.blob()).arrayBuffer(); // in Chromium, a third of the time of a direct arrayBuffer()
}

/** Bytes of the arrays in a description. @param {unknown} value @returns {number} */
function weight(value) {
  if (ArrayBuffer.isView(value)) return value.byteLength;
  return value && typeof value === "object" ? Object.values(value).reduce((sum, part) => sum + weight(part), 0) : 0;
}

/** @type {import("../tracing/description.js").SceneDescription} */
let scene;

/** @param {Extract<Request, {kind: "read"}>} request */
async function read({ name, source, beside, yUp, port, module }) {
  try {
    const core = new Core(module);
    scene = await readFile(core, name, await bytesOf(name, source), new Beside(beside));
    if (yUp) scene = await inCanonicalOrder(core, turnedUpright(scene));
    port.postMessage({ kind: "open", scene, edition: 0 });
    const [shape] = scene.shapes;
    const script = scene.shapes.length === 1 && shape.kind === "script" && !yUp ? shape.source : null;
    reply({ kind: "read", summary: { script, warnings: scene.warnings ?? [] } });
  } catch (error) {
    reply({ kind: "failed", message: error instanceof Error ? error.message : String(error) });
  }
}

/** @param {MessageEvent<Request>} event */
onmessage = ({ data }) => {
  if (data.kind === "read") {
    read(data);
  } else {
    const others = data.ports.slice(0, Math.max(0, Math.floor(MOST / weight(scene)) - 1));
    for (const port of others) port.postMessage({ kind: "open", scene, edition: 0 });
    reply({ kind: "shared", tracers: 1 + others.length });
  }
};
