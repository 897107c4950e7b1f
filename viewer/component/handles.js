// @ts-check
/** Handles of section planes in the picture: the mouse, a finger or keys move them along their normals. Fetched with the first section. */
import { axesOf, projection } from "../picture/projection.js";
import { AXES, shortened } from "../tracing/section.js";
import { addStyle, made, madeSvg } from "./made.js";

/**
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../tracing/section.js").Section} Section
 * @typedef {import("../tracing/scene.js").About} About
 * @typedef {{section: Section, root: HTMLElement, knob: HTMLElement, outline: SVGElement}} Handle
 */

const STEPS = 100; // along the scene's box, by arrows
const PAGE = 10; // steps
const LEAST = 0.25; // of a length across the line of sight: planes that face the viewer move as if at an angle
const NEAR = 1e-3; // radii, for directions in the picture
const MARGIN = 26; // CSS pixels between a handle and the picture's border
const UPWARDS = 0.1; // depths across the picture: of corners equally near, handles are at the upper one
const CURSORS = ["ew", "nwse", "ns", "nesw"]; // by eighths of a turn

const STYLE = `
#planes { position: absolute; z-index: 2; pointer-events: none; }

#planes svg { position: absolute; top: 0; left: 0; width: 100%; height: 100%; z-index: -1; opacity: 0; fill: none; stroke: #fff; stroke-width: 1.5; }

#planes polygon:first-child { stroke: #000; stroke-width: 3.5; }

#planes [role=slider] {
  position: absolute; top: -15px; left: -15px; box-sizing: border-box; width: 30px; height: 30px; border: 1px solid #767676; border-radius: 50%;
  background: #fff; color: #1b1b1a; font: 600 13px/28px system-ui, sans-serif; text-align: center; user-select: none;
  filter: drop-shadow(0 0 1px #000); touch-action: none; pointer-events: auto;
}

#planes [role=slider]::before, #planes [role=slider]::after {
  position: absolute; top: 8px; left: 10px; width: 8px; height: 12px; background: #fff; clip-path: polygon(0 0, 100% 50%, 0 100%); content: "";
  transform: rotate(var(--angle)) translate(var(--out, 25px));
}

#planes [role=slider]::after { transform: rotate(calc(var(--angle) + 180deg)) translate(var(--out, 25px)); }

#planes [role=slider]:is(:hover, :active) { background: #d5e8dc; }

#planes [role=slider]:focus-visible { outline: 2px solid #000; outline-offset: 3px; box-shadow: 0 0 0 3px #fff; }

#planes [role=slider]:is(:hover, :active, :focus-visible) + svg { opacity: 1; }

@media (pointer: coarse) {
  #planes [role=slider] { top: -22px; left: -22px; width: 44px; height: 44px; line-height: 42px; }

  #planes [role=slider]::before, #planes [role=slider]::after { top: 15px; left: 17px; --out: 32px; }
}

@media (forced-colors: active) {
  #planes [role=slider] { border-color: ButtonText; background: ButtonFace; color: ButtonText; }

  #planes [role=slider]::before, #planes [role=slider]::after { background: ButtonText; forced-color-adjust: none; }

  #planes [role=slider]:focus-visible { outline-color: Highlight; }
}
`;

export class Handles {
  #layer = made("div", { id: "planes" });
  /** @type {Handle[]} */
  #handles = [];
  #about;
  #move;
  #box;
  #canvas;
  /** Box and unit of the scene, once known. @type {About | undefined} */
  #known;
  /** @type {Camera} of the picture */
  #camera;

