// @ts-check
/** The lights of scene files (docs/reference/scene-files.md); src/bobrossnet/adapters/lights.py is its other half. */

import { CoreError, brief, checkFields, checkFinite, checkList, checkNumber } from "../core/errors.js";

/**
 * @typedef {import("../tracing/light.js").Environment} Environment
 * @typedef {import("../tracing/light.js").Lights} Lights
 * @typedef {import("../tracing/light.js").SceneLights} SceneLights
 */

/** The tensor of a sky's image. */
export const ENVIRONMENT = "environment";

const MAX_LIGHTS = 32, MAX_INTENSITY = 1e6; // as in bobrossnet.tracing.light

/** Maximum pixels of an environment: each worker has a copy. */
const MOST_TEXELS = 2048 * 1024;

/**
 * @param {string | undefined} text
 * @param {Float32Array | undefined} texels of an environment, (height, width, 3)
 * @param {number[] | undefined} shape
 * @returns {{lights: SceneLights | null, warnings: string[]}}
 */
export function readLights(text, texels, shape) {
  const content = text === undefined ? { lights: null, ground: null } : checkFields("light", JSON.parse(text), "lights", "ground");
  const { lights, ground } = content;
  if (ground !== null && typeof ground !== "boolean") throw new CoreError(`light.ground: expected true or false, got ${brief(ground)}`);
  if (lights === null || lights === "headlight" || lights === "studio") {
    if (texels) throw new CoreError(`${ENVIRONMENT}: expected float32, of a scene with a sky`);
    return { lights: lights && { lights, ground: ground ?? lights === "studio" }, warnings: [] };
  }
  if (!Array.isArray(lights)) throw new CoreError(`light.lights: expected a list, headlight or studio, got ${brief(lights)}`);
  /** @type {any[]} */
  const several = lights, skies = several.filter((light) => Object.hasOwn(Object(light), "top"));
  if (several.length > MAX_LIGHTS) throw new CoreError(`light: expected at most ${MAX_LIGHTS}, got ${several.length}`);
  if (skies.length > 1) throw new CoreError("light: expected at most one Sky, got several");
  if (texels && skies.length === 0) throw new CoreError(`${ENVIRONMENT}: expected a sky that has it`);
  /** @type {Lights} */
  const own = { discs: [], sky: [0, 0, 0, 0, 0, 0, 0], environment: null };
  several.forEach((light, i) => {
    if (skies.includes(light)) own.sky = sky(`light.lights[${i}]`, light);
    else own.discs.push(...disc(`light.lights[${i}]`, light));
  });
  /** @type {string[]} */
  const warnings = [];
  if (texels) {
    checkFinite(ENVIRONMENT, texels);
    if (texels.some((value) => value < 0)) throw new CoreError(`${ENVIRONMENT}: expected radiance of at least 0`);
    if (String(own.sky.slice(0, 3)) !== String(own.sky.slice(3, 6))) {
      throw new CoreError(`light.lights[${several.indexOf(skies[0])}].bottom: expected top's colour with an environment`);
    }
    const [height, width] = /** @type {number[]} */ (shape), whole = { height, width, texels };
    if (!(height > 0 && width > 0)) throw new CoreError(`${ENVIRONMENT}: expected at least one pixel, got ${width} x ${height}`);
    own.environment = reduced(whole);
    if (own.environment !== whole) {
      warnings.push(`${ENVIRONMENT}: ${width} x ${height} pixels are reduced to ${own.environment.width} x ${own.environment.height} in the page`);
    }
  }
  return { lights: { lights: own, ground: ground ?? false }, warnings };
}

/** A disc's numbers in the core. @param {string} place @param {any} fields @returns {number[]} */
function disc(place, fields) {
  const { direction, angle, color, intensity } = checkFields(place, fields, "direction", "angle", "color", "intensity");
  const toward = three(`${place}.direction`, direction, -Infinity, Infinity), length = Math.hypot(...toward);
  if (!(Math.abs(length - 1) < 1e-9)) throw new CoreError(`${place}.direction: expected unit length, got ${length}`);
  checkNumber(`${place}.angle`, angle, 0, 180);
  return [...toward, 2 * Math.sin(angle / 4 * Math.PI / 180) ** 2, ...scaled(`${place}.color`, color, `${place}.intensity`, intensity)];
}

/** A sky's numbers in the core. @param {string} place @param {any} fields @returns {number[]} */
function sky(place, fields) {
  const { top, bottom, turn, intensity } = checkFields(place, fields, "top", "bottom", "turn", "intensity");
  checkNumber(`${place}.turn`, turn, -1e6, 1e6);
  const of = (/** @type {string} */ name, /** @type {any} */ color) => scaled(`${place}.${name}`, color, `${place}.intensity`, intensity);
  return [...of("top", top), ...of("bottom", bottom), turn * Math.PI / 180];
}

/** @param {string} name @param {any} color @param {string} of @param {any} intensity @returns {number[]} */
function scaled(name, color, of, intensity) {
  checkNumber(of, intensity, 0, MAX_INTENSITY);
  return three(name, color, 0, 1).map((value) => intensity * value);
}

/** @param {string} name @param {any} values @param {number} low @param {number} high @returns {number[]} */
function three(name, values, low, high) {
  if (checkList(name, values).length !== 3) throw new CoreError(`${name}: expected three numbers, got ${values.length}`);
  for (const value of values) checkNumber(name, value, low, high);
  return values;
}

/** An environment of at most `MOST_TEXELS`: means over squares of pixels. @param {Environment} whole @returns {Environment} */
function reduced(whole) {
  const step = Math.ceil(Math.sqrt(whole.height * whole.width / MOST_TEXELS));
  if (step <= 1) return whole;
  const height = Math.floor(whole.height / step) || 1, width = Math.floor(whole.width / step) || 1, texels = new Float32Array(3 * height * width);
  const rows = whole.height / height, columns = whole.width / width;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const sum = [0, 0, 0], [top, bottom] = [y, y + 1].map((i) => Math.floor(i * rows)), [left, right] = [x, x + 1].map((i) => Math.floor(i * columns));
      for (let i = top; i < bottom; ++i) {
        for (let j = left; j < right; ++j) for (let c = 0; c < 3; ++c) sum[c] += whole.texels[3 * (i * whole.width + j) + c];
      }
      for (let c = 0; c < 3; ++c) texels[3 * (y * width + x) + c] = sum[c] / ((bottom - top) * (right - left));
    }
  }
  return { height, width, texels };
}
