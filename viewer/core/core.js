// @ts-check
/**
 * The core's WebAssembly module at work: calls, and its memory.
 *
 * Everything lies in the memory of one instance. Where pages may share memory between workers, others lend it their threads
 * (workers/thread.js); elsewhere it has one, and a page starts as many workers as it likes, each with a core of its own. What the
 * other folders make of a core (shapes, scenes, G-buffers, networks) stays until it is freed, and must not be used afterwards. Any call
 * may move the memory: views of it are good until the next.
 */
import { CoreError } from "./errors.js";

/** @typedef {Float32Array | Float64Array | Int32Array | Uint8Array} Numbers */

/** Memory for an instance of a module that shares it with other workers, as wasm.cmake has it. @param {WebAssembly.Module} module */
export const sharedMemoryFor = (module) =>
  WebAssembly.Module.imports(module).length > 0 ? new WebAssembly.Memory({ initial: 512, maximum: 65_535, shared: true }) : undefined;

export class Core {
  /** @type {Record<string, any>} */
  #functions;
  #memory;
  /** @type {number[]} */
  #lent = [];

  /** @param {WebAssembly.Module} module @param {WebAssembly.Memory} [memory] what sharedMemoryFor makes */
  constructor(module, memory = sharedMemoryFor(module)) {
    this.#functions = new WebAssembly.Instance(module, memory && { env: { memory } }).exports;
    this.#memory = memory ?? this.#functions.memory;
    this.#functions._initialize();
  }

  /** The module's memory as it is now. @returns {ArrayBuffer} */
  get memory() {
    return this.#memory.buffer;
  }

  /**
   * Calls a function of bindings/wasm*.cpp. Typed arrays are copied to the module, and texts, with their
   * size in bytes behind them.
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

  /** As `call`, of a function that returns 0 where it fails. @type {Core["call"]} */
  made(name, ...values) {
    const result = this.call(name, ...values);
    if (result === 0) throw new CoreError(this.#error());
    return result;
  }

  /** @param {number} bytes @returns {number} the address of memory, which `release` gives back */
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

  /** @param {ArrayBufferView} array @returns {number} the address of a copy, which `release` gives back */
  put(array) {
    const address = this.allocate(array.byteLength);
    new Uint8Array(this.memory, address).set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return address;
  }

  /**
   * Fills an array with what f writes to the module's memory.
   *
   * @template {Numbers} T
   * @param {T} array
   * @param {(address: number) => void} f writes as many numbers of its type
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
 * An array as one of a type.
 *
 * @template T
 * @param {{new (values: ArrayLike<number>): T}} type @param {ArrayLike<number>} values @returns {T}
 */
export const as = (type, values) => (values instanceof type ? values : new type(values));
