// @ts-check
/**
 * The light of a scene under a moving camera, as core/frame/moving_light.h: the studio or the scene's own lights, and a
 * ground that shows shadows. Only modules with lights have it.
 *
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/camera.js").Size} Size
 * @typedef {{height: number, width: number, texels: Float32Array}} Environment texels: (height, width, 3) linear radiance
 * @typedef {{discs: number[], sky: number[], environment: Environment | null}} Lights
 *   discs: (n, 7), direction, height and colour of each as DiscLight in the core; sky: top, bottom, and the turn in radians
 * @typedef {{lights: "headlight" | "studio" | Lights, ground: boolean}} SceneLights as a scene file has them
 * @typedef {{isOwn: boolean, azimuth: number}} Choice isOwn: the scene's own lights; otherwise the studio; azimuth: of the
 *   camera that the studio is set up for, in degrees
 */
import { cameraValues } from "../picture/camera.js";

/** Numbers of a wanted pixel: row, column, and its paths before. */
const WANTED = 3;

/** Numbers of a traced one. */
const TRACED = 7;

/** Numbers of a disc. */
const DISC = 7;

/** @type {SceneLights} */
const STUDIO = { lights: "studio", ground: true };

export class Light {
  #scene;
  #handle;

  /** @param {import("./scene.js").Scene} scene lives longer @param {Choice} choice */
  constructor(scene, choice) {
    this.#scene = scene;
    this.choice = choice;
    const { core, handle, sphere: { radius }, lights: own } = scene;
    const { lights, ground } = own && (choice.isOwn || own.lights === "studio") ? own : STUDIO;
    if (typeof lights === "string") {
      this.#handle = core.made("make_studio", handle, choice.azimuth, Number(ground), radius);
      return;
    }
    const { discs, sky, environment } = lights, { height = 0, width = 0, texels = new Float32Array(0) } = environment ?? {};
    this.#handle = core.made("make_lights", handle, new Float32Array(discs), discs.length / DISC, new Float32Array(sky), texels, height, width,
      Number(ground), radius);
  }

  /** Whether it is of this choice. @param {Choice} choice */
  is({ isOwn, azimuth }) {
    return isOwn === this.choice.isOwn && azimuth === this.choice.azimuth;
  }

  get #core() {
    return this.#scene.core;
  }

  /** Forgets all pictures, for the scene as it is now; measurements stay. */
  renew() {
    this.#core.made("renew_light", this.#handle, this.#scene.handle);
  }

  /** The divisor of a moving picture's height and width. @param {number} pixels at 1 @param {number} milliseconds */
  scale(pixels, milliseconds) {
    return this.#core.call("light_scale", this.#handle, pixels, milliseconds);
  }

  /** Turns to a camera: finds all first hits, and reprojects earlier light. @param {Camera} camera @param {Size} size */
  move(camera, { height, width }) {
    this.#core.made("move_light", this.#handle, cameraValues(camera), height, width);
  }

  /** The camera rests: each pixel waits for paths from this camera. */
  rest() {
    this.#core.made("rest_light", this.#handle);
  }

  /** The number of pixels for a picture with this time left. @param {number} milliseconds */
  pixelsIn(milliseconds) {
    return this.#core.call("light_pixels", this.#handle, milliseconds);
  }

  /** Reports the time for pixels' paths. @param {number} pixels @param {number} milliseconds */
  traced(pixels, milliseconds) {
    this.#core.call("light_traced", this.#handle, pixels, milliseconds);
  }

  /** Reports the time for completing a picture. @param {number} hits milliseconds for its first hits @param {number} milliseconds */
  completed(hits, milliseconds) {
    this.#core.call("light_completed", this.#handle, hits, milliseconds);
  }

  /** Milliseconds for a pixel's paths; 0 before the first. */
  get pixelMs() {
    return this.#core.call("light_pixel_time", this.#handle);
  }

  /** Paths of a pixel each time it is traced in motion. */
  get paths() {
    return this.#core.call("light_paths");
  }

  /** Number of pixels that wait for paths from this camera. */
  get left() {
    return this.#core.call("light_left", this.#handle);
  }

  /** The seed of this camera's paths. */
  get seed() {
    return this.#core.call("light_seed", this.#handle);
  }

  /** @param {number} atMost @returns {Int32Array} (n, 3), for `trace` */
  next(atMost) {
    let first = 0;
    const [count] = this.#core.filled(new Int32Array(1), (written) => {
      first = this.#core.made("next_light", this.#handle, atMost, written) >>> 0;
    });
    return new Int32Array(this.#core.memory, first, WANTED * count).slice();
  }

  /**
   * Traces paths through pixels of any picture.
   *
   * @param {Int32Array} wanted (n, 3) @param {number} paths of each pixel @param {number} seed @param {Camera} camera @param {Size} size
   * @returns {Float32Array} (n, 7), for `add`
   */
  trace(wanted, paths, seed, camera, { height, width }) {
    const count = wanted.length / WANTED;
    return this.#core.filled(new Float32Array(TRACED * count), (address) => {
      this.#core.made("trace_light", this.#handle, cameraValues(camera), height, width, wanted, count, paths, seed, address);
    });
  }

  /** @param {Int32Array} wanted @param {Float32Array} traced */
  add(wanted, traced) {
    this.#core.made("add_light", this.#handle, wanted, wanted.length / WANTED, traced);
  }

  /**
   * The completed picture.
   *
   * @param {boolean} isSmooth whether edges are means over their pixels
   * @param {Float32Array<ArrayBuffer>} planes (4, height, width), filled with linear RGB times coverage, and coverage
   */
  complete(isSmooth, planes) {
    return this.#core.filled(planes, (address) => this.#core.made("complete_light", this.#handle, Number(isSmooth), address));
  }

  /** 1 where a pixel has, or needs no, paths of this camera. @param {Size} size @returns {Float32Array} (height, width) */
  mask({ height, width }) {
    return this.#core.filled(new Float32Array(height * width), (address) => this.#core.call("light_mask", this.#handle, address));
  }

  free() {
    this.#core.call("free_light", this.#handle);
  }
}
