// @ts-check
/** The rotation of a file's scene, by the attributes `up` and `orientation`. Fetched where it is wanted. */
import { UPRIGHT, product, rotation } from "../shapes/affine.js";
import { degrees } from "./words.js";

const UPRIGHT_FORMATS = /\.(glb|gltf)$/i; // their readers turn y up to z up

/**
 * The rotation of a scene, from roll, pitch and yaw: about the axes towards the viewer, to the right and up of the front
 * view, in this order.
 *
 * @param {string} text such as "0deg 90deg 0deg"
 * @returns {number[] | null} null if invalid
 */
function fromOrientation(text) {
  const [roll, pitch, yaw, ...others] = text.trim().split(/\s+/).map(degrees);
  if (others.length > 0 || typeof roll !== "number" || typeof pitch !== "number" || typeof yaw !== "number") return null;
  return product(rotation(2, yaw), product(rotation(0, pitch), rotation(1, -roll)));
}

/**
 * @param {string} file its name
 * @param {string | null} up @param {string | null} orientation the attributes
 * @returns {import("../shapes/affine.js").Matrix | null}
 * @throws {Error} of one sentence, if an attribute is invalid
 */
export function rotationOf(file, up, orientation) {
  if (up !== null && up !== "y" && up !== "z") throw new Error(`up: expected y or z, got ${up}`);
  const upright = up === "y" && !UPRIGHT_FORMATS.test(file) ? UPRIGHT : null;
  if (orientation === null) return upright;
  const turn = fromOrientation(orientation);
  if (!turn) throw new Error(`orientation: expected three angles, such as 0deg 90deg 0deg, got ${orientation}`);
  return upright ? product(turn, upright) : turn;
}
