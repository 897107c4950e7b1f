// @ts-check
/** Text files, line by line. */

/**
 * Text of whatever encoding: what is not UTF-8 in names and comments does not matter.
 *
 * @param {ArrayBuffer | Uint8Array} bytes
 */
export function textOf(bytes) {
  const text = new TextDecoder().decode(bytes);
  return text.includes("\r") ? text.replace(/\r\n?/g, "\n") : text;
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
