// @ts-check
/**
 * <bob-view src="part.glb" camera-controls></bob-view>: an element that displays a scene. While it turns, each picture
 * traces a few percent of its pixels; at rest, all are traced.
 *
 * Names are <model-viewer>'s where it has them. The npm package lists them from these tables (page/manifest.py).
 *
 * | attribute | |
 * |---|---|
 * | `src` | a scene's address; its suffix determines the format; without it, the picture is empty |
 * | `alt` | text alternative |
 * | `poster` | the address of a picture until the first one is traced |
 * | `reveal` | "manual" keeps the poster until `dismissPoster()` |
 * | `up` | "y" or "z"; by default that of the format, or y if it has none and the meshes seem to lie on their back |
 * | `orientation` | "0deg 90deg 0deg": roll, pitch and yaw of the scene |
 * | `camera-orbit` | "120deg 70deg 100%": angle about the vertical, angle from straight above, distance |
 * | `field-of-view` | "35deg"; if omitted, the camera is orthographic |
 * | `min-camera-orbit`, `max-camera-orbit`, `min-field-of-view`, `max-field-of-view` | limits of these |
 * | `camera-controls` | the mouse, touch and keys move the camera |
 * | `touch-action` | "pan-y", the default, leaves vertical swipes to the page, "pan-x" horizontal ones, "none" none |
 * | `auto-rotate` | it turns while idle, unless the user prefers reduced motion |
 * | `auto-rotate-delay`, `rotation-per-second` | milliseconds until then, 3000 by default; "5.625deg" by default |
 * | `section` | planes that cut the scene open, such as "x=0" or "x<2, z>0.5", as in bobrossnet.render |
 * | `snap` | clicks, and the mark under the mouse, snap to corners, centres and edges within this distance in CSS pixels, 10 if empty |
 * | `edges` | lines at visible edges: borders of faces, creases and silhouettes, at rest as in bobrossnet.render |
 * | `view-cube` | a cube whose sides are the views, in the upper right corner |
 * | `interaction-prompt` | "none" hides the hint that it can be turned |
 * | `background` | any CSS background, or "transparent"; black by default, under lights a bright gradient, which shows shadows |
 * | `exposure` | factor of the light, 1 by default |
 * | `light` | "scene", the default: the lights of a scene file, otherwise the headlight; "headlight"; "studio": a soft key light from the upper left, and shadows on a ground |
 * | `picture-size` | "640x480" fixes the size in pixels; by default the screen's pixels |
 * | `samples` | maximum number of rays in a pixel at an edge, at rest, as in bobrossnet.render: 4, or 1 for unsmoothed edges |
 * | `workers` | number of tracing threads; by default the number of processors |
 * | `loading` | "eager" loads at once; by default once the element is seen |
 * | `base` | the folder with the package's files, for all elements of the page; by default they are next to this module |
 *
 * | event | |
 * |---|---|
 * | `load` | at the first picture of a scene |
 * | `progress` | with each picture; `detail.totalProgress` is the fraction of traced pixels, 1 for an exact picture |
 * | `error` | `detail.message` is displayed unless the default is prevented |
 * | `camera-change` | after each change of the camera; `detail.source` is "user-interaction" or "none" |
 * | `pick` | at a click; `detail` is the surface there, or null |
 * | `section-change` | after each change of `section`; `detail` has its text and `source`, "user-interaction" or "none" |
 * | `poster-dismissed` | when the poster gives way to the picture |
 *
 * Children with slot="hotspot-…" and data-position="x y z" are hot spots (spots.js).
 *
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {"user-interaction" | "none"} Source of a movement
 */
import { addressOf, fileName } from "../core/addresses.js";
import { isSingleFile, useFolder, usedFolder } from "../core/parts.js";
import { VERSION } from "../core/version.js";
import { FIELDS, FRONT, HOME, given, valid } from "../picture/camera.js";
import { projection } from "../picture/projection.js";
import { WHOLE, changed } from "../tracing/cutaway.js";
import { planesOf, sectionsOf, textOf, toggled, validSections } from "../tracing/section.js";
import { LIGHTS, expectation } from "./attributes.js";
import { define } from "./define.js";
import { listen, listenForClicks } from "./gestures.js";
import { KEYS, listenToKeys } from "./keys.js";
import { LIMITS, limited } from "./limits.js";
import { made } from "./made.js";
import { Motion, isCalm } from "./motion.js";
import { reflect } from "./properties.js";
import { Sight } from "./sight.js";
import { style } from "./style.js";
import { Viewing } from "./viewing.js";
import { VIEWS, VIEW_NAMES } from "./views.js";
import { degrees, fromCameraOrbit, fromFieldOfView } from "./words.js";

