// @ts-check
/** The control of the light: the scene's own lights if it has some, the camera's headlight, or the studio. */

export class LightControl {
  #picture;
  #select;
  /** Display modes that need the exact picture of the headlight. */
  #modes;

  /**
   * @param {import("../component/bob-view.js").BobView} picture
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
    const light = this.#picture.getAttribute("light") ?? "scene";
    return light === "headlight" && !this.#picture.viewing.isSceneLit ? "scene" : light;
  }

  set light(value) {
    this.#picture.setAttribute("light", value === "studio" || value === "headlight" ? value : "scene");
    this.#show();
  }

  /** A scene was opened. */
  opened() {
    this.#select.options[0].hidden = !this.#picture.viewing.isSceneLit;
    this.#show();
  }

  #show() {
    const { isLit } = this.#picture.viewing;
    this.#select.value = isLit ? this.light : "headlight";
    for (const mode of this.#modes) {
      mode.disabled = isLit;
      if (isLit && mode.checked) /** @type {HTMLElement} */ (document.querySelector('input[value="completed"]')).click();
    }
  }
}
