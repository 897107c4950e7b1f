// @ts-check
/**
 * Opens scenes: from the gallery, from files, and from the editor's script. On failure, the previous scene stays.
 *
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").OpenScene} OpenScene
 * @typedef {import("../component/viewing.js").Viewing} Viewing
 * @typedef {import("../component/viewing.js").Summary} Summary
 *
 * @typedef {object} Shown Callbacks of the page
 * @property {(busy: boolean) => void} busy reports whether a scene is being opened
 * @property {() => void} opened called once another scene is displayed
 * @property {() => void} chosen called whenever the scene in the state may have changed or been restored
 * @property {(text: string | null) => void} message the error in a file, or null
 * @property {(text: string | null) => void} wrong the error in the script, or null
 */
import { fileName } from "../core/addresses.js";
import { UPRIGHT } from "../shapes/affine.js";

export class Opening {
  #state;
  #viewing;
  #shown;

  /** @param {State} state @param {Viewing} viewing @param {Shown} shown */
  constructor(state, viewing, shown) {
    this.#state = state;
    this.#viewing = viewing;
    this.#shown = shown;
    viewing.expectMore();
  }

  /** @param {string} name of a file of the gallery @throws {Error} of one sentence for another name */
  async builtIn(name) {
    const { gallery } = this.#state, entry = gallery.find(({ file }) => file === name);
    if (!entry) {
      const known = gallery.map(({ file }) => file).join(", ");
      throw new Error(`${name.slice(0, 100)}: expected a built-in scene, one of ${known}`);
    }
    const address = new URL(`../gallery/${name}`, import.meta.url);
    return this.file({ title: capitalised(entry.title), gallery: name }, fileName(address), address.href, false);
  }

  /**
   * @param {OpenScene} opened
   * @param {string} name with its suffix
   * @param {Blob | string} source the file or its address, possibly relative to the page
   * @param {boolean | null} yUp whether y is up in the file; null if unknown
   * @param {File[]} [beside] files opened together with it
   */
  file(opened, name, source, yUp, beside = []) {
    const from = opened.gallery === undefined ? { name, source, beside, yUp } : undefined, turn = yUp ? UPRIGHT : null;
    return this.#replace({ ...opened, source: from }, () => this.#viewing.read(name, source, { turn, isUpKnown: yUp !== null, beside }), this.#shown.message);
  }

  /** @param {string} text @param {string} [edited] the title under which it is kept (kept.js), if edited */
  script(text, edited) {
    return this.#replace({ title: edited ?? "Script", edited }, () => this.#viewing.run(text), this.#shown.wrong);
  }

  /**
   * Displays a changed script, in the workers of the previous one if there is one. Each text that is opened gets a
   * picture before the next one, which is then the newest: otherwise fast changes would show nothing.
   *
   * @param {string} text
   */
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
        await this.script(now, edits.title ?? undefined);
        await viewing.pictured();
        continue;
      }
      try {
        const summary = await viewing.edit(now);
        if (!summary) continue;
        state.scene = { title: state.scene.title, script: now, edited: edits.title ?? undefined };
        this.#shown.wrong(null);
        this.#shown.message(summary.warnings.join(" ") || null);
        this.#shown.chosen();
        await viewing.pictured();
      } catch (error) {
        this.#shown.wrong(messageOf(error));
      }
    }
    edits.busy = false;
    if (!viewing.isOpening) this.#shown.busy(false);
  }

  /**
   * Opens a scene in place of the previous one.
   *
   * @param {OpenScene} opened
   * @param {() => Promise<Summary | null>} open
   * @param {(text: string | null) => void} complain reports the error, or null
   */
  async #replace(opened, open, complain) {
    this.#shown.busy(true);
    try {
      const summary = await open();
      if (!summary) return;
      if (opened.source && summary.stoodUp) opened.source.yUp = true;
      this.#state.scene = { ...opened, script: summary.script ?? undefined };
      this.#state.edits.title = opened.edited ?? null;
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
