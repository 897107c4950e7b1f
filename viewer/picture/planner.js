// @ts-check
/** The planner of frames, as in core/frame/planner.h. */
import { cameraValues } from "./camera.js";

/**
 * @typedef {import("./camera.js").Camera} Camera
 * @typedef {import("./camera.js").Size} Size
 *
 * @typedef {"whole" | "squares" | "adaptive" | "reproject"} Mode the choice of pixels
 * @typedef {"filling" | "small" | "default"} Model the network that completes a picture
 */

/** In the order of bob::Mode. @type {Mode[]} */
const MODES = ["whole", "squares", "adaptive", "reproject"];
/** In the order of bob::Completion, the fastest first. @type {Model[]} */
const MODELS = ["filling", "small", "default"];

/** Times are in milliseconds; tracing times are for one thread. */
export class FramePlanner {
  #core;
  #handle;

  /**
   * @param {import("../core/core.js").Core} core @param {boolean} completesMeanwhile whether another processor
   *   completes pictures while this one traces
   */
  constructor(core, completesMeanwhile) {
    this.#core = core;
    this.#handle = core.made("make_planner", Number(completesMeanwhile));
  }

  /**
   * Reports the time for tracing.
   *
   * @param {Mode} mode @param {number} pixels @param {number} milliseconds @param {boolean} isFirstRound
   */
  traced(mode, pixels, milliseconds, isFirstRound) {
    this.#core.call("planner_traced", this.#handle, MODES.indexOf(mode), pixels, milliseconds / 1000, Number(isFirstRound));
  }

  /** Reports the time for completing. @param {Model} model @param {number} pixels @param {number} milliseconds */
  completed(model, pixels, milliseconds) {
    this.#core.call("planner_completed", this.#handle, MODELS.indexOf(model), pixels, milliseconds / 1000);
  }

  /** Reports the time for reprojecting. @param {number} pixels of the picture @param {number} milliseconds */
  reprojected(pixels, milliseconds) {
    this.#core.call("planner_reprojected", this.#handle, pixels, milliseconds / 1000);
  }

  /**
   * The divisor of a moving picture's height and width.
   *
   * @param {{camera: Camera, scale: number} | undefined} before the last picture, if it can be reprojected
   * @param {Camera} camera @param {Size} size at rest
   * @param {number} milliseconds @param {number} threads
   */
  scale(before, camera, size, milliseconds, threads) {
    return this.#moving("frame_scale", before?.camera, camera, size, milliseconds, threads, before?.scale ?? 1);
  }

  /**
   * Chooses the mode of a picture, and sets the size for the other methods.
   *
   * @param {Camera | undefined} before of the last picture, if it can be reprojected @param {Camera} camera
   *   @param {Size} size
   * @param {number} milliseconds @param {number} threads @returns {Mode}
   */
  plan(before, camera, size, milliseconds, threads) {
    return MODES[this.#moving("plan_frame", before, camera, size, milliseconds, threads)];
  }

  /**
   * @param {string} name @param {Camera | undefined} before @param {Camera} camera @param {Size} size
   * @param {number} milliseconds @param {number} threads @param {number[]} more
   */
  #moving(name, before, camera, { height, width }, milliseconds, threads, ...more) {
    const last = before ? cameraValues(before) : 0;
    return this.#core.call(name, this.#handle, last, cameraValues(camera), height, width, milliseconds / 1000, threads, ...more);
  }

  /**
   * The network that completes a picture when the time is over.
   *
   * @param {Mode} mode @param {number} known share @param {number} milliseconds @param {number} threads
   */
  completion(mode, known, milliseconds, threads) {
    return MODELS[this.#core.call("frame_completion", this.#handle, MODES.indexOf(mode), known, milliseconds / 1000, threads)];
  }

  /**
   * Milliseconds for tracing in a frame of `milliseconds`.
   *
   * @param {Mode} mode @param {Model} model that completes it @param {number} milliseconds
   */
  forTracing(mode, model, milliseconds) {
    return 1000 * this.#core.call("frame_tracing", this.#handle, MODES.indexOf(mode), MODELS.indexOf(model), milliseconds / 1000);
  }

  /** Number of pixels that one thread traces in `milliseconds`. @param {Mode} mode @param {number} milliseconds */
  pixelsIn(mode, milliseconds) {
    return this.#core.call("frame_pixels", this.#handle, MODES.indexOf(mode), milliseconds / 1000);
  }

  free() {
    this.#core.call("free_planner", this.#handle);
  }
}
