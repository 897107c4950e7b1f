// @ts-check
/**
 * From a scene to pictures: its turns at the page's workers, and the schedule of its pictures. Independent of elements.
 *
 * Without a turn, a viewing has nothing but its last picture and the way to open its scene again.
 *
 * @typedef {import("../workers/reader.js").Summary} Summary
 * @typedef {import("../workers/completing.js").Picture} Picture
 * @typedef {import("../workers/completing.js").Buffers} Buffers
 * @typedef {import("../workers/completing.js").Showing} Showing
 * @typedef {import("../workers/crew.js").CoreName} CoreName
 * @typedef {import("../workers/pool.js").Pool} Pool
 *
 * @typedef {"scene" | "headlight" | "studio"} LightName scene: its own lights, otherwise the headlight
 *
 * @typedef {object} Told Callbacks
 * @property {(summary: Summary) => void} opened a new scene; its first picture follows
 * @property {(picture: Picture, repainted: boolean) => void} picture displays it; repainted: it is the last one in
 *   another mode
 * @property {(message: string) => void} failed no more pictures will come, for the reason given
 */
import { isMesh, isModel } from "../core/endings.js";
import { isThere } from "../core/parts.js";
import { HOME } from "../picture/camera.js";
import { crew } from "../workers/crew.js";
import { Schedule } from "../workers/schedule.js";
import { Statistics } from "./statistics.js";

/** The smallest module for a file; a single file for meshes has no other. @param {string} name @returns {CoreName} */
const coreFor = (name) => (isMesh(name) || !isThere("core.wasm") ? "core.mesh" : "core");

/**
 * A scene that was opened, or will be.
 *
 * @typedef {object} Scene
 * @property {() => void} [prepare] begins to read it
 * @property {(pool: Pool) => Promise<Summary>} open may be called again
 * @property {(opened: Summary | null) => void} resolve
 * @property {(error: Error) => void} reject
 */

let count = 0; // of viewings so far

export class Viewing {
  id = ++count;
  statistics;
  schedule;
  /** The module that supports its scenes. @type {CoreName} */
  core = "core.mesh";
  /** Whether lights replace the headlight. */
  get isLit() {
    return this.schedule.isLit;
  }
  /** Whether a core of meshes has to have lights and edges. */
  get needsExtras() {
    return this.isLit || this.#usesEdges;
  }
  #usesEdges = false;
  /** Whether the displayed scene has lights of its own. */
  isSceneLit = false;
  /** @type {LightName} */
  #light = "scene";
  /** When the user moved it, until its picture is exact: it comes first. */
  movedAt = -Infinity;
  isSeen = false;
  hasPicture = false; // of its scene
  /** The displayed scene. @type {Scene | undefined} */
  #scene;
  /** The scene that replaces it. @type {Scene | undefined} */
  #coming;
  /** One of these, while workers open it. @type {Scene | undefined} */
  #opening;
  isBroken = false; // until something changes
  #isShowing = false; // whether the schedule has workers
  /** @type {Showing} */
  #showing = { mode: "completed", divider: 0.5, isTransparent: false };
  /** Callbacks for the answers of the completing worker. @type {((buffers: Buffers | null) => void)[]} */
  #waiting = [];
  /** Questions to ask once tracers have the scene. @type {((pool?: Pool) => void)[]} */
  #questions = [];
  #told;
  /** Waits for the first picture of the scene. @type {{promise: Promise<void>, resolve: () => void} | undefined} */
  #first;

  /**
   * @param {{workers: number, scales: boolean}} settings workers: number of tracing threads; scales: whether moving
   *   pictures may be smaller
   * @param {Told} told
   */
  constructor({ workers, scales }, told) {
    this.workers = workers;
    this.#told = told;
    this.statistics = new Statistics(workers);
    this.schedule = new Schedule(HOME, scales);
  }

  // ---- Turns ---------------------------------------------------------------------------------------------