const MOST_WORKERS = 8; // each has a copy of the whole scene
const MOST_PIXELS = 2 ** 26; // of a canvas: twice an 8K screen's
const SAMPLES = 4;
const PAPER = "linear-gradient(#fff, #dde2e8)"; // behind shadows
const REACH = 10; // CSS pixels, within which clicks snap
const LINE = 1.5; // CSS pixels, as bobrossnet.Edges
const REMOVED = "bob-view-removed"; // an event for the element itself
const REST_MS = 500; // after a movement, before it is described to screen readers
const IDLE_MS = 3000; // without input, before it turns by itself and hints that it can be turned
const TURN = 360 / 64; // degrees per second, when it turns by itself

/** Attributes with properties of the same names. */
const TEXTS = [
  "poster", "reveal", "up", "orientation", "camera-orbit", "field-of-view", ...LIMITS, "touch-action", "auto-rotate-delay",
  "rotation-per-second", "interaction-prompt", "background", "exposure", "light", "picture-size", "samples", "workers",
  "loading", "base", "section", "snap",
];
const SWITCHES = ["camera-controls", "auto-rotate", "view-cube", "edges"];

/** Servers that import this module to render pages have no elements. */
const Parent = /** @type {typeof HTMLElement} */ (globalThis.HTMLElement ?? Object);

/** Not named Element, which would hide the browser's from bundled modules. */
class BobViewElement extends Parent {
  /** The package's version: elements with embedded parts, as in notebooks, differ from those with files. */
  static version = isSingleFile ? `${VERSION}-embedded` : VERSION;
  /** The attribute `base`: an address, or null if not set. @returns {string | null} */
  static get base() {
    return usedFolder()?.href ?? null;
  }

