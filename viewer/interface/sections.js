// @ts-check
/** The controls of sections: for each axis a switch, a slider along the scene's box, and its other side. */
import { made } from "../component/made.js";
import { AXES, shortened, textOf, toggled, validSections } from "../tracing/section.js";

/**
 * @typedef {import("../tracing/section.js").Axis} Axis
 * @typedef {import("../tracing/scene.js").About} About
 * @typedef {import("../component/bob-view.js").BobView} BobView
 */

const STEPS = 1000; // of a slider

export class Sections {
  #picture;
  #note;
  /** Box and unit of the open scene, once known. @type {About | undefined} */
  #about;
  /** The rows of controls, by axis. */
  #rows;

  /** @param {BobView} picture @param {HTMLElement} root @param {HTMLElement} note */
  constructor(picture, root, note) {
    this.#picture = picture;
    this.#note = note;
    this.#rows = AXES.map((name, axis) => this.#row(name.toUpperCase(), /** @type {Axis} */ (axis)));
    root.append(...this.#rows.flatMap(({ elements }) => elements));
    new MutationObserver(() => this.#display()).observe(picture, { attributeFilter: ["section"] }); // keys change it, too
    this.#display();
  }

  /** Another scene is whole. */
  opened() {
    this.#about = undefined;
    this.#picture.removeAttribute("section");
  }

  /** A changed scene has another box. */
  changed() {
    this.#about = undefined;
    if (this.#sections.length > 0) this.#display();
  }

  /** @param {string} name @param {Axis} axis */
  #row(name, axis) {
    const check = made("input", { type: "checkbox" }), label = made("label", { className: "check" }, check, ` ${name}`);
    const slider = made("input", { type: "range", min: "0", max: String(STEPS), step: "1", disabled: true, ariaLabel: `Section along ${name}` });
    const output = made("output"), other = made("button", { type: "button", textContent: "⇄", title: "Keep the other side", ariaLabel: `Keep the other side of ${name}`, disabled: true });
    check.addEventListener("change", async () => this.#set(toggled(this.#sections, axis, (await this.#known()).box)));
    slider.addEventListener("input", async () => {
      const { box } = await this.#known(), size = box[axis + 3] - box[axis];
      this.#change(axis, { at: shortened(box[axis] + Number(slider.value) / STEPS * size, size) });
    });
    other.addEventListener("click", () => {
      const own = this.#sections.find((section) => section.axis === axis);
      if (own) this.#change(axis, { sign: own.sign > 0 ? -1 : 1 });
    });
    return { check, slider, output, other, elements: [label, slider, output, other] };
  }

  get #sections() {
    return validSections(this.#picture.getAttribute("section"));
  }

  /** Changes the first section along an axis. @param {Axis} axis @param {Partial<import("../tracing/section.js").Section>} changes */
  #change(axis, changes) {
    const sections = this.#sections, i = sections.findIndex((section) => section.axis === axis);
    if (i >= 0) this.#set(sections.with(i, { ...sections[i], ...changes }));
  }

  /** @param {import("../tracing/section.js").Section[]} sections */
  #set(sections) {
    if (sections.length > 0) this.#picture.setAttribute("section", textOf(sections));
    else this.#picture.removeAttribute("section");
  }

  /** @returns {Promise<About>} of the open scene */
  async #known() {
    const about = this.#about ?? await this.#picture.about();
    if (!about) throw new Error("section: expected an open scene, got none");
    return this.#about = about;
  }

  async #display() {
    const sections = this.#sections, about = sections.length > 0 ? await this.#known() : this.#about;
    this.#rows.forEach(({ check, slider, output, other }, axis) => {
      const own = sections.find((section) => section.axis === axis);
      check.checked = own !== undefined;
      slider.disabled = other.disabled = !own;
      output.value = own ? String(own.at) : "";
      if (!own || !about) return;
      const { box, unit } = about, size = box[axis + 3] - box[axis];
      slider.value = String(Math.round((own.at - box[axis]) / size * STEPS));
      if (unit) output.value += ` ${unit}`;
      slider.setAttribute("aria-valuetext", output.value);
    });
    this.#note.textContent = "";
    if (sections.length > 0) this.#picture.addEventListener("progress", () => this.#warn(), { once: true });
  }

  /** Names the first shape without caps. */
  async #warn() {
    const about = await this.#picture.about();
    if (!about || this.#sections.length === 0) return;
    const { open, labels } = about;
    this.#note.textContent = open < 0 ? "" : `${labels[open].name ?? "The shape"} is open: a section shows its inside, without a cap.`;
  }
}
