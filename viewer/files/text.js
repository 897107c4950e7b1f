// @ts-check
/** Texts in JSON. */

/** What a text in JSON holds, which has to be UTF-8. @param {ArrayBuffer | Uint8Array} bytes @returns {any} */
export function jsonOf(bytes) {
  return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
}
