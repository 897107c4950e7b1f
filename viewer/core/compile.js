// @ts-check
/** The core's WebAssembly modules, which a page compiles once for all of its workers. */
import { fetchPart, isThere } from "./parts.js";

/** A module of one function that multiplies and adds with a single rounding: valid where relaxed SIMD is known. */
const RELAXED = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0,
  10, 19, 1, 17, 0, 65, 1, 253, 15, 65, 2, 253, 15, 65, 3, 253, 15, 253, 133, 2, 11,
]);

const hasRelaxed = () => WebAssembly.validate(RELAXED);

/** Whether there are modules that can be lent threads, and workers of this page may share memory. */
export const canLendThreads = () => globalThis.crossOriginIsolated === true && hasRelaxed() && isThere("core.threads.relaxed.wasm");

/**
 * Fetches and compiles a module; `new Core(module)` runs it.
 *
 * @param {"core" | "core.mesh" | "core.threads" | "core.mesh.threads" | "complete"} [name] "core.mesh" has no shapes but meshes, and is
 *   a third as large; those of "threads" can be lent some; "complete" has networks alone, a tenth
 * @param {boolean} [relaxed] in relaxed SIMD; by default where the browser has it
 * @returns {Promise<WebAssembly.Module>}
 */
export async function compileCore(name = "core", relaxed = hasRelaxed()) {
  const fast = `${name}.relaxed.wasm`, response = await fetchPart(relaxed && isThere(fast) ? fast : `${name}.wasm`);
  // Some servers do not know the type, without which browsers refuse to compile while they fetch.
  const typed = response.headers.get("Content-Type")?.startsWith("application/wasm");
  return typed ? WebAssembly.compileStreaming(response) : WebAssembly.compile(await response.arrayBuffer());
}
