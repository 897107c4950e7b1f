// @ts-check
/**
 * The page: its state, and its elements. Nothing here takes long; what does is done by workers.
 *
 * In the page's address, `?scene=files/NAME.bob` opens a file of the same server, `?size=640x480` fixes the picture's size in
 * pixels, and `?workers=1` the number of workers that trace.
 */
import { compileCore } from "./compile.js";
import { Editor } from "./editor.js";
import { Frames } from "./frames.js";
import { fromFragment, toFragment } from "./link.js";
import { HOME, orbit, valid } from "./orbit.js";
import { DIFFERENCE_GAIN } from "./paint.js";
import { Pool } from "./pool.js";

const MOST_WORKERS = 8; // each holds the whole scene
const MOST_PIXELS = 2 ** 21;
const SPARE_MS = 500; // after a scene came, when workers for the next one are started
const THUMB = 44; // CSS pixels, as in style.css

/** @template {HTMLElement} T @param {string} id @param {new () => T} type @returns {T} */
function element(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`#${id}: expected ${type.name}, got ${found}`);
  return found;
}

const stage = element("stage", HTMLElement), canvas = element("picture", HTMLCanvasElement);
const gallery = element("gallery", HTMLSelectElement), file = element("file", HTMLInputElement);
const message = element("message", HTMLElement), status = element("status", HTMLElement), note = element("note", HTMLElement);
const divider = element("divider", HTMLInputElement), line = element("line", HTMLElement), drop = element("drop", HTMLElement);
const yUp = element("y-up", HTMLInputElement);
const budget = element("budget", HTMLInputElement), refines = element("refines", HTMLInputElement);
const copy = element("link", HTMLButtonElement);
const context = /** @type {ImageBitmapRenderingContext} */ (canvas.getContext("bitmaprenderer"));

const query = new URLSearchParams(location.search);
const fixedSize = /^(\d+)x(\d+)$/.exec(query.get("size") ?? "");
const workers = Math.max(1, Math.min(Number(query.get("workers")) || navigator.hardwareConcurrency || 1, MOST_WORKERS));

// ---- Pictures --------------------------------------------------------------------------------------------

/** One for all workers. */
const module = compileCore();
const weights = fetch(new URL("weights/default.safetensors", import.meta.url)).then((response) => response.arrayBuffer());
const completing = new Worker(new URL("completing.js", import.meta.url), { type: "module" });
Promise.all([module, weights]).then(
  ([module, weights]) => completing.postMessage({ kind: "start", module, weights }, [weights]),
  (error) => (message.textContent = error.message));
const frames = new Frames(HOME, !fixedSize);
/** @type {Pool | undefined} that has the scene */
let shown;
/** @type {Pool | undefined} that will have the next */
let coming;
/** When pictures of the last second were shown, in milliseconds. @type {number[]} */
let times = [];
const statistics = {
  pictures: 0, fraction: 0, completing: 0, backend: "wasm", framesPerSecond: 0, raysPerSecond: 0, exact: false, error: NaN, workers,
};
/** Called with what the completing worker answers. @type {((buffers: import("./completing.js").Buffers | null) => void)[]} */
const waitingForBuffers = [];

/** @param {MessageEvent<import("./completing.js").Reply>} event */
completing.onmessage = ({ data }) => {
  if (data.kind === "picture") showPicture(data.picture, data.repainted);
  else if (data.kind === "buffers") waitingForBuffers.shift()?.(data.buffers);
  else if (data.kind === "failed") message.textContent = data.message;
};

/** @param {import("./completing.js").Picture} picture @param {boolean} repainted */
function showPicture(picture, repainted) {
  const { bitmap, frame, traced } = picture;
  if (canvas.width !== bitmap.width) canvas.width = bitmap.width;
  if (canvas.height !== bitmap.height) canvas.height = bitmap.height;
  context.transferFromImageBitmap(bitmap);
  if (repainted) return;
  shown?.grow();
  const now = performance.now(), exact = frames.completed(picture);
  times = [...times.filter((time) => time > now - 1000), now];
  Object.assign(statistics, {
    pictures: statistics.pictures + 1, fraction: traced / (frame.height * frame.width), completing: picture.completing,
    backend: picture.backend, raysPerSecond: frames.raysPerSecond, exact, error: picture.error,
  });
  document.dispatchEvent(new CustomEvent("picture", { detail: frame }));
}

