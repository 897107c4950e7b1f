// @ts-check
/**
 * WebGPU's flags, missing from TypeScript's types; undefined without WebGPU.
 *
 * @typedef {Record<"COPY_DST" | "COPY_SRC" | "MAP_READ" | "STORAGE" | "UNIFORM", number>} BufferUsage
 */

/** @type {{GPUBufferUsage: BufferUsage, GPUMapMode: {READ: number}}} */
export const { GPUBufferUsage, GPUMapMode } = /** @type {any} */ (globalThis);