  /**
   * @param {ShadowRoot} root
   * @param {HTMLElement} canvas of the picture, which gets the wheel
   * @param {Camera} camera
   * @param {() => Promise<About | null>} about facts about the scene
   * @param {(index: number, at: number) => void} move called for a section that the user moves
   * @param {() => {left: number, top: number, width: number, height: number}} box of the picture, in CSS pixels
   */
  constructor(root, canvas, camera, about, move, box) {
    this.#canvas = canvas, this.#camera = camera, this.#about = about, this.#move = move, this.#box = box;
    addStyle(root, STYLE);
    root.append(this.#layer);
  }

  /** Shows handles of these sections. @param {readonly Section[]} sections */
  set(sections) {
    while (this.#handles.length > sections.length) this.#handles.pop()?.root.remove();
    sections.forEach((section, i) => {
      const handle = this.#handles[i] ??= this.#made(i, section), { knob } = handle, name = AXES[section.axis].toUpperCase();
      handle.section = section;
      if (knob.textContent !== name) knob.textContent = name, knob.ariaLabel = `Section plane ${name}`;
    });
    this.#place();
  }

  /** Places them on a picture. @param {Camera} camera */
  show(camera) {
    this.#camera = camera;
    this.#place();
  }

  /** Asks for the scene's box: it may be new. */
  async ask() {
    this.#known = await this.#about() ?? undefined;
    this.#place();
  }

  /** @param {number} i @param {Section} section @returns {Handle} */
  #made(i, section) {
    const knob = made("div", { role: "slider", tabIndex: 0 }), outline = madeSvg("svg", madeSvg("polygon"), madeSvg("polygon"));
    const root = made("div", { hidden: true }, knob, outline), handle = { section, root, knob, outline };
    outline.ariaHidden = "true";
    /** The drag: the finger, its last place, and the plane's place, which sections round. */
    let drag = { finger: NaN, x: 0, y: 0, at: 0 };
    knob.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || drag.finger === drag.finger) return;
      event.preventDefault(); // no selection
      knob.focus({ preventScroll: true });
      knob.setPointerCapture(event.pointerId);
      drag = { finger: event.pointerId, x: event.clientX, y: event.clientY, at: handle.section.at };
    });
    knob.addEventListener("pointermove", (event) => {
      if (event.pointerId !== drag.finger || !this.#known) return;
      const { x, y, pixels } = this.#direction(handle, this.#known), [low, high] = this.#range(handle, this.#known);
      const from = Math.max(low, Math.min(high, drag.at));
      const at = from + ((event.clientX - drag.x) * x + (event.clientY - drag.y) * y) / pixels;
      drag = { finger: event.pointerId, x: event.clientX, y: event.clientY, at };
      this.#moveTo(i, at);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) knob.addEventListener(end, () => (drag.finger = NaN));
    knob.addEventListener("keydown", (event) => this.#press(i, event));
    knob.addEventListener("wheel", (event) => {
      if (!this.#canvas.dispatchEvent(new WheelEvent(event.type, event))) event.preventDefault();
    }, { passive: false });
    this.#layer.append(root);
    return handle;
  }

  /** @param {number} i @param {KeyboardEvent} event */
  #press(i, event) {
    if (event.ctrlKey || event.metaKey || event.altKey || !this.#known) return;
    const { at } = this.#handles[i].section, [low, high] = this.#range(this.#handles[i], this.#known), step = (high - low) / STEPS;
    /** @type {Record<string, number>} */
    const places = {
      ArrowLeft: at - step, ArrowDown: at - step, ArrowRight: at + step, ArrowUp: at + step, PageDown: at - PAGE * step, PageUp: at + PAGE * step,
      Home: low, End: high,
    };
    if (!Object.hasOwn(places, event.key)) return;
    event.preventDefault();
    this.#moveTo(i, places[event.key]);
  }

  /** @param {number} i @param {number} at */
  #moveTo(i, at) {
    const [low, high] = this.#range(this.#handles[i], /** @type {About} */ (this.#known));
    this.#move(i, shortened(Math.max(low, Math.min(high, at)), high - low));
  }

  /** The scene's box along a section's axis. @param {Handle} handle @param {About} about */
  #range({ section: { axis } }, { box }) {
    return [box[axis], box[axis + 3]];
  }

  /** Corners of the plane within the scene's box, in radii from the centre. @param {Handle} handle @param {About} about */
  #corners({ section: { axis, at } }, { box, sphere: { center, radius } }) {
    return [[0, 0], [3, 0], [3, 3], [0, 3]].map(([b, c]) => {
      const corner = [0, 0, 0], [second, third] = [(axis + 1) % 3, (axis + 2) % 3];
      corner[axis] = at, corner[second] = box[second + b], corner[third] = box[third + c];
      return corner.map((value, k) => (value - center[k]) / radius);
    });
  }

  /** The corner with the handle: the nearest one. @param {Handle} handle @param {About} about */
  #corner(handle, about) {
    const size = this.#box(), { seen } = projection(this.#camera, size);
    const height = (/** @type {number[]} */ corner) => seen(corner).depth - UPWARDS * seen(corner).y / size.height;
    return this.#corners(handle, about).reduce((best, corner) => (height(corner) > height(best) ? corner : best));
  }

  /** The way of the plane in the picture: a unit vector, and pixels for a unit of the scene. @param {Handle} handle @param {About} about */
  #direction(handle, about) {
    const { axis } = handle.section, { seen } = projection(this.#camera, this.#box()), from = this.#corner(handle, about), start = seen(from);
    const way = (/** @type {number[]} */ of) => {
      const end = seen(from.map((value, k) => value + NEAR * of[k]));
      return [end.x - start.x, end.y - start.y];
    };
    const [x, y] = way([0, 1, 2].map((k) => Number(k === axis))), length = Math.hypot(x, y), full = Math.hypot(...way(axesOf(this.#camera)[0]));
    const isSeen = length > 1e-3 * full;
    return { x: isSeen ? x / length : 0, y: isSeen ? y / length : -1, pixels: Math.max(length, LEAST * full) / (NEAR * about.sphere.radius) };
  }

  #place() {
    const about = this.#known, { left, top, width, height } = this.#box(), { seen } = projection(this.#camera, { width, height });
    Object.assign(this.#layer.style, { left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px` });
    for (const handle of this.#handles) {
      const { section: { axis, sign, at }, root, knob, outline } = handle, places = about ? this.#corners(handle, about).map(seen) : [];
      root.hidden = !about || places.some(({ x }) => x !== x);
      if (!about || root.hidden) continue;
      const { x, y } = seen(this.#corner(handle, about)), way = this.#direction(handle, about), [low, high] = this.#range(handle, about);
      const within = (/** @type {number} */ place, /** @type {number} */ size) => Math.max(Math.min(MARGIN, size / 2), Math.min(Math.max(size - MARGIN, size / 2), place));
      knob.style.transform = `translate(${within(x, width)}px, ${within(y, height)}px)`;
      const angle = Math.atan2(way.y, way.x);
      knob.style.setProperty("--angle", `${angle}rad`);
      knob.style.cursor = `${CURSORS[Math.round(angle / (Math.PI / 4) + 8) % 4]}-resize`;
      for (const polygon of outline.children) polygon.setAttribute("points", places.map((place) => `${place.x},${place.y}`).join(" "));
      Object.assign(knob, { ariaValueMin: low, ariaValueMax: high, ariaValueNow: at });
      knob.ariaValueText = `${AXES[axis]} ${sign > 0 ? "up to" : "from"} ${at}${about.unit ? ` ${about.unit}` : ""}`;
    }
  }
}