/** @param {import("./core.js").Camera} camera */
function look(camera) {
  statistics.exact = false;
  frames.change({ camera });
}

/** The size of the picture at rest: device pixels. */
function fit() {
  const { clientWidth, clientHeight } = stage;
  const [width, height] = fixedSize ? [Number(fixedSize[1]), Number(fixedSize[2])]
                                    : [clientWidth * devicePixelRatio, clientHeight * devicePixelRatio];
  if (width < 1 || height < 1) return;
  const scale = fixedSize ? 1 : Math.min(1, Math.sqrt(MOST_PIXELS / (width * height)));
  const shrink = Math.min(clientWidth / width, clientHeight / height);
  canvas.style.width = `${width * shrink}px`, canvas.style.height = `${height * shrink}px`;
  show();
  statistics.exact = false;
  frames.change({ size: { height: Math.max(1, Math.round(height * scale)), width: Math.max(1, Math.round(width * scale)) } });
}

new ResizeObserver(fit).observe(stage);
orbit(canvas, () => frames.camera, look);

// ---- What is shown of them -------------------------------------------------------------------------------

/** @returns {import("./paint.js").Mode} */
function mode() {
  const checked = document.querySelector('input[name="mode"]:checked');
  return /** @type {import("./paint.js").Mode} */ (checked instanceof HTMLInputElement ? checked.value : "completed");
}

function show() {
  line.hidden = divider.hidden = mode() !== "split";
  completing.postMessage({ kind: "show", mode: mode(), divider: placeDivider() });
}

/** Has the line run where the slider's thumb has its centre. @returns {number} where that is, 0..1 of the picture's width */
function placeDivider() {
  const left = THUMB / 2 + Number(divider.value) / 100 * (stage.clientWidth - THUMB);
  line.style.left = `${left}px`;
  return Math.min(1, Math.max(0, (left - canvas.offsetLeft) / canvas.clientWidth));
}

for (const radio of document.querySelectorAll('input[name="mode"]')) radio.addEventListener("change", show);
divider.addEventListener("input", show);

const shownStatistics = Object.fromEntries(["fraction", "rays", "network", "rate"].map((id) => [id, element(id, HTMLElement)]));

/** A few times a second, which can be read. */
setInterval(() => {
  const now = performance.now();
  times = times.filter((time) => time > now - 1000);
  statistics.framesPerSecond = times.length;
  const { fraction, raysPerSecond, completing, backend, exact, error } = statistics;
  const percent = 100 * fraction;
  const texts = {
    fraction: exact ? "100 %, exact" : `${percent.toFixed(percent < 10 ? 1 : 0)} %`,
    rays: raysPerSecond >= 1e6 ? `${(raysPerSecond / 1e6).toFixed(2)} M` : `${Math.round(raysPerSecond / 1000)} k`,
    network: `${completing.toFixed(0)} ms${backend === "gpu" ? ", GPU" : ""}`, rate: times.length > 1 ? String(times.length) : "at rest",
  };
  for (const [id, text] of Object.entries(texts)) {
    if (statistics.pictures > 0 && shownStatistics[id].textContent !== text) shownStatistics[id].textContent = text;
  }
  note.textContent = mode() !== "difference" ? ""
    : exact ? `First completed picture against the exact one, ${DIFFERENCE_GAIN} times as bright; on average ${(255 * error).toFixed(1)} of 255.`
    : "The difference is shown once the picture is exact.";
}, 250);

budget.addEventListener("input", () => {
  frames.budget = Number(budget.value);
  element("budget-shown", HTMLOutputElement).value = `${budget.value} ms`;
});

refines.addEventListener("change", () => {
  frames.refines = refines.checked;
  frames.next();
});

// ---- Scenes ----------------------------------------------------------------------------------------------

/**
 * @typedef {{name: string, source: Blob | string, yUp: boolean}} Source a file, or its address
 * @typedef {{title: string, gallery?: string, script?: string, address?: string, source?: Source}} Scene
 *   gallery: which file of it; script: its text; address: of the file in the page's own; one without any has no link;
 *   source: of what is not in the gallery
 */
/** @type {Scene} */
let scene = { title: "" };

