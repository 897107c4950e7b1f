// @ts-check
/**
 * Camera control by gestures and keys. One finger or the mouse orbits, two fingers or the other button pan; wheel and
 * pinch zoom about the place under them. Arrows, + and - do the same. P toggles perspective.
 */
import { HOME, PERSPECTIVE, panned, valid, zoomed } from "../picture/camera.js";

/** @typedef {import("../picture/camera.js").Camera} Camera */

const TURN = 200; // degrees per drag across the picture's shorter side
const KEY_DEGREES = 5;
const KEY_PAN = 0.1; // of half the shorter side
const KEY_ZOOM = 1.15;
const WHEEL_ZOOM = 0.0015; // logarithm of the zoom per pixel of a wheel

/** The front view, with the same field of view. @param {Camera} camera */
export const home = ({ fov }) => ({ ...HOME, fov });

/**
 * @param {HTMLElement} element of the picture
 * @param {() => Camera} camera the current camera
 * @param {(camera: Camera) => void} move
 * @param {AbortSignal} signal removes the handlers
 */
export function orbit(element, camera, move, signal) {
  /** Positions of the fingers, in CSS pixels. @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();

  /** Size of the picture, in CSS pixels. */
  const size = () => ({ height: element.clientHeight, width: element.clientWidth });
  const shorterSide = () => Math.min(element.clientHeight, element.clientWidth);

  /** @param {Partial<Camera>} change */
  const change = (change) => move(valid({ ...camera(), ...change }));

  /** @param {number} x @param {number} y in CSS pixels, right and down */
  const turn = (x, y) => {
    const { azimuth, elevation, roll } = camera(), angle = roll * Math.PI / 180, degrees = TURN / shorterSide();
    const [right, down] = [x * Math.cos(angle) + y * Math.sin(angle), y * Math.cos(angle) - x * Math.sin(angle)];
    change({ azimuth: azimuth - right * degrees, elevation: elevation + down * degrees });
  };

  /** @param {number} x @param {number} y in CSS pixels, right and down */
  const pan = (x, y) => move(panned(camera(), size(), x, y));

  /** Zooms about a place in the window. @param {number} factor @param {number} x @param {number} y */
  const zoomAt = (factor, x, y) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    move(zoomed(camera(), size(), factor, x - left - width / 2, y - top - height / 2));
  };

  /** Centre and spread of the fingers. */
  const grip = () => {
    const all = [...fingers.values()], n = all.length;
    const x = all.reduce((sum, finger) => sum + finger.x, 0) / n, y = all.reduce((sum, finger) => sum + finger.y, 0) / n;
    return { x, y, spread: Math.hypot(all[0].x - x, all[0].y - y) };
  };

  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }, { signal });
  element.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = grip();
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const now = grip();
    if (fingers.size > 1) {
      pan(now.x - before.x, now.y - before.y);
      if (before.spread > 0) zoomAt(now.spread / before.spread, now.x, now.y);
    } else if (event.buttons & 6 || event.shiftKey || event.ctrlKey) {
      pan(now.x - before.x, now.y - before.y);
    } else {
      turn(now.x - before.x, now.y - before.y);
    }
  }, { signal });
  for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) {
    element.addEventListener(end, (event) => fingers.delete(event.pointerId), { signal });
  }
  element.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
    zoomAt(Math.exp(-WHEEL_ZOOM * pixels), event.clientX, event.clientY);
  }, { passive: false, signal });

  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const before = camera(), { azimuth, elevation, roll, zoom, fov } = before, step = KEY_PAN * shorterSide() / 2;
    const panKey = (/** @type {number} */ right, /** @type {number} */ down) => panned(before, size(), right, down);
    /** @type {Record<string, Partial<Camera>>} */
    const changes = event.shiftKey ? {
      ArrowLeft: panKey(step, 0), ArrowRight: panKey(-step, 0), ArrowDown: panKey(0, -step), ArrowUp: panKey(0, step),
    } : {
      ArrowLeft: { azimuth: azimuth - KEY_DEGREES }, ArrowRight: { azimuth: azimuth + KEY_DEGREES },
      ArrowDown: { elevation: elevation - KEY_DEGREES }, ArrowUp: { elevation: elevation + KEY_DEGREES },
      "[": { roll: roll - KEY_DEGREES }, "]": { roll: roll + KEY_DEGREES }, Home: home(before), 0: home(before),
    };
    Object.assign(changes, {
      "+": { zoom: zoom * KEY_ZOOM }, "=": { zoom: zoom * KEY_ZOOM }, "-": { zoom: zoom / KEY_ZOOM },
      p: { fov: fov ? 0 : PERSPECTIVE },
    });
    if (!(event.key in changes)) return;
    event.preventDefault();
    change(changes[event.key]);
  }, { signal });
}
