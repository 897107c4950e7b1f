// @ts-check
/** Movements of the camera: by pixels of a drag, about a point; smoothly to another camera; and on by inertia. */
import { valid } from "../picture/camera.js";
import { panned, projection, zoomed } from "../picture/projection.js";

/** @typedef {import("../picture/camera.js").Camera} Camera */

const TURN = 200; // degrees per drag across the picture's shorter side
const DECAY_MS = 120; // for inertia to slow down by e
const SLOWEST = 0.01; // pixels per millisecond, below which inertia ends
const WAY_MS = 300; // to another camera

/** Whether the user prefers reduced motion. */
export const isCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Motion {
  /** The point about which the camera turns, in radii from the scene's centre; null is the centre. @type {ArrayLike<number> | null} */
  pivot = null;
  #camera;
  #move;
  #size;
  #frame = 0;
  #ended = () => {};
  #arrive = () => {};

  /**
   * @param {() => Camera} camera the current camera
   * @param {(camera: Camera, source: "user-interaction" | "none") => void} move
   * @param {() => import("../picture/camera.js").Size} size of the picture, in CSS pixels
   */
  constructor(camera, move, size) {
    this.#camera = camera, this.#move = move, this.#size = size;
  }

  /** @param {Partial<Camera>} change by the user */
  change(change) {
    this.#move(valid({ ...this.#camera(), ...change }), "user-interaction");
  }

  /** @param {number} x @param {number} y in CSS pixels, right and down */
  turn(x, y) {
    const { azimuth, elevation, roll } = this.#camera(), { height, width } = this.#size();
    const angle = roll * Math.PI / 180, degrees = TURN / Math.min(height, width);
    const [right, down] = [x * Math.cos(angle) + y * Math.sin(angle), y * Math.cos(angle) - x * Math.sin(angle)];
    this.turnTo({ azimuth: azimuth - right * degrees, elevation: elevation + down * degrees });
  }

  /** Turns about the pivot. @param {Partial<Camera>} angles */
  turnTo(angles) {
    const before = this.#camera(), size = this.#size(), turned = valid({ ...before, ...angles });
    const { x, y } = this.pivot ? projection(before, size).seen(this.pivot) : { x: NaN, y: NaN };
    this.change(this.pivot && x === x ? { ...turned, ...projection(turned, size).panTo(this.pivot, x, y) } : turned);
  }

  /** @param {number} x @param {number} y in CSS pixels, right and down */
  pan(x, y) {
    this.change(panned(this.#camera(), this.#size(), x, y));
  }

  /** Zooms about a place. @param {number} factor @param {number} [x] @param {number} [y] CSS pixels from the picture's centre */
  zoom(factor, x = 0, y = 0) {
    this.change(zoomed(this.#camera(), this.#size(), factor, x, y));
  }

  stop() {
    cancelAnimationFrame(this.#frame);
    this.#arrive = () => {};
    this.#ended();
  }

  /** Ends a movement at its destination; inertia, without a destination, stops. */
  finish() {
    this.#arrive();
    this.stop();
  }

  /** Goes on with a movement, ever more slowly. @param {(x: number, y: number) => void} step @param {number} x @param {number} y pixels per millisecond */
  glide(step, x, y) {
    if (isCalm()) return;
    let last = 0;
    this.#animate((now) => {
      const slower = Math.exp((last - now) / DECAY_MS), way = DECAY_MS * (1 - slower);
      last = now;
      step(x * way, y * way);
      x *= slower, y *= slower;
      return Math.hypot(x, y) > SLOWEST;
    });
  }

  /**
   * @param {Partial<Camera>} camera missing parameters stay
   * @param {"user-interaction" | "none"} [source]
   * @returns {Promise<void>} resolved once it is there, or something else moves the camera
   */
  async goTo(camera, source = "none") {
    const from = this.#camera(), to = valid({ ...from, ...camera });
    const around = (/** @type {number} */ angle) => ((angle % 360) + 540) % 360 - 180;
    const [azimuth, roll] = [around(to.azimuth - from.azimuth), around(to.roll - from.roll)];
    this.stop();
    if (isCalm()) return this.#move(to, source);
    const moved = this.#animate((now) => {
      const part = Math.min(1, now / WAY_MS), share = part * part * (3 - 2 * part);
      const between = (/** @type {"elevation" | "panX" | "panY" | "fov"} */ name) => from[name] + share * (to[name] - from[name]);
      this.#move(part === 1 ? to : valid({
        azimuth: from.azimuth + share * azimuth, elevation: between("elevation"), roll: from.roll + share * roll,
        zoom: from.zoom * (to.zoom / from.zoom) ** share, panX: between("panX"), panY: between("panY"), fov: between("fov"),
      }), source);
      return part < 1;
    });
    this.#arrive = () => this.#move(to, source);
    await moved;
  }

  /** @param {(now: number) => boolean} step milliseconds since the start; whether it goes on @returns {Promise<void>} */
  #animate(step) {
    this.stop();
    const begin = performance.now(), next = () => {
      if (step(performance.now() - begin)) this.#frame = requestAnimationFrame(next);
      else this.stop();
    };
    this.#frame = requestAnimationFrame(next);
    return new Promise((resolve) => (this.#ended = resolve));
  }
}
