// @ts-check
/**
 * The worker that reads files, one at a time.
 *
 * @typedef {import("./reader.js").Summary} Summary
 * @typedef {{name: string, source: Blob | string, beside: File[], turn: import("../shapes/affine.js").Matrix | null, isUpKnown: boolean}} Source
 *   as in reader.js
 *
 * @typedef {object} ReadFile
 * @property {MessagePort} port brings the scene to the first tracer
 * @property {Promise<Summary & {bytes: Blob}>} summary
 * @property {(ports: MessagePort[]) => Promise<number | null>} share gives the scene to the other tracers; returns the
 *   number of all that got it, because a large one may not fit all; null if the worker has another file
 */
import { startWorker } from "../core/parts.js";

const LARGE = 64e6; // bytes of a core's memory, which never shrinks: the worker then reads no other file

export class Reading {
  /** @type {Worker | undefined} */
  #worker;
  /** Rejects the summary that is not there yet. @type {((error: Error) => void) | undefined} */
  #fail;
  /** @type {ReadFile | undefined} */
  #newest;
  /** @type {((count: number | null) => void)[]} */
  #sharing = [];
  #isLast = false; // whether the worker ends after its file

  /** Starts the worker if necessary. @returns {Worker} */
  start() {
    if (this.#worker) return this.#worker;
    const worker = this.#worker = startWorker("reader");
    worker.onerror = (event) => this.end(event.message ?? "reader.js did not start");
    return worker;
  }

  /** Whether a file is being read. */
  get isBusy() {
    return this.#fail !== undefined;
  }

  /**
   * Reads a file; one that is being read is given up.
   *
   * @param {Source} source @param {Promise<WebAssembly.Module>} module of the core that reads it
   * @param {Promise<WebAssembly.Module>} [other] of a core for files opened together with it
   * @returns {ReadFile}
   */
  read(source, module, other) {
    if (this.isBusy) this.end();
    this.#isLast = false;
    const worker = this.start(), { port1, port2 } = new MessageChannel();
    /** @type {ReadFile["summary"]} */
    const summary = new Promise((resolve, reject) => {
      this.#fail = reject;
      worker.onmessage = ({ data }) => {
        if (data.kind === "shared") return this.#shared(data);
        this.#fail = undefined;
        if (data.kind === "read") resolve({ ...data.summary, bytes: data.bytes });
        else reject(new Error(data.message));
      };
      Promise.all([module, other]).then(
        ([module, other]) => worker.postMessage({ kind: "read", ...source, port: port2, module, other }, [port2]), reject);
    });
    summary.catch(() => {}); // awaited by whoever opens the file
    const file = { port: port1, summary, share: (/** @type {MessagePort[]} */ ports) => this.#share(file, ports) };
    return this.#newest = file;
  }

  /** @param {ReadFile} file @param {MessagePort[]} ports @returns {Promise<number | null>} */
  #share(file, ports) {
    if (file !== this.#newest || !this.#worker) return Promise.resolve(null);
    this.#worker.postMessage({ kind: "share", ports }, ports);
    return new Promise((resolve) => this.#sharing.push(resolve));
  }

  /** @param {Extract<import("./reader.js").Reply, {kind: "shared"}>} reply */
  #shared({ tracers, memory }) {
    this.#sharing.shift()?.(tracers);
    if (memory > LARGE || this.#isLast) this.finish();
  }

  /** Ends the worker once it has read and shared its file. */
  finish() {
    this.#isLast = this.isBusy || this.#sharing.length > 0;
    if (!this.#isLast) this.end();
  }

  /** Ends the worker and its work. @param {string} [reason] */
  end(reason = "another scene was opened") {
    this.#worker?.terminate();
    this.#fail?.(new Error(reason));
    for (const resolve of this.#sharing.splice(0)) resolve(null);
    this.#worker = this.#fail = this.#newest = undefined;
  }
}
