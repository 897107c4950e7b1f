// @ts-check
/**
 * Opens scenes: of the gallery, of files, and of the editor's script. Where that fails, the one before stays.
 *
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").OpenScene} OpenScene
 * @typedef {import("../component/viewing.js").Viewing} Viewing
 * @typedef {import("../component/viewing.js").Summary} Summary
 *
 * @typedef {object} Shown How the page shows what happens here
 * @property {(busy: boolean) => void} busy whether a scene is being opened
 * @property {() => void} opened called once another scene is shown
 * @property {() => void} chosen called whenever the state may have another scene, or has the same again
 * @property {(text: string | null) => void} message what is wrong with a file, or null
 * @property {(text: string | null) => void} wrong the same of the script
 */
import { fileName } from "../core/addresses.js";

export class Opening {
  #state;
  #viewing;
  #shown;

  /** @param {State} state @param {Viewing} viewing @param {Shown} shown */
  constructor(state, viewing, shown) {
    this.#state = state;
    this.#viewing = viewing;
    this.#shown = shown;
    viewing.expectsMore = true;
  }

  /** @param {string} name of a file of the gallery */
  async builtIn(name) {
    const { gallery } = this.#state, entry = gallery.find(({ file }) => file === name);
    if (!entry) {
      const known = gallery.map(({ file }) => file).join(", ");
      return this.#shown.message(`${name.slice(0, 100)}: expected a built-in scene, one of ${known}`);
    }
    const address = new URL(`../gallery/${name}`, import.meta.url);
    return this.file({ title: capitalised(entry.title), gallery: name }, fileName(address), address.href, false);
  }

  /**
   * @param {OpenScene} opened
   * @param {string} name with its ending
   * @param {Blob | string} source or its address, also relative to the page
   * @param {boolean} yUp whether it stores y up, which is known of the gallery
   * @param {File[]} [beside] what was opened together with it
   */
  file(opened, name, source, yUp, beside = []) {
    const from = opened.gallery === undefined ? { name, source, beside, yUp } : undefined;
    return this.#replace({ ...opened, source: from }, () => this.#viewing.read(name, source, { yUp, beside }), this.#shown.message);
  }

  /** @param {string} text */
  script(text) {
    return this.#replace({ title: "Script" }, () => this.#viewing.run(text), this.#shown.wrong);
  }

  /** Shows a changed script, in the workers that have the one before if there is one. @param {string} text */
  async edit(text) {
    const state = this.#state, { edits } = state, viewing = this.#viewing;
    edits.newest = text;
    if (edits.busy) return;
    edits.busy = true;
    this.#shown.busy(true);
    while (edits.newest !== null) {
      const now = edits.newest;
      edits.newest = null;
      if (!viewing.canEdit || state.scene.script === undefined) {
        await this.script(now);
        continue;
      }
      try {
        const summary = await viewing.edit(now);
        if (!summary) continue;
        state.scene = { title: state.scene.title, script: now };
        this.#shown.wrong(null);
        this.#shown.message(summary.warnings.join(" ") || null);
        this.#shown.chosen();
      } catch (error) {
        this.#shown.wrong(messageOf(error));
      }
    }
    edits.busy = false;
    if (!viewing.isOpening) this.#shown.busy(false);
  }

  /**
   * Opens a scene in the place of the one before.
   *
   * @param {OpenScene} opened
   * @param {() => Promise<Summary | null>} open
   * @param {(text: string | null) => void} complain says what is wrong, null where nothing is
   */
  async #replace(opened, open, complain) {
    this.#shown.busy(true);
    try {
      const summary = await open();
      if (!summary) return;
      this.#state.scene = { ...opened, script: summary.script ?? undefined };
      this.#shown.opened();
      complain(null);
      this.#shown.message(summary.warnings.join(" ") || null);
    } catch (error) {
      complain(messageOf(error));
    } finally {
      if (!this.#viewing.isOpening) this.#shown.busy(false);
      this.#shown.chosen();
    }
  }
}

/** @param {unknown} error */
const messageOf = (error) => (error instanceof Error ? error.message : String(error));

/** @param {string} text */
export const capitalised = (text) => text[0].toUpperCase() + text.slice(1);
