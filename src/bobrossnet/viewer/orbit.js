// @ts-check
/**
 * From a person's hands to the camera: one finger or the mouse orbits, two fingers or the other button pan, wheel and pinch zoom
 * about the place under them; arrows, + and - do the same.
 *
 * @typedef {Required<import("./core.js").Camera>} Camera
 */

/** @type {Readonly<Camera>} */
export const HOME = Object.freeze({ azimuth: 30, elevation: 20, roll: 0, zoom: 1, panX: 0, panY: 0 });

const TURN = 200; // degrees for a drag across the picture's shorter side
const KEY_DEGREES = 5;
const KEY_PAN = 0.1; // of half the shorter side
const KEY_ZOOM = 1.15;
const WHEEL_ZOOM = 0.0015; // logarithm of the zoom for each pixel of a wheel

/** @param {number} value @param {number} low @param {number} high */
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** @param {Camera} camera @returns {Camera} with angles as links have them, and within what can be traced */
export function valid({ azimuth, elevation, roll, zoom, panX, panY }) {
  return {
    azimuth: ((azimuth % 360) + 360) % 360, elevation: clamp(elevation, -90, 90), roll: ((roll % 360) + 360) % 360,
    zoom: clamp(zoom, 0.2, 1000), panX: clamp(panX, -2, 2), panY: clamp(panY, -2, 2),
  };
}

/**
 * @param {HTMLElement} element that shows the picture
 * @param {() => Camera} camera as it is
 * @param {(camera: Camera) => void} move
 */
export function orbit(element, camera, move) {
  /** Where the fingers are, in CSS pixels. @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();

  /** Radii of the scene for a CSS pixel. @param {number} zoom */
  const pixel = (zoom) => 2 / (zoom * Math.min(element.clientWidth, element.clientHeight));

  /** @param {Partial<Camera>} change */
  const change = (change) => move(valid({ ...camera(), ...change }));

  /** @param {number} x @param {number} y in CSS pixels, right and down */
  const turn = (x, y) => {
    const { azimuth, elevation, roll } = camera(), angle = roll * Math.PI / 180;
    const degrees = TURN / Math.min(element.clientWidth, element.clientHeight);
    const [right, down] = [x * Math.cos(angle) + y * Math.sin(angle), y * Math.cos(angle) - x * Math.sin(angle)];
    change({ azimuth: azimuth - right * degrees, elevation: elevation + down * degrees });
  };

  /** @param {number} x @param {number} y in CSS pixels, right and down */
  const pan = (x, y) => {
    const { zoom, panX, panY } = camera();
    change({ panX: panX - x * pixel(zoom), panY: panY + y * pixel(zoom) });
  };

  /** About a place in the window. @param {number} factor @param {number} x @param {number} y */
  const zoomAt = (factor, x, y) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    const before = camera(), { zoom } = valid({ ...before, zoom: before.zoom * factor });
    const moved = pixel(before.zoom) - pixel(zoom);
    change({
      zoom, panX: before.panX + (x - left - width / 2) * moved, panY: before.panY - (y - top - height / 2) * moved,
    });
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
  });
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
  });
  for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) {
    element.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
    zoomAt(Math.exp(-WHEEL_ZOOM * pixels), event.clientX, event.clientY);
  }, { passive: false });

  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { azimuth, elevation, roll, zoom, panX, panY } = camera(), step = KEY_PAN / zoom;
    /** @type {Record<string, Partial<Camera>>} */
    const changes = event.shiftKey ? {
      ArrowLeft: { panX: panX - step }, ArrowRight: { panX: panX + step },
      ArrowDown: { panY: panY - step }, ArrowUp: { panY: panY + step },
    } : {
      ArrowLeft: { azimuth: azimuth - KEY_DEGREES }, ArrowRight: { azimuth: azimuth + KEY_DEGREES },
      ArrowDown: { elevation: elevation - KEY_DEGREES }, ArrowUp: { elevation: elevation + KEY_DEGREES },
      "[": { roll: roll - KEY_DEGREES }, "]": { roll: roll + KEY_DEGREES }, Home: HOME, 0: HOME,
    };
    Object.assign(changes, {
      "+": { zoom: zoom * KEY_ZOOM }, "=": { zoom: zoom * KEY_ZOOM }, "-": { zoom: zoom / KEY_ZOOM },
    });
    if (!(event.key in changes)) return;
    event.preventDefault();
    change(changes[event.key]);
  });
}
