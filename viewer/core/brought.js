// @ts-check
/**
 * What a page of a single file brings with it: nothing here, where its parts are files beside each other. Where there is one file,
 * src/bobrossnet/page/joining.py writes this module anew.
 *
 * @type {{workers: Record<string, string>, parts: Record<string, string>}} workers: the text of each, by its name; parts:
 *   bytes, deflated and in base64, by their paths from the page's folder
 */
export const BROUGHT = { workers: {}, parts: {} };
