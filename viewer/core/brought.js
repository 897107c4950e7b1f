// @ts-check
/**
 * Contents embedded in a page of a single file: empty here, where the parts are separate files. For a single file,
 * src/bobrossnet/page/joining.py generates this module.
 *
 * @type {{workers: Record<string, string>, parts: Record<string, string>}} workers: source texts by name; parts: bytes,
 *   deflated and in base64, by path from the page's folder
 */
export const BROUGHT = { workers: {}, parts: {} };
