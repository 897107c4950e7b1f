// @ts-check
/** The control of the light: the scene's own lights if it has some, the camera's headlight, or the studio. */

/** @typedef {import("../component/viewing.js").LightName} LightName */

export class LightControl {
  #picture;
  #select;
  /** Display modes that need the exact picture of the headlight. */
  #modes;
  /** @type {LightName} */
  #light = "scene";
  #isSceneLit = false;

  /**
   * @param {HTMLElement} picture a <bob-view>
   * @param {HTMLSelectElement} select its first option is the scene's lights
   * @param {HTMLInputElement[]} modes radio buttons
   */
  constructor(picture, select, modes) {
    this.#picture = picture;
    this.#select = select;
    this.#modes = modes;
    select.addEventListener("change", () => (this.light = select.value));
  }

  /** The attribute `light`; "scene" if that is the same. An unknown one is "scene". @returns {string} */
  get light() {
    return this.#light === "headlight" && !this.#isSceneLit ? "scene" : this.#light;
  }

  set light(value) {
    this.#light = value === "studio" || value === "headlight" ? value : "scene";
    this.#picture.setAttribute("light", this.#light);
    this.#show();
  }

  /** A scene was opened. @param {boolean} isLit whether it has lights of its own */
  opened(isLit) {
    this.#isSceneLit = isLit;
    this.#select.options[0].hidden = !isLit;
    this.#show();
  }

  #show() {
    const isOwn = this.#light === "scene" && this.#isSceneLit, isLit = isOwn || this.#light === "studio";
    this.#select.value = isLit ? this.#light : "headlight";
    for (const mode of this.#modes) {
      mode.disabled = isLit;
      if (isLit && mode.checked) /** @type {HTMLElement} */ (document.querySelector('input[value="completed"]')).click();
    }
  }
}
