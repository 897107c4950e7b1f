// @ts-check
/**
 * The workers of a page, shared by its elements. They work for one viewing at a time, until its picture is exact: then
 * for the next one that is waiting. The viewing that the user moves comes first. Nobody waits who is not seen.
 *
 * Between scenes, workers whose memory is large are replaced, since a WebAssembly instance never releases memory. When
 * nobody is left whom they could work for, all end.
 *
 * @typedef {import("../component/viewing.js").Viewing} Viewing
 * @typedef {import("../picture/planner.js").Model} Model
 */
import { canLendThreads, compileCore } from "../core/compile.js";
import { Completers } from "./completers.js";
import { Pool } from "./pool.js";
import { Reading } from "./reading.js";

const TURN_MS = 500; // of a viewing that has a picture, while others wait
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

/** For all workers of a page: compiled once. @type {Map<CoreName, Promise<WebAssembly.Module>>} */
const compiled = new Map();

/** @param {CoreName} core */
function compiledCore(core) {
  const module = compiled.get(core) ?? compileCore(canLendThreads() ? /** @type {`${CoreName}.threads`} */ (`${core}.threads`) : core);
  compiled.set(core, module);
  module.catch(() => compiled.delete(core)); // for another try
  return module;
}

class Crew {
  /** Viewings with work, in the order of asking. @type {Set<Viewing>} */
  #waiting = new Set();
  /** The viewing that the workers work for, or last did. @type {Viewing | undefined} */
  #holder;
  #isFree = true; // whether the holder has no more work
  #since = 0; // of the holder's turn
  #isChoosing = false;
  #leaving = 0;
  /** @type {CoreName} */
  #core = "core.mesh";
  /** @type {Completers | undefined} */
  #completers;
  #reading = new Reading();
  /** The workers with the holder's scene, with its next scene, and for the one after that. @type {{shown?: Pool, coming?: Pool, spare?: Pool}} */
  #pools = {};
  /** The viewing whose scene is in the workers that show one. @type {Viewing | undefined} */
  #owner;
  #pixels = 0; // of the largest picture
  /** How pictures are painted. @type {import("./completing.js").Showing | undefined} */
  #showing;

  // ---- Turns ---------------------------------------------------------------------------------------------

