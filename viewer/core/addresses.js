// @ts-check
/** Addresses, of files on servers and of those that a file names, as people and programs write them. */

/** @param {string} text perhaps with escapes such as %20; one with others is taken as it is */
export function unescaped(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** @param {URL} address @returns {string} the name of its file */
export const fileName = ({ pathname }) => unescaped(pathname.replace(/^.*\//, ""));

/** @param {string} text @param {string} base @returns {URL | null} null if it is no address */
export function addressOf(text, base) {
  try {
    return new URL(text, base);
  } catch {
    return null;
  }
}
