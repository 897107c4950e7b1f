// @ts-check
/**
 * The page: its elements, and their connection to its state. Nothing here blocks; workers do all long work.
 *
 * In the page's address, `?scene=files/NAME.bob` opens a file of the same server, `?size=640x480` fixes the picture's
 * size in pixels, `?samples=1` leaves edges unsmoothed, `?light=studio` or `headlight` is the light, and `?workers=1` is the number of
 * tracing threads. The body may set the field of view, light and background of all pictures by `data-field-of-view`,
 * `data-light` and `data-background`, in the notation of <bob-view>.
 */
import { BobView } from "../component/bob-view.js";
import { made } from "../component/made.js";
import { addressOf, fileName } from "../core/addresses.js";
import { isModel } from "../core/endings.js";
import { fetchPart } from "../core/parts.js";
import { PERSPECTIVE } from "../picture/camera.js";
import { droppedFiles } from "./dropped.js";
import { Editor } from "./editor.js";
import { Kept } from "./kept.js";
import { LightControl } from "./lighting.js";
import { fromFragment, toFragment } from "./link.js";
import { Opening, capitalised } from "./opening.js";
import { PartsList } from "./parts.js";
import { Sections } from "./sections.js";
import { createState } from "./state.js";
import { display } from "./statistics.js";

const THUMB = 44; // CSS pixels, as in style.css

/** @template {HTMLElement} T @param {string} id @param {new () => T} type @returns {T} */
function element(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`#${id}: expected ${type.name}, got ${found}`);
  return found;
}

const stage = element("stage", HTMLElement);
const gallery = element("gallery", HTMLSelectElement), file = element("file", HTMLInputElement);
const message = element("message", HTMLElement), status = element("status", HTMLElement);
const divider = element("divider", HTMLInputElement), line = element("line", HTMLElement), drop = element("drop", HTMLElement);
const yUp = element("y-up", HTMLInputElement);
const budget = element("budget", HTMLInputElement), refines = element("refines", HTMLInputElement);
const perspective = element("perspective", HTMLInputElement), edges = element("edges", HTMLInputElement);
const copy = element("link", HTMLButtonElement);

const query = new URLSearchParams(location.search);
const state = createState(), kept = new Kept();

// ---- Pictures --------------------------------------------------------------------------------------------

const picture = new BobView();
picture.id = "picture";
const { fieldOfView, background, light = "scene" } = document.body.dataset;
for (const [name, value] of Object.entries({
  "picture-size": query.get("size"), samples: query.get("samples"), workers: query.get("workers"), "field-of-view": fieldOfView, background,
})) if (value) picture.setAttribute(name, value);
if (background) stage.style.background = "none";
picture.toggleAttribute("camera-controls", true);
picture.toggleAttribute("view-cube", true);
picture.setAttribute("interaction-prompt", "none");
picture.setAttribute("touch-action", "none"); // the page scrolls by its controls
stage.prepend(picture);
const { viewing } = picture, { schedule, statistics } = viewing;

picture.addEventListener("error", (event) => {
  event.preventDefault();
  message.textContent = /** @type {any} */ (event).detail.message;
});
const showLens = () => (perspective.checked = picture.camera.fov > 0);
picture.addEventListener("camera-change", showLens);
showLens();
perspective.addEventListener("change", () => look({ fov: perspective.checked ? PERSPECTIVE : 0 }));

edges.addEventListener("change", () => picture.toggleAttribute("edges", edges.checked));
new MutationObserver(() => (edges.checked = picture.hasAttribute("edges"))).observe(picture, { attributeFilter: ["edges"] }); // a key changes it, too

const snaps = element("snap", HTMLInputElement), showSnap = () => picture.toggleAttribute("snap", snaps.checked);
snaps.addEventListener("change", showSnap);
showSnap();

/** @param {Partial<import("../picture/camera.js").Camera>} camera */
const look = (camera) => (picture.camera = camera);

// ---- Display modes ---------------------------------------------------------------------------------------

function show() {
  const checked = document.querySelector('input[name="mode"]:checked');
  const value = checked instanceof HTMLInputElement ? checked.value : "completed";
  state.mode = /** @type {import("../picture/paint.js").Mode} */ (value);
  line.hidden = divider.hidden = state.mode !== "split";
  picture.show({ mode: state.mode, divider: placeDivider() });
}

const lighting = new LightControl(picture, element("light", HTMLSelectElement),
                                  ["difference", "uncertain"].map((mode) => /** @type {HTMLInputElement} */ (document.querySelector(`input[value=${mode}]`))));
const usualLight = query.get("light") ?? light;
lighting.light = usualLight;

/** Aligns the dividing line with the centre of the slider's thumb. @returns {number} its place, 0..1 of the picture's width */
function placeDivider() {
  const left = THUMB / 2 + Number(divider.value) / 100 * (stage.clientWidth - THUMB), box = picture.pictureBox;
  line.style.left = `${left}px`;
  return Math.min(1, Math.max(0, (left - box.left) / box.width));
}

