// @ts-check
/** Addresses of files on servers, and of files referenced by other files, as people and programs write them. */

/** @param {string} text possibly with escapes such as %20; unchanged if an escape is invalid */
export function unescaped(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** @param {URL} address @returns {string} the name of its file */
export const fileName = ({ pathname }) => unescaped(pathname.replace(/^.*\//, ""));

/** @param {string} text @param {string} base @returns {URL | null} null if invalid */
export function addressOf(text, base) {
  try {
    return new URL(text, base);
  } catch {
    return null;
  }
}
