// @ts-check
/** Edited scripts of this tab: they survive reloading the page and choosing another scene. */

const KEY = "bobrossnet.edits";

/** @typedef {{current: string | null, scripts: Record<string, string>}} Edits current: the title of the displayed one */

/** Pages without an origin have no storage. @returns {Edits} */
function stored() {
  try {
    const { current, scripts } = JSON.parse(sessionStorage.getItem(KEY) ?? "");
    return { current, scripts };
  } catch {
    return { current: null, scripts: {} };
  }
}

export class Kept {
  #edits = stored();

  get titles() {
    return Object.keys(this.#edits.scripts);
  }

  /** The title of the script displayed when the page was reloaded, else null. */
  get reloaded() {
    const [navigation] = performance.getEntriesByType("navigation");
    const isReloaded = navigation instanceof PerformanceNavigationTiming && navigation.type !== "navigate";
    return isReloaded ? this.#edits.current : null;
  }

  /** @param {string} title @returns {string | undefined} */
  script(title) {
    return Object.hasOwn(this.#edits.scripts, title) ? this.#edits.scripts[title] : undefined;
  }

  /** The title with a number, if another script has it. @param {string} title */
  free(title) {
    let free = title;
    for (let i = 2; this.script(free) !== undefined; ++i) free = `${title} ${i}`;
    return free;
  }

  /** @param {string} title @param {string} script the edited one */
  keep(title, script) {
    this.#edits.scripts[title] = script;
    this.display(title);
  }

  /** @param {string | null} title of the displayed script, null if another scene is displayed */
  display(title) {
    this.#edits.current = title;
    try {
      sessionStorage.setItem(KEY, JSON.stringify(this.#edits));
    } catch {
      // Full or unavailable: then edits last as long as the page.
    }
  }
}