for (const radio of document.querySelectorAll('input[name="mode"]')) radio.addEventListener("change", show);
divider.addEventListener("input", show);
new ResizeObserver(show).observe(stage);

display(statistics, state, {
  fraction: element("fraction", HTMLElement), rays: element("rays", HTMLElement), network: element("network", HTMLElement),
  rate: element("rate", HTMLElement), note: element("note", HTMLElement),
});

budget.addEventListener("input", () => {
  schedule.budget = Number(budget.value);
  element("budget-shown", HTMLOutputElement).value = `${budget.value} ms`;
});

refines.addEventListener("change", () => viewing.refine(refines.checked));

const sections = new Sections(picture, element("axes", HTMLElement), element("open-shape", HTMLElement));
const parts = new PartsList(picture, {
  details: element("parts", HTMLDetailsElement), list: element("tree", HTMLElement), all: element("show-all", HTMLButtonElement),
  picked: element("picked", HTMLElement), status,
});

// ---- Scenes ----------------------------------------------------------------------------------------------

const opening = new Opening(state, viewing, {
  busy: (busy) => (busy ? stage.setAttribute("aria-busy", "true") : stage.removeAttribute("aria-busy")),
  opened: () => {
    const { title, script = "", edited } = state.scene;
    picture.begun();
    lighting.opened();
    sections.opened();
    parts.opened();
    picture.alt = `Picture of ${title}`;
    status.textContent = `${title} is open`;
    kept.display(edited ?? null);
    if (state.edits.newest === null && editor.script !== script) editor.script = script;
  },
  chosen: () => {
    choose();
    sections.changed();
  },
  message: (text) => (message.textContent = text),
  wrong: (text) => {
    editor.wrong(text);
    if (text !== null) element("script", HTMLDetailsElement).open = true;
  },
});

const editor = new Editor({
  text: element("text", HTMLTextAreaElement), numbers: element("numbers", HTMLElement),
  sliders: element("sliders", HTMLElement), error: element("error", HTMLElement),
}, (script) => {
  const { scene, edits } = state;
  edits.title ??= kept.free(scene.script === undefined ? "Script" : scene.title);
  kept.keep(edits.title, script);
  opening.edit(script);
});

const EDITED = "edited: "; // before the title, in the list

/** Selects the open scene in the list. */
function choose() {
  const { scene } = state, known = scene.gallery !== undefined || scene.edited !== undefined;
  offerEdited();
  const other = gallery.querySelector('option[value=""]') ?? gallery.appendChild(new Option("", ""));
  other.textContent = known ? "" : scene.title || "…";
  if (known) other.remove();
  gallery.value = scene.gallery ?? (scene.edited === undefined ? "" : EDITED + scene.edited);
  copy.disabled = !known && scene.script === undefined && scene.address === undefined;
  copy.title = copy.disabled ? "A file of this machine has no link" : "";
  // The up axis is known for the gallery and for scripts.
  yUp.parentElement?.toggleAttribute("hidden", !scene.source || scene.script !== undefined);
  yUp.checked = scene.source?.yUp ?? false;
}

/** Lists the edited scripts, last. */
function offerEdited() {
  const { titles } = kept, listed = gallery.querySelector("#edited");
  if (titles.length === 0 || listed?.childElementCount === titles.length) return;
  const group = listed ?? gallery.appendChild(made("optgroup", { id: "edited", label: "Edited" }));
  group.replaceChildren(...titles.map((title) => new Option(title, EDITED + title)));
}

/** @param {string} title of an edited script */
function openEdited(title) {
  editor.script = kept.script(title) ?? "";
  return opening.script(editor.script, title);
}

async function fillGallery() {
  state.gallery = await (await fetchPart("gallery/index.json")).json();
  const kinds = [...new Set(state.gallery.map(({ kind }) => kind))];
  gallery.append(...kinds.map((kind) => {
    const group = document.createElement("optgroup"), entries = state.gallery.filter((entry) => entry.kind === kind);
    group.label = capitalised(kind);
    group.append(...entries.map(({ file, title }) => new Option(capitalised(title), file)));
    return group;
  }));
}

gallery.addEventListener("change", () => {
  const { value } = gallery;
  if (value.startsWith(EDITED)) openEdited(value.slice(EDITED.length));
  else if (value) opening.builtIn(value);
});
element("open", HTMLButtonElement).addEventListener("click", () => file.click());

/** @param {import("./state.js").OpenScene} opened @param {string} name @param {Blob | string} source @param {File[]} [beside] */
function openFile(opened, name, source, beside) {
  return opening.file(opened, name, source, null, beside);
}

/** Opens the models among the files as one scene; the others may be their textures, buffers and materials. @param {Iterable<File> | null} files */
function openFiles(files) {
  const all = Array.from(files ?? []), models = all.filter(({ name }) => isModel(name)), model = models[0] ?? all[0];
  if (!model) return;
  const title = models.length > 1 ? `${model.name} and ${models.length - 1} more` : model.name;
  openFile({ title }, model.name, model, all.filter((other) => other !== model));
}

