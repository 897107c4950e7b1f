// @ts-check
/**
 * Hot spots: children with slot="hotspot-…" and data-position="x y z", in the scene's coordinates. They follow the
 * picture, and hide behind things. Fetched where there are any.
 */
import { projection } from "../picture/projection.js";
import { addStyle } from "./made.js";

/**
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/camera.js").Size} Size
 * @typedef {import("../tracing/scene.js").Probe} Probe
 * @typedef {{child: HTMLElement, place: HTMLElement, isHidden: boolean}} Spot place: the element around its slot
 */

const BEHIND = 0.004; // of the bounding sphere's diameter: nearer surfaces are the spot's own

const STYLE = `
#spots { position: absolute; z-index: 1; pointer-events: none; }

#spots > div { position: absolute; display: grid; top: 0; left: 0; pointer-events: auto; transition: opacity 0.2s; }

#spots > div[inert] { opacity: var(--min-hotspot-opacity, 0); pointer-events: none; }

@media (prefers-reduced-motion: reduce) { #spots > div { transition: none; } }
`;

export class Spots {
  #layer = document.createElement("div");
  /** @type {Spot[]} */
  #spots = [];
  #probe;
  #box;
  #isProbing = false;
  /** The bounding sphere, once it is known. @type {Probe["sphere"] | undefined} */
  #sphere;
  /** The camera of the displayed picture. @type {Camera | undefined} */
  #camera;

  /**
   * @param {HTMLElement} host whose children they are
   * @param {ShadowRoot} root of the host
   * @param {(places: number[], size: Size, camera: Camera) => Promise<Probe | null>} probe
   * @param {() => {left: number, top: number, width: number, height: number}} box of the picture in the host
   */
  constructor(host, root, probe, box) {
    this.#probe = probe, this.#box = box;
    addStyle(root, STYLE);
    this.#layer.id = "spots";
    root.append(this.#layer);
    const take = () => this.#take(host);
    new MutationObserver(take).observe(host, { childList: true, subtree: true, attributeFilter: ["slot", "data-position"] });
    take();
  }

  /** @param {HTMLElement} host */
  #take(host) {
    const children = /** @type {HTMLElement[]} */ ([...host.children]).filter(({ slot }) => slot.startsWith("hotspot"));
    this.#spots = children.map((child) => {
      const known = this.#spots.find((spot) => spot.child === child);
      if (known && known.place.dataset.slot === child.slot) return known;
      const place = document.createElement("div"), slot = document.createElement("slot");
      slot.name = child.slot;
      place.dataset.slot = child.slot;
      place.inert = true;
      place.style.visibility = "hidden"; // until its place is known
      place.append(slot);
      return { child, place, isHidden: true };
    });
    this.#layer.replaceChildren(...this.#spots.map(({ place }) => place));
    if (this.#camera) this.show(this.#camera);
  }

  /** Forgets the scene, before another one is shown. */
  clear() {
    this.#sphere = this.#camera = undefined;
  }

  /** Places them on the picture of a camera. @param {Camera} camera */
  show(camera) {
    this.#camera = camera;
    const { left, top, width, height } = this.#box(), places = this.#places(camera, { width, height });
    Object.assign(this.#layer.style, { left: `${left}px`, top: `${top}px` });
    this.#spots.forEach((spot, i) => {
      const { x, y } = places[i], isOutside = !(x >= 0 && x <= width && y >= 0 && y <= height);
      spot.place.style.visibility = isOutside ? "hidden" : "";
      if (!isOutside) spot.place.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
      const isVisible = !isOutside && !spot.isHidden;
      spot.place.inert = !isVisible;
      spot.child.toggleAttribute(`data-${spot.child.dataset.visibilityAttribute ?? "visible"}`, isVisible);
    });
    this.#hide();
  }

  /** @param {Camera} camera @param {Size} size @returns {{x: number, y: number, depth: number}[]} NaN if unknown */
  #places(camera, size) {
    const { seen } = projection(camera, size), sphere = this.#sphere;
    return this.#spots.map(({ child }) => {
      const position = (child.dataset.position ?? "").trim().split(/\s+/).map(parseFloat);
      return seen(position.map((value, axis) => (sphere ? (value - sphere.center[axis]) / sphere.radius : NaN)));
    });
  }

  /** Finds out which ones are behind something. */
  async #hide() {
    const camera = this.#camera, { width, height } = this.#box(), spots = this.#spots;
    if (this.#isProbing || !camera || spots.length === 0) return;
    this.#isProbing = true;
    const places = this.#places(camera, { width, height }), isKnown = this.#sphere !== undefined;
    const probe = await this.#probe(places.flatMap(({ x, y }) => [x, y]), { width, height }, camera);
    this.#isProbing = false;
    if (!probe || !this.#camera) return;
    this.#sphere = probe.sphere;
    const wasHidden = spots.map(({ isHidden }) => isHidden);
    if (isKnown) spots.forEach((spot, i) => (spot.isHidden = probe.depths[i] > places[i].depth + BEHIND));
    // Again, if the picture or an answer is new.
    if (!isKnown || camera !== this.#camera || spots.some(({ isHidden }, i) => isHidden !== wasHidden[i])) this.show(this.#camera);
  }
}
