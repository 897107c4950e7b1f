// @ts-check
/**
 * A worker that reads files, one at a time, and passes each scene to the tracers. A large scene never passes through the
 * page. The first tracer gets it first; once that can show it, the others do.
 *
 * @typedef {import("../shapes/affine.js").Matrix} Matrix
 * @typedef {{script: string | null, warnings: string[], hasFront: boolean, isLit: boolean, stoodUp?: boolean}} Summary
 *   script: the text of a file that is one shape script; warnings: parts left out or shown differently, a line each; hasFront:
 *   whether -y is known to be the scene's front; isLit: whether it has lights of its own; stoodUp: whether meshes
 *   that seemed to lie on their back were turned
 * @typedef {{kind: "read", name: string, source: Blob | string, beside: File[], turn: Matrix | null, isUpKnown: boolean, port: MessagePort,
 *   module: WebAssembly.Module, other?: WebAssembly.Module}
 *   | {kind: "share", ports: MessagePort[]}} Request
 *   source: a file, or its address; beside: files opened together with it; turn: the rotation of the file's scene; isUpKnown: otherwise
 *   meshes that seem to lie on their back are stood up; port: to a tracer; module: of the core that reads it; other: of one for files opened together with it that need another; ports: to the other tracers; a large scene may not fit all of them
 * @typedef {{kind: "read", summary: Summary, bytes: Blob} | {kind: "failed", message: string} | {kind: "shared", tracers: number, memory: number}} Reply
 *   "read" is answered by "read" or "failed"; bytes: of the file, which the browser keeps, to read it again. "share" is
 *   answered by "shared"; tracers: number of all that got the scene; memory: bytes of the reader's core
 */
import { Core } from "../core/core.js";
import { fetched } from "../core/fetching.js";
import { Beside } from "../files/beside.js";
import { checkFormat, readFile } from "../files/read.js";
import { inCanonicalOrder } from "../tracing/canonical.js";
import { turned } from "../tracing/description.js";

/** Maximum bytes of scenes in all tracers together. */
const MOST = 400e6;

/** @param {Reply} message */
const reply = (message) => postMessage(message);

/** @param {string} name @param {Blob | string} source @returns {Promise<Blob>} */
async function blobOf(name, source) {
  checkFormat(name);
  if (source instanceof Blob) return source;
  const response = await fetched(name, source);
  return response.blob(); // in Chromium, a third of the time of a direct arrayBuffer()
}

/** Bytes of the arrays in a description. @param {unknown} value @returns {number} */
function weight(value) {
  if (ArrayBuffer.isView(value)) return value.byteLength;
  return value && typeof value === "object" ? Object.values(value).reduce((sum, part) => sum + weight(part), 0) : 0;
}

/** @type {import("../tracing/description.js").SceneDescription | undefined} */
let scene;
let memory = 0; // bytes of the core that read it

/** @param {Extract<Request, {kind: "read"}>} request */
async function read({ name, source, beside, turn, isUpKnown, port, module, other }) {
  try {
    const core = new Core(module), further = other && new Core(other), bytes = await blobOf(name, source);
    scene = await readFile(core, name, await bytes.arrayBuffer(), new Beside(beside), further, isUpKnown);
    if (turn) scene = await inCanonicalOrder(core, turned(scene, turn));
    memory = core.memory.byteLength + (further?.memory.byteLength ?? 0);
    port.postMessage(scene);
    const [shape] = scene.shapes;
    const script = scene.shapes.length === 1 && shape.kind === "script" && !turn ? shape.source : null;
    const { warnings = [], hasFront = false, stoodUp, lights } = scene;
    reply({ kind: "read", summary: { script, warnings, hasFront, stoodUp, isLit: Boolean(lights && lights.lights !== "headlight") }, bytes });
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
    for (const port of others) port.postMessage(scene);
    scene = undefined;
    reply({ kind: "shared", tracers: 1 + others.length, memory });
  }
};
