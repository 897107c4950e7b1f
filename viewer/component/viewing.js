// @ts-check
/**
 * From a scene to pictures: the workers that read, trace and complete it, and their schedule. Independent of elements.
 *
 * @typedef {import("../workers/reader.js").Summary} Summary
 * @typedef {import("../workers/completing.js").Picture} Picture
 * @typedef {import("../workers/completing.js").Buffers} Buffers
 * @typedef {import("../workers/completing.js").Model} Model
 *
 * @typedef {object} Told Callbacks
 * @property {(picture: Picture, repainted: boolean) => void} picture displays it; repainted: it is the last one in
 *   another mode
 * @property {(message: string) => void} failed no more pictures will come, for the reason given
 */
import { canLendThreads, compileCore } from "../core/compile.js";
import { fetchPart, isThere, startWorker } from "../core/parts.js";
import { HOME } from "../picture/camera.js";
import { Pool } from "../workers/pool.js";
import { Schedule } from "../workers/schedule.js";
import { Statistics } from "./statistics.js";

/** Number of workers that complete bands of a picture: one, if all cores are busy tracing the next one meanwhile. */
const completingWorkers = () => (navigator.hardwareConcurrency >= 4 ? 2 : 1);

const SPARE_MS = 500; // after a scene arrived, before workers for the next one are started

/**
 * Initial modules of pages: the core's, and networks; the first also replaces networks not loaded yet. Pages of meshes
 * are small: their rays are so fast that pictures are dense, and completed by the filling, without trained weights.
 *
 * @typedef {"core" | "core.mesh"} CoreName
 * @type {Record<CoreName, [Model, ...Model[]]>}
 */
const NETWORKS = { "core": ["default", "filling", "small"], "core.mesh": ["filling"] };

const ASKED = 2; // requests before a network is fetched: the first picture of a scene asks for one before the speed of its rays is known

const MESHES = /\.(ply|obj|stl|off|glb|gltf)$/i;

/** The smallest module for a file; a single file for meshes has no other. @param {string} name @returns {CoreName} */
export const coreFor = (name) => (MESHES.test(name) || !isThere("core.wasm") ? "core.mesh" : "core");

/** For all workers of a page: compiled once. @type {Map<CoreName, Promise<WebAssembly.Module>>} */
const compiled = new Map();

/** @param {CoreName} core */
function compiledCore(core) {
  const module = compiled.get(core) ?? compileCore(canLendThreads() ? /** @type {`${CoreName}.threads`} */ (`${core}.threads`) : core);
  compiled.set(core, module);
  return module;
}

/** @param {string} name of a network @returns {Promise<ArrayBuffer>} its weights */
const weightsOf = async (name) => (await fetchPart(`weights/${name}.safetensors`)).arrayBuffer();

export class Viewing {
  /** Whether workers for another scene are started ahead: that takes longer than opening most scenes. */
  expectsMore = false;
  statistics;
  schedule;
  /**
   * The workers with the current scene, with the next scene, and for the one after that.
   *
   * @type {{shown?: Pool, coming?: Pool, spare?: Pool}}
   */
  #pools = {};
  #module;
  /** The first gathers and displays the bands; the others help. @type {[Worker, ...Worker[]]} */
  #completing = [startWorker("completing")];
  /** Callbacks for the answers of the completing worker. @type {((buffers: Buffers | null) => void)[]} */
  #waiting = [];
  /** Number of requests for each network. @type {Partial<Record<Model, number>>} */
  #asked = {};
  /** Names of the available networks. @type {Set<Model>} */
  #models;
  #workers;
  #told;

  /**
   * @param {{workers: number, scales: boolean, core?: CoreName}} settings scales: whether moving pictures may be
   *   smaller; core: the module that supports all scenes of the page
   * @param {Told} told
   */
  constructor({ workers, scales, core = "core" }, told) {
    this.core = core;
    this.#module = compiledCore(core);
    this.#workers = workers;
    this.#told = told;
    this.statistics = new Statistics(workers);
    this.schedule = new Schedule(HOME, scales);
    this.#models = new Set(NETWORKS[core]);
    this.#startCompleting(this.#completing[0]);
    this.#pools.spare = this.#createPool();
  }

  /** @param {Worker} worker */
  #startCompleting(worker) {
    /** @param {MessageEvent<import("../workers/completing.js").Reply>} event */
    worker.onmessage = ({ data }) => {
      if (data.kind === "picture") this.#show(data.picture, data.repainted);
      else if (data.kind === "buffers") this.#waiting.shift()?.(data.buffers);
      else if (data.kind === "failed") this.#told.failed(data.message);
    };
    worker.onerror = ({ message }) => this.#told.failed(message);
    this.#bringNetworks(worker).catch((error) => this.#told.failed(error.message));
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

