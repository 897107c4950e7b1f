// @ts-check
/**
 * Cutaways: the displayed part of a scene.
 *
 * @typedef {{id: number, planes: number[], hidden: number[], highlighted: number[]}} Cutaway
 *   id: unique among cutaways; planes (n, 4): sections, unit normals and offsets in the scene's units;
 *   hidden, highlighted (n, 3): an instance, the first of its primitives, and the one after the last
 */

/** The whole scene, without sections. @type {Readonly<Cutaway>} */
export const WHOLE = Object.freeze({ id: 0, planes: [], hidden: [], highlighted: [] });

let count = 0; // of cutaways so far

/** A cutaway with changes. @param {Cutaway} before @param {Partial<Omit<Cutaway, "id">>} changes @returns {Cutaway} */
export const changed = (before, changes) => ({ ...before, ...changes, id: ++count });
