// @ts-check
/**
 * Where everything is that is not among the modules of the page: workers, WebAssembly, weights. They are files beside this one, on
 * this server or another, or come with the page itself where that is a single file.
 */
import { BROUGHT } from "./brought.js";

/** Browsers compile WebAssembly while it arrives only where the type says what it is. @param {string} path */
const typeOf = (path) => (path.endsWith(".wasm") ? "application/wasm" : "application/octet-stream");

/** @param {string} path from the page's folder @returns {Promise<Response>} that has its bytes */
export async function fetchPart(path) {
  if (Object.hasOwn(BROUGHT.parts, path)) {
    const deflated = Uint8Array.from(atob(BROUGHT.parts[path]), (letter) => letter.charCodeAt(0));
    const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Response(stream, { headers: { "Content-Type": typeOf(path) } });
  }
  const url = new URL(`../${path}`, import.meta.url), response = await fetch(url);
  if (!response.ok) throw new Error(`${url.pathname}: ${response.status} ${response.statusText}`);
  return response;
}

/** @param {"completing" | "reader" | "tracer"} name of a module in workers/ @returns {Worker} */
export function startWorker(name) {
  if (Object.hasOwn(BROUGHT.workers, name)) return workerOf(BROUGHT.workers[name]);
  const url = new URL(`../workers/${name}.js`, import.meta.url);
  // Browsers start no worker that is of another server, but one of this page may import it.
  return url.origin === location.origin ? new Worker(url, { type: "module" }) : workerOf(`import ${JSON.stringify(url)};`);
}

/** Of the modules that no file has, by their texts. @type {Map<string, string>} */
const addresses = new Map();

/** @param {string} text of a module @returns {Worker} */
function workerOf(text) {
  const address = addresses.get(text) ?? URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  addresses.set(text, address);
  return new Worker(address, { type: "module" });
}
