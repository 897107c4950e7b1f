// @ts-check
/** Texts in JSON. */

/** The content of a text in JSON, which has to be UTF-8. @param {ArrayBuffer | Uint8Array} bytes @returns {any} */
export function jsonOf(bytes) {
  return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
}
