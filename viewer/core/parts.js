// @ts-check
/**
 * Locations of workers, WebAssembly and weights. They are files next to this one, on this server or another, or
 * embedded in a page of a single file.
 */
import { BROUGHT } from "./brought.js";
import { VERSION } from "./version.js";

/** Browsers compile WebAssembly while it arrives only with this type. @param {string} path */
const typeOf = (path) => (path.endsWith(".wasm") ? "application/wasm" : "application/octet-stream");

/** Whether parts are embedded in this module. */
export const isSingleFile = Object.keys(BROUGHT.parts).length > 0;

/** The parts of all modules of this version in the page, which share one element (component/define.js). */
const brought = isSingleFile ? sharedBy(`bob-view ${VERSION}`, BROUGHT) : BROUGHT;

/** @param {string} name of the modules @param {typeof BROUGHT} own @returns {typeof BROUGHT} */
function sharedBy(name, { workers, parts }) {
  const key = Symbol.for(name), page = /** @type {Record<symbol, typeof BROUGHT>} */ (/** @type {unknown} */ (globalThis));
  page[key] ??= { workers, parts: {} };
  Object.assign(page[key].parts, parts);
  return page[key];
}

/** Whether there is a part: a single file contains only the parts it needs. @param {string} path from the page's folder */
export const isThere = (path) => !isSingleFile || Object.hasOwn(brought.parts, path);

/** @param {string} path from the page's folder @returns {Promise<Response>} with its bytes */
export async function fetchPart(path) {
  if (isSingleFile) {
    if (!isThere(path)) throw new Error(`${path}: expected a part of this file, got none`);
    const stream = new Blob([bytesOf(brought.parts[path])]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Response(stream, { headers: { "Content-Type": typeOf(path) } });
  }
  const url = new URL(`../${path}`, import.meta.url), response = await fetch(url);
  if (!response.ok) throw new Error(`${url.pathname}: ${response.status} ${response.statusText}`);
  return response;
}

/** @param {string} base64 */
function bytesOf(base64) {
  const letters = atob(base64), bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/** @param {"completing" | "reader" | "thread" | "tracer"} name of a module in workers/ @returns {Worker} */
export function startWorker(name) {
  // A page from a disk, or in a frame with an opaque origin, may start scripts but no modules.
  if (isSingleFile) return workerOf(`"use strict";\n${brought.workers[name]}`, "classic");
  const url = new URL(`../workers/${name}.js`, import.meta.url);
  // Browsers start no worker from another server, but a worker of this page may import it.
  return url.origin === location.origin ? new Worker(url, { type: "module" }) : workerOf(`import ${JSON.stringify(url)};`, "module");
}

/** Object URLs of sources without a file, by text. @type {Map<string, string>} */
const addresses = new Map();

/** @param {string} text @param {WorkerType} type @returns {Worker} */
function workerOf(text, type) {
  const address = addresses.get(text) ?? URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  addresses.set(text, address);
  return new Worker(address, { type });
}
