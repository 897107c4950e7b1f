// @ts-check
/** Text files, line by line. */

import { CoreError, brief } from "../core/errors.js";

/**
 * Text of whatever encoding: what is not UTF-8 in names and comments does not matter.
 *
 * @param {ArrayBuffer | Uint8Array} bytes
 */
export function textOf(bytes) {
  const text = new TextDecoder().decode(bytes);
  return text.includes("\r") ? text.replace(/\r\n?/g, "\n") : text;
}

/** What a text in JSON holds, which has to be UTF-8. @param {ArrayBuffer | Uint8Array} bytes @returns {any} */
export function jsonOf(bytes) {
  return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
}

const NINE = 57;

/** A number, as Python reads them. @param {string} word */
export function numberOf(word) {
  const number = Number(word);
  // 0x10 and the like, which are no decimals, have a letter second; so has 1e3.
  if (!Number.isNaN(number) && !(word.charCodeAt(1) > NINE && /^0[box]/i.test(word))) return number;
  if (/^[-+]?nan$/i.test(word)) return NaN;
  if (/^[-+]?inf(inity)?$/i.test(word)) return word.startsWith("-") ? -Infinity : Infinity;
  const grouped = word.replace(/([0-9])_(?=[0-9])/g, "$1");  // 1_000
  if (grouped === word) throw new CoreError(`expected numbers, got others (${brief(word)})`);
  return numberOf(grouped);
}

/**
 * The words of each line that has some, one line after the other.
 *
 * @param {string} text
 * @param {string} [comment] begins one
 */
export function* wordsOfLines(text, comment) {
  for (let at = 0; at < text.length;) {
    const end = text.indexOf("\n", at), line = text.slice(at, end < 0 ? text.length : end);
    const words = (comment ? line.split(comment, 1)[0] : line).trim();
    if (words) yield words.split(/\s+/);
    at = end < 0 ? text.length : end + 1;
  }
}
