// @ts-check
/**
 * The workers of a page, shared by its elements. They work for one viewing at a time: first for the one that the user
 * moves, then for those without a picture, then for the others until their pictures are exact; never for one that is not
 * seen. They keep the scenes of several viewings.
 *
 * A WebAssembly instance never releases memory: workers whose memory is large are replaced before they get another
 * scene. When nobody is left whom they could work for, all end.
 *
 * @typedef {import("../picture/planner.js").Model} Model
 *
 * @typedef {object} Viewing A scene and its pictures, for which the crew works
 * @property {number} id
 * @property {number} workers number of tracing threads
 * @property {CoreName} core supports its scenes
 * @property {boolean} needsExtras whether a core of meshes has to have lights and edges
 * @property {import("./schedule.js").Schedule} schedule of its pictures
 * @property {number} movedAt when the user moved it, until its picture is exact; else -Infinity
 * @property {boolean} isMoved whether movedAt is finite
 * @property {boolean} isSeen
 * @property {boolean} hasWork whether there is something to open or to trace
 * @property {boolean} hasPicture of its scene
 * @property {() => void} prepare reads its scene ahead
 * @property {() => void} begin its turn begins, or goes on with something new
 * @property {() => void} stop its turn ends
 * @property {(traced: import("./pool.js").Traced) => void} traced
 * @property {(picture: import("./completing.js").Picture) => boolean} owns whether a picture is of its current scene
 * @property {(picture: import("./completing.js").Picture, repainted: boolean) => void} show
 * @property {(buffers: import("./completing.js").Buffers | null) => void} give
 * @property {(message: string) => void} fail
 */
import { canLendThreads, compileCore } from "../core/compile.js";
import { isThere } from "../core/parts.js";
import { Completers } from "./completers.js";
import { Pool } from "./pool.js";
import { Reading } from "./reading.js";

const TURN_MS = 500; // after its first picture, if its scene may have to be opened again; at least twice the time it took to begin
const AMPLE = 64e6; // bytes of tracers: with more, scenes of exact pictures are freed before another is opened
const LEAVING_MS = 2000; // after the last viewing was seen, before the workers end
const SPARE_MS = 500; // after a scene arrived, before workers for the next one are started
const MOST_PIXELS = 1e6; // of pictures whose memory a completing worker may keep

/**
 * Initial modules of pages: the core's, and networks; the first also replaces networks not loaded yet. Pages of meshes
 * are small: their rays are so fast that pictures are dense, and completed by the filling, without trained weights.
 *
 * @typedef {"core" | "core.mesh"} CoreName
 * @type {Record<CoreName, [Model, ...Model[]]>}
 */
const NETWORKS = { "core": ["default", "filling", "small"], "core.mesh": ["filling"] };

/**
 * The module of a core. All shapes have lights and edges; meshes only if they are wanted, or in a single file.
 *
 * @param {CoreName} core @param {boolean} hasExtras @returns {CoreName | "core.mesh.light"}
 */
function moduleOf(core, hasExtras) {
  return core === "core.mesh" && (hasExtras || !isThere("core.mesh.wasm")) ? "core.mesh.light" : core;
}

/** Modules compiled once for all workers of a page. @type {Map<string, Promise<WebAssembly.Module>>} */
const compiled = new Map();

/** @param {CoreName} core @param {boolean} hasExtras */
function compiledCore(core, hasExtras) {
  const name = moduleOf(core, hasExtras), module = compiled.get(name) ?? compileCore(canLendThreads() ? /** @type {const} */ (`${name}.threads`) : name);
  compiled.set(name, module);
  module.catch(() => compiled.delete(name)); // for another try
  return module;
}

