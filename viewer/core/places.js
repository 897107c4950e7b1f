// @ts-check
/**
 * Addresses of separate files. The npm package replaces this module by one that names each file, in the form that
 * bundlers follow (src/bobrossnet/page/package.py).
 */

/** @param {string} path from the page's folder @returns {URL} */
export const placeOf = (path) => new URL(`../${path}`, import.meta.url);
