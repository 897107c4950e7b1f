// @ts-check
/** Views in words. Fetched after the first movement. @typedef {import("../picture/camera.js").Camera} Camera */

const SIDES = ["right", "back right", "back", "back left", "left", "front left", "front", "front right"];
const STEEP = 75; // degrees, above which sides no longer matter

/** The view in words, for screen readers. @param {Camera} camera @returns {string} such as "View from the front, 20 degrees above" */
export function inWords({ azimuth, elevation, zoom, fov }) {
  const side = SIDES[Math.round(azimuth / 45) % 8], degrees = Math.round(Math.abs(elevation)), way = elevation < 0 ? "below" : "above";
  const from = degrees > STEEP ? way : degrees ? `the ${side}, ${degrees} degrees ${way}` : `the ${side}`;
  const zoomed = Math.abs(zoom - 1) < 0.005 ? "" : `, enlarged ${Number(zoom.toPrecision(2))} times`;
  return `View from ${from}${zoomed}${fov ? ", in perspective" : ""}`;
}
