// @ts-check
/** Loads a core without a compiled module. */
import { compileCore } from "./compile.js";
import { Core } from "./core.js";

/**
 * Loads the core.
 *
 * @param {Parameters<typeof compileCore>[0]} [name]
 * @param {boolean} [relaxed]
 * @returns {Promise<Core>}
 */
export async function loadCore(name, relaxed) {
  return new Core(await compileCore(name, relaxed));
}
