// @ts-check
/** Errors about unusable input, and the checks that throw them: name, expected, got. */

/** The line number at the start of the core's messages. */
const LINE = /^line (\d+)/;

/** An input error, in one line. */
export class CoreError extends Error {
  /** @param {string} message @param {number | null} [line] from 1; by default the line at the start of the message */
  constructor(message, line = Number(LINE.exec(message)?.[1] ?? 0) || null) {
    super(message);
    /** The line of the error in a script or formula, from 1; null if it has no line. */
    this.line = line;
  }
}

/**
 * Returns f(), and prefixes its CoreErrors with the place: "shapes[2]: expected ...".
 *
 * @template T
 * @param {string} place
 * @param {() => T} f
 * @returns {T}
 */
export function placedErrors(place, f) {
  try {
    return f();
  } catch (error) {
    throw error instanceof CoreError ? new CoreError(`${place}: ${error.message}`, error.line) : error;
  }
}

/** Maximum length of a line, as in bobrossnet.support.messages.one_line. */
const MOST_LETTERS = 200;

/** @param {string} text at most MOST_LETTERS are kept */
export function oneLine(text) {
  const letters = [...text.replace(/[\p{C}\p{Z}\s]+/gu, " ").trim()];
  return (letters.length <= MOST_LETTERS ? letters : [...letters.slice(0, MOST_LETTERS - 3), "..."]).join("");
}

/** A short text for a value. @param {unknown} value */
export function brief(value) {
  const text = Array.isArray(value) ? `a list of ${value.length}` : value === null ? "null"
    : typeof value === "object" ? "an object" : `${typeof value} ${JSON.stringify(value)}`;
  return text.length <= 60 ? text : `${text.slice(0, 57)}...`;
}

/** @param {string} name @param {unknown} value @param {number} low @param {number} high @returns {number} */
export function checkInteger(name, value, low, high) {
  if (typeof value !== "number" || !Number.isInteger(value)) {
    throw new CoreError(`${name}: expected an integer, got ${brief(value)}`);
  }
  if (!(low <= value && value <= high)) {
    throw new CoreError(`${name}: expected an integer in ${low}..${high}, got ${value}`);
  }
  return value;
}

/** @param {string} name @param {unknown} value @param {number} low @param {number} high @returns {number} */
export function checkNumber(name, value, low, high) {
  if (typeof value !== "number") throw new CoreError(`${name}: expected a number, got ${brief(value)}`);
  if (!(low <= value && value <= high)) {
    throw new CoreError(`${name}: expected a number in [${low}, ${high}], got ${value}`);
  }
  return value;
}

/** Checks that all numbers are finite. @template {ArrayLike<number>} T @param {string} name @param {T} array @returns {T} */
export function checkFinite(name, array) {
  let bad = 0;
  for (let i = 0; i < array.length; ++i) if (!Number.isFinite(array[i])) ++bad;
  if (bad) throw new CoreError(`${name}: expected finite numbers, got ${bad} of ${array.length} NaN or infinite`);
  return array;
}

/** @param {string} name @param {unknown} value @returns {any[]} */
export function checkList(name, value) {
  if (!Array.isArray(value)) throw new CoreError(`${name}: expected a list, got ${brief(value)}`);
  return value;
}

/**
 * Checks that an object has exactly these fields.
 *
 * @param {string} name
 * @param {any} value
 * @param {...string} fields
 * @returns {any}
 */
export function checkFields(name, value, ...fields) {
  const got = typeof value === "object" && value && !Array.isArray(value) ? Object.keys(value) : null;
  if (got?.length !== fields.length || !fields.every((field) => got.includes(field))) {
    const what = got ? got.join(", ") || "nothing in it" : brief(value);
    throw new CoreError(`${name}: expected an object of ${fields.join(", ")}, got ${what}`);
  }
  return value;
}
