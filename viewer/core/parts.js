// @ts-check
/**
 * Locations of workers, WebAssembly and weights. They are files next to this one, on this server or another, or
 * embedded in a page of a single file.
 */
import { BROUGHT } from "./brought.js";
import { fetched } from "./fetching.js";
import { placeOf } from "./places.js";
import { VERSION } from "./version.js";

/** The folder with all files, if pages set it. @type {URL | undefined} */
let folder;

/**
 * Sets the folder of all files that have not been fetched yet.
 *
 * @param {URL | undefined} address with a slash at its end
 */
export function useFolder(address) {
  if (address?.href === folder?.href) return;
  folder = address;
  checked = undefined;
}

/** The folder set by the page. */
export const usedFolder = () => folder;

const ADVICE = "set base to the folder with the files of bob-view";

/** The check of this folder. @type {Promise<void> | undefined} */
let checked;

/** Checks that the folder's files have this module's version. @param {URL} address */
async function checkVersion(address) {
  const { version } = await (await fetched("base", new URL("package.json", address), ADVICE)).json();
  if (version !== VERSION) {
    throw new Error(`base: expected the files of bob-view ${VERSION} in ${address.href}, got version ${version}; copy node_modules/bob-view there`);
  }
}

/** @param {string} path from the page's folder */
const addressOf = (path) => (folder ? new URL(path, folder) : placeOf(path));

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
  const url = addressOf(path);
  if (folder && !checked) {
    const mine = checked = checkVersion(folder);
    mine.catch(() => mine === checked && (checked = undefined)); // for another try
  }
  const [, response] = await Promise.all([checked, fetched(path, url, ADVICE)]);
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
  const worker = started(name);
  // Errors of a worker that does not start have no message.
  worker.addEventListener("error", (event) => {
    if (event.message) return;
    event.stopImmediatePropagation();
    worker.dispatchEvent(new ErrorEvent("error", { message: `${name}.js: expected a worker, got none that starts; ${REASONS}` }));
  });
  return worker;
}

const REASONS = `${ADVICE}, and allow workers by worker-src in the page's Content-Security-Policy`;

/** @param {Parameters<typeof startWorker>[0]} name @returns {Worker} */
function started(name) {
  // A page from a disk, or in a frame with an opaque origin, may start scripts but no modules.
  if (isSingleFile) return workerOf(`"use strict";\n${brought.workers[name]}`, "classic");
  const url = addressOf(`workers/${name}.js`);
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
