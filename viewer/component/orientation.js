// @ts-check
/** The rotation of a file's scene, by the attributes `up` and `orientation`. Fetched where it is wanted. */
import { UPRIGHT, product, rotation } from "../shapes/affine.js";
import { anglesOf } from "./words.js";

const UPRIGHT_FORMATS = /\.(glb|gltf)$/i; // their readers turn y up to z up

/**
 * The rotation of a scene; invalid attributes turn nothing.
 *
 * @param {string} file its name
 * @param {string | null} up @param {string | null} orientation the attributes: roll, pitch and yaw, about the axes towards
 *   the viewer, to the right and up of the front view, in this order
 * @returns {import("../shapes/affine.js").Matrix | null}
 */
export function rotationOf(file, up, orientation) {
  const upright = up === "y" && !UPRIGHT_FORMATS.test(file) ? UPRIGHT : null, angles = anglesOf(orientation ?? "");
  if (!angles) return upright;
  const [roll, pitch, yaw] = angles, turn = product(rotation(2, yaw), product(rotation(0, pitch), rotation(1, -roll)));
  return upright ? product(turn, upright) : turn;
}
