// @ts-check
/** The editor of a shape script: line numbers, the line in error, sliders for named numbers, and undo of both. */
import { Undo, endOfChange, stepsOf } from "./undo.js";

/** A line that names a number: `HEIGHT = 4  # in metres`. */
const NAMED = /^([A-Za-z_]\w*)[ \t]*=[ \t]*(-?\d+(?:\.\d*)?|-?\.\d+)[ \t]*(?:#[ \t]*(.*))?$/;

/** @param {string} text of a number @returns {{min: number, max: number, step: number}} the range of its slider */
function range(text) {
  const value = Number(text), whole = /^-?\d+$/.test(text), size = Math.abs(value) || 1;
  const low = whole && value > 0 ? 1 : 0, high = whole ? Math.max(2 * size, 4) : 2 * size;
  const step = whole ? 1 : 10 ** Math.floor(Math.log10(size / 20));
  return value > 0 ? { min: low, max: high, step } : { min: -high, max: value < 0 ? 0 : high, step };
}

export class Editor {
  #text;
  #numbers;
  #sliders;
  #error;
  #changed;
  #undo = new Undo();

  /**
   * @param {{text: HTMLTextAreaElement, numbers: HTMLElement, sliders: HTMLElement, error: HTMLElement}} elements
   * @param {(script: string) => void} changed called after each change of the text here
   */
  constructor({ text, numbers, sliders, error }, changed) {
    this.#text = text, this.#numbers = numbers, this.#sliders = sliders, this.#error = error, this.#changed = changed;
    text.addEventListener("input", (event) => {
      this.#undo.record(text.value, event instanceof InputEvent ? event.inputType : "", event.timeStamp);
      this.#number();
      this.#offer();
      changed(text.value);
    });
    text.addEventListener("beforeinput", (event) => {
      const steps = { historyUndo: -1, historyRedo: 1 }[event.inputType];
      if (steps) this.#move(event, steps);
    });
    for (const part of [text, sliders]) {
      part.addEventListener("keydown", (event) => {
        const steps = stepsOf(event);
        if (steps) this.#move(event, steps);
      });
    }
    text.addEventListener("scroll", () => (numbers.scrollTop = text.scrollTop));
  }

  get script() {
    return this.#text.value;
  }

  set script(script) {
    this.#text.value = script;
    this.#text.scrollTop = 0;
    this.#undo.begin(script);
    this.#number();
    this.#offer();
    this.wrong(null);
  }

  /** Undoes or redoes. @param {Event} event that asks for it @param {number} steps */
  #move(event, steps) {
    event.preventDefault();
    const before = this.#text.value, after = this.#undo.move(steps);
    if (after === undefined) return;
    const sliders = [...this.#sliders.querySelectorAll("input")], focused = sliders.findIndex((slider) => slider === document.activeElement);
    this.#text.value = after;
    this.#text.selectionStart = this.#text.selectionEnd = endOfChange(before, after);
    this.#number();
    this.#offer();
    if (focused >= 0) this.#sliders.querySelectorAll("input")[focused]?.focus();
    this.#changed(after);
  }

  /** Marks an error; null removes the mark. @param {string | null} message possibly beginning with "line 3, column 7: " */
  wrong(message) {
    const line = Number(/^line (\d+)/.exec(message ?? "")?.[1]);
    this.#error.textContent = message ?? "";
    this.#text.setAttribute("aria-invalid", String(message !== null));
    [...this.#numbers.children].forEach((number, i) => number.classList.toggle("wrong", i + 1 === line));
  }

  #number() {
    const count = this.#text.value.split("\n").length;
    while (this.#numbers.childElementCount > count) this.#numbers.lastElementChild?.remove();
    while (this.#numbers.childElementCount < count) {
      const number = document.createElement("span");
      number.textContent = String(this.#numbers.childElementCount + 1);
      this.#numbers.append(number);
    }
  }

  /** Makes a slider for each named number. */
  #offer() {
    const found = this.#text.value.split("\n").flatMap((line, i) => {
      const match = NAMED.exec(line.trimEnd());
      return match ? [{ line: i, name: match[1], value: match[2], comment: match[3] }] : [];
    });
    this.#sliders.replaceChildren(...found.map(({ line, name, value, comment }) => {
      const label = document.createElement("label"), slider = document.createElement("input");
      const shown = document.createElement("output");
      Object.assign(slider, { type: "range", ...range(value) });
      slider.value = value;
      shown.value = value;
      label.title = comment ?? "";
      label.append(name, slider, shown);
      slider.addEventListener("change", () => this.#undo.end());
      slider.addEventListener("input", (event) => {
        shown.value = slider.value;
        const lines = this.#text.value.split("\n");
        lines[line] = lines[line].replace(/(=[ \t]*)[-.\d]+/, `$1${slider.value}`);
        this.#text.value = lines.join("\n");
        this.#undo.record(this.#text.value, `slider ${name}`, event.timeStamp);
        this.#changed(this.#text.value);
      });
      return label;
    }));
  }
}
