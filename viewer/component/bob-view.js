// @ts-check
/**
 * <bob-view src="part.glb" camera-controls></bob-view>: an element that displays a scene. While it turns, each picture
 * traces a few percent of its pixels; at rest, all are traced.
 *
 * Names are those of <model-viewer> where it has them. The npm package lists them from these tables (page/manifest.py).
 *
 * | attribute | |
 * |---|---|
 * | `src` | a scene's address; its suffix determines the format |
 * | `alt` | text alternative |
 * | `poster` | the address of a picture until the first one is traced |
 * | `camera-orbit` | "120deg 70deg 100%": angle about the vertical, angle from straight above, distance |
 * | `field-of-view` | "35deg"; if omitted, the camera is orthographic |
 * | `camera-controls` | the mouse, touch and keys move the camera |
 * | `auto-rotate` | it turns while idle, unless the user prefers reduced motion |
 * | `interaction-prompt` | "none" hides the hint that it can be turned |
 * | `background` | any CSS background, or "transparent"; black by default |
 * | `picture-size` | "640x480" fixes the size in pixels; by default the screen's pixels |
 * | `workers` | number of tracing threads; by default the number of processors |
 * | `base` | the folder with the package's files, for all elements of the page; by default they are next to this module |
 *
 * | event | |
 * |---|---|
 * | `load` | at the first picture of a scene |
 * | `progress` | with each picture; `detail.totalProgress` is the fraction of traced pixels, 1 for an exact picture |
 * | `error` | `detail.message` is displayed unless the default is prevented |
 * | `camera-change` | after each change of the camera |
 *
 * @typedef {import("../picture/camera.js").Camera} Camera
 */
import { addressOf, fileName } from "../core/addresses.js";
import { isSingleFile, useFolder, usedFolder } from "../core/parts.js";
import { VERSION } from "../core/version.js";
import { FIELDS, HOME, valid } from "../picture/camera.js";
import { define } from "./define.js";
import { orbit } from "./orbit.js";
import { style } from "./style.js";
import { Viewing, coreFor } from "./viewing.js";
import { fromCameraOrbit, fromFieldOfView, toCameraOrbit } from "./words.js";

const MOST_WORKERS = 8; // each has a copy of the whole scene
const MOST_PIXELS = 2 ** 21;
const IDLE_MS = 3000; // without input, before it turns by itself and hints that it can be turned
const TURN = 360 / 64; // degrees per second, when it turns by itself

const KEYS = "Drag or arrows: orbit. Shift: pan. Wheel, + and -: zoom. [ and ]: roll. P: perspective. Home: reset.";

/** @template {keyof HTMLElementTagNameMap} T @param {T} name @param {Partial<HTMLElementTagNameMap[T]>} [fields] */
const made = (name, fields = {}) => Object.assign(document.createElement(name), fields);

/** Servers that import this module to render pages have no elements. */
const Parent = /** @type {typeof HTMLElement} */ (globalThis.HTMLElement ?? Object);

class Element extends Parent {
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

  static observedAttributes = [
    "src", "alt", "poster", "camera-orbit", "field-of-view", "camera-controls", "auto-rotate", "interaction-prompt", "background",
    "picture-size", "base",
  ];

  #canvas = made("canvas", { width: 1, height: 1 });
  #poster = made("img", { hidden: true, alt: "" });
  #prompt = made("p", { id: "prompt", className: "unseen", textContent: "Drag to turn" });
  #wrong = made("p", { id: "wrong", hidden: true });
  #context = /** @type {ImageBitmapRenderingContext} */ (this.#canvas.getContext("bitmaprenderer"));
  /** @type {Viewing | undefined} */
  #viewing;
  /** While the element is disconnected. @type {Camera} */
  #camera = HOME;
  #resizing = new ResizeObserver(() => this.#fit());
  /** Removes the input handlers. @type {AbortController | undefined} */
  #hands;
  #touchedAt = 0;
  #wasTouched = false;
  #promptTimer = 0;
  #turning = 0;
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
    root.append(this.#canvas, this.#poster, this.#prompt, this.#wrong, made("p", { id: "keys", hidden: true, textContent: KEYS }));
  }