const editor = new Editor({
  text: element("text", HTMLTextAreaElement), numbers: element("numbers", HTMLElement),
  sliders: element("sliders", HTMLElement), error: element("error", HTMLElement),
}, edit);

/** Workers for the next scene, started ahead: that takes longer than opening most scenes. @type {Pool | undefined} */
let spare = pool();

function pool() {
  const made = new Pool(workers, module, completing, (parts) => made === shown && frames.traced(parts),
                        (text) => made === shown && (message.textContent = text));
  return made;
}

/**
 * Opens a scene in workers of its own. Where that fails, the one before stays.
 *
 * @param {Scene} opened
 * @param {(pool: Pool) => Promise<import("./reader.js").Summary>} open
 * @param {(message: string | null) => void} [complain] says what is wrong, null where nothing is
 */
async function replace(opened, open, complain = (text) => (message.textContent = text)) {
  coming?.end();
  const mine = coming = spare ?? pool();
  spare = undefined;
  stage.setAttribute("aria-busy", "true");
  try {
    const { script: text, warnings } = await open(mine);
    if (mine !== coming) return;
    shown?.end();
    shown = mine, coming = undefined;
    scene = { ...opened, script: text ?? undefined };
    canvas.setAttribute("aria-label", `Picture of ${scene.title}`);
    status.textContent = `${scene.title} is open`;
    if (edited === null && editor.script !== (text ?? "")) editor.script = text ?? "";
    message.textContent = "";
    complain(warnings.join(" ") || null);
    statistics.exact = false;
    frames.show(mine);
  } catch (error) {
    if (mine !== coming) return;
    coming = undefined;
    mine.end();
    complain(error instanceof Error ? error.message : String(error));
  } finally {
    if (!coming) stage.removeAttribute("aria-busy");
    setTimeout(() => (spare ??= pool()), SPARE_MS);
    choose();
  }
}

/** @param {string} text of a script */
const described = (text) => ({ shapes: [{ kind: /** @type {const} */ ("script"), source: text }], instances: [{ shape: 0 }] });

/** @param {Scene} opened @param {string} name @param {Blob | string} source */
function openFile(opened, name, source) {
  const turned = opened.gallery === undefined && yUp.checked;
  const from = opened.gallery === undefined ? { name, source, yUp: turned } : undefined;
  return replace({ ...opened, source: from }, (pool) => pool.read(name, source, turned));
}

/** @param {string} text */
const openScript = (text) => replace({ title: "Script" }, async (pool) => {
  await pool.open(described(text));
  return { script: text, warnings: [] };
}, (wrong) => editor.wrong(wrong));

/** The newest text of the editor that is not yet shown. @type {string | null} */
let edited = null;
let editing = false;

/** Shows a changed script, in the workers that have the one before if there is one. @param {string} text */
async function edit(text) {
  edited = text;
  if (editing) return;
  editing = true;
  stage.setAttribute("aria-busy", "true");
  while (edited !== null) {
    const now = edited;
    edited = null;
    if (!shown || shown.ended || scene.script === undefined) {
      await openScript(now);
      continue;
    }
    const same = shown;
    try {
      await same.open(described(now));
      if (same !== shown) continue;
      scene = { title: scene.title, script: now };
      statistics.exact = false;
      frames.show(same);
      editor.wrong(null);
      choose();
    } catch (error) {
      editor.wrong(error instanceof Error ? error.message : String(error));
    }
  }
  editing = false;
  if (!coming) stage.removeAttribute("aria-busy");
}

/** @type {{file: string, title: string, kind: string}[]} */
let built = [];

/** Has the list say which scene is open. */
function choose() {
  const known = scene.gallery !== undefined;
  const other = gallery.querySelector('option[value=""]') ?? gallery.appendChild(new Option("", ""));
  other.textContent = scene.gallery === undefined ? scene.title || "…" : "";
  if (known) other.remove();
  gallery.value = scene.gallery ?? "";
  copy.disabled = scene.gallery === undefined && scene.script === undefined && scene.address === undefined;
  copy.title = copy.disabled ? "A file of this machine has no link" : "";
  // It is known of the gallery and of scripts which way is up.
  yUp.parentElement?.toggleAttribute("hidden", !scene.source || scene.script !== undefined);
  yUp.checked = scene.source?.yUp ?? false;
}

