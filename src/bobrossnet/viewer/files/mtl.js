// @ts-check
/** MTL: the materials of an OBJ, and their textures, as bobrossnet.adapters.mtl reads them. */

import { CoreError } from "../core/errors.js";
import { WHITE } from "../tracing/description.js";
import { decoded, fromSrgb, unit } from "./surface.js";
import { textOf } from "./text.js";

/**
 * @typedef {import("./beside.js").Beside} Beside
 * @typedef {import("./surface.js").Surface} Surface
 * @typedef {import("./surface.js").Picture} Picture
 */

/** Of maps: how many numbers may follow; one word follows the others. @type {Record<string, number>} */
const OPTIONS = { "-s": 3, "-o": 3, "-t": 3, "-mm": 2 };

/**
 * The surfaces that libraries describe, by their names. A library or a texture that can't be read is left out, with a
 * warning.
 *
 * @param {string[]} lines what follows each mtllib
 * @param {Beside} beside
 * @param {import("./part.js").Warn} warn
 * @returns {Promise<Map<string, Surface>>}
 */
export async function readMtl(lines, beside, warn) {
  /** @type {Map<string, Map<string, string[]>>} */
  const statements = new Map();
  for (const name of new Set(lines.flatMap((line) => libraries(line, beside)))) {
    const bytes = await attempt(() => beside.read(name), (why) => warn(`materials were left out: ${why}`));
    let of = new Map();
    for (const line of bytes ? textOf(bytes).split("\n") : []) {
      const words = wordsOf(line);
      if (words[0] === "newmtl") statements.set(line.slice(line.indexOf("newmtl") + 6).trim(), of = new Map());
      else if (words.length) of.set(words[0].toLowerCase(), words.slice(1));
    }
  }
  /** @type {Map<string, Picture | undefined>} */
  const pictures = new Map();
  /** @type {Map<string, Surface>} */
  const surfaces = new Map();
  for (const [name, of] of statements) {
    const { file, clamped } = mapOf(of.get("map_kd") ?? []);
    if (file && !pictures.has(file)) {
      const load = async () => decoded(await beside.read(file));
      pictures.set(file, await attempt(load, (why) => warn(`texture ${file} was left out: ${why}`)));
    }
    const picture = pictures.get(file), beyond = clamped ? 1 : 0;
    surfaces.set(name, { ...surfaceOf(of, picture !== undefined), ...(picture && { texture: textureOf(picture, beyond) }), ...(name && { name }) });
  }
  return surfaces;
}

/** What a line names is several files, if there are such, or one with spaces in its name. @param {string} line @param {Beside} beside */
function libraries(line, beside) {
  const whole = line.trim(), parts = whole.split(/\s+/);
  return !beside.has(whole) && parts.some((part) => beside.has(part)) ? parts : [whole];
}

/** @template T @param {() => Promise<T>} read @param {(why: string) => void} failed @returns {Promise<T | undefined>} */
async function attempt(read, failed) {
  try {
    return await read();
  } catch (error) {
    if (!(error instanceof CoreError)) throw error;
    failed(error.message);
    return undefined;
  }
}

/** @param {string} line */
const wordsOf = (line) => line.split("#", 1)[0].trim().split(/\s+/).filter(Boolean);

/** @param {Map<string, string[]>} of @param {boolean} isTextured @returns {Surface} */
function surfaceOf(of, isTextured) {
  // Exporters write any Kd beside a texture, and importers such as Blender's do not look at it.
  const color = isTextured ? [1, 1, 1] : colorOf(of.get("kd"), 1), emissive = colorOf(of.get("ke"), 0);
  if (of.has("pm") || of.has("pr")) {
    const metallic = unit(numberOf(of.get("pm")?.[0]), 0), roughness = unit(numberOf(of.get("pr")?.[0]), 0.5);
    return { material: { ...WHITE, color, emissive, metallic, roughness } };
  }
  // Highlights of full strength are common in files and wash colours out: Ks scales the one that surfaces have here.
  const exponent = numberOf(of.get("ns")?.[0]) ?? 0;
  const specular = 0.2 * Math.max(...colorOf(of.get("ks"), 1)), shininess = exponent >= 1 ? Math.min(exponent, 10_000) : 32;
  return { material: { ...WHITE, color, emissive, specular, shininess } };
}

/** @param {Picture} picture @param {number} beyond its edges @returns {import("./surface.js").Texture} */
const textureOf = (picture, beyond) => ({ picture, wrap: [beyond, beyond] });

/** The file of a map, and whether it is clamped. @param {string[]} words */
function mapOf(words) {
  let clamped = false;
  while (words.length > 1 && words[0].startsWith("-")) {
    const [option, ...rest] = words;
    words = rest;
    const most = OPTIONS[option.toLowerCase()];
    if (most) {
      for (let count = 0; count < most && words.length > 1 && numberOf(words[0]) !== undefined; ++count) words = words.slice(1);
    } else {
      clamped ||= option.toLowerCase() === "-clamp" && words[0].toLowerCase() === "on";
      words = words.slice(1);
    }
  }
  return { file: words.join(" "), clamped };
}

/** Linear RGB of a statement's sRGB. @param {string[] | undefined} words @param {number} otherwise */
function colorOf(words = [], otherwise) {
  const values = words.length === 1 ? [words[0], words[0], words[0]] : words;
  return [0, 1, 2].map((channel) => fromSrgb(unit(numberOf(values[channel]), otherwise)));
}

/** @param {string | undefined} word */
function numberOf(word) {
  const number = Number(word);
  return word !== undefined && Number.isFinite(number) ? number : undefined;
}
