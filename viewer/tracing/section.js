// @ts-check
/**
 * Sections as texts, such as "x=0" or "z<20": planes that cut a scene open, as bobrossnet.Section.
 *
 * @typedef {0 | 1 | 2} Axis
 * @typedef {{axis: Axis, sign: 1 | -1, at: number}} Section
 *   keeps coordinates of at most `at` along the axis if the sign is 1, and of at least `at` if it is -1; in the scene's unit
 */

/** A section as text, as bobrossnet.tracing.section.PATTERN. */
const PATTERN = /^\s*([xyz])\s*(<=|>=|=|<|>)\s*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[-+]?[0-9]+)?)\s*$/i;

/** Maximum number of sections of a scene, as bobrossnet.tracing.section.MAX_SECTIONS. */
const MAX_SECTIONS = 6;

export const AXES = ["x", "y", "z"];

/**
 * @param {string | null} text sections with commas between them
 * @returns {Section[]} empty for null and empty texts
 * @throws {Error} of one line, if a section means nothing, or there are too many
 */
export function sectionsOf(text) {
  if (!text?.trim()) return [];
  const texts = text.split(",");
  if (texts.length > MAX_SECTIONS) throw new Error(`section: expected at most ${MAX_SECTIONS}, got ${texts.length}`);
  return texts.map((one) => {
    const match = PATTERN.exec(one), at = Number(match?.[3] ?? NaN);
    if (!match || !Number.isFinite(at)) {
      throw new Error(`section: expected an axis, a relation and a number, such as 'x=0', 'z>3' or 'y<=-1.5', got '${one.trim().slice(0, 100)}'`);
    }
    return { axis: /** @type {Axis} */ (AXES.indexOf(match[1].toLowerCase())), sign: match[2][0] === ">" ? -1 : 1, at };
  });
}

/** The same, empty for texts that mean nothing. @param {string | null} text */
export function validSections(text) {
  try {
    return sectionsOf(text);
  } catch {
    return [];
  }
}

/** The reverse of `sectionsOf`. @param {readonly Section[]} sections */
export const textOf = (sections) => sections.map(({ axis, sign, at }) => `${AXES[axis]}${sign > 0 ? "<" : ">"}${at}`).join(", ");

/** Unit normals and offsets, (n, 4). @param {readonly Section[]} sections @returns {number[]} */
export const planesOf = (sections) => sections.flatMap(({ axis, sign, at }) => [0, 1, 2, 3].map((k) => (k === axis ? sign : k === 3 ? sign * at : 0)));

/**
 * The sections with one along an axis, through the middle of a box; without those along it, if there are any.
 *
 * @param {readonly Section[]} sections @param {Axis} axis @param {ArrayLike<number>} box lowest, then highest coordinates
 * @returns {Section[]}
 */
export function toggled(sections, axis, box) {
  const others = sections.filter((section) => section.axis !== axis);
  if (others.length < sections.length) return others;
  return [...others.slice(0, MAX_SECTIONS - 1), { axis, sign: 1, at: shortened((box[axis] + box[axis + 3]) / 2, box[axis + 3] - box[axis]) }];
}

/** A coordinate with as many digits as a thousandth of a size needs. @param {number} value @param {number} size */
export function shortened(value, size) {
  const digits = Math.max(0, Math.min(20, 3 - Math.floor(Math.log10(size)))) || 0;
  return Number(value.toFixed(digits));
}
