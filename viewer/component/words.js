// @ts-check
/**
 * Cameras in the notation of <model-viewer>, such as "30deg 75deg 105%". The first angle is about the vertical, 0 for
 * the front of a glTF; the second is from straight above; the distance is 100 % for a view of everything.
 *
 * @typedef {import("../picture/camera.js").Camera} Camera
 */
import { HOME, PERSPECTIVE } from "../picture/camera.js";

/** Offset from our azimuth: the front of an upright glTF faces -y. */
const FRONT = 90;

/** Parses "30deg", "0.5rad" or "30" to degrees. @param {string} text @returns {number | null} */
export function degrees(text) {
  const match = /^([-+]?(?:\d+\.?\d*|\.\d+))(deg|rad|)$/.exec(text);
  return match && Number(match[1]) * (match[2] === "rad" ? 180 / Math.PI : 1);
}

/** Parses three angles to degrees. @param {string} text such as "0deg 90deg 0deg" @returns {number[] | null} null if invalid */
export function anglesOf(text) {
  const angles = text.trim().split(/\s+/).map(degrees);
  return angles.length === 3 && angles.every((angle) => angle !== null) ? /** @type {number[]} */ (angles) : null;
}

/**
 * Parses an orbit; "auto" is undefined.
 *
 * @param {string | null} text
 * @returns {{azimuth?: number, elevation?: number, zoom?: number} | null} null if invalid
 */
export function orbitOf(text) {
  const words = text?.trim().split(/\s+/) ?? [];
  if (words.length !== 3) return null;
  const [theta, phi] = words.map((word) => (word === "auto" ? undefined : degrees(word)));
  const share = words[2] === "auto" ? undefined : Number(/^(\d+\.?\d*|\.\d+)%$/.exec(words[2])?.[1] ?? NaN);
  if (theta === null || phi === null || !(share === undefined || share > 0)) return null;
  return {
    azimuth: theta === undefined ? theta : theta - FRONT, elevation: phi === undefined ? phi : 90 - phi, zoom: share && 100 / share,
  };
}

/** @param {string | null} text each of the three may be "auto" @returns {Partial<Camera> | null} null if invalid */
export function fromCameraOrbit(text) {
  const orbit = orbitOf(text);
  return orbit && { azimuth: orbit.azimuth ?? HOME.azimuth, elevation: orbit.elevation ?? HOME.elevation, zoom: orbit.zoom ?? 1 };
}

/** @param {Camera} camera @returns {string} */
export function toCameraOrbit({ azimuth, elevation, zoom }) {
  const [theta, phi, share] = [(azimuth + FRONT) % 360, 90 - elevation, 100 / zoom].map((value) => Number(value.toPrecision(6)));
  return `${theta}deg ${phi}deg ${share}%`;
}

/**
 * @param {string | null} text an angle; "auto" suits most scenes, "0deg" is orthographic
 * @returns {number | null} degrees; null if invalid
 */
export function fromFieldOfView(text) {
  return text === null ? null : text.trim() === "auto" ? PERSPECTIVE : degrees(text.trim());
}
