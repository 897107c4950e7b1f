// @ts-check
/** The core's WebAssembly modules, compiled once for all workers of a page. */
import { fetchPart, isThere } from "./parts.js";

/** A module of one function that multiplies and adds with a single rounding: valid if the browser has relaxed SIMD. */
const RELAXED = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0,
  10, 19, 1, 17, 0, 65, 1, 253, 15, 65, 2, 253, 15, 65, 3, 253, 15, 253, 133, 2, 11,
]);

const hasRelaxed = () => WebAssembly.validate(RELAXED);

/** Whether there are modules with lent threads, and workers of this page may share memory. */
export const canLendThreads = () => globalThis.crossOriginIsolated === true && hasRelaxed() && isThere("core.threads.relaxed.wasm");

/**
 * Fetches and compiles a module, for `new Core(module)`.
 *
 * @param {"core" | "core.mesh" | "core.threads" | "core.mesh.threads" | "complete"} [name] "core.mesh" has meshes only,
 *   and reads their files, at half the size; modules with "threads" can be lent threads; "complete" has networks only, at a tenth of the
 *   size
 * @param {boolean} [relaxed] in relaxed SIMD; by default if the browser has it
 * @returns {Promise<WebAssembly.Module>}
 */
export async function compileCore(name = "core", relaxed = hasRelaxed()) {
  const fast = `${name}.relaxed.wasm`, response = await fetchPart(relaxed && isThere(fast) ? fast : `${name}.wasm`);
  // Some servers do not know the type; without it, browsers refuse to compile while fetching.
  const typed = response.headers.get("Content-Type")?.startsWith("application/wasm");
  return typed ? WebAssembly.compileStreaming(response) : WebAssembly.compile(await response.arrayBuffer());
}
