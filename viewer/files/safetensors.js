// @ts-check
/**
 * Safetensors, the container of weight and scene files: named arrays behind a header in JSON, with texts about them.
 *
 * @typedef {{dtype: any, shape: any, data_offsets: any}} Entry of the header, unchecked
 * @typedef {{metadata: any, entries: Record<string, any>, start: number, bytes: ArrayBuffer}} Container
 *   metadata: texts by their names; entries: of the arrays, by their names; start: where the first one begins
 */
import { CoreError, checkList } from "../core/errors.js";
import { jsonOf } from "./text.js";

/** @type {Record<string, {new (buffer: ArrayBuffer): any, BYTES_PER_ELEMENT: number}>} */
const TYPES = { F64: Float64Array, F32: Float32Array, I32: Int32Array, U32: Uint32Array, U8: Uint8Array };

/** @param {ArrayBuffer} bytes @returns {Container} */
export function readContainer(bytes) {
  const size = Number(new DataView(bytes).getBigUint64(0, true)), start = 8 + size;
  const { __metadata__: metadata, ...entries } = jsonOf(new Uint8Array(bytes).subarray(8, start));
  return { metadata, entries, start, bytes };
}

/**
 * One of the arrays: a view of the file where its place allows that, else a copy.
 *
 * @param {Container} container
 * @param {string} name for errors
 * @param {Entry} entry of one of TYPES
 * @returns {any} a typed array
 */
export function readTensor({ bytes, start }, name, { dtype, shape, data_offsets }) {
  const [begin, end] = checkList(name, data_offsets), type = TYPES[dtype];
  const count = checkList(name, shape).reduce((product, size) => product * size, 1);
  if (!(begin >= 0 && end - begin === count * type.BYTES_PER_ELEMENT && start + end <= bytes.byteLength)) {
    throw new CoreError(`${name}: expected ${count} items within the file, got bytes ${begin} to ${end}`);
  }
  const at = start + begin;
  return at % type.BYTES_PER_ELEMENT ? new type(bytes.slice(at, start + end))
    : new /** @type {any} */ (type)(bytes, at, count);
}
