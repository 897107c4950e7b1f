// @ts-check
/** The list of parts, and measures of picked points. */
import { made } from "../component/made.js";
import { between } from "../component/parts.js";
import { inWords } from "../component/snaps.js";
import { withAllBelow } from "../tracing/parts.js";
import { coordinatesOf, directionOf, lengthOf, measuresOf } from "./measures.js";

/**
 * @typedef {import("../component/bob-view.js").BobView} BobView
 * @typedef {import("../tracing/parts.js").Part} Part
 * @typedef {import("../tracing/picking.js").Picked} Picked
 */

const MOST_OPEN = 30; // parts of a tree that is unfolded at first

export class PartsList {
  #picture;
  #elements;
  /** The list's items, and their switches. @type {Map<Part, {item: HTMLElement, shown: HTMLInputElement, name: HTMLButtonElement}>} */
  #rows = new Map();
  /** @type {Part | undefined} */
  #root;
  /** The highlighted one, or that below which all are. @type {Part | undefined} */
  #chosen;
  /** The last two picks, the newest second. @type {Picked[]} */
  #picks = [];
  #isOld = true;
  /** Of the scene that was picked. */
  #radius = 1;

  /**
   * @param {BobView} picture
   * @param {{details: HTMLDetailsElement, list: HTMLElement, all: HTMLButtonElement, picked: HTMLElement, status: HTMLElement}} elements
   */
  constructor(picture, elements) {
    this.#picture = picture;
    this.#elements = elements;
    const { details, all } = elements;
    details.addEventListener("toggle", () => this.#fill());
    all.addEventListener("click", async () => {
      await picture.isolate();
      this.#display();
    });
    picture.addEventListener("pick", (event) => this.#pick(/** @type {CustomEvent} */ (event).detail));
  }

  /** Forgets the tree, after another scene was opened. */
  opened() {
    this.#isOld = true;
    this.#root = this.#chosen = undefined;
    this.#rows.clear();
    this.#picks = [];
    this.#elements.list.replaceChildren();
    this.#elements.picked.replaceChildren();
    this.#fill();
  }

  /** Lists the parts, if someone looks at them. */
  async #fill() {
    const { details, list } = this.#elements;
    if (!this.#isOld || !details.open) return;
    this.#isOld = false;
    const root = this.#root = await this.#picture.parts().catch(() => undefined);
    this.#isOld = !root;
    if (!root) return; // no scene is open
    list.replaceChildren(...root.children.map((part) => this.#item(part, countOf(root) <= MOST_OPEN)));
    this.#display();
  }

  /** @param {Part} part @param {boolean} isOpen @returns {HTMLElement} */
  #item(part, isOpen) {
    const shown = made("input", { type: "checkbox", checked: true, ariaLabel: `Show ${part.name}` });
    const name = made("button", { type: "button", className: "name", textContent: part.name, title: part.path, ariaPressed: "false" });
    const only = made("button", { type: "button", className: "only", textContent: "Only", ariaLabel: `Show only ${part.name}` });
    shown.addEventListener("change", () => this.#hide(part, !shown.checked));
    name.addEventListener("click", () => this.#choose(part));
    only.addEventListener("click", () => this.#isolate(part));
    const row = made("div", { className: "part" }, shown, name, only), item = made("li");
    this.#rows.set(part, { item, shown, name });
    if (part.children.length === 0) {
      item.append(row);
      return item;
    }
    // Parts below are listed once someone looks at them.
    const below = made("ul"), details = made("details", {}, made("summary", { ariaLabel: `Parts of ${part.name}` }), below);
    const fill = () => {
      if (below.childElementCount > 0) return;
      below.append(...part.children.map((child) => this.#item(child, isOpen)));
      this.#display();
    };
    details.addEventListener("toggle", fill);
    if (isOpen) fill(), details.open = true;
    item.append(row, details);
    return item;
  }

  /** @param {Part} part @param {boolean} isHidden */
  async #hide(part, isHidden) {
    await (isHidden ? this.#picture.hide(part.number) : this.#picture.unhide(part.number));
    this.#display();
  }

  /** @param {Part} part */
  async #isolate(part) {
    await this.#picture.isolate(part.number);
    this.#display();
  }

  /** Highlights and measures a part. @param {Part} part */
  async #choose(part) {
    const { name } = this.#rows.get(part) ?? {}, isChosen = name?.ariaPressed === "true";
    this.#picks = [];
    await this.#highlight(isChosen ? undefined : part);
    if (isChosen) this.#elements.picked.replaceChildren();
    else await this.#show([]);
  }

  /** @param {Part} [part] */
  async #highlight(part) {
    this.#chosen = part;
    this.#display();
    await (part ? this.#picture.highlight(part.number) : this.#picture.highlight());
  }

  /** @param {Picked | null} picked */
  async #pick(picked) {
    this.#picks = picked ? [...this.#picks.slice(-1), picked] : [];
    const [root, about] = await Promise.all([this.#picture.parts(), this.#picture.about()]), parts = withAllBelow(root).filter(({ path }) => path);
    this.#radius = about?.sphere.radius ?? 1;
    const part = picked ? parts.find(({ path }) => path === picked.part) : undefined;
    await this.#highlight(parts.length > 1 ? part : undefined);
    this.#rows.get(/** @type {Part} */ (part))?.item.scrollIntoView({ block: "nearest" });
    if (picked) await this.#show(this.#picks, part);
    else this.#elements.picked.replaceChildren();
  }

  /** @param {Picked[]} picks @param {Part} [part] */
  async #show(picks, part = this.#chosen) {
    const { picked, status } = this.#elements, [, second] = picks, last = picks.at(-1);
    /** @type {[string, string][]} */
    const rows = [["Part", part?.path ?? ""]];
    if (last) {
      if (last.face !== null) rows.push([/mesh/.test(last.kind) ? "Triangle" : "Face", String(last.face)]);
      if (last.section !== null) rows.push(["Section", "cap"]);
      if (last.snapped) rows.push(["Snapped to", inWords(last.snapped, last.radius, last.unit)]);
      rows.push(["Point", coordinatesOf(last.point, this.#radius) + (last.unit ? ` ${last.unit}` : "")]);
      rows.push(["Normal", directionOf(last.normal)]);
    }
    if (second) {
      const { distance, offset, angle, unit, ends } = between(picks[0], second);
      rows.push(["Distance", `${lengthOf(distance, unit)}, ${ends.join(" to ")}`], ["Offset", coordinatesOf(offset, this.#radius)], ["Angle", `${angle.toFixed(1)}°`]);
    }
    const list = (/** @type {[string, string][]} */ all) => all.flatMap(([term, value]) => [made("dt", { textContent: term }), made("dd", { textContent: value })]);
    const said = (/** @type {[string, string][]} */ all) => (status.textContent = all.map(([term, value]) => `${term} ${value}`).join(". "));
    const shown = list(rows);
    picked.replaceChildren(...shown);
    if (last) said(rows);
    const measures = measuresOf(await this.#picture.measure(part?.number)); // which may take a second
    if (shown[0].parentElement !== picked) return; // another pick came
    picked.append(...list(measures));
    if (!last) said([...rows, ...measures].slice(0, 3));
  }

  #display() {
    for (const [part, { shown, name }] of this.#rows) {
      const all = withAllBelow(part), hidden = all.filter(({ isHidden }) => isHidden).length;
      shown.checked = hidden < all.length;
      shown.indeterminate = hidden > 0 && hidden < all.length;
      name.ariaPressed = String(part === this.#chosen);
    }
    this.#elements.all.disabled = !this.#root || !withAllBelow(this.#root).some(({ isHidden }) => isHidden);
  }
}

/** @param {Part} part @returns {number} */
const countOf = (part) => withAllBelow(part).length;
