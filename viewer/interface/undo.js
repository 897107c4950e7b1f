// @ts-check
/** Undo and redo of a text area, including changes by scripts, which end the browser's own history. */

const MOST = 500; // states
const PAUSE_MS = 1000; // between strokes of one step

export class Undo {
  /** @type {string[]} */
  #states = [""];
  #at = 0;
  #kind = "";
  #time = -Infinity;

  /** Forgets all states but this one. @param {string} text */
  begin(text) {
    this.#states = [text];
    this.#at = 0;
    this.end();
  }

  /**
   * Records a change. Changes of one kind in quick succession are one step.
   *
   * @param {string} text after it
   * @param {string} kind
   * @param {number} now in milliseconds
   */
  record(text, kind, now) {
    const continues = kind === this.#kind && now < this.#time + PAUSE_MS && this.#at > 0;
    this.#states.splice(this.#at + (continues ? 0 : 1), Infinity, text);
    if (this.#states.length > MOST) this.#states.shift();
    this.#at = this.#states.length - 1;
    this.#kind = kind;
    this.#time = now;
  }

  /** Ends a step. */
  end() {
    this.#kind = "";
  }

  /** @param {number} steps back if negative @returns {string | undefined} the text to show, if there is one */
  move(steps) {
    const text = this.#states[this.#at + steps];
    if (text === undefined) return undefined;
    this.#at += steps;
    this.end();
    return text;
  }
}

/** The steps that keys ask for: -1 to undo, 1 to redo, else 0. @param {KeyboardEvent} event */
export function stepsOf({ key, ctrlKey, metaKey, shiftKey, altKey }) {
  if (!(ctrlKey || metaKey) || altKey) return 0;
  const letter = key.toLowerCase();
  return letter === "z" ? (shiftKey ? 1 : -1) : letter === "y" && !shiftKey ? 1 : 0;
}

/** The end of the difference of two texts, in the second. @param {string} before @param {string} after */
export function endOfChange(before, after) {
  let same = 0;
  while (same < Math.min(before.length, after.length) && before.at(-1 - same) === after.at(-1 - same)) ++same;
  return after.length - same;
}
