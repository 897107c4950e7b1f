// @ts-check
/** Measures as texts, with their unit. */

const DIGITS = 6;
const ROUNDING = 4e-7; // of the scene's radius: rays are single precision
const MEASURED_DIGITS = 5; // of sizes that rays find

/** @param {number} value @param {number} [digits] */
export const numberOf = (value, digits = DIGITS) => String(Number(value.toPrecision(digits)));

/** @param {number[]} values coordinates @param {number} radius of the scene */
export function coordinatesOf(values, radius) {
  return values.map((value) => numberOf(Math.abs(value) < ROUNDING * radius ? 0 : value)).join(", ");
}

/** @param {number[]} values of a unit vector */
export const directionOf = (values) => values.map((value) => value.toFixed(3).replace(/^-(?=[.0]*$)/, "")).join(", ");

/** @param {number} value @param {string | null} unit @param {string} [power] */
export const lengthOf = (value, unit, power = "") => numberOf(value) + (unit ? ` ${unit}${power}` : "");

/** Terms and values. @param {import("../component/parts.js").Measures} measures @returns {[string, string][]} */
export function measuresOf({ size, area, volume, unit }) {
  const sides = size.map((side) => numberOf(side, area === null ? MEASURED_DIGITS : DIGITS)), text = sides.join(" × ") + (unit ? ` ${unit}` : "");
  const found = [/** @type {[string, string]} */ (["Size", text])];
  if (area !== null) found.push(["Area", lengthOf(area, unit, "²")], ["Volume", volume === null ? "open" : lengthOf(volume, unit, "³")]);
  return found;
}