  static set base(value) {
    const folder = value === null ? undefined : addressOf(value.replace(/\/*$/, "/"), document.baseURI);
    if (folder === null) throw new TypeError(`base: expected the address of a folder, got ${value?.slice(0, 100)}`);
    useFolder(folder);
  }

  static observedAttributes = ["src", "alt", ...TEXTS, ...SWITCHES];

  #canvas = made("canvas", { width: 1, height: 1 });
  #poster = made("img", { hidden: true, alt: "" });
  #prompt = made("p", { id: "prompt", className: "unseen", textContent: "Drag to turn" });
  #wrong = made("p", { id: "wrong", hidden: true });
  #wrongIn = ""; // the attribute that its message is about
  #where = made("p", { id: "where", role: "status" });
  #whereTimer = 0;
  #context = /** @type {ImageBitmapRenderingContext} */ (this.#canvas.getContext("bitmaprenderer"));
  /** @type {Viewing | undefined} */
  #viewing;
  /** While the element is disconnected. @type {Camera} */
  #camera = HOME;
  /** The default camera of the scene. */
  #default = HOME;
  #isTurned = false; // whether an azimuth was chosen
  #resizing = new ResizeObserver(() => this.#resize());
  /** Ends listening to the screen. @type {AbortController | undefined} */
  #watching;
  #sight = new Sight(this, () => this.#see());
  #motion = new Motion(() => this.camera, (camera, source) => this.#look(camera, source), () => this.pictureBox);
  #children = new MutationObserver(() => this.#addSpots());
  /** @type {import("./spots.js").Spots | undefined} */
  #spots;
  /** @type {ReturnType<typeof import("./cube.js").createCube> | undefined} */
  #cube;
  /** @type {import("./marker.js").Marker | undefined} */
  #marker;
  /** Where the mouse is, if clicks snap there. @type {{x: number, y: number} | undefined} */
  #hovered;
  #cutaway = WHOLE;
  /** @type {import("./handles.js").Handles | undefined} */
  #handles;
  /** The source of a change of the sections in progress. @type {Source} */
  #cutBy = "none";
  /** @type {import("./parts.js").Parts | undefined} */
  #parts;
  /** Removes the input handlers. @type {AbortController | undefined} */
  #hands;
  #touchedAt = 0;
  #wasTouched = false;
  #promptTimer = 0;
  #turning = 0;
  #saving = 0; // pictures being saved, for which it stands still
  #refines = true; // without such pictures
  /** The open scene's name and source. @type {[string, Blob | string] | undefined} */
  #source;
  /** The source of the displayed scene. @type {[string, Blob | string] | undefined} */
  #begun;
  /** Resolves once the scene asked for last is displayed; rejected if it cannot be. @type {Promise<void>} */
  #displayed = Promise.resolve();
  #isRevealed = false; // by dismissPoster()
  #isNew = false; // whether the scene has no picture yet
  /** @type {import("../workers/completing.js").Showing} */
  #showing = { mode: "completed", divider: 0.5, isTransparent: false };

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open", delegatesFocus: true });
    root.adoptedStyleSheets = [style()];
    this.#prompt.ariaHidden = "true";
    this.#wrong.role = "alert";
    this.#canvas.setAttribute("aria-describedby", "keys");
    listenForClicks(this.#canvas, (event) => this.#click(event));
    this.#canvas.addEventListener("pointermove", (event) => this.#hover(event));
    this.#canvas.addEventListener("pointerleave", () => {
      this.#hovered = undefined;
      this.#marker?.hide();
    });
    for (const [name, of] of Object.entries({ picture: this.#canvas, poster: this.#poster, prompt: this.#prompt, error: this.#wrong })) {
      of.setAttribute("part", name);
    }
    root.append(this.#canvas, this.#poster, this.#prompt, this.#wrong, made("div", { id: "ring" }), this.#where,
                made("p", { id: "keys", hidden: true, textContent: KEYS }));
  }

  connectedCallback() {
    this.#takeOver();
    const asked = Number(this.getAttribute("workers")) || navigator.hardwareConcurrency || 1;
    this.#viewing = new Viewing({ workers: Math.max(1, Math.min(asked, MOST_WORKERS)), scales: !this.#fixedSize }, {
      opened: (summary) => this.#face(summary),
      picture: (picture, repainted) => this.#show(picture, repainted),
      failed: (message) => this.#fail(message),
    });
    this.#viewing.schedule.side = this.#side;
    this.#viewing.light(this.#light);
    this.#showBehind();
    this.#viewing.change({ camera: this.#camera, cutaway: this.#cutaway });
    this.#draw();
    this.show(this.#showing);
    this.#resize();
    this.#describe();
    this.#resizing.observe(this);
    this.#watching = new AbortController();
    this.#watchPixels(this.#watching.signal);
    this.#children.observe(this, { childList: true });
    this.#addSpots();
    this.#sight.begin();
    this.#see();
    if (this.#source) this.#read(this.#source);
    else if (this.src !== null) this.#open();
  }

  /** Takes over properties that were set before this class was known: they hide its accessors. */
  #takeOver() {
    const set = /** @type {Record<string, any>} */ (/** @type {unknown} */ (this));
    for (const name of Object.keys(this).filter((name) => name in BobViewElement.prototype)) {
      const value = set[name];
      delete set[name];
      set[name] = value;
    }
  }

  disconnectedCallback() {
    this.#camera = this.camera;
    this.#resizing.disconnect();
    this.#watching?.abort();
    this.#children.disconnect();
    this.#sight.end();
    this.#viewing?.end();
    this.#viewing = undefined;
    this.#motion.stop();
    clearTimeout(this.#promptTimer);
    clearTimeout(this.#whereTimer);
    this.dispatchEvent(new Event(REMOVED));
  }

  adoptedCallback() {
    if (this.ownerDocument === document) return;
    this.#fail("document: expected an element that stays in its document, got one moved to another; make a new one there");
  }

  /** @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (before === value) return;
    if (this.#wrongIn === name) this.#wrong.hidden = true;
    const expected = expectation(name, value), isRight = expected === null;
    if (!isRight) this.#fail(`${name}: expected ${expected}, got ${value}`, name);
    if (name === "src") {
      if (!this.#viewing) this.#source = undefined; // opened when it is connected
      else if (value !== null) this.#open();
      else this.#close();
    } else if (name === "camera-orbit") {
      const camera = fromCameraOrbit(value);
      if (camera) this.#look(camera, "none");
    } else if (name === "field-of-view") {
      const fov = value === null ? 0 : fromFieldOfView(value);
      if (fov !== null) this.#look({ fov }, "none");
    } else if (LIMITS.includes(name)) {
      this.#look({}, "none");
    } else if (name === "up" || name === "orientation") {
      if (this.#source) this.#source = [...this.#source]; // another scene: its parts may have another sequence
      if (this.#source && this.#viewing) this.#read(this.#source);
    } else if (name === "poster") {
      this.#poster.src = value ?? "";
      this.#poster.hidden = value === null || (this.#canvas.width > 1 && !this.#isCovered);
    } else if (name === "view-cube") {
      this.#addCube();
    } else if (name === "exposure") {
      if (isRight) this.show({ exposure: Number(value ?? 1) });
    } else if (name === "light") {
      this.#viewing?.light(this.#light);
      this.#showBehind();
    } else if (name === "background") {
      this.style.background = value ?? "";
      this.#showBehind();
    } else if (name === "picture-size") {
      this.#resize();
    } else if (name === "edges") {
      this.#draw();
    } else if (name === "section") {
      this.#section(value);
    } else if (name === "samples") {
      if (this.#viewing) this.#viewing.schedule.side = this.#side;
      this.#viewing?.change({});
    } else if (name === "base") {
      BobViewElement.base = value;
    } else if (name === "loading") {
      this.#see();
    } else if (name === "auto-rotate" || name === "rotation-per-second") {
      this.#turn();
    } else {
      this.#describe();
    }
  }

  /** The scene and its schedule, for pages that control more of it. Throws while the element is disconnected. */
  get viewing() {
    if (!this.#viewing) throw new Error("viewing: expected an element in a document, got one that is nowhere");
    return this.#viewing;
  }

  /** As bobrossnet.Camera, in degrees. @returns {Camera} */
  get camera() {
    return this.#viewing?.schedule.camera ?? this.#camera;
  }

  /** @param {Partial<Camera>} camera missing parameters are unchanged */
  set camera(camera) {
    const changes = given(camera);
    this.#motion.stop();
    this.#look(changes, "none");
  }

  /** The attribute `src`. @returns {string | null} */
  get src() {
    return this.getAttribute("src");
  }

  set src(value) {
    if (value === null) this.removeAttribute("src");
    else this.setAttribute("src", value);
  }

  /** The attribute `alt`. @returns {string} */
  get alt() {
    return this.getAttribute("alt") ?? "";
  }

  set alt(value) {
    this.setAttribute("alt", value);
  }

  /** The picture's box in the element, in CSS pixels. */
  get pictureBox() {
    const { offsetLeft, offsetTop, clientWidth, clientHeight } = this.#canvas;
    return { left: offsetLeft, top: offsetTop, width: clientWidth, height: clientHeight };
  }

  /**
   * Opens a scene from bytes, without an address.
   *
   * @param {string} name with the suffix of its format
   * @param {Blob} source
   * @returns {Promise<void>} resolved once its first picture has begun, or after an "error" event
   */
  open(name, source) {
    return this.#read([name, source]);
  }

  /**
   * Sets how pictures are painted.
   *
   * @param {Partial<import("../workers/completing.js").Showing>} showing missing fields are unchanged
   */
  show(showing) {
    this.#showing = { ...this.#showing, ...showing };
    this.#viewing?.paint(this.#showing);
  }

  /**
   * The exact picture, of the size at rest: waits until it is traced. `progress` events report how far that is.
   *
   * @param {{mimeType?: string, qualityArgument?: number}} [options] @returns {Promise<Blob>}
   */
  async toBlob({ mimeType = "image/png", qualityArgument } = {}) {
    const { viewing } = this;
    this.#motion.stop();
    if (this.#saving++ === 0) this.#refines = viewing.schedule.refines;
    viewing.refine(true);
    try {
      await this.converged();
    } finally {
      if (--this.#saving === 0) viewing.refine(this.#refines);
    }
    return new Promise((resolve, reject) => this.#canvas.toBlob(
      (blob) => (blob ? resolve(blob) : reject(new Error("toBlob: expected a picture, got none"))), mimeType, qualityArgument));
  }

  /** The current picture. @param {string} [type] @param {number} [quality] */
  toDataURL(type, quality) {
    return this.#canvas.toDataURL(type, quality);
  }

  /**
   * Resolves once the picture is exact, and its edges are smoothed; so not before it is seen.
   *
   * @returns {Promise<void>} rejected if the element is removed before, or its scene fails
   */
  async converged() {
    let displayed;
    do {
      displayed = this.#displayed;
      await displayed;
      await this.#exact();
    } while (displayed !== this.#displayed); // another scene was asked for meanwhile
  }

  /** Resolves once the picture of the displayed scene is final. @returns {Promise<void>} rejected as converged */
  #exact() {
    return new Promise((resolve, reject) => {
      const listening = new AbortController(), { signal } = listening;
      const check = () => {
        const isBroken = this.#viewing?.isBroken;
        if (this.#viewing && !isBroken && !this.#viewing.statistics.final) return;
        listening.abort();
        if (isBroken) reject(new Error("converged: expected a picture, got a scene that failed"));
        else if (this.#viewing) resolve();
        else reject(new Error("converged: expected an element in a document, got one that was removed"));
      };
      this.addEventListener("progress", check, { signal });
      this.addEventListener("error", check, { signal });
      this.addEventListener(REMOVED, check, { signal });
      check();
    });
  }

  /**
   * Moves the camera, smoothly unless the user prefers reduced motion.
   *
   * @param {import("./views.js").ViewName | "home" | Partial<Camera>} view
   * @returns {Promise<void>} resolved once it is there, or something else moves the camera
   */
  async goTo(view) {
    if (view === "home") return this.#home("none");
    const camera = typeof view === "string" ? VIEWS[view] : view;
    if (!camera) throw new TypeError(`goTo: expected home, ${VIEW_NAMES.join(", ")} or a camera, got ${view}`);
    return this.#motion.goTo(given(camera));
  }

  /** Removes the poster, with reveal="manual" as soon as there is a picture. */
  dismissPoster() {
    this.#isRevealed = true;
    if (this.#canvas.width > 1) this.#uncover();
  }

  /** Shows the whole scene, as large as possible, in the same direction. @returns {Promise<void>} as goTo */
  fit() {
    return this.#goToFit("none");
  }

  /**
   * The surface at a place of the window, such as an event's clientX and clientY.
   *
   * @param {number} clientX @param {number} clientY
   * @param {{snap?: boolean}} [options] snap: to corners, centres and edges, within the attribute's distance; by default if that is set
   * @returns {Promise<import("../tracing/picking.js").Picked | null>} null if there is none
   */
  async pick(clientX, clientY, { snap = this.hasAttribute("snap") } = {}) {
    const { camera, pictureBox } = this, { left, top, width, height } = this.#canvas.getBoundingClientRect();
    const place = { x: (clientX - left) * pictureBox.width / width, y: (clientY - top) * pictureBox.height / height };
    const { picked } = await import("../tracing/picking.js");
    const parts = await this.#ofParts();
    /** @type {import("../tracing/picking.js").Asked} */
    const ask = { pick: (...seen) => this.#ask("pick", ...seen), snap: (...seen) => this.#ask("snap", ...seen) };
    return picked(place, pictureBox, camera, snap ? this.#reach : 0, ask, () => parts.tree());
  }

  // ---- Parts and measures --------------------------------------------------------------------------------

  /** The tree of the scene's parts, by the names in its file. @returns {Promise<import("../tracing/parts.js").Part>} the root */
  async parts() {
    const tree = await (await this.#ofParts()).tree();
    if (!tree) throw new Error("parts: expected an open scene that is seen, got none");
    return tree.root;
  }

  /** Hides parts, with all below them. @param {...(string | number)} parts paths, names or numbers @returns {Promise<void>} */
  async hide(...parts) {
    await (await this.#ofParts()).hide(parts, true);
  }

  /** Shows parts that are hidden, with all below them. @param {...(string | number)} parts paths, names or numbers @returns {Promise<void>} */
  async unhide(...parts) {
    await (await this.#ofParts()).hide(parts, false);
  }

  /** Shows only these parts; without any, all of them. @param {...(string | number)} parts paths, names or numbers @returns {Promise<void>} */
  async isolate(...parts) {
    await (await this.#ofParts()).isolate(parts);
  }

  /** Highlights parts, and no others. @param {...(string | number)} parts paths, names or numbers @returns {Promise<void>} */
  async highlight(...parts) {
    await (await this.#ofParts()).highlight(parts);
  }

  /**
   * Measures a part or, if omitted, the whole scene: its size, area and volume.
   *
   * @param {string | number} [part] a path, name or number
   * @returns {Promise<import("./parts.js").Measures>}
   */
  async measure(part) {
    return (await this.#ofParts()).measure(part);
  }

  /** The box around the scene, and other facts about it. @returns {Promise<import("../tracing/scene.js").About | null>} null without a scene */
  about() {
    return this.#ask("about");
  }

  /** CSS pixels within which points snap. */
  get #reach() {
    const asked = Number(this.getAttribute("snap") || REACH);
    return asked > 0 && asked < Infinity ? asked : 0;
  }

  async #ofParts() {
    if (!this.#parts) {
      const { Parts } = await import("../component/parts.js");
      this.#parts ??= new Parts(this.#ask, (changes) => this.#cut(changes));
    }
    return this.#parts;
  }

  #draw() {
    const scale = this.#fixedSize ? 1 : Math.max(1, devicePixelRatio), thickness = this.hasAttribute("edges") ? LINE * scale : 0;
    if (this.#viewing && this.#viewing.schedule.thickness !== thickness) this.#viewing.draw(thickness);
  }

  /** @param {Partial<import("../tracing/cutaway.js").Cutaway>} changes @param {Source} [source] */
  #cut(changes, source = "none") {
    const before = this.#cutaway, names = /** @type {(keyof typeof before)[]} */ (Object.keys(changes));
    if (names.every((name) => String(changes[name]) === String(before[name]))) return;
    this.#cutaway = changed(before, changes);
    this.#viewing?.change({ cutaway: this.#cutaway }, source === "user-interaction");
    this.#marker?.hide();
  }

  /** @param {string | null} text */
  #section(text) {
    const source = this.#cutBy;
    try {
      this.#cut({ planes: planesOf(sectionsOf(text)) }, source);
    } catch (error) {
      return this.#fail(/** @type {Error} */ (error).message, "section");
    }
    this.#handle();
    this.dispatchEvent(new CustomEvent("section-change", { detail: { section: text, source } }));
  }

  /** The user changes the sections. @param {readonly import("../tracing/section.js").Section[]} sections */
  #cutAt(sections) {
    this.#cutBy = "user-interaction";
    this.#touched();
    if (sections.length > 0) this.setAttribute("section", textOf(sections));
    else this.removeAttribute("section");
    this.#cutBy = "none";
  }

  /** Shows the handles of section planes, if the user may move them. */
  async #handle() {
    const sections = () => (this.hasAttribute("camera-controls") ? validSections(this.getAttribute("section")) : []);
    if (!this.#handles && sections().length > 0) {
      const { Handles } = await import("../component/handles.js");
      const moved = (/** @type {number} */ i, /** @type {number} */ at) => this.#cutAt(sections().with(i, { ...sections()[i], at }));
      this.#handles ??= new Handles(/** @type {ShadowRoot} */ (this.shadowRoot), this.#canvas, this.camera, () => this.about(), moved, () => this.pictureBox);
      this.#handles.ask();
    }
    this.#handles?.set(sections());
  }

  /** Cuts the scene open along an axis, or not. @param {import("../tracing/section.js").Axis} axis */
  async #toggleSection(axis) {
    const about = await this.about();
    if (about) this.#cutAt(toggled(validSections(this.getAttribute("section")), axis, about.box));
  }

  // ---- Scenes --------------------------------------------------------------------------------------------

  get #address() {
    return addressOf(this.src ?? "", document.baseURI);
  }

  #open() {
    const address = this.#address;
    if (address) return this.#read([fileName(address), address.href]);
    const message = `src: expected an address, got ${this.src?.slice(0, 100)}`;
    this.#await(Promise.reject(new Error(message)));
    // Deferred, so that the page can add listeners first.
    queueMicrotask(() => this.#fail(message));
  }

  /** @param {Promise<void>} displayed of the scene that was asked for */
  #await(displayed) {
    this.#displayed = displayed;
    displayed.catch(() => {}); // told by an event
  }

  /** The rotation of a file's scene. @param {string} name with the suffix of its format */
  async #rotationOf(name) {
    const up = this.getAttribute("up"), orientation = this.getAttribute("orientation");
    if (up === null && orientation === null) return null;
    const { rotationOf } = await import("../component/orientation.js");
    return rotationOf(name, up, orientation);
  }

  /** @param {[string, Blob | string]} asked a name and a source @returns {Promise<void>} resolved once it is displayed, or after an event */
  async #read(asked) {
    const { viewing } = this, [name, source] = this.#source = asked;
    this.ariaBusy = "true";
    const display = async () => {
      const turn = await this.#rotationOf(name);
      // The module for turning may have come after a newer request.
      if (viewing === this.#viewing && asked === this.#source && await viewing.read(name, source, { turn, isUpKnown: this.hasAttribute("up") })) this.begun();
    };
    const displayed = display();
    this.#await(displayed);
    try {
      await displayed;
    } catch (error) {
      this.#fail(error instanceof Error ? error.message : String(error));
    } finally {
      if (!viewing.isOpening) this.ariaBusy = null;
    }
  }

  /** Shows nothing: the address was removed. */
  #close() {
    this.#source = undefined;
    this.#await(Promise.resolve());
    this.viewing.close();
    this.ariaBusy = null;
    this.begun();
    this.#spots?.show(this.camera); // nowhere
    this.#canvas.width = this.#canvas.height = 1;
    this.#context.transferFromImageBitmap(null);
    this.#poster.hidden = !this.hasAttribute("poster");
    this.#showBehind();
  }

  /** Called for each new scene. */
  begun() {
    const isMoved = this.#source !== undefined && this.#source === this.#begun;
    this.#begun = this.#source;
    this.#isNew = true;
    this.#motion.pivot = null;
    this.#spots?.clear();
    this.#handles?.ask();
    this.#marker?.clear();
    if (!isMoved) {
      this.#parts?.clear();
      this.#cut({ hidden: [], highlighted: [] });
    }
    if (this.#wrongIn === "src") this.#wrong.hidden = true;
  }

  /** @param {string} message @param {string} [attribute] that is wrong */
  #fail(message, attribute = "src") {
    const event = new CustomEvent("error", { detail: { type: "loadfailure", message }, cancelable: true });
    if (!this.dispatchEvent(event)) return;
    this.#wrong.textContent = message;
    this.#wrong.hidden = false;
    this.#wrongIn = attribute;
  }

  // ---- Pictures ------------------------------------------------------------------------------------------

  /** @param {import("../workers/completing.js").Picture} picture @param {boolean} repainted */
  #show({ bitmap, batch }, repainted) {
    const canvas = this.#canvas, { width, height } = bitmap;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    this.#context.transferFromImageBitmap(bitmap);
    if (!this.#isCovered) this.#uncover();
    if (repainted) return;
    this.#sight.look();
    if (!this.#sight.isSeen) this.#see();
    this.#spots?.show(batch.camera);
    this.#handles?.show(batch.camera);
    if (this.viewing.statistics.final) this.#handles?.ask();
    this.dispatchEvent(new CustomEvent("progress", { detail: { totalProgress: this.viewing.statistics.progress, batch } }));
    if (!this.#isNew) return;
    this.#isNew = false;
    this.dispatchEvent(new CustomEvent("load", { detail: { url: this.src } }));
    this.#touchedAt = performance.now();
    clearTimeout(this.#promptTimer);
    this.#promptTimer = setTimeout(() => this.#prompt.classList.toggle("unseen", !this.#isPrompting), IDLE_MS);
  }

  /** Whether the poster stays before the picture. */
  get #isCovered() {
    return this.getAttribute("reveal") === "manual" && !this.#isRevealed;
  }

  #uncover() {
    if (this.#poster.hidden) return;
    this.#poster.hidden = true;
    this.dispatchEvent(new CustomEvent("poster-dismissed"));
  }

  get #isPrompting() {
    return this.hasAttribute("camera-controls") && this.getAttribute("interaction-prompt") !== "none" && !this.#wasTouched;
  }

  get #fixedSize() {
    const match = /^(\d+)x(\d+)$/.exec(this.getAttribute("picture-size") ?? "");
    return match && { width: Number(match[1]), height: Number(match[2]) };
  }

  /** Side of the grid of rays in a pixel at an edge. */
  get #side() {
    const samples = Number(this.getAttribute("samples") ?? SAMPLES);
    return samples >= 1 ? Math.min(8, Math.floor(Math.sqrt(samples))) : Math.sqrt(SAMPLES);
  }

  /** @returns {import("./viewing.js").LightName} */
  get #light() {
    const light = this.getAttribute("light") ?? "";
    return LIGHTS.includes(light) ? /** @type {import("./viewing.js").LightName} */ (light) : "scene";
  }

  /** Shows the background around the shapes; the page's styles may replace the default ones. */
  #showBehind() {
    const isLit = this.#viewing?.isLit ?? false;
    if (isLit) this.style.setProperty("--bob-view-behind", PAPER);
    else this.style.removeProperty("--bob-view-behind");
    this.show({ isTransparent: isLit || this.hasAttribute("background") });
  }

  /** The size of the picture at rest: device pixels. */
  #resize() {
    const { clientWidth, clientHeight } = this, fixed = this.#fixedSize;
    const { width, height } = fixed ?? { width: clientWidth * devicePixelRatio, height: clientHeight * devicePixelRatio };
    if (!this.#viewing || width < 1 || height < 1) return;
    const scale = fixed ? 1 : Math.min(1, Math.sqrt(MOST_PIXELS / (width * height)));
    const shrink = Math.min(clientWidth / width, clientHeight / height);
    this.#canvas.style.width = `${width * shrink}px`, this.#canvas.style.height = `${height * shrink}px`;
    this.#viewing.change({ size: { height: Math.max(1, Math.round(height * scale)), width: Math.max(1, Math.round(width * scale)) } });
  }

  /** Follows the size of the screen's pixels, which the page's zoom and other screens change. @param {AbortSignal} signal */
  #watchPixels(signal) {
    matchMedia(`(resolution: ${devicePixelRatio}dppx)`).addEventListener("change", () => {
      this.#resize();
      this.#draw();
      this.#watchPixels(signal);
    }, { once: true, signal });
  }

  // ---- Marks on the picture -------------------------------------------------------------------------------

  /** Places the children that are hot spots, if there are any. */
  async #addSpots() {
    if (this.#spots || !this.querySelector(":scope > [slot^=hotspot]")) return;
    const { Spots } = await import("../component/spots.js"), root = /** @type {ShadowRoot} */ (this.shadowRoot);
    this.#spots ??= new Spots(this, root, (...places) => this.#ask("probe", ...places), () => this.pictureBox);
    if (this.#canvas.width > 1) this.#spots.show(this.camera);
  }

  /** Adds or removes the view cube. */
  async #addCube() {
    const { createCube } = await import("../component/cube.js"), isWanted = this.hasAttribute("view-cube");
    if (isWanted === (this.#cube !== undefined)) return;
    this.#cube?.remove();
    const choose = (/** @type {import("./views.js").ViewName} */ name) => {
      this.#motion.pivot = null;
      this.#motion.goTo(VIEWS[name], "user-interaction");
    };
    this.#cube = isWanted ? createCube(/** @type {ShadowRoot} */ (this.shadowRoot), choose) : undefined;
    this.#cube?.show(this.camera);
  }

  // ---- Hands ---------------------------------------------------------------------------------------------

  /** Sets the accessible description, and enables or disables the input handlers. */
  #describe() {
    const canvas = this.#canvas, isTurned = this.hasAttribute("camera-controls");
    canvas.ariaLabel = this.alt || "Picture";
    canvas.role = isTurned ? "application" : "img";
    canvas.ariaRoleDescription = isTurned ? "3D view" : null;
    if (!this.#isPrompting) this.#prompt.classList.add("unseen");
    this.#handle();
    if (isTurned === (this.#hands !== undefined)) return;
    this.#hands?.abort();
    this.#hands = isTurned ? new AbortController() : undefined;
    if (isTurned) canvas.tabIndex = 0;
    else canvas.removeAttribute("tabindex");
    if (!this.#hands) return;
    const { signal } = this.#hands;
    listen(canvas, this.#motion, (x, y) => this.#focus(x, y), signal);
    listenToKeys(canvas, this.#motion, () => this.camera, {
      fit: () => this.#goToFit("user-interaction"), home: () => this.#home("user-interaction"), pick: () => this.#pickCentre(),
      section: (axis) => this.#toggleSection(axis), edges: () => this.toggleAttribute("edges"),
    }, signal);
  }

  /** As Viewing.ask. @type {Viewing["ask"]} */
  #ask = async (question, ...values) => this.#viewing?.ask(question, ...values) ?? null;

  /** @param {Source} source */
  async #goToFit(source) {
    const { fitted } = await import("../tracing/fitting.js");
    const camera = await fitted(this.camera, this.pictureBox, (...places) => this.#ask("probe", ...places));
    this.#motion.pivot = null;
    await this.#motion.goTo(camera, source);
  }

  /** @param {Source} source */
  async #home(source) {
    this.#motion.pivot = null;
    await this.#motion.goTo({ ...this.#default, fov: this.camera.fov }, source);
    this.#isTurned = false;
  }

  /** Shows a new scene from its front, if it has one, unless a camera was chosen. @param {import("../workers/reader.js").Summary} scene */
  #face({ hasFront }) {
    this.#showBehind();
    this.#default = hasFront ? FRONT : HOME;
    if (!this.#isTurned) this.#move({ azimuth: this.#default.azimuth }, "none");
  }

  /** Brings the surface at a place of the window to the centre, and turns about it; without one, shows everything. @param {number} x @param {number} y */
  async #focus(x, y) {
    const picked = await this.pick(x, y, { snap: false }), { pictureBox } = this;
    if (!picked) return this.#goToFit("user-interaction");
    this.#motion.pivot = picked.inSphere;
    const pan = projection(this.camera, pictureBox).panTo(picked.inSphere, pictureBox.width / 2, pictureBox.height / 2);
    await this.#motion.goTo(pan, "user-interaction");
  }

  #pickCentre() {
    const { left, top, width, height } = this.#canvas.getBoundingClientRect();
    this.#click({ clientX: left + width / 2, clientY: top + height / 2 });
  }

  /** @param {{clientX: number, clientY: number}} place */
  async #click({ clientX, clientY }) {
    const detail = await this.pick(clientX, clientY);
    this.dispatchEvent(new CustomEvent("pick", { detail }));
  }

  /** Marks the point that a click snaps to. @param {PointerEvent} event */
  async #hover({ buttons, pointerType, offsetX: x, offsetY: y }) {
    const snaps = this.hasAttribute("snap") && buttons === 0 && pointerType === "mouse" && this.#viewing?.canSnap;
    this.#hovered = snaps ? { x, y } : undefined;
    if (snaps && !this.#marker) {
      const { Marker } = await import("../component/marker.js");
      this.#marker ??= new Marker(/** @type {ShadowRoot} */ (this.shadowRoot), this.#ask, () => this.camera, () => this.pictureBox, () => this.#reach);
    }
    if (this.#hovered) this.#marker?.move(this.#hovered);
    else this.#marker?.hide();
  }

  /** @param {Partial<Camera>} camera @param {Source} source */
  #look(camera, source) {
    this.#isTurned ||= camera.azimuth !== undefined;
    this.#move(camera, source);
  }

  /** @param {Partial<Camera>} camera @param {Source} source */
  #move(camera, source) {
    const before = this.camera, after = valid(limited(valid({ ...before, ...camera }), (name) => this.getAttribute(name)));
    if (source === "user-interaction") {
      this.#touched();
      clearTimeout(this.#whereTimer);
      this.#whereTimer = setTimeout(async () => {
        const { inWords } = await import("../component/saying.js");
        this.#where.textContent = inWords(this.camera);
      }, REST_MS);
    }
    if (FIELDS.every((name) => after[name] === before[name])) return;
    this.#camera = after;
    this.#viewing?.change({ camera: after }, source === "user-interaction");
    this.#cube?.show(after);
    this.#marker?.hide();
    this.dispatchEvent(new CustomEvent("camera-change", { detail: { source } }));
  }

  /** The user has moved something. */
  #touched() {
    this.#touchedAt = performance.now();
    this.#wasTouched = true;
    this.#prompt.classList.add("unseen");
  }