class Crew {
  /** Viewings with work, in the order of asking. @type {Set<Viewing>} */
  #waiting = new Set();
  /** The viewing that the workers work for, or last did. @type {Viewing | undefined} */
  #holder;
  #isFree = true; // whether the holder has no more work
  #begun = 0; // when the holder's turn began
  #until = Infinity; // when it ends if others have no picture
  #isChoosing = false;
  #leaving = 0;
  /** @type {CoreName} */
  #core = "core.mesh";
  #hasExtras = !isThere("core.mesh.wasm"); // whether a core of meshes has lights and edges
  /** @type {Completers | undefined} */
  #completers;
  #reading = new Reading();
  /** The tracers with scenes, with the next scene, and for the one after that. @type {{shown?: Pool, coming?: Pool, spare?: Pool}} */
  #pools = {};
  /** Viewings whose scenes may be kept. @type {Set<Viewing>} */
  #kept = new Set();
  /** Identifies the scene that is being opened. @type {object | undefined} */
  #opening;
  #pixels = 0; // of the largest picture
  /** How pictures are painted. @type {import("./completing.js").Showing | undefined} */
  #showing;

  // ---- Turns ---------------------------------------------------------------------------------------------

  /** Asks for the workers. @param {Viewing} viewing that is seen and has work */
  ask(viewing) {
    if (viewing === this.#holder) {
      this.#isFree = false;
      this.#start(viewing);
      viewing.begin();
    } else {
      this.#waiting.add(viewing);
      this.#choose();
    }
  }