file.addEventListener("change", () => {
  openFiles(file.files);
  file.value = "";
});

yUp.addEventListener("change", () => {
  const { scene } = state;
  if (scene.source) opening.file(scene, scene.source.name, scene.source.source, yUp.checked, scene.source.beside);
});

/** Whether files are dragged, not text, which the editor takes. @param {DragEvent} event */
const hasFiles = ({ dataTransfer }) => dataTransfer?.types.includes("Files") === true;

addEventListener("dragover", (event) => {
  if (!hasFiles(event)) return;
  event.preventDefault();
  drop.hidden = false;
});
addEventListener("dragleave", (event) => {
  if (event.relatedTarget === null) drop.hidden = true;
});
addEventListener("drop", (event) => {
  if (!event.dataTransfer || !hasFiles(event)) return;
  event.preventDefault();
  drop.hidden = true;
  droppedFiles(event.dataTransfer).then(openDropped, tell);
});

/** @param {File[]} files */
function openDropped(files) {
  if (files.length > 0) openFiles(files);
  else message.textContent = "drop: expected files, got an empty folder";
}

// ---- Saving and links -------------------------------------------------------------------------------------

element("home", HTMLButtonElement).addEventListener("click", () => picture.goTo("home"));
element("fit", HTMLButtonElement).addEventListener("click", () => picture.fit());

const save = element("save", HTMLButtonElement), saveLabel = save.textContent;

/** The share of the picture that is traced, on the button. @param {Event} event */
const showProgress = (event) =>
  (save.textContent = `Tracing… ${Math.floor(100 * /** @type {CustomEvent} */ (event).detail.totalProgress)} %`);

save.addEventListener("click", async () => {
  save.disabled = true;
  picture.addEventListener("progress", showProgress);
  try {
    const anchor = document.createElement("a"), blob = await picture.toBlob();
    anchor.href = URL.createObjectURL(blob);
    anchor.download = `${state.scene.title.replace(/\.[^.]*$/, "").replace(/\s+/g, "_").toLowerCase() || "picture"}.png`;
    anchor.click();
    URL.revokeObjectURL(anchor.href);
    status.textContent = "The picture is saved";
  } catch (error) {
    message.textContent = error instanceof Error ? error.message : String(error);
  } finally {
    picture.removeEventListener("progress", showProgress);
    save.textContent = saveLabel;
    save.disabled = false;
  }
});

/** A link to this page with its scene and camera. */
async function link() {
  const { gallery, script } = state.scene;
  const light = lighting.light === "scene" ? undefined : lighting.light;
  const fragment = await toFragment({ gallery, script: gallery ? undefined : script, camera: picture.camera, light });
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

/**
 * Opens the scene and the camera in the page's fragment.
 *
 * @param {() => Promise<void>} [open] opens another scene, if there is none in it
 * @throws {Error} of one sentence, if it is damaged
 */
async function follow(open) {
  const { hash } = location, linked = await fromFragment(hash);
  if (hash !== location.hash) return; // another link is followed meanwhile
  if (linked.camera) look(linked.camera);
  lighting.light = linked.light ?? usualLight;
  if (linked.script !== undefined) {
    editor.script = linked.script;
    await opening.script(linked.script);
  } else if (linked.gallery) {
    await opening.builtIn(linked.gallery);
  } else {
    await open?.();
  }
  if (linked.wrong) message.textContent = linked.wrong;
}

/** Opens the scene in the address, or the gallery's first. */
async function start() {
  await fillGallery();
  const { reloaded } = kept, address = query.get("scene"), openFirst = () => opening.builtIn(state.gallery[0].file);
  offerEdited();
  try {
    if (reloaded !== null && kept.script(reloaded) !== undefined) await openEdited(reloaded);
    else await follow(() => (address === null ? openFirst() : openAddress(address)));
  } catch (error) {
    await openFirst();
    throw error;
  }
}

/** @param {string} address of a file of this server @throws {Error} of one sentence, if it is of another one */
async function openAddress(address) {
  const url = addressOf(address, location.href);
  if (url?.origin !== location.origin) {
    throw new Error(`scene: expected a file of ${location.origin}, got ${url?.origin ?? address.slice(0, 100)}`);
  }
  const name = fileName(url);
  await openFile({ title: name, address }, name, url.href);
}

/** @param {Error} error */
const tell = (error) => (message.textContent = error.message);

addEventListener("hashchange", () => {
  page.started = follow().catch(tell);
});

/** The page's state, for tests and measurements. */
export const page = {
  statistics, started: start().catch(tell), converged: () => picture.converged(), buffers: () => viewing.buffers(), look, link, openFile,
  camera: () => picture.camera, schedule,
};
Object.assign(window, { bobrossnet: page });
