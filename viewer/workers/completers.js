// @ts-check
/**
 * The workers that complete pictures. The first gathers the bands of the others and paints the pictures.
 *
 * @typedef {import("./completing.js").Reply} Reply
 * @typedef {import("../picture/planner.js").Model} Model
 */
import { fetchPart, startWorker } from "../core/parts.js";

const ASKED = 2; // requests before a network is fetched: the first picture of a scene asks for one before the speed of its rays is known

/** Number of workers: one, if all cores are busy tracing the next picture meanwhile. */
const count = () => (navigator.hardwareConcurrency >= 4 ? 2 : 1);

/** @param {string} name of a network @returns {Promise<ArrayBuffer>} its weights */
const weightsOf = async (name) => (await fetchPart(`weights/${name}.safetensors`)).arrayBuffer();

export class Completers {
  /** @type {Worker[]} */
  #workers = [];
  /** Number of requests for each network. @type {Partial<Record<Model, number>>} */
  #asked = {};
  /** Names of the available networks; the first also replaces networks that are missing. @type {Set<Model>} */
  #models;
  #module;
  #told;

  /** @param {Promise<WebAssembly.Module>} module @param {Model[]} models initial networks @param {(reply: Reply) => void} told */
  constructor(module, models, told) {
    this.#module = module;
    this.#models = new Set(models);
    this.#told = told;
    this.leader = this.#start();
  }

  #start() {
    const worker = startWorker("completing");
    worker.onmessage = ({ data }) => this.#told(data);
    worker.onerror = ({ message }) => this.#fail(new Error(message));
    this.#workers.push(worker);
    this.#bringNetworks(worker).catch((error) => this.#fail(error));
    return worker;
  }

  /** @param {Error} error */
  #fail({ message }) {
    if (this.#workers.length > 0) this.#told({ kind: "failed", message });
  }

  /** @param {Worker} worker that starts completing */
  async #bringNetworks(worker) {
    const [first, ...others] = this.#models;
    const [module, weights, uncertainty] = await Promise.all([this.#module, weightsOf(first), weightsOf("uncertainty")]);
    worker.postMessage({ kind: "start", module, name: first, weights, uncertainty }, [weights, uncertainty]);
    await Promise.all(others.map((name) => this.#bring(worker, name))); // once the first picture does not wait for them
  }

  /** @param {Worker} worker @param {Model} name of a network to make available */
  async #bring(worker, name) {
    const weights = await weightsOf(name);
    worker.postMessage({ kind: "network", name, weights }, [weights]);
  }

  /** Adds helpers that complete bands, once the camera moves: the first picture does not need them. */
  grow() {
    while (this.#workers.length < count()) {
      const worker = this.#start(), { port1, port2 } = new MessageChannel();
      worker.postMessage({ kind: "help", leader: port1 }, [port1]);
      this.leader.postMessage({ kind: "helped", helper: port2 }, [port2]);
    }
  }

  /** Fetches a network that was not loaded initially, once it is clearly needed. @param {Model} name */
  ask(name) {
    const asked = this.#asked[name] = 1 + (this.#asked[name] ?? 0);
    if (asked !== ASKED || this.#models.has(name)) return;
    this.#models.add(name);
    for (const worker of this.#workers) this.#bring(worker, name).catch((error) => this.#fail(error));
  }

  end() {
    for (const worker of this.#workers.splice(0)) worker.terminate();
  }
}
