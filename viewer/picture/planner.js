// @ts-check
/** How frames are made, as core/frame/planner.h has it. */
import { cameraValues } from "./camera.js";

/**
 * @typedef {import("./camera.js").Camera} Camera
 * @typedef {import("./camera.js").Size} Size
 *
 * @typedef {"whole" | "squares" | "adaptive" | "reproject"} Mode how pixels are chosen
 * @typedef {"filling" | "small" | "default"} Model what completes a picture
 */

/** In the order of bob::Mode. @type {Mode[]} */
const MODES = ["whole", "squares", "adaptive", "reproject"];
/** In the order of bob::Completion, the quickest first. @type {Model[]} */
const MODELS = ["filling", "small", "default"];

/** Times are in milliseconds, those of tracing of one thread. */
export class FramePlanner {
  #core;
  #handle;

  /** @param {import("../core/core.js").Core} core @param {boolean} completesMeanwhile whether another processor completes while this one traces */
  constructor(core, completesMeanwhile) {
    this.#core = core;
    this.#handle = core.made("make_planner", Number(completesMeanwhile));
  }

  /** Learns what tracing took. @param {Mode} mode @param {number} pixels @param {number} milliseconds @param {boolean} isFirstRound */
  traced(mode, pixels, milliseconds, isFirstRound) {
    this.#core.call("planner_traced", this.#handle, MODES.indexOf(mode), pixels, milliseconds / 1000, Number(isFirstRound));
  }

  /** Learns what completing took. @param {Model} model @param {number} pixels @param {number} milliseconds */
  completed(model, pixels, milliseconds) {
    this.#core.call("planner_completed", this.#handle, MODELS.indexOf(model), pixels, milliseconds / 1000);
  }

  /** Learns what reprojecting took. @param {number} pixels of the picture @param {number} milliseconds */
  reprojected(pixels, milliseconds) {
    this.#core.call("planner_reprojected", this.#handle, pixels, milliseconds / 1000);
  }

  /**
   * How to make a picture. What else it says is of that size.
   *
   * @param {Camera | undefined} before of the last picture, where that can be reprojected @param {Camera} camera @param {Size} size
   * @param {number} milliseconds @param {number} threads @returns {Mode}
   */
  plan(before, camera, { height, width }, milliseconds, threads) {
    const last = before ? cameraValues(before) : 0;
    return MODES[this.#core.call("plan_frame", this.#handle, last, cameraValues(camera), height, width, milliseconds / 1000, threads)];
  }

  /** What is to complete a picture when a time is over. @param {Mode} mode @param {number} known share @param {number} milliseconds @param {number} threads */
  completion(mode, known, milliseconds, threads) {
    return MODELS[this.#core.call("frame_completion", this.#handle, MODES.indexOf(mode), known, milliseconds / 1000, threads)];
  }

  /** Milliseconds for tracing in a frame of so many. @param {Mode} mode @param {Model} model that completes it @param {number} milliseconds */
  forTracing(mode, model, milliseconds) {
    return 1000 * this.#core.call("frame_tracing", this.#handle, MODES.indexOf(mode), MODELS.indexOf(model), milliseconds / 1000);
  }

  /** Milliseconds that the quickest completion takes; 0 while nothing was measured. */
  get completing() {
    return 1000 * this.#core.call("frame_completing", this.#handle, 0);
  }

  /** How many pixels fit into so many milliseconds of one thread. @param {Mode} mode @param {number} milliseconds */
  pixelsIn(mode, milliseconds) {
    return this.#core.call("frame_pixels", this.#handle, MODES.indexOf(mode), milliseconds / 1000);
  }

  free() {
    this.#core.call("free_planner", this.#handle);
  }
}
