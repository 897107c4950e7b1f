// @ts-check
/** Measures as texts, with their unit. */

const DIGITS = 6;

/** A number with six digits. @param {number} value */
export const numberOf = (value) => String(Number(value.toPrecision(DIGITS)));

/** @param {number} value @param {string | null} unit @param {string} [power] */
export const lengthOf = (value, unit, power = "") => numberOf(value) + (unit ? ` ${unit}${power}` : "");

/** Terms and values. @param {import("../component/parts.js").Measures} measures @returns {[string, string][]} */
export function measuresOf({ size, area, volume, unit }) {
  const found = [/** @type {[string, string]} */ (["Size", size.map(numberOf).join(" × ") + (unit ? ` ${unit}` : "")])];
  if (area !== null) found.push(["Area", lengthOf(area, unit, "²")], ["Volume", volume === null ? "open" : lengthOf(volume, unit, "³")]);
  return found;
}
