// @ts-check
/** A core for whoever has no module compiled yet. */
import { compileCore } from "./compile.js";
import { Core } from "./core.js";

/**
 * Loads the core.
 *
 * @param {"core" | "complete"} [name] "complete" has networks alone and is a tenth as large
 * @param {boolean} [relaxed] in relaxed SIMD; by default where the browser has it
 * @returns {Promise<Core>}
 */
export async function loadCore(name, relaxed) {
  return new Core(await WebAssembly.instantiate(await compileCore(name, relaxed)));
}
