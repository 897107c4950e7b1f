// @ts-check
/** Names of the features that points snap to; bobrossnet.measuring.measure has the same. */

const DIGITS = 6;

const WORDS = { corner: "corner", center: "centre of a circle", middle: "middle of an edge", edge: "edge" };

/**
 * @param {import("../tracing/scene.js").Snap["kind"] | null} kind
 * @param {number | null} radius of the circle whose centre or edge it is @param {string | null} unit
 */
export function inWords(kind, radius, unit) {
  if (kind === null) return "point";
  if (radius === null) return WORDS[kind];
  return `${kind === "center" ? "centre" : "edge"} of a circle, radius ${Number(radius.toPrecision(DIGITS))}${unit ? ` ${unit}` : ""}`;
}