  get #idleMs() {
    const delay = Number(this.getAttribute("auto-rotate-delay") ?? NaN);
    return delay >= 0 ? delay : IDLE_MS;
  }

  /** Turns by itself while `auto-rotate` applies, and it is seen. */
  #turn() {
    cancelAnimationFrame(this.#turning);
    if (!this.#sight.isSeen || !this.hasAttribute("auto-rotate") || isCalm()) return;
    let last = performance.now();
    const turn = degrees(this.getAttribute("rotation-per-second") ?? "") ?? TURN;
    const step = (/** @type {number} */ now) => {
      this.#turning = requestAnimationFrame(step);
      const since = now - last;
      last = now;
      if (!this.#viewing?.statistics.pictures || this.#saving || now <= this.#touchedAt + this.#idleMs) return;
      this.#sight.look(); // which may end this
      if (this.#sight.isSeen) this.#move({ azimuth: this.camera.azimuth - turn * since / 1000 }, "none");
    };
    this.#turning = requestAnimationFrame(step);
  }

  /** Works while it is seen, and turns. With `loading="eager"`, the first resting picture does not wait until it is seen. */
  #see() {
    const isEager = this.getAttribute("loading") === "eager" && this.#viewing?.statistics.final === false;
    this.#viewing?.see(this.#sight.isSeen || isEager);
    this.#turn();
  }
}

reflect(BobViewElement, TEXTS, SWITCHES);

/** @typedef {BobViewElement} BobView */
export const BobView = define("bob-view", BobViewElement);
