// @ts-check
/** Limits of the camera, as attributes of <model-viewer>: `min-camera-orbit` and so on. */
import { fromFieldOfView, orbitOf } from "./words.js";

/** @typedef {import("../picture/camera.js").Camera} Camera */

/** Attributes, which the element observes. */
export const LIMITS = ["min-camera-orbit", "max-camera-orbit", "min-field-of-view", "max-field-of-view"];

/** @param {number} value @param {number} [low] @param {number} [high] */
const within = (value, low = -Infinity, high = Infinity) => Math.max(low, Math.min(high, value));

/**
 * @param {Camera} camera
 * @param {(name: string) => string | null} attribute invalid ones limit nothing
 * @returns {Camera} as close as the limits allow
 */
export function limited(camera, attribute) {
  const [low, high] = ["min-camera-orbit", "max-camera-orbit"].map((name) => orbitOf(attribute(name)) ?? {});
  const [narrow, wide] = ["min-field-of-view", "max-field-of-view"].map((name) => fromFieldOfView(attribute(name)) ?? undefined);
  const { azimuth, elevation, zoom, fov } = camera;
  // Turns are counted from the middle, so that each end is the nearer one.
  const middle = ((low.azimuth ?? -Infinity) + (high.azimuth ?? Infinity)) / 2;
  const from = Number.isFinite(middle) ? middle + ((azimuth - middle) % 360 + 540) % 360 - 180 : azimuth;
  return {
    ...camera, azimuth: Number.isFinite(middle) ? within(from, low.azimuth, high.azimuth) : azimuth,
    elevation: within(elevation, high.elevation, low.elevation), zoom: within(zoom, high.zoom, low.zoom),
    fov: fov ? within(fov, narrow, wide) : 0,
  };
}
