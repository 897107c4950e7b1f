// @ts-check
/**
 * A worker that reads one file and hands its scene to tracers, so that a large one never passes through the page. It ends after
 * that, which frees what reading took.
 *
 * @typedef {{script: string | null}} Summary the text of a file that is one shape script
 * @typedef {{kind: "read", name: string, source: Blob | string, ports: MessagePort[], module: WebAssembly.Module}} Request
 *   source: a file, or its address; ports: to tracers, not all of which are given a large scene
 * @typedef {{kind: "read", summary: Summary} | {kind: "failed", message: string}} Reply
 */
import { Core } from "./core.js";
import { readFile } from "./files.js";

/** Bytes of scenes that may be held by all tracers together. */
const MOST = 400e6;

/** @param {Reply} message */
const reply = (message) => postMessage(message);

/** @param {Blob | string} source */
async function bytesOf(source) {
  if (source instanceof Blob) return source.arrayBuffer();
  const response = await fetch(source);
  if (!response.ok) throw new Error(`${source}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

/** Bytes of the arrays in a description. @param {unknown} value @returns {number} */
function weight(value) {
  if (ArrayBuffer.isView(value)) return value.byteLength;
  return value && typeof value === "object" ? Object.values(value).reduce((sum, part) => sum + weight(part), 0) : 0;
}

/** @param {MessageEvent<Request>} event */
onmessage = async ({ data: { name, source, ports, module } }) => {
  try {
    const core = new Core(new WebAssembly.Instance(module));
    const scene = await readFile(core, name, await bytesOf(source));
    const given = Math.max(1, Math.min(ports.length, Math.floor(MOST / weight(scene))));
    for (const port of ports.slice(0, given)) port.postMessage({ kind: "open", scene });
    const [shape] = scene.shapes;
    reply({ kind: "read", summary: { script: scene.shapes.length === 1 && shape.kind === "script" ? shape.source : null } });
  } catch (error) {
    reply({ kind: "failed", message: error instanceof Error ? error.message : String(error) });
  }
};
