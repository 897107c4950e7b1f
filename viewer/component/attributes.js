// @ts-check
/** The right values of attributes, in words. */
import { HOME } from "../picture/camera.js";
import { LIMITS } from "./limits.js";
import { anglesOf, degrees, fromFieldOfView, orbitOf, toCameraOrbit } from "./words.js";

export const LIGHTS = ["scene", "headlight", "studio"];

/** @typedef {[expected: string, isRight: (value: string) => boolean]} Form */

/** @param {string} expected @param {(value: number) => boolean} isRight @returns {Form} */
const number = (expected, isRight) => [expected, (value) => value.trim() !== "" && Number.isFinite(Number(value)) && isRight(Number(value))];

/** @param {string} example @returns {Form} */
const angle = (example) => [`an angle, such as ${example}`, (value) => fromFieldOfView(value) !== null];

/** @param {string} example @returns {Form} */
const orbit = (example) => [`angles and a share, such as ${example}`, (value) => orbitOf(value) !== null];

/** @type {Record<string, Form>} */
const FORMS = {
  "up": ["y or z", (value) => value === "y" || value === "z"],
  "orientation": ["three angles, such as 0deg 90deg 0deg", (value) => anglesOf(value) !== null],
  "camera-orbit": orbit(toCameraOrbit(HOME)),
  "field-of-view": angle("35deg"),
  ...Object.fromEntries(LIMITS.map((name) => [name, /orbit/.test(name) ? orbit("auto 30deg 50%") : angle("20deg")])),
  "auto-rotate-delay": number("milliseconds", (value) => value >= 0),
  "rotation-per-second": ["an angle, such as 30deg", (value) => degrees(value) !== null],
  "exposure": number("a number of at least 0", (value) => value >= 0),
  "light": [`${LIGHTS.slice(0, -1).join(", ")} or ${LIGHTS.at(-1)}`, (value) => LIGHTS.includes(value)],
  "picture-size": ["a width and a height in pixels, such as 640x480", (value) => /^[1-9]\d*x[1-9]\d*$/.test(value)],
  "samples": number("a number of at least 1", (value) => value >= 1),
  "workers": number("a number of at least 1", (value) => value >= 1),
  "snap": ["a number of CSS pixels, or nothing", (value) => value === "" || (Number(value) > 0 && Number(value) < Infinity)],
};

/**
 * What an attribute should have, if it has a wrong value.
 *
 * @param {string} name @param {string | null} value null if it is not set
 * @returns {string | null} null for a right value
 */
export function expectation(name, value) {
  if (value === null || !Object.hasOwn(FORMS, name)) return null;
  const [expected, isRight] = FORMS[name];
  return isRight(value) ? null : expected;
}
