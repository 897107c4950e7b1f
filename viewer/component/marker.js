// @ts-check
/** The mark at the corner, centre, middle or edge that a click snaps to. Fetched when the mouse first moves over a picture with `snap`. */
import { projection } from "../picture/projection.js";
import { addStyle, made, madeSvg } from "./made.js";
import { inWords } from "./snaps.js";

/**
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {{left: number, top: number, width: number, height: number}} Box
 * @typedef {import("../tracing/scene.js").Snap} Snap
 */

const LEFT = 0.6; // of the picture's width, from where on words stand to the left of the mark

const STYLE = `
#snap { position: absolute; top: 0; left: 0; z-index: 2; color: #fff; font: 13px/1.4 system-ui, sans-serif; pointer-events: none; }

#snap svg { position: absolute; top: -9px; left: -9px; width: 18px; height: 18px; overflow: visible; fill: none; stroke: #ffd400; stroke-width: 2; }

#snap path:first-child { stroke: #000; stroke-width: 5; }

#snap p { position: absolute; top: 12px; left: 12px; margin: 0; padding: 0 0.5em; border-radius: 0.7em; background: #000c; white-space: nowrap; }

#snap.left p { right: 12px; left: auto; }

@media (forced-colors: active) { #snap p { border: 1px solid CanvasText; background: Canvas; color: CanvasText; } }
`;

/** In a square of 18 pixels. @type {Record<Snap["kind"], string>} */
const SHAPES = {
  corner: "M2 2H16V16H2Z", center: "M9 2A7 7 0 1 1 8.99 2M9 5V13M5 9H13", middle: "M9 2L16 15H2Z", edge: "M3 15L15 3M3 9H3.01M15 9H15.01",
};

export class Marker {
  #ask;
  #box;
  #look;
  #reach;
  #unit = /** @type {string | null} */ (null);
  #mark = made("div", { id: "snap", hidden: true, ariaHidden: "true" });
  #words = made("p");
  #paths = [0, 1].map(() => madeSvg("path"));
  #isAsking = false;
  #isWanted = false; // hidden before an answer comes, it stays so
  /** The last place of the mouse, while it awaits its request. @type {{x: number, y: number} | undefined} */
  #next;

  /**
   * @param {ShadowRoot} root
   * @param {import("./viewing.js").Viewing["ask"]} ask
   * @param {() => Camera} look the camera @param {() => Box} box of the picture, in CSS pixels @param {() => number} reach in CSS pixels
   */
  constructor(root, ask, look, box, reach) {
    this.#ask = ask, this.#look = look, this.#box = box, this.#reach = reach;
    addStyle(root, STYLE);
    this.#mark.append(madeSvg("svg", ...this.#paths), this.#words);
    root.append(this.#mark);
  }

  hide() {
    this.#next = undefined, this.#isWanted = false;
    this.#mark.hidden = true;
  }

  /** Marks the corner, centre, middle or edge near a place, as soon as the scene has found it. @param {{x: number, y: number}} place in CSS pixels */
  async move(place) {
    this.#next = place, this.#isWanted = true;
    if (this.#isAsking) return;
    this.#isAsking = true;
    while (this.#next) {
      const asked = this.#next, camera = this.#look(), size = this.#box();
      this.#next = undefined;
      const [snapped, about] = await Promise.all([this.#ask("snap", asked, size, camera, this.#reach()), this.#unit === null ? this.#ask("about") : null]);
      if (about) this.#unit = about.unit ?? "";
      if (this.#isWanted && camera === this.#look()) this.#show(snapped, camera, size);
    }
    this.#isAsking = false;
  }

  /** Forgets the scene, before another one is shown. */
  clear() {
    this.hide();
    this.#unit = null;
  }

  /** @param {Snap | null} snapped @param {Camera} camera @param {Box} size */
  #show(snapped, camera, { left, top, width, height }) {
    this.#mark.hidden = !snapped;
    if (!snapped) return;
    const { kind, radius, point, sphere } = snapped, { x, y } = projection(camera, { width, height }).seen(point);
    for (const path of this.#paths) path.setAttribute("d", SHAPES[kind]);
    this.#words.textContent = inWords(kind, radius === null ? null : radius * sphere.radius, this.#unit || null);
    this.#mark.classList.toggle("left", x > LEFT * width);
    this.#mark.style.transform = `translate(${left + x}px, ${top + y}px)`;
  }
}
