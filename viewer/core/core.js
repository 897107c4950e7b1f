// @ts-check
/**
 * An instance of the core's WebAssembly module: calls and memory.
 *
 * All objects are in the memory of one instance. If pages may share memory between workers, other workers lend it their
 * threads (workers/thread.js); otherwise it has one thread, and a page starts several workers, each with a separate
 * core. Objects that the other folders make in a core (shapes, scenes, G-buffers, networks) live until they are freed,
 * and must not be used afterwards. Any call may move the memory: views of it are valid until the next call.
 */
import { CoreError } from "./errors.js";

/** @typedef {Float32Array | Float64Array | Int32Array | Uint8Array} Numbers */

/** Memory for an instance of a module that shares it with other workers, as in wasm.cmake. @param {WebAssembly.Module} module */
export const sharedMemoryFor = (module) =>
  WebAssembly.Module.imports(module).length > 0 ? new WebAssembly.Memory({ initial: 512, maximum: 65_535, shared: true }) : undefined;

export class Core {
  /** @type {Record<string, any>} */
  #functions;
  #memory;
  /** @type {number[]} */
  #lent = [];

  /** @param {WebAssembly.Module} module @param {WebAssembly.Memory} [memory] from sharedMemoryFor */
  constructor(module, memory = sharedMemoryFor(module)) {
    this.#functions = new WebAssembly.Instance(module, memory && { env: { memory } }).exports;
    this.#memory = memory ?? this.#functions.memory;
    this.#functions._initialize();
  }

  /** The module's current memory. @returns {ArrayBuffer} */
  get memory() {
    return this.#memory.buffer;
  }

  /**
   * Calls a function of bindings/wasm*.cpp. Typed arrays and texts are copied to the module; texts are followed by
   * their size in bytes.
   *
   * @param {string} name
   * @param {...(number | string | ArrayBufferView)} values
   * @returns {number}
   */
  call(name, ...values) {
    const before = this.#lent.length;
    try {
      const numbers = values.flatMap((value) => {
        if (typeof value === "number") return [value];
        const bytes = typeof value === "string" ? new TextEncoder().encode(value) : value;
        const address = this.put(bytes);
        this.#lent.push(address);
        return typeof value === "string" ? [address, bytes.byteLength] : [address];
      });
      return Number(this.#functions[name](...numbers));
    } finally {
      for (const address of this.#lent.splice(before)) this.#functions.release(address);
    }
  }

  /** As `call`, for a function that returns 0 on failure. @type {Core["call"]} */
  made(name, ...values) {
    const result = this.call(name, ...values);
    if (result === 0) throw new CoreError(this.#error());
    return result;
  }

  /** @param {number} bytes @returns {number} the address of memory to pass to `release` */
  allocate(bytes) {
    const address = this.#functions.allocate(bytes) >>> 0;
    if (address === 0) throw new CoreError(this.#error());
    return address;
  }

  /** @param {number} address */
  release(address) {
    this.#functions.release(address);
  }

  #error() {
    const bytes = new Uint8Array(this.memory, this.#functions.error() >>> 0);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  /** @param {ArrayBufferView} array @returns {number} the address of a copy to pass to `release` */
  put(array) {
    const address = this.allocate(array.byteLength);
    new Uint8Array(this.memory, address).set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return address;
  }

  /**
   * Fills an array with numbers that f writes to the module's memory.
   *
   * @template {Numbers} T
   * @param {T} array
   * @param {(address: number) => void} f writes the array's number of elements, of its type
   * @returns {T} the array
   */
  filled(array, f) {
    const address = this.allocate(array.byteLength);
    try {
      f(address);
      const type = /** @type {{new (buffer: ArrayBuffer, offset: number, length: number): Numbers}} */ (array.constructor);
      array.set(new type(this.memory, address, array.length));
      return array;
    } finally {
      this.release(address);
    }
  }
}

/**
 * Converts an array to a type.
 *
 * @template T
 * @param {{new (values: ArrayLike<number>): T}} type @param {ArrayLike<number>} values @returns {T}
 */
export const as = (type, values) => (values instanceof type ? values : new type(values));