  /** Whether the workers have something to do for it. */
  get hasWork() {
    const isDone = this.schedule.isDone && this.#questions.length === 0;
    return this.isSeen && !this.isBroken && (this.#coming !== undefined || (this.#scene !== undefined && !isDone));
  }

  /** Whether the user moved it, and the picture is not exact yet. */
  get isMoved() {
    return this.movedAt > -Infinity;
  }

  /** Says whether anyone sees it; otherwise nothing is done. @param {boolean} isSeen */
  see(isSeen) {
    if (isSeen === this.isSeen) return;
    this.isSeen = isSeen;
    if (!isSeen) this.stop();
    this.#ask();
  }

  #ask() {
    if (this.hasWork) return crew.ask(this);
    this.#answer();
    crew.rest(this);
  }

  /** Reads its scene ahead: it is the next. */
  prepare() {
    if (!this.#isShowing) (this.#coming ?? this.#scene)?.prepare?.();
  }

  /** Its turn begins, or goes on with something new. */
  begin() {
    const pool = crew.poolOf(this), scene = this.#coming ?? (pool ? undefined : this.#scene);
    if (scene && scene !== this.#opening) this.#open(scene);
    else if (pool && !this.#isShowing && !this.#opening) this.#begin(pool);
  }

  /** Its turn ends, or it is not seen. */
  stop() {
    this.#isShowing = false;
    this.#opening = undefined;
    this.schedule.stop();
    for (const resolve of this.#waiting.splice(0)) resolve(null);
  }

  /** @param {Scene} scene */
  async #open(scene) {
    this.#opening = scene;
    try {
      const opened = await crew.open(this, scene.open);
      if (scene !== this.#opening || !opened) return;
      if (scene === this.#coming) {
        this.isSceneLit = opened.result.isLit;
        this.#chooseLights();
        this.#told.opened(opened.result);
      }
      this.#scene = scene;
      this.#opening = this.#coming = undefined;
      this.#begin(opened.pool);
      scene.resolve(opened.result);
    } catch (error) {
      if (scene !== this.#opening || !(error instanceof Error)) return;
      this.#opening = undefined;
      if (scene === this.#coming) this.#coming = undefined;
      else this.fail(error.message);
      scene.reject(error);
      this.#ask();
    }
  }

  /** @param {Pool} pool with the new scene */
  #begin(pool) {
    this.#isShowing = true;
    this.statistics.change();
    this.#first ??= Promise.withResolvers();
    crew.paint(this.#showing);
    pool.turnTo(this.id);
    this.schedule.show(pool);
    this.#answer(pool);
  }

  // ---- Called by the workers ------------------------------------------------------------------------------

  /** Whether a picture is of the current scene. @param {Picture} picture */
  owns({ batch }) {
    return this.#isShowing && this.schedule.owns(batch);
  }

  /** @param {Picture} picture @param {boolean} repainted */
  show(picture, repainted) {
    const { statistics, schedule } = this;
    statistics.expected = picture.expected;
    this.hasPicture = true;
    if (!repainted) statistics.count(picture, schedule, schedule.completed(picture));
    this.#told.picture(picture, repainted);
    if (!repainted && schedule.isCurrent(picture)) this.#isPictured();
    this.#rest();
  }

  /** @param {import("../workers/pool.js").Traced} traced */
  traced(traced) {
    if (!this.#isShowing || !this.schedule.owns(traced.batch)) return;
    this.schedule.traced(traced);
    this.#rest(); // its picture may have come before
  }

  #rest() {
    if (this.schedule.isDone) this.movedAt = -Infinity;
    if (!this.hasWork) crew.rest(this);
  }

  /** @param {Buffers | null} buffers */
  give(buffers) {
    this.#waiting.shift()?.(buffers);
  }

  /** The workers failed; so did a scene that they were opening. @param {string} message */
  fail(message) {
    const coming = this.#coming;
    this.#coming = undefined;
    this.isBroken = true;
    this.stop();
    this.#answer();
    this.#isPictured();
    if (coming) coming.reject(new Error(message));
    else this.#told.failed(message);
  }

  // ---- Scenes --------------------------------------------------------------------------------------------

  /** Starts workers for further scenes ahead. */
  expectMore() {
    this.core = coreFor("");
    crew.expect(this);
  }

  /** Whether a scene is being opened. */
  get isOpening() {
    return this.#coming !== undefined;
  }

  /** Whether there is a scene, with workers that can replace it. */
  get canEdit() {
    return crew.poolOf(this) !== undefined;
  }

  /**
   * Opens a file, once it is seen.
   *
   * @param {string} name with its suffix
   * @param {Blob | string} source the file or its address
   * @param {{turn?: import("../shapes/affine.js").Matrix | null, isUpKnown?: boolean, beside?: File[]}} [options] turn: the rotation of
   *   the file's scene; isUpKnown: otherwise meshes that seem to lie on their back are stood up; beside: files opened together with it
   * @returns {Promise<Summary | null>} once it is displayed; null if another scene was opened meanwhile
   * @throws {Error} of one line if it cannot be read; then the previous scene stays
   */
  read(name, source, { turn = null, isUpKnown = false, beside = [] } = {}) {
    const core = coreFor(name), isMixed = beside.some((file) => isModel(file.name) && coreFor(file.name) !== core);
    // Resolve relative addresses against the page: the reading worker has another base.
    let bytes = typeof source === "string" ? new URL(source, document.baseURI).href : source;
    /** @type {import("../workers/reading.js").ReadFile | undefined} */
    let file;
    const prepared = () => {
      if (file) return file;
      const mine = file = crew.read({ name, source: bytes, beside, turn, isUpKnown }, core, isMixed);
      mine.summary.catch(() => file === mine && (file = undefined));
      return mine;
    };
    const open = async (/** @type {Pool} */ pool) => {
      const mine = prepared();
      file = undefined;
      const summary = await pool.read(this.id, mine);
      bytes = summary.bytes; // the address may be gone when the scene is opened again
      return summary;
    };
    return this.#replace(isMixed ? "core" : core, open, prepared);
  }

  /** Opens a shape script; otherwise as `read`. @param {string} text @returns {Promise<Summary | null>} */
  run(text) {
    return this.#replace(coreFor(""), running(this.id, text));
  }

  /**
   * Replaces the scene by a script's, in the same workers: for small changes of a script.
   *
   * @param {string} text
   * @returns {Promise<Summary | null>} null if another scene was opened meanwhile
   */
  async edit(text) {
    const pool = crew.poolOf(this), open = running(this.id, text);
    if (!pool) throw new Error("edit: expected a scene that is shown, got none");
    const opened = await open(pool).catch((error) => {
      if (pool === crew.poolOf(this)) throw error;
    });
    if (!opened || pool !== crew.poolOf(this)) return null;
    this.#scene = { open, resolve: () => {}, reject: () => {} };
    this.#begin(pool);
    return opened;
  }

  /**
   * @param {CoreName} core that supports it @param {Scene["open"]} open @param {Scene["prepare"]} [prepare]
   * @returns {Promise<Summary | null>}
   */
  #replace(core, open, prepare) {
    this.#coming?.resolve(null);
    this.hasPicture = false;
    this.schedule.relight();
    if (core === "core") this.core = core;
    this.isBroken = false;
    return new Promise((resolve, reject) => {
      this.#coming = { open, prepare, resolve, reject };
      this.#ask();
    });
  }

  // ---- Pictures ------------------------------------------------------------------------------------------

  /**
   * @param {Parameters<Schedule["change"]>[0]} changes the camera, the size or the cutaway
   * @param {boolean} [isMoved] whether the user did it
   */
  change(changes, isMoved = false) {
    this.statistics.change();
    this.isBroken = false;
    if (isMoved) this.movedAt = performance.now();
    this.schedule.change(changes);
    this.#ask();
  }

  /** Replaces the light; a studio is set up for the current camera. @param {LightName} light */
  light(light) {
    this.#light = light;
    if (this.#chooseLights()) this.change({});
  }

  /** @returns {boolean} whether the lights are others */
  #chooseLights() {
    const { schedule } = this, before = schedule.lights;
    schedule.lights = this.#light === "studio" ? "studio" : this.#light === "scene" && this.isSceneLit ? "own" : null;
    if (schedule.lights === before) return false;
    schedule.relight();
    return true;
  }

  /** Draws lines at visible edges. @param {number} thickness in pixels; 0 for no lines */
  draw(thickness) {
    this.#usesEdges ||= thickness > 0;
    this.schedule.thickness = thickness;
    this.change({});
  }

  /** Whether it can snap to edges at once. */
  get canSnap() {
    return crew.hasExtras && crew.poolOf(this) !== undefined;
  }

  /** Resolves once the scene has a picture, or will not get one. @returns {Promise<void>} */
  async pictured() {
    await this.#first?.promise;
  }

  #isPictured() {
    this.#first?.resolve();
    this.#first = undefined;
  }

  /** Refines resting pictures until they are exact, or leaves them. @param {boolean} isWanted */
  refine(isWanted) {
    this.schedule.refines = isWanted;
    this.schedule.next();
    this.#ask();
  }

  /**
   * Asks the scene: calls a method of Scene.
   *
   * @template {import("../workers/tracer.js").Question} Q
   * @param {Q} question
   * @param {Parameters<import("../tracing/scene.js").Scene[Q]>} values
   * @returns {Promise<ReturnType<import("../tracing/scene.js").Scene[Q]> | null>} null if there is no scene, or nobody sees it
   */
  ask(question, ...values) {
    const pool = crew.poolOf(this);
    this.#usesEdges ||= question === "snap";
    if (pool && (question !== "snap" || crew.hasExtras)) return pool.ask(this.id, question, ...values);
    return new Promise((resolve) => {
      this.#questions.push((opened) => resolve(opened ? opened.ask(this.id, question, ...values) : null));
      this.#ask();
    });
  }

  /** @param {Pool} [pool] with the scene */
  #answer(pool) {
    for (const ask of this.#questions.splice(0)) ask(pool);
  }

  /** @param {Showing} showing the way to paint pictures */
  paint(showing) {
    const { isTransparent, exposure = 1 } = this.#showing;
    const isOther = showing.isTransparent !== isTransparent || (showing.exposure ?? 1) !== exposure; // resting pictures are painted once
    this.#showing = showing;
    if (this.#isShowing) crew.paint(showing);
    if (this.#scene && (isOther || !this.#isShowing)) this.change({});
  }

  /** @returns {Promise<Buffers | null>} of the last picture; null if the workers have no picture, or work for another */
  buffers() {
    return new Promise((resolve) => {
      if (!this.#isShowing) return resolve(null);
      this.#waiting.push(resolve);
      crew.post({ kind: "buffers" });
    });
  }

  /** Forgets its scene; one being opened is given up. */
  close() {
    this.#coming?.resolve(null);
    this.#coming = this.#scene = undefined;
    this.hasPicture = this.isSceneLit = false;
    this.statistics.change();
    this.#chooseLights();
    this.stop();
    this.#answer();
    this.#isPictured();
    crew.leave(this);
  }

  end() {
    this.isSeen = false;
    this.close();
  }
}

/** @param {number} id of the viewing @param {string} text of a script @returns {Scene["open"]} */
const running = (id, text) => async (pool) => (
  { script: text, hasFront: false, isLit: false, warnings: await pool.open(id, { shapes: [{ kind: "script", source: text }], instances: [{ shape: 0 }] }) });
