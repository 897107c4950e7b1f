// @ts-check
/** Properties that reflect attributes: `cameraOrbit` reflects `camera-orbit`. */

/** @param {string} name of an attribute */
const camelCase = (name) => name.replace(/-(.)/g, (_, letter) => letter.toUpperCase());

/**
 * @param {typeof HTMLElement} type
 * @param {string[]} texts attributes with a text or null
 * @param {string[]} switches attributes with a boolean
 */
export function reflect(type, texts, switches) {
  for (const name of texts) {
    Object.defineProperty(type.prototype, camelCase(name), {
      configurable: true, enumerable: true,
      get() {
        return this.getAttribute(name);
      },
      set(value) {
        if (value === null || value === undefined) this.removeAttribute(name);
        else this.setAttribute(name, value);
      },
    });
  }
  for (const name of switches) {
    Object.defineProperty(type.prototype, camelCase(name), {
      configurable: true, enumerable: true,
      get() {
        return this.hasAttribute(name);
      },
      set(value) {
        this.toggleAttribute(name, Boolean(value));
      },
    });
  }
}