  /** Asks for the workers. @param {Viewing} viewing that is seen and has work */
  ask(viewing) {
    clearTimeout(this.#leaving);
    this.#leaving = 0;
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
    if (viewing !== this.#holder) return;
    this.#isFree = true;
    this.#choose();
  }

  /** A viewing ends. @param {Viewing} viewing */
  leave(viewing) {
    if (viewing === this.#expecting) this.#expecting = undefined;
    this.rest(viewing);
    if (viewing === this.#owner) this.#owner = undefined;
    if (viewing !== this.#holder) return;
    this.#lose();
    if (this.#waiting.size === 0 || this.#pixels > MOST_PIXELS) this.#end();
  }

  /** Whether the workers work for a viewing. @param {Viewing} viewing */
  isOf(viewing) {
    return viewing === this.#holder;
  }

  /** Called after each picture. @param {Viewing} holder @param {import("./completing.js").Picture} picture */
  #shown(holder, { batch: { height, width }, wanted }) {
    this.#pixels = Math.max(this.#pixels, height * width);
    this.#pools.shown?.grow();
    if (holder.isMoved) this.#completers?.grow();
    this.#completers?.ask(wanted);
    this.#next?.prepare();
    if (!holder.hasWork) return this.rest(holder);
    if (this.#waiting.size === 0 || holder.isMoved || performance.now() < this.#since + TURN_MS) return;
    this.#waiting.add(holder);
    this.#isFree = true;
    this.#choose();
  }

  /** The viewing that the user moved last, or that waits longest. @returns {Viewing | undefined} */
  get #next() {
    let next;
    for (const viewing of this.#waiting) if (!next || viewing.movedAt > next.movedAt) next = viewing;
    return next;
  }

  /** Decides who is next, once all that happens now has happened: a page's elements come one after the other. */
  #choose() {
    if (this.#isChoosing) return;
    this.#isChoosing = true;
    queueMicrotask(() => {
      this.#isChoosing = false;
      const first = this.#next;
      if (!first) {
        if (this.#isFree) this.#idle();
      } else if (this.#isFree || first.movedAt > (this.#holder?.movedAt ?? -Infinity)) {
        this.#give(first);
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
    this.#since = performance.now();
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

  /** Nobody is waiting: workers end if nobody sees the holder either. */
  #idle() {
    if (!this.#expecting) this.#reading.end();
    if (this.#holder?.isSeen || this.#leaving || !this.#completers) return;
    this.#leaving = setTimeout(() => {
      this.#leaving = 0;
      this.#lose();
      this.#end();
    }, LEAVING_MS);
  }

  // ---- Workers -------------------------------------------------------------------------------------------

  /** Opens further scenes: workers for them are started ahead, which takes longer than opening most. @type {Viewing | undefined} */
  #expecting;

  /** Starts the workers for a viewing, if necessary. @param {Viewing} viewing */
  #start(viewing) {
    const isTooSmall = this.#core === "core.mesh" && [viewing, ...this.#waiting].some(({ core }) => core === "core");
    if (isTooSmall) {
      this.#end();
      this.#core = "core";
    }
    this.#completers ??= new Completers(compiledCore(this.#core), NETWORKS[this.#core], (reply) => this.#receive(reply));
    if (this.#pools.shown && this.#owner !== viewing) {
      const { shown } = this.#pools;
      this.#pools.shown = this.#owner = undefined;
      if (shown.isReusable && !this.#pools.spare) this.#pools.spare = shown;
      else shown.end();
    }
  }

  /** Ends all workers. */
  #end() {
    const pools = Object.values(this.#pools);
    this.#holder?.stop();
    this.#pools = {};
    this.#owner = undefined;
    this.#pixels = 0;
    for (const pool of pools) pool?.end();
    this.#completers?.end();
    this.#completers = this.#showing = undefined;
    this.#reading.end();
  }

  /** @param {number} size number of threads @returns {Pool} */
  #createPool(size) {
    const { leader } = /** @type {Completers} */ (this.#completers), isShown = () => pool === this.#pools.shown;
    const pool = new Pool(size, compiledCore(this.#core), leader, (traced) => isShown() && this.#holder?.traced(traced),
                          (message) => isShown() && this.#lost(message));
    return pool;
  }

  /** The last tracer has failed. @param {string} message */
  #lost(message) {
    const holder = this.#holder;
    if (!holder) return;
    holder.fail(message);
    this.rest(holder);
  }

  /** Gives up the scene that is being opened. */
  #abandon() {
    const { coming, shown } = this.#pools;
    this.#pools.coming = undefined;
    if (coming === shown) this.#pools.shown = this.#owner = undefined;
    coming?.end();
    if (this.#reading.isBusy) this.#reading.end();
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

  /** The workers with a viewing's scene. @param {Viewing} viewing @returns {Pool | undefined} */
  poolOf(viewing) {
    const { shown } = this.#pools;
    return viewing === this.#owner && shown?.ended === false ? shown : undefined;
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
    const pools = this.#pools, { shown, spare } = pools, isReusable = viewing !== this.#expecting && shown?.isReusable && shown.size === viewing.workers;
    if (spare && spare.size !== viewing.workers) spare.end(), pools.spare = undefined;
    const pool = pools.coming = pools.spare ?? (isReusable && shown ? shown : this.#createPool(viewing.workers));
    pools.spare = undefined;
    try {
      const result = await open(pool);
      if (pool !== this.#pools.coming) return null;
      if (pools.shown !== pool) pools.shown?.end();
      pools.shown = pool, pools.coming = undefined;
      this.#owner = viewing;
      return { pool, result };
    } catch (error) {
      if (pool !== this.#pools.coming) return null;
      pools.coming = undefined;
      if (pool !== shown || pool.ended) pool.end();
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

  /** @param {import("./reading.js").Source} source @param {CoreName} core that reads it @returns {import("./reading.js").ReadFile} */
  read(source, core) {
    return this.#reading.read(source, compiledCore(core));
  }

  /** Sets how pictures are painted. @param {import("./completing.js").Showing} showing */
  paint(showing) {
    const { mode, divider, isTransparent } = this.#showing ?? {};
    if (mode === showing.mode && divider === showing.divider && isTransparent === showing.isTransparent) return;
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
