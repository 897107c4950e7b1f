// @ts-check
/** The core's WebAssembly modules, compiled once for all workers of a page. */
import { fetchPart, isThere } from "./parts.js";

/** A module of one function that multiplies and adds with a single rounding: valid if the browser has relaxed SIMD. */
const RELAXED = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0,
  10, 19, 1, 17, 0, 65, 1, 253, 15, 65, 2, 253, 15, 65, 3, 253, 15, 253, 133, 2, 11,
]);

/** A module of one function of SIMD and exceptions. */
const NEEDED = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0,
  10, 12, 1, 10, 0, 31, 123, 0, 65, 1, 253, 15, 11, 11,
]);

const BROWSERS = "Chrome 137, Firefox 131, Safari 18.4, or newer";

/** @param {Uint8Array<ArrayBuffer>} module */
const validates = (module) => typeof WebAssembly === "object" && WebAssembly.validate(module);

const hasRelaxed = () => validates(RELAXED);

/** Whether there are modules with lent threads, and workers of this page may share memory. */
export const canLendThreads = () => globalThis.crossOriginIsolated === true && hasRelaxed() && isThere("core.threads.relaxed.wasm");

/**
 * Fetches and compiles a module, for `new Core(module)`.
 *
 * @param {"complete" | `core${"" | ".mesh" | ".mesh.light"}${"" | ".threads"}`} [name] "core.mesh" has meshes only, and reads
 *   their files, at half the size; it has lights as "core.mesh.light"; modules with "threads" can be lent threads; "complete" has networks
 *   only, at a tenth of the size
 * @param {boolean} [relaxed] in relaxed SIMD; by default if the browser has it
 * @returns {Promise<WebAssembly.Module>}
 */
export async function compileCore(name = "core", relaxed = hasRelaxed()) {
  if (typeof WebAssembly !== "object") {
    throw new Error("WebAssembly: expected a browser that has it, got one without; allow it in the browser's settings, or use another browser");
  }
  if (!validates(NEEDED)) throw new Error(`WebAssembly: expected SIMD and exceptions, got an older browser; use ${BROWSERS}`);
  const fast = `${name}.relaxed.wasm`, response = await fetchPart(relaxed && isThere(fast) ? fast : `${name}.wasm`);
  // Some servers do not know the type; without it, browsers refuse to compile while fetching.
  const typed = response.headers.get("Content-Type")?.startsWith("application/wasm");
  try {
    return await (typed ? WebAssembly.compileStreaming(response) : WebAssembly.compile(await response.arrayBuffer()));
  } catch (error) {
    throw new Error(`${name}.wasm: ${reason(error)}`);
  }
}

/** @param {unknown} error of the compiler */
function reason(error) {
  const text = error instanceof Error ? error.message : String(error);
  if (/unsafe-eval|content security policy/i.test(text)) {
    return "this page's Content-Security-Policy forbids WebAssembly; add 'wasm-unsafe-eval' to its script-src";
  }
  return `expected a module that this browser compiles, got: ${text.slice(0, 150)}; reload the page, or use ${BROWSERS}`;
}