/** @param {URL} address */
const fileName = ({ pathname }) => decodeURIComponent(pathname.replace(/^.*\//, ""));

/** @param {string} name of a file of the gallery */
function openGallery(name) {
  const entry = built.find(({ file }) => file === name);
  if (!entry) {
    message.textContent = `${name}: expected a built-in scene, one of ${built.map(({ file }) => file).join(", ")}`;
    return Promise.resolve();
  }
  const address = new URL(`gallery/${name}`, import.meta.url);
  return openFile({ title: capitalised(entry.title), gallery: name }, fileName(address), address.href);
}

/** @param {string} text */
const capitalised = (text) => text[0].toUpperCase() + text.slice(1);

async function fillGallery() {
  built = await (await fetch(new URL("gallery/index.json", import.meta.url))).json();
  const kinds = [...new Set(built.map(({ kind }) => kind))];
  gallery.append(...kinds.map((kind) => {
    const group = document.createElement("optgroup");
    group.label = capitalised(kind);
    group.append(...built.filter((entry) => entry.kind === kind).map(({ file, title }) => new Option(capitalised(title), file)));
    return group;
  }));
}

gallery.addEventListener("change", () => gallery.value && openGallery(gallery.value));
element("open", HTMLButtonElement).addEventListener("click", () => file.click());

/** @param {Iterable<File> | null | undefined} files */
function openFiles(files) {
  const [first] = files ?? [];
  if (first) openFile({ title: first.name }, first.name, first);
}

file.addEventListener("change", () => {
  openFiles(file.files);
  file.value = "";
});

yUp.addEventListener("change", () => {
  if (scene.source) openFile(scene, scene.source.name, scene.source.source);
});

addEventListener("dragover", (event) => {
  event.preventDefault();
  drop.hidden = false;
});
addEventListener("dragleave", (event) => {
  if (event.relatedTarget === null) drop.hidden = true;
});
addEventListener("drop", (event) => {
  event.preventDefault();
  drop.hidden = true;
  openFiles(event.dataTransfer?.files);
});

// ---- What is taken along ---------------------------------------------------------------------------------

element("home", HTMLButtonElement).addEventListener("click", () => look(HOME));

element("save", HTMLButtonElement).addEventListener("click", () => canvas.toBlob((blob) => {
  if (!blob) return;
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(blob);
  anchor.download = `${scene.title.replace(/\.[^.]*$/, "").replace(/\s+/g, "_").toLowerCase() || "picture"}.png`;
  anchor.click();
  URL.revokeObjectURL(anchor.href);
}, "image/png"));

/** This page with its scene and camera. */
async function link() {
  const { gallery, script } = scene;
  const fragment = await toFragment({ gallery, script: gallery ? undefined : script, camera: frames.camera });
  return new URL(fragment, location.href).href;
}

copy.addEventListener("click", async () => {
  const address = await link();
  history.replaceState(null, "", address);
  try {
    await navigator.clipboard.writeText(address);
    status.textContent = "The link is copied";
  } catch {
    status.textContent = "The link is in the address bar";
  }
});

// ---- Start -----------------------------------------------------------------------------------------------

async function start() {
  const [state] = await Promise.all([fromFragment(location.hash), fillGallery()]);
  look(state.camera);
  const address = query.get("scene");
  if (state.script !== undefined) {
    await openScript(state.script);
  } else if (address !== null && !state.gallery) {
    const url = new URL(address, location.href), name = fileName(url);
    if (url.origin === location.origin) await openFile({ title: name, address }, name, url.href);
    else message.textContent = `scene: expected a file of ${location.origin}, got ${url.origin}`;
  } else {
    await openGallery(state.gallery ?? built[0].file);
  }
}

/** Resolves once the picture is exact. @returns {Promise<void>} */
function converged() {
  return new Promise((resolve) => {
    const check = () => {
      if (!statistics.exact) return;
      document.removeEventListener("picture", check);
      resolve();
    };
    document.addEventListener("picture", check);
    check();
  });
}

/** @returns {Promise<import("./completing.js").Buffers | null>} of the last picture */
function buffers() {
  return new Promise((resolve) => {
    waitingForBuffers.push(resolve);
    completing.postMessage({ kind: "buffers" });
  });
}

/** For tests and measurements. */
export const page = { statistics, started: start(), converged, buffers, look, link, openFile, camera: () => frames.camera, valid };
Object.assign(window, { bobrossnet: page });
