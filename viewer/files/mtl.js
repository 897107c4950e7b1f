// @ts-check
/** MTL: the materials of an OBJ, and their textures, as bobrossnet.adapters.mtl reads them. */

import { CoreError } from "../core/errors.js";
import { WHITE } from "../tracing/description.js";
import { Pictures, fromSrgb, half, unit } from "./surface.js";
import { textOf } from "./text.js";

/**
 * @typedef {import("./beside.js").Beside} Beside
 * @typedef {import("./surface.js").Surface} Surface
 * @typedef {import("./surface.js").Picture} Picture
 * @typedef {import("./surface.js").Texture} Texture
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
  const files = new Map(), pictures = new Pictures();
  /** @type {Map<string, Surface>} */
  const surfaces = new Map();
  /** @param {string[]} [words] of a map @returns {Promise<Texture | undefined>} */
  const textureOf = async (words = []) => {
    const { file, clamped } = mapOf(words), beyond = clamped ? 1 : 0;
    if (file && !files.has(file)) {
      const load = async () => pictures.decoded(await beside.read(file));
      files.set(file, await attempt(load, (why) => warn(`texture ${file} was left out: ${why}`)));
    }
    const picture = files.get(file);
    return picture && { picture, wrap: [beyond, beyond] };
  };
  /** @type {Map<Picture | undefined, Map<Picture, Picture>>} */
  const withMasks = new Map();
  for (const [name, of] of statements) {
    const laid = await textureOf(of.get("map_kd")), mask = await textureOf(of.get("map_d"));
    const cutOut = mask && await attempt(
      async () => ({ wrap: (laid ?? mask).wrap, picture: kept(withMasks, laid?.picture, mask.picture, pictures) }),
      (why) => warn(`the mask of ${name} was left out: ${why}`),
    );
    const texture = cutOut ?? laid;
    const alphaCutoff = half(texture?.picture);
    surfaces.set(name, {
      ...surfaceOf(of, laid !== undefined), ...(texture && { texture }), ...(name && { name }),
      ...(alphaCutoff !== undefined && { alphaCutoff }),
    });
  }
  return surfaces;
}

/**
 * What `masked` makes of two pictures, made and counted once.
 *
 * @param {Map<Picture | undefined, Map<Picture, Picture>>} made
 * @param {Picture | undefined} picture
 * @param {Picture} mask
 * @param {Pictures} pictures of the file
 * @returns {Picture}
 */
function kept(made, picture, mask, pictures) {
  const of = made.get(picture) ?? new Map(), { height, width } = picture ?? mask;
  if (!of.has(mask)) {
    pictures.count(height, width);
    made.set(picture, of.set(mask, masked(picture, mask)));
  }
  return of.get(mask);
}

/**
 * The picture, or a white one, with the alpha of a mask, or what is bright of one without alpha. A mask of another size
 * lends each texel what is at its centre.
 *
 * @param {Picture | undefined} picture
 * @param {Picture} mask
 * @returns {Picture}
 */
function masked(picture, mask) {
  const { texels, height, width } = picture ?? { ...mask, texels: new Uint8Array(mask.texels.length).fill(255) };
  const alpha = new Uint8Array(height * width);
  for (let row = 0, to = 0; row < height; ++row) {
    const start = Math.floor((2 * row + 1) * mask.height / (2 * height)) * mask.width;
    for (let column = 0; column < width; ++column, ++to) {
      const from = start + Math.floor((2 * column + 1) * mask.width / (2 * width));
      alpha[to] = mask.alpha ? mask.alpha[from] : mask.texels[3 * from];
    }
  }
  return { texels, height, width, alpha };
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
