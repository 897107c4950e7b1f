// @ts-check
/**
 * Pictures with lights, for the tracer. The leading one finds the first hits, distributes light paths, and completes the
 * picture along its surfaces; where light goes is decided in the core.
 *
 * @typedef {import("./tracer.js").Batch} Batch
 * @typedef {import("../tracing/light.js").Choice} Choice
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/camera.js").Size} Size
 *
 * @typedef {{camera: Camera, size: Size, lights: Choice, wanted: Int32Array, paths: number, seed: number}} Paths
 *   a slice: pixels (n, 3), as from Light.next, and paths through each
 * @typedef {{
 *   kind: "lit", batch: Batch, planes: Float32Array<ArrayBuffer>, mask: Float32Array, traced: number, isLast: boolean,
 *   covered: Uint8Array | null, milliseconds: number
 * }} Lit
 *   to the completing worker, once per batch: planes (4, height, width) of linear RGB times coverage, and coverage; mask (height,
 *   width): 1 where a pixel has, or needs no, paths of this camera; traced: number of those; isLast: whether these are all;
 *   covered: the share of each pixel that lines cover, 0..255, coarse ones in motion, exact ones with the first batch at rest; else null;
 *   milliseconds: for first hits, reprojection and completing. The array of planes is returned
 */
import { Light } from "../tracing/light.js";
import { BAND, LIT_LINES_SHARE, coarseLines } from "./lined.js";

const SLICE_MS = 30; // movement waits for the slice under way
const LEAST = 64; // minimum pixels of a slice
const AHEAD = 2; // slices for each tracer until the end of a batch

/** Whether a slice is of light paths. @param {object} slice @returns {slice is Paths} */
export const areLightPaths = (slice) => "wanted" in slice;

/** The light of a tracer's scene. */
export class SceneLight {
  /** Whether the last picture was converged. */
  isDone = false;
  /** The array of planes that was returned. @type {Float32Array<ArrayBuffer> | undefined} */
  spare;
  #scene;
  /** @type {Light | undefined} */
  #light;
  /** The view of the light's picture. */
  #view = -1;
  /** The last view with exact lines. */
  #lined = -1;

  /** @param {import("../tracing/scene.js").Scene} scene lives longer */
  constructor(scene) {
    this.#scene = scene;
  }

  /** @param {Choice} choice */
  #of(choice) {
    if (!this.#light?.is(choice)) {
      this.free();
      this.#light = new Light(this.#scene, choice);
    }
    return /** @type {Light} */ (this.#light);
  }

  /** The divisor of a moving picture's height and width. @param {Batch} batch @returns {number} */
  scale({ lights, height, width, milliseconds, thickness }) {
    const time = (thickness > 0 ? 1 - LIT_LINES_SHARE : 1) * milliseconds;
    return this.#of(/** @type {Choice} */ (lights)).scale(height * width, time);
  }

  /** Traces another tracer's slice. @param {Paths} slice @returns {Float32Array} */
  trace({ lights, wanted, paths, seed, camera, size }) {
    return this.#of(lights).trace(wanted, paths, seed, camera, size);
  }

  /** @param {import("./tracer.js").Circumstances} circumstances @returns {import("./tracer.js").Work} */
  work({ batch, lent, others, begin }) {
    const { camera, height, width, side, rests, parts, thickness } = batch, size = { height, width };
    const lights = /** @type {Choice} */ (batch.lights), light = this.#of(lights);
    if (this.#view !== batch.view) light.move(camera, size);
    if (rests) light.rest();
    this.#view = batch.view;
    this.isDone = false;
    const isLined = thickness === 0 || this.#lined === batch.view, hits = performance.now() - begin;
    const covered = isLined ? null : rests ? new Uint8Array(height * width) : coarseLines(this.#scene, batch, LIT_LINES_SHARE * batch.milliseconds);
    const started = performance.now(), time = batch.milliseconds - (started - begin), end = begin + batch.milliseconds;
    const { seed } = light, paths = rests ? 4 * side ** 2 : light.paths;
    const max = light.pixelsIn(Math.max(0, time)), wanted = light.next(rests ? Math.min(max, light.left) : max), count = wanted.length / 3;
    let dealt = 0, added = 0, tracing = started, lined = rests && !isLined ? 0 : height;
    return {
      deal() {
        if (lined < height) return { camera, size, rows: [lined, lined = Math.min(height, lined + BAND)], thickness };
        const left = count - dealt;
        if (left === 0 || (rests && performance.now() > end && dealt > 0)) return;
        const inTime = light.pixelMs > 0 ? lent * SLICE_MS / light.pixelMs : LEAST;
        const share = others > 0 ? left / (AHEAD * parts) : left, own = Math.ceil(Math.max(LEAST, Math.min(share, inTime)));
        const slice = wanted.slice(3 * dealt, 3 * (dealt += Math.min(left, own)));
        return { camera, size, lights, wanted: slice, paths, seed };
      },
      keep({ slice, values }) {
        if ("rows" in slice) {
          covered?.set(values, slice.rows[0] * width);
          tracing = performance.now(); // paths follow lines
          return;
        }
        const { wanted } = /** @type {Paths} */ (slice);
        light.add(wanted, /** @type {Float32Array} */ (values));
        added += wanted.length / 3;
      },
      left: () => light.left,
      result: () => {
        const completing = performance.now();
        if (added > 0) light.traced(added, completing - tracing);
        const planes = this.spare?.length === 4 * height * width ? this.spare : new Float32Array(4 * height * width);
        this.spare = undefined;
        light.complete(side > 1, planes);
        const { left } = light; // the picture tells which pixels wait for more
        const mask = light.mask(size), done = performance.now();
        light.completed(hits, done - completing);
        this.isDone = rests && left === 0;
        if (rests) this.#lined = batch.view;
        const milliseconds = hits + done - completing;
        /** @type {Lit} */
        const message = { kind: "lit", batch, planes, mask, traced: height * width - left, isLast: this.isDone, covered, milliseconds };
        return { message, transfer: [planes, mask, covered].flatMap((array) => (array ? [array.buffer] : [])) };
      },
    };
  }

  /** Forgets all pictures. */
  forget() {
    this.#light?.renew();
    this.#view = this.#lined = -1;
  }

  /** Frees all but the scene. */
  free() {
    this.#light?.free();
    this.#light = undefined;
    this.#view = this.#lined = -1;
  }
}
