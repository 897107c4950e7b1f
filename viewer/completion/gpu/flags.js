// @ts-check
/**
 * WebGPU's flags, which TypeScript's own types leave out; undefined where there is no WebGPU.
 *
 * @typedef {Record<"COPY_DST" | "COPY_SRC" | "MAP_READ" | "STORAGE" | "UNIFORM", number>} BufferUsage
 */

/** @type {{GPUBufferUsage: BufferUsage, GPUMapMode: {READ: number}}} */
export const { GPUBufferUsage, GPUMapMode } = /** @type {any} */ (globalThis);