  connectedCallback() {
    const address = this.src === null ? null : this.#address;
    this.#start(coreFor(address ? fileName(address) : ""));
    this.#describe();
    this.#resizing.observe(this);
    if (this.src !== null) this.#open();
    this.#turn();
  }

  /** @param {import("./viewing.js").CoreName} core */
  #start(core) {
    const asked = Number(this.getAttribute("workers")) || navigator.hardwareConcurrency || 1;
    this.#viewing?.end();
    this.#viewing = new Viewing({ workers: Math.max(1, Math.min(asked, MOST_WORKERS)), scales: !this.#fixedSize, core }, {
      picture: (picture, repainted) => this.#show(picture, repainted),
      failed: (message) => this.#fail(message),
    });
    this.#viewing.change({ camera: this.#camera });
    this.show(this.#showing);
    this.#fit();
  }

  disconnectedCallback() {
    this.#camera = this.camera;
    this.#resizing.disconnect();
    this.#viewing?.end();
    this.#viewing = undefined;
    clearTimeout(this.#promptTimer);
    cancelAnimationFrame(this.#turning);
  }

  /** @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (before === value) return;
    if (name === "src") {
      if (this.#viewing && value !== null) this.#open(); // else when it is connected
    } else if (name === "camera-orbit") {
      const camera = fromCameraOrbit(value);
      if (camera) this.#look(camera, "none");
      else if (value !== null) this.#fail(`camera-orbit: expected angles and a share, such as ${toCameraOrbit(HOME)}, got ${value}`);
    } else if (name === "field-of-view") {
      const fov = value === null ? 0 : fromFieldOfView(value);
      if (fov !== null) this.#look({ fov }, "none");
      else this.#fail(`field-of-view: expected an angle, such as 35deg, got ${value}`);
    } else if (name === "poster") {
      this.#poster.src = value ?? "";
      this.#poster.hidden = value === null || this.#canvas.width > 1;
    } else if (name === "background") {
      this.style.background = value ?? "";
      this.show({ isTransparent: value !== null });
    } else if (name === "picture-size") {
      this.#fit();
    } else if (name === "base") {
      Element.base = value;
    } else if (name === "auto-rotate") {
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
    this.#look(camera, "none");
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
    return this.#read(name, source);
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

  /** The current picture. @param {{mimeType?: string, qualityArgument?: number}} [options] @returns {Promise<Blob>} */
  toBlob({ mimeType = "image/png", qualityArgument } = {}) {
    return new Promise((resolve, reject) => this.#canvas.toBlob(
      (blob) => (blob ? resolve(blob) : reject(new Error("toBlob: expected a picture, got none"))), mimeType, qualityArgument));
  }

  /** The current picture. @param {string} [type] @param {number} [quality] */
  toDataURL(type, quality) {
    return this.#canvas.toDataURL(type, quality);
  }

  /** Resolves once the picture is exact. @returns {Promise<void>} */
  converged() {
    return new Promise((resolve) => {
      const check = () => {
        if (!this.#viewing?.statistics.exact) return;
        this.removeEventListener("progress", check);
        resolve();
      };
      this.addEventListener("progress", check);
      check();
    });
  }

  // ---- Scenes --------------------------------------------------------------------------------------------

  get #address() {
    return addressOf(this.src ?? "", document.baseURI);
  }

  #open() {
    const address = this.#address;
    if (address) return this.#read(fileName(address), address.href);
    // Deferred, so that the page can add listeners first.
    queueMicrotask(() => this.#fail(`src: expected an address, got ${this.src?.slice(0, 100)}`));
  }

  /** @param {string} name @param {Blob | string} source */
  async #read(name, source) {
    this.ariaBusy = "true";
    if (this.viewing.core === "core.mesh" && coreFor(name) === "core") this.#start("core");
    const { viewing } = this;
    try {
      if (await viewing.read(name, source)) this.begun();
    } catch (error) {
      this.#fail(error instanceof Error ? error.message : String(error));
    } finally {
      if (!viewing.isOpening) this.ariaBusy = null;
    }
  }

  /** Called for each new scene. */
  begun() {
    this.#isNew = true;
    this.#wrong.hidden = true;
  }

  /** @param {string} message */
  #fail(message) {
    const event = new CustomEvent("error", { detail: { type: "loadfailure", message }, cancelable: true });
    if (!this.dispatchEvent(event)) return;
    this.#wrong.textContent = message;
    this.#wrong.hidden = false;
  }

  // ---- Pictures ------------------------------------------------------------------------------------------

  /** @param {import("../workers/completing.js").Picture} picture @param {boolean} repainted */
  #show({ bitmap, batch, traced }, repainted) {
    const canvas = this.#canvas, { width, height } = bitmap;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    this.#context.transferFromImageBitmap(bitmap);
    this.#poster.hidden = true;
    if (repainted) return;
    this.dispatchEvent(new CustomEvent("progress", { detail: { totalProgress: traced / (batch.width * batch.height), batch } }));
    if (!this.#isNew) return;
    this.#isNew = false;
    this.dispatchEvent(new CustomEvent("load", { detail: { url: this.src } }));
    this.#touchedAt = performance.now();
    this.#promptTimer = setTimeout(() => this.#prompt.classList.toggle("unseen", !this.#isPrompting), IDLE_MS);
  }

  get #isPrompting() {
    return this.hasAttribute("camera-controls") && this.getAttribute("interaction-prompt") !== "none" && !this.#wasTouched;
  }

  get #fixedSize() {
    const match = /^(\d+)x(\d+)$/.exec(this.getAttribute("picture-size") ?? "");
    return match && { width: Number(match[1]), height: Number(match[2]) };
  }

  /** The size of the picture at rest: device pixels. */
  #fit() {
    const { clientWidth, clientHeight } = this, fixed = this.#fixedSize;
    const { width, height } = fixed ?? { width: clientWidth * devicePixelRatio, height: clientHeight * devicePixelRatio };
    if (!this.#viewing || width < 1 || height < 1) return;
    const scale = fixed ? 1 : Math.min(1, Math.sqrt(MOST_PIXELS / (width * height)));
    const shrink = Math.min(clientWidth / width, clientHeight / height);
    this.#canvas.style.width = `${width * shrink}px`, this.#canvas.style.height = `${height * shrink}px`;
    this.#viewing.change({ size: { height: Math.max(1, Math.round(height * scale)), width: Math.max(1, Math.round(width * scale)) } });
  }

  // ---- Hands ---------------------------------------------------------------------------------------------

  /** Sets the accessible description, and enables or disables the input handlers. */
  #describe() {
    const canvas = this.#canvas, isTurned = this.hasAttribute("camera-controls");
    canvas.ariaLabel = this.alt || "Picture";
    canvas.role = isTurned ? "application" : "img";
    canvas.ariaRoleDescription = isTurned ? "3D view" : null;
    if (!this.#isPrompting) this.#prompt.classList.add("unseen");
    if (isTurned === (this.#hands !== undefined)) return;
    this.#hands?.abort();
    this.#hands = isTurned ? new AbortController() : undefined;
    if (isTurned) canvas.tabIndex = 0;
    else canvas.removeAttribute("tabindex");
    if (this.#hands) orbit(canvas, () => this.camera, (camera) => this.#look(camera, "user-interaction"), this.#hands.signal);
  }

  /** @param {Partial<Camera>} camera @param {"user-interaction" | "none"} source */
  #look(camera, source) {
    const before = this.camera, after = valid({ ...before, ...camera });
    if (source === "user-interaction") {
      this.#touchedAt = performance.now();
      this.#wasTouched = true;
      this.#prompt.classList.add("unseen");
    }
    if (FIELDS.every((name) => after[name] === before[name])) return;
    this.#camera = after;
    this.#viewing?.change({ camera: after });
    this.dispatchEvent(new CustomEvent("camera-change", { detail: { source } }));
  }

  /** Turns by itself while `auto-rotate` applies. */
  #turn() {
    cancelAnimationFrame(this.#turning);
    if (!this.isConnected || !this.hasAttribute("auto-rotate") || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    let last = performance.now();
    const step = (/** @type {number} */ now) => {
      this.#turning = requestAnimationFrame(step);
      const since = now - last;
      last = now;
      if (this.#viewing?.statistics.pictures && now > this.#touchedAt + IDLE_MS && this.checkVisibility()) {
        this.#look({ azimuth: this.camera.azimuth - TURN * since / 1000 }, "none");
      }
    };
    this.#turning = requestAnimationFrame(step);
  }
}

/** @typedef {Element} BobView */
export const BobView = define("bob-view", Element);
