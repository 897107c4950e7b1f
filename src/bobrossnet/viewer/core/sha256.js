// @ts-check
/** SHA-256, which pages without https do not have by themselves. */

/** Bytes that are copied to the module at once. */
const PIECE = 1 << 20;

/** @param {import("./core.js").Core} core @param {Uint8Array} bytes @returns {Uint8Array} (32,) */
export function sha256(core, bytes) {
  const hash = core.made("make_sha256");
  for (let at = 0; at < bytes.length; at += PIECE) {
    const piece = bytes.subarray(at, at + PIECE);
    core.call("add_bytes", hash, piece, piece.length);
  }
  return core.filled(new Uint8Array(32), (address) => core.call("end_sha256", hash, address));
}