  /** A viewing has no work, or is not seen. @param {Viewing} viewing */
  rest(viewing) {
    this.#waiting.delete(viewing);
    if (viewing === this.#holder) this.#isFree = true;
    this.#choose();
  }

  /** A viewing ends. @param {Viewing} viewing */
  leave(viewing) {
    if (viewing === this.#expecting) this.#expecting = undefined;
    this.rest(viewing);
    if (viewing === this.#holder) this.#lose();
    this.#forget(viewing);
    this.#giveBack();
  }

  /** Called after each picture. @param {Viewing} holder @param {import("./completing.js").Picture} picture */
  #shown(holder, { batch: { height, width }, wanted }) {
    this.#pixels = Math.max(this.#pixels, height * width);
    this.#pools.shown?.grow();
    if (holder.schedule.isMoving && this.#waiting.size === 0) this.#completers?.grow();
    this.#completers?.ask(wanted);
    this.next?.prepare();
    if (!holder.hasWork) return;
    const now = performance.now(), isKept = (this.#pools.shown?.memory ?? Infinity) <= AMPLE;
    if (this.#until === Infinity) this.#until = isKept ? now : now + Math.max(TURN_MS, 2 * (now - this.#begun));
    const { next } = this, isOver = next && (next.hasPicture ? holder.schedule.isMoving : now >= this.#until);
    if (!isOver || holder.isMoved) return holder.schedule.next();
    this.#waiting.add(holder);
    this.#isFree = true;
    this.#choose();
  }

  /** The viewing that the user moved last, or has no picture, or waits longest. @returns {Viewing | undefined} */
  get next() {
    const waiting = [...this.#waiting], moved = waiting.reduce((a, b) => (b.movedAt > a.movedAt ? b : a), waiting[0]);
    return moved?.isMoved ? moved : waiting.find(({ hasPicture }) => !hasPicture) ?? moved;
  }

  /** Decides who is next, once all that happens now has happened: a page's elements come one after the other. */
  #choose() {
    if (this.#isChoosing) return;
    this.#isChoosing = true;
    queueMicrotask(() => {
      this.#isChoosing = false;
      const first = this.next, holder = this.#holder;
      if (first && (this.#isFree || first.movedAt > (holder?.movedAt ?? -Infinity))) this.#give(first);
      else if (!first && this.#isFree && !this.#expecting) this.#reading.finish();
      if (this.#holder) this.#holder.schedule.isShared = this.#waiting.size > 0;
      if (!this.#leaving && [holder, ...this.#kept].some((viewing) => viewing?.isSeen === false)) {
        this.#leaving = setTimeout(() => this.#giveBack(), LEAVING_MS);
      }
    });
  }

  /** @param {Viewing} viewing */
  #give(viewing) {
    const before = this.#holder;
    this.#waiting.delete(viewing);
    if (viewing !== before) {
      if (before && !this.#isFree && before.hasWork) this.#waiting.add(before);
      this.#lose();
      this.#holder = viewing;
    }
    this.#isFree = false;
    this.#begun = performance.now();
    this.#until = Infinity;
    this.#start(viewing);
    viewing.begin();
  }

  /** The holder stops where it is. */
  #lose() {
    const holder = this.#holder, { shown, coming } = this.#pools;
    this.#holder = undefined;
    this.#isFree = true;
    if (coming) this.#abandon();
    shown?.cancel();
    holder?.stop();
  }

  /** Frees the scenes that nobody sees, and ends the workers that nobody needs, or whose memory is large. */
  #giveBack() {
    clearTimeout(this.#leaving);
    this.#leaving = 0;
    for (const viewing of this.#kept) if (!viewing.isSeen) this.#forget(viewing);
    const holder = this.#holder, isNeeded = this.#waiting.size > 0 || this.#kept.size > 0 || holder?.isSeen;
    if (isNeeded && (this.#pools.shown?.memory ?? 0) <= AMPLE && this.#pixels <= MOST_PIXELS) return;
    this.#end();
    if (holder?.hasWork) this.ask(holder);
  }

  // ---- Workers -------------------------------------------------------------------------------------------

  /** Opens further scenes: workers for them are started ahead, which takes longer than opening most. @type {Viewing | undefined} */
  #expecting;

  /** Starts the workers for a viewing, if necessary. @param {Viewing} viewing */
  #start(viewing) {
    const all = [viewing, ...this.#waiting], needsAll = all.some(({ core }) => core === "core"), needsExtras = all.some((one) => one.needsExtras);
    const isTooSmall = this.#core === "core.mesh" && (needsAll || (needsExtras && !this.#hasExtras));
    if (isTooSmall) {
      this.#end();
      if (needsAll) this.#core = "core";
      this.#hasExtras ||= needsExtras;
    }
    this.#completers ??= new Completers(compiledCore(this.#core, this.#hasExtras), NETWORKS[this.#core], (reply) => this.#receive(reply));
  }

  /** Whether the workers' core has lights and edges. */
  get hasExtras() {
    return this.#core === "core" || this.#hasExtras;
  }

  /** Ends all workers. */
  #end() {
    const pools = Object.values(this.#pools);
    this.#holder?.stop();
    this.#pools = {};
    this.#opening = undefined;
    this.#kept.clear();
    this.#pixels = 0;
    for (const pool of pools) pool?.end();
    this.#completers?.end();
    this.#completers = this.#showing = undefined;
    this.#reading.end();
  }

  /** @param {number} size number of threads @returns {Pool} */
  #createPool(size) {
    const { leader } = /** @type {Completers} */ (this.#completers), isShown = () => pool === this.#pools.shown;
    const pool = new Pool(size, compiledCore(this.#core, this.#hasExtras), leader, (traced) => isShown() && this.#holder?.traced(traced),
                          (message) => isShown() && this.#lost(message));
    return pool;
  }

  /** The last tracer has failed. A scene that is being opened replaces its scene, or fails by itself. @param {string} message */
  #lost(message) {
    const holder = this.#holder;
    if (!holder || this.#pools.coming) return;
    holder.fail(message);
    this.rest(holder);
  }

  /** Gives up the scene that is being opened. */
  #abandon() {
    const { coming, shown } = this.#pools;
    this.#pools.coming = this.#opening = undefined;
    if (coming !== shown) coming?.end();
    if (this.#reading.isBusy) this.#reading.end();
  }

  /** Frees the scene of a viewing. @param {Viewing} viewing */
  #forget(viewing) {
    if (!this.#kept.delete(viewing)) return;
    this.#pools.shown?.forget(viewing.id);
  }

  /** @param {import("./completing.js").Reply} reply */
  #receive(reply) {
    const holder = this.#holder;
    if (reply.kind === "failed") {
      holder?.fail(reply.message);
      this.#end();
      if (holder) this.rest(holder);
    } else if (reply.kind === "buffers") {
      holder?.give(reply.buffers);
    } else if (holder?.owns(reply.picture)) {
      holder.show(reply.picture, reply.repainted);
      if (holder === this.#holder && !reply.repainted) this.#shown(holder, reply.picture);
    } else {
      reply.picture.bitmap.close();
    }
  }

  // ---- Scenes --------------------------------------------------------------------------------------------

  /** The tracers that keep a viewing's scene. @param {Viewing} viewing @returns {Pool | undefined} */
  poolOf({ id }) {
    const { shown } = this.#pools;
    return shown?.has(id) ? shown : undefined;
  }

  /** The tracers for the holder's next scene. @param {Viewing} holder @returns {Pool} */
  #poolFor({ id, workers }) {
    const pools = this.#pools, { shown, spare } = pools;
    pools.spare = undefined;
    if (spare?.size === workers && !spare.ended) return spare;
    spare?.end();
    if (this.#expecting) return this.#createPool(workers);
    if (shown?.isReusable && shown.size === workers) {
      if (shown.memory > AMPLE) for (const viewing of this.#kept) if (!viewing.hasWork) this.#forget(viewing);
      return shown;
    }
    if (shown && !shown.has(id)) {
      shown.end();
      pools.shown = undefined;
    }
    return this.#createPool(workers);
  }

  /**
   * Opens a scene of the holder; a previous one that is being opened is given up.
   *
   * @template T
   * @param {Viewing} viewing the holder
   * @param {(pool: Pool) => Promise<T>} open
   * @returns {Promise<{pool: Pool, result: T} | null>} null if it was given up
   * @throws {Error} if it cannot be opened
   */
  async open(viewing, open) {
    if (this.#pools.coming) this.#abandon();
    const pools = this.#pools, pool = pools.coming = this.#poolFor(viewing), opening = this.#opening = {};
    try {
      const result = await open(pool);
      if (opening !== this.#opening) return null;
      if (pools.shown !== pool) {
        pools.shown?.end();
        this.#kept.clear();
      }
      pools.shown = pool, pools.coming = this.#opening = undefined;
      this.#kept.add(viewing);
      return { pool, result };
    } catch (error) {
      if (opening !== this.#opening) return null;
      pools.coming = this.#opening = undefined;
      if (pool !== pools.shown || pool.ended) pool.end();
      throw error;
    } finally {
      setTimeout(() => this.#startSpare(viewing.workers), SPARE_MS);
    }
  }

  /** Starts workers for a further scene. @param {number} size number of threads */
  #startSpare(size) {
    if (!this.#expecting || !this.#completers) return;
    (this.#pools.spare ??= this.#createPool(size)).lend();
    this.#reading.start();
  }

  /** Expects further scenes, and starts the workers for the first. @param {Viewing} viewing */
  expect(viewing) {
    this.#expecting = viewing;
    if (!viewing.isSeen) return;
    this.#start(viewing);
    this.#startSpare(viewing.workers);
  }

  /**
   * @param {import("./reading.js").Source} source @param {CoreName} core that reads it
   * @param {boolean} isMixed whether files opened together with it need the other core
   * @returns {import("./reading.js").ReadFile}
   */
  read(source, core, isMixed) {
    const compiled = (/** @type {CoreName} */ one) => compiledCore(one, this.#hasExtras && one === this.#core);
    return this.#reading.read(source, compiled(core), isMixed ? compiled(core === "core" ? "core.mesh" : "core") : undefined);
  }

  /** Sets how pictures are painted. @param {import("./completing.js").Showing} showing */
  paint(showing) {
    const { mode, divider, isTransparent, exposure } = this.#showing ?? {}, isSame = exposure === showing.exposure;
    if (isSame && mode === showing.mode && divider === showing.divider && isTransparent === showing.isTransparent) return;
    this.#showing = showing;
    this.post({ kind: "show", ...showing });
  }

  /** Sends a message to the worker that paints. @param {import("./completing.js").Request} message */
  post(message) {
    this.#completers?.leader.postMessage(message);
  }
}

/** The page's. */
export const crew = new Crew();