  /** Adds helpers that complete bands, after the first picture, which they would only delay. */
  #growCompleting() {
    const leader = this.#completing[0];
    while (this.#completing.length < completingWorkers()) {
      const worker = startWorker("completing"), { port1, port2 } = new MessageChannel();
      this.#completing.push(worker);
      this.#startCompleting(worker);
      worker.postMessage({ kind: "help", leader: port1 }, [port1]);
      leader.postMessage({ kind: "helped", helper: port2 }, [port2]);
    }
  }

  /** Fetches a network that was not loaded initially, once it is clearly needed. @param {Model} name */
  #ask(name) {
    const asked = this.#asked[name] = 1 + (this.#asked[name] ?? 0);
    if (asked !== ASKED || this.#models.has(name)) return;
    this.#models.add(name);
    for (const worker of this.#completing) this.#bring(worker, name).catch((error) => this.#told.failed(error.message));
  }

  #createPool() {
    const { schedule } = this, isShown = () => made === this.#pools.shown;
    const made = new Pool(this.#workers, this.#module, this.#completing[0], (traced) => isShown() && schedule.traced(traced),
                          (message) => isShown() && this.#told.failed(message));
    return made;
  }

  /** @param {Picture} picture @param {boolean} repainted */
  #show(picture, repainted) {
    const { statistics, schedule } = this;
    statistics.expected = picture.expected;
    if (!repainted) statistics.count(picture, schedule, schedule.completed(picture));
    this.#told.picture(picture, repainted);
    if (repainted) return;
    this.#pools.shown?.grow();
    this.#growCompleting();
    this.#ask(picture.wanted);
  }

  /** Whether a scene is being opened. */
  get isOpening() {
    return this.#pools.coming !== undefined;
  }

  /** Whether there is a scene, with workers that can replace it. */
  get canEdit() {
    return this.#pools.shown?.ended === false;
  }

  /**
   * Opens a file.
   *
   * @param {string} name with its suffix
   * @param {Blob | string} source the file or its address
   * @param {{yUp?: boolean, beside?: File[]}} [options] yUp: whether y is up in the file; beside: files opened together
   *   with it
   * @returns {Promise<Summary | null>} once it is displayed; null if another scene was opened meanwhile
   * @throws {Error} of one line if it cannot be read; then the previous scene stays
   */
  read(name, source, { yUp = false, beside = [] } = {}) {
    // Resolve relative addresses against the page: the reading worker has another base.
    const whole = typeof source === "string" ? new URL(source, document.baseURI).href : source;
    const module = compiledCore(MESHES.test(name) ? "core.mesh" : this.core); // only core.mesh reads these
    return this.#replace((pool) => pool.read(name, whole, yUp, beside, module));
  }

  /** Opens a shape script; otherwise as `read`. @param {string} text @returns {Promise<Summary | null>} */
  run(text) {
    return this.#replace(async (pool) => ({ script: text, warnings: await pool.open(described(text)) }));
  }

  /**
   * Replaces the scene by a script's, in the same workers: for small changes of a script.
   *
   * @param {string} text
   * @returns {Promise<Summary | null>} null if another scene was opened meanwhile
   */
  async edit(text) {
    const pool = this.#pools.shown;
    if (!pool) throw new Error("edit: expected a scene that is shown, got none");
    const warnings = await pool.open(described(text));
    if (pool !== this.#pools.shown) return null;
    this.#begin(pool);
    return { script: text, warnings };
  }

  /** @param {(pool: Pool) => Promise<Summary>} open @returns {Promise<Summary | null>} */
  async #replace(open) {
    const pools = this.#pools;
    pools.coming?.end();
    const mine = pools.coming = pools.spare ?? this.#createPool();
    pools.spare = undefined;
    try {
      const summary = await open(mine);
      if (mine !== pools.coming) return null;
      pools.shown?.end();
      pools.shown = mine, pools.coming = undefined;
      this.#begin(mine);
      return summary;
    } catch (error) {
      if (mine !== pools.coming) return null;
      pools.coming = undefined;
      mine.end();
      throw error;
    } finally {
      setTimeout(() => this.expectsMore && (pools.spare ??= this.#createPool()).lend(), SPARE_MS);
    }
  }

  /** @param {Pool} pool with the new scene */
  #begin(pool) {
    this.statistics.exact = false;
    this.schedule.show(pool);
  }

  /** @param {Parameters<Schedule["change"]>[0]} what is new: the camera or the size */
  change(what) {
    this.statistics.exact = false;
    this.schedule.change(what);
  }

  /** @param {import("../workers/completing.js").Showing} showing the way to paint pictures */
  paint(showing) {
    this.#completing[0].postMessage({ kind: "show", ...showing });
  }

  /** @returns {Promise<Buffers | null>} of the last picture */
  buffers() {
    return new Promise((resolve) => {
      this.#waiting.push(resolve);
      this.#completing[0].postMessage({ kind: "buffers" });
    });
  }

  /** Ends all workers. */
  end() {
    this.expectsMore = false;
    const pools = Object.values(this.#pools);
    Object.assign(this.#pools, { shown: undefined, coming: undefined, spare: undefined }); // so that a scene being opened is included
    for (const pool of pools) pool?.end();
    for (const worker of this.#completing) worker.terminate();
  }
}

/** @param {string} text of a script @returns {import("../tracing/description.js").SceneDescription} */
const described = (text) => ({ shapes: [{ kind: "script", source: text }], instances: [{ shape: 0 }] });
