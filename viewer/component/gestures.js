// @ts-check
/**
 * Gestures of mouse and fingers. One finger or the mouse turns, two fingers or another button pan; wheel and pinch zoom
 * about the place under them. A page can be scrolled past the picture: the wheel zooms while the picture has the focus,
 * with Ctrl, which trackpads report for a pinch, and where nothing scrolls. Of touches, `touch-action` leaves the page its share.
 */

/** @typedef {import("./motion.js").Motion} Motion */

const WHEEL_ZOOM = 0.0015; // logarithm of the zoom per pixel of a wheel
const PINCH_ZOOM = 0.01; // the same for a trackpad's pinch, whose steps are small
const PINCH_MOST = 40; // pixels of this step
const LINE = 16; // pixels
const STILL = 4; // CSS pixels that a click may move
const SLOP = 16; // CSS pixels of a touch, within which browsers decide whether the page scrolls
const TRAIL_MS = 80; // of a drag, whose speed inertia continues
const PAUSE_MS = 40; // at rest before the release, after which there is no inertia

/** Whether the wheel could scroll something around an element. @param {Element} element */
function isInScroller(element) {
  if (window.top !== window) return true; // the frame's page may scroll
  const page = document.scrollingElement;
  if (page && page.scrollHeight > page.clientHeight + 1) return true;
  for (let node = /** @type {Node | null} */ (element); node; node = node instanceof ShadowRoot ? node.host : node.parentNode) {
    if (node instanceof Element && node.scrollHeight > node.clientHeight && /auto|scroll/.test(getComputedStyle(node).overflowY)) return true;
  }
  return false;
}

/**
 * @param {HTMLElement} element of the picture
 * @param {Motion} motion
 * @param {(x: number, y: number) => void} focus called for a double click, with its place in the window
 * @param {AbortSignal} signal removes the handlers
 */
export function listen(element, motion, focus, signal) {
  /** Positions of the fingers, in CSS pixels. @type {Map<number, {x: number, y: number}>} */
  const fingers = new Map();
  /** Recent centres of the fingers. @type {{x: number, y: number, time: number}[]} */
  let trail = [];
  /** Where a touch began, while the page may still scroll with it; else NaN. */
  let held = { x: NaN, y: NaN };
  /** @param {string} type @param {(event: any) => void} handle @param {AddEventListenerOptions} [options] */
  const on = (type, handle, options) => element.addEventListener(type, handle, { ...options, signal });

  /** Zooms about a place in the window. @param {number} factor @param {number} x @param {number} y */
  const zoomAt = (factor, x, y) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    motion.zoom(factor, x - left - width / 2, y - top - height / 2);
  };

  /** Centre and spread of the fingers. */
  const grip = () => {
    const all = [...fingers.values()], n = all.length;
    const x = all.reduce((sum, finger) => sum + finger.x, 0) / n, y = all.reduce((sum, finger) => sum + finger.y, 0) / n;
    return { x, y, spread: Math.hypot(all[0].x - x, all[0].y - y) };
  };

  /** The movement of a drag. @param {PointerEvent} event @returns {(x: number, y: number) => void} */
  const movement = ({ buttons, shiftKey, ctrlKey }) =>
    (fingers.size > 1 || buttons & 6 || shiftKey || ctrlKey ? (x, y) => motion.pan(x, y) : (x, y) => motion.turn(x, y));
  let glides = movement(new PointerEvent("pointermove"));

  on("pointerdown", (/** @type {PointerEvent} */ event) => {
    motion.stop();
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    trail = [];
    const isShared = event.pointerType === "touch" && getComputedStyle(element).touchAction !== "none";
    held = { x: isShared ? event.clientX : NaN, y: event.clientY };
  });
  on("pointermove", (/** @type {PointerEvent} */ event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = grip();
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const now = grip();
    trail = [...trail.filter(({ time }) => time > event.timeStamp - TRAIL_MS), { x: now.x, y: now.y, time: event.timeStamp }];
    const isHeld = fingers.size === 1 && held.x === held.x;
    if (fingers.size > 1 || Math.hypot(now.x - held.x, now.y - held.y) > SLOP) held.x = NaN; // unless it is cancelled next
    if (isHeld) return;
    glides = movement(event);
    glides(now.x - before.x, now.y - before.y);
    if (fingers.size > 1 && before.spread > 0) zoomAt(now.spread / before.spread, now.x, now.y);
  });
  on("pointerup", (/** @type {PointerEvent} */ event) => {
    const first = trail[0], last = trail[trail.length - 1], ms = last?.time - first?.time;
    const isThrown = fingers.delete(event.pointerId) && fingers.size === 0 && ms > 0 && event.timeStamp - last.time < PAUSE_MS;
    if (isThrown && Math.hypot(last.x - first.x, last.y - first.y) > STILL) motion.glide(glides, (last.x - first.x) / ms, (last.y - first.y) / ms);
    trail = [];
  });
  on("pointercancel", (/** @type {PointerEvent} */ event) => fingers.delete(event.pointerId));
  on("mousedown", (/** @type {MouseEvent} */ event) => event.button === 1 && event.preventDefault()); // it would scroll
  on("contextmenu", (event) => event.preventDefault());
  on("dblclick", (/** @type {MouseEvent} */ event) => focus(event.clientX, event.clientY));
  on("wheel", (/** @type {WheelEvent} */ event) => {
    if (!event.ctrlKey && !element.matches(":focus") && isInScroller(element)) return;
    event.preventDefault();
    motion.stop();
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1);
    zoomAt(Math.exp(-pixels * (event.ctrlKey && Math.abs(pixels) < PINCH_MOST ? PINCH_ZOOM : WHEEL_ZOOM)), event.clientX, event.clientY);
  }, { passive: false });
}

/** Calls for each click or tap that does not drag. @param {HTMLElement} element @param {(event: PointerEvent) => void} click */
export function listenForClicks(element, click) {
  let x = NaN, y = NaN;
  element.addEventListener("pointerdown", (event) => (x = event.clientX, y = event.clientY));
  element.addEventListener("click", (event) => {
    if (Math.hypot(event.clientX - x, event.clientY - y) <= STILL) click(/** @type {PointerEvent} */ (event));
  });
}
