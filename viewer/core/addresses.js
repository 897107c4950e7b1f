// @ts-check
/** Addresses of files on servers, and of files referenced by other files, as people and programs write them. */

/** @param {string} text possibly with escapes such as %20; unchanged if an escape is invalid */
function unescaped(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

const ENDING = /\.\w+$/;

/** Endings of media types, for data without a name. @type {Record<string, string>} */
const MEDIA = {
  "model/gltf-binary": ".glb", "model/gltf+json": ".gltf", "model/stl": ".stl", "model/obj": ".obj", "model/ply": ".ply",
  "application/sla": ".stl", "application/vnd.ms-pki.stl": ".stl", "model/x.stl-binary": ".stl", "model/x.stl-ascii": ".stl",
};

/**
 * The name of an address's file: of its path; if that has no ending, of the fragment, as in blob:...#part.glb; or by the
 * media type of data.
 *
 * @param {URL} address @returns {string}
 */
export function fileName({ protocol, pathname, hash }) {
  const data = protocol === "data:" ? /^[^;,]*/.exec(pathname)?.[0] ?? "" : null;
  const name = data === null ? unescaped(pathname.replace(/^.*\//, "")) : "data", named = unescaped(hash.replace(/^.*[#/]/, ""));
  if (ENDING.test(name)) return name;
  return ENDING.test(named) ? named : name + (MEDIA[data ?? ""] ?? "");
}

/** @param {string} text @param {string} base @returns {URL | null} null if invalid */
export function addressOf(text, base) {
  try {
    return new URL(text, base);
  } catch {
    return null;
  }
}
