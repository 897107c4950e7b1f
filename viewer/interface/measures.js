// @ts-check
/** Measures as texts, with their unit. */

const DIGITS = 6;
const MEASURED_DIGITS = 5; // of sizes that rays find

/** @param {number} value @param {number} [digits] */
export const numberOf = (value, digits = DIGITS) => String(Number(value.toPrecision(digits)));

/** @param {number} value @param {string | null} unit @param {string} [power] */
export const lengthOf = (value, unit, power = "") => numberOf(value) + (unit ? ` ${unit}${power}` : "");

/** Terms and values. @param {import("../component/parts.js").Measures} measures @returns {[string, string][]} */
export function measuresOf({ size, area, volume, unit }) {
  const sides = size.map((side) => numberOf(side, area === null ? MEASURED_DIGITS : DIGITS)), text = sides.join(" × ") + (unit ? ` ${unit}` : "");
  const found = [/** @type {[string, string]} */ (["Size", text])];
  if (area !== null) found.push(["Area", lengthOf(area, unit, "²")], ["Volume", volume === null ? "open" : lengthOf(volume, unit, "³")]);
  return found;
}
