// @ts-check
/** The control of the light: the camera's headlight or the studio. */

const HEADLIGHT = "headlight";

/** Behind the studio's shadows, unless the page has a background. */
const PAPER = "linear-gradient(#fff, #dde2e8)";

export class LightControl {
  #picture;
  #select;
  #stage;
  /** Display modes that need the exact picture of the headlight. */
  #modes;

  /**
   * @param {HTMLElement} picture a <bob-view>
   * @param {HTMLSelectElement} select
   * @param {HTMLElement} stage behind the picture
   * @param {HTMLInputElement[]} modes radio buttons
   */
  constructor(picture, select, stage, modes) {
    this.#picture = picture;
    this.#select = select;
    this.#stage = stage;
    this.#modes = modes;
    this.hasBackground = picture.hasAttribute("background");
    select.addEventListener("change", () => (this.light = select.value));
  }

  /** The attribute `light`; an unknown one is the headlight. @returns {string} */
  get light() {
    return this.#select.value;
  }

  set light(value) {
    this.#select.value = value;
    const isLit = this.#select.selectedIndex > 0;
    if (!isLit) this.#select.value = HEADLIGHT;
    this.#picture.setAttribute("light", this.light);
    for (const mode of this.#modes) {
      mode.disabled = isLit;
      if (isLit && mode.checked) /** @type {HTMLElement} */ (document.querySelector('input[value="completed"]')).click();
    }
    if (this.hasBackground) return;
    this.#picture.toggleAttribute("background", isLit);
    if (isLit) this.#picture.setAttribute("background", PAPER);
    this.#stage.style.background = isLit ? "none" : "";
  }
}
