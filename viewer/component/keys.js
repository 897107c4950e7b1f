// @ts-check
/** Keys that move the camera; numbers show the sides, as in FreeCAD. */
import { PERSPECTIVE } from "../picture/camera.js";
import { VIEWS, VIEW_NAMES } from "./views.js";

/** @typedef {import("../picture/camera.js").Camera} Camera */

const DEGREES = 5;
const PAN = 0.1; // of half the shorter side
const ZOOM = 1.15;

/** The keys in words, for screen readers. */
export const KEYS = "Arrows: turn. Shift and arrows: pan. + and -: zoom. [ and ]: roll. F: fit. "
  + `${VIEW_NAMES.map((name, i) => `${i + 1}: ${name}`).join(", ")}. P: perspective. X, Y, Z: section. E: edges. Home: reset. Enter: pick the centre. Escape: leave.`;

/**
 * @param {HTMLElement} element of the picture
 * @param {import("./motion.js").Motion} motion
 * @param {() => Camera} camera the current camera
 * @param {{fit: () => void, home: () => void, pick: () => void, section: (axis: import("../tracing/section.js").Axis) => void, edges: () => void}} actions
 *   pick: the surface in the centre; section: along an axis, or no section; edges: drawn, or not
 * @param {AbortSignal} signal removes the handlers
 */
export function listenToKeys(element, motion, camera, actions, signal) {
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const pan = PAN * Math.min(element.clientHeight, element.clientWidth) / 2;
    const turn = (/** @type {"azimuth" | "elevation" | "roll"} */ name, /** @type {number} */ by) => motion.turnTo({ [name]: camera()[name] + by });
    const goTo = (/** @type {Partial<Camera>} */ view) => motion.goTo(view, "user-interaction");
    /** @type {Record<string, () => void>} */
    const does = event.shiftKey ? {
      ArrowLeft: () => motion.pan(pan, 0), ArrowRight: () => motion.pan(-pan, 0), ArrowDown: () => motion.pan(0, -pan), ArrowUp: () => motion.pan(0, pan),
    } : {
      ArrowLeft: () => turn("azimuth", -DEGREES), ArrowRight: () => turn("azimuth", DEGREES),
      ArrowDown: () => turn("elevation", -DEGREES), ArrowUp: () => turn("elevation", DEGREES),
      "[": () => turn("roll", -DEGREES), "]": () => turn("roll", DEGREES),
      Home: actions.home, 0: actions.home, f: actions.fit, Enter: actions.pick, Escape: () => element.blur(),
      x: () => actions.section(0), y: () => actions.section(1), z: () => actions.section(2), e: actions.edges,
      ...Object.fromEntries(VIEW_NAMES.map((name, i) => [i + 1, () => goTo(VIEWS[name])])),
    };
    const zoomIn = () => motion.zoom(ZOOM), zoomOut = () => motion.zoom(1 / ZOOM);
    Object.assign(does, {
      "+": zoomIn, "=": zoomIn, "-": zoomOut, PageUp: zoomIn, PageDown: zoomOut, p: () => motion.change({ fov: camera().fov ? 0 : PERSPECTIVE }),
    });
    if (!Object.hasOwn(does, event.key)) return;
    event.preventDefault();
    motion.finish(); // a key goes on from where the last one leads
    does[event.key]();
  }, { signal });
}
