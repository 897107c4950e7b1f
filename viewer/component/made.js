// @ts-check
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
