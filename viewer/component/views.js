// @ts-check
/** Named views, from the sides that CAD programs show by the keys 1 to 6. The front faces -y, as in glTF once z is up. */

/** @typedef {"front" | "top" | "right" | "back" | "bottom" | "left"} ViewName */

/** @param {number} azimuth @param {number} elevation */
const from = (azimuth, elevation) => Object.freeze({ azimuth, elevation, roll: 0 });

/** @type {Readonly<Record<ViewName, {azimuth: number, elevation: number, roll: number}>>} */
export const VIEWS = {
  front: from(270, 0), top: from(270, 90), right: from(0, 0), back: from(90, 0), bottom: from(270, -90), left: from(180, 0),
};

export const VIEW_NAMES = /** @type {ViewName[]} */ (Object.keys(VIEWS));
