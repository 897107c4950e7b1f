// @ts-check
/** Elements and styles of the picture's controls. */

/**
 * An element with these fields and children.
 *
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} name @param {Partial<HTMLElementTagNameMap[T]>} [fields] @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function made(name, fields = {}, ...children) {
  const element = Object.assign(document.createElement(name), fields);
  element.append(...children);
  return element;
}

/** @param {string} name @param {...Element} children */
export function madeSvg(name, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  element.append(...children);
  return element;
}

/** Adds a sheet of styles. @param {ShadowRoot} root @param {string} text */
export function addStyle(root, text) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  root.adoptedStyleSheets.push(sheet);
  return sheet;
}
