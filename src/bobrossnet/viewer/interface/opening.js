// @ts-check
/**
 * Opens scenes: of the gallery, of files, and of the editor's script. Where that fails, the one before stays.
 *
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").OpenScene} OpenScene
 * @typedef {import("../workers/pool.js").Pool} Pool
 *
 * @typedef {object} Shown How the page shows what happens here
 * @property {(busy: boolean) => void} busy whether a scene is being opened
 * @property {() => void} opened called once the state has a scene in new workers
 * @property {() => void} chosen called whenever the state may have another scene, or has the same again
 * @property {(text: string | null) => void} message what is wrong with a file, or null
 * @property {(text: string | null) => void} wrong the same of the script
 */

const SPARE_MS = 500; // after a scene came, when workers for the next one are started

export class Opening {
  #state;
  #createPool;
  #shown;

  /** @param {State} state @param {() => Pool} createPool starts workers @param {Shown} shown */
  constructor(state, createPool, shown) {
    this.#state = state;
    this.#createPool = createPool;
    this.#shown = shown;
    state.pools.spare = createPool();
  }

  /** @param {string} name of a file of the gallery */
  async builtIn(name) {
    const { gallery } = this.#state, entry = gallery.find(({ file }) => file === name);
    if (!entry) {
      const known = gallery.map(({ file }) => file).join(", ");
      return this.#shown.message(`${name}: expected a built-in scene, one of ${known}`);
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
    // Relative addresses are the page's: the worker that reads is of another folder.
    const whole = typeof source === "string" ? new URL(source, location.href).href : source;
    return this.#replace({ ...opened, source: from }, (pool) => pool.read(name, whole, yUp, beside), this.#shown.message);
  }

  /** @param {string} text */
  script(text) {
    return this.#replace({ title: "Script" }, async (pool) => {
      return { script: text, warnings: await pool.open(described(text)) };
    }, this.#shown.wrong);
  }

  /** Shows a changed script, in the workers that have the one before if there is one. @param {string} text */
  async edit(text) {
    const state = this.#state, { edits, pools } = state;
    edits.newest = text;
    if (edits.busy) return;
    edits.busy = true;
    this.#shown.busy(true);
    while (edits.newest !== null) {
      const now = edits.newest;
      edits.newest = null;
      const same = pools.shown;
      if (!same || same.ended || state.scene.script === undefined) {
        await this.script(now);
        continue;
      }
      try {
        const warnings = await same.open(described(now));
        if (same !== pools.shown) continue;
        state.scene = { title: state.scene.title, script: now };
        state.statistics.exact = false;
        state.schedule.show(same);
        this.#shown.wrong(null);
        this.#shown.message(warnings.join(" ") || null);
        this.#shown.chosen();
      } catch (error) {
        this.#shown.wrong(messageOf(error));
      }
    }
    edits.busy = false;
    if (!pools.coming) this.#shown.busy(false);
  }

  /**
   * Opens a scene in workers of its own.
   *
   * @param {OpenScene} opened
   * @param {(pool: Pool) => Promise<import("../workers/reader.js").Summary>} open
   * @param {(text: string | null) => void} complain says what is wrong, null where nothing is
   */
  async #replace(opened, open, complain) {
    const state = this.#state, { pools } = state;
    pools.coming?.end();
    const mine = pools.coming = pools.spare ?? this.#createPool();
    pools.spare = undefined;
    this.#shown.busy(true);
    try {
      const { script, warnings } = await open(mine);
      if (mine !== pools.coming) return;
      pools.shown?.end();
      pools.shown = mine, pools.coming = undefined;
      state.scene = { ...opened, script: script ?? undefined };
      this.#shown.opened();
      complain(null);
      this.#shown.message(warnings.join(" ") || null);
      state.statistics.exact = false;
      state.schedule.show(mine);
    } catch (error) {
      if (mine !== pools.coming) return;
      pools.coming = undefined;
      mine.end();
      complain(messageOf(error));
    } finally {
      if (!pools.coming) this.#shown.busy(false);
      setTimeout(() => (pools.spare ??= this.#createPool()), SPARE_MS);
      this.#shown.chosen();
    }
  }
}

/** @param {string} text of a script @returns {import("../tracing/description.js").SceneDescription} */
const described = (text) => ({ shapes: [{ kind: "script", source: text }], instances: [{ shape: 0 }] });

/** @param {unknown} error */
const messageOf = (error) => (error instanceof Error ? error.message : String(error));

/** @param {URL} address */
export const fileName = ({ pathname }) => decodeURIComponent(pathname.replace(/^.*\//, ""));

/** @param {string} text */
export const capitalised = (text) => text[0].toUpperCase() + text.slice(1);
