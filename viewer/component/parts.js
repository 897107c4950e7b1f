// @ts-check
/**
 * The parts of an element's scene: which are hidden or highlighted, and their measures. Fetched with the first use.
 *
 * @typedef {import("../tracing/parts.js").Part} Part
 * @typedef {import("../tracing/parts.js").Tree} Tree
 * @typedef {import("../tracing/picking.js").Picked} Picked
 *
 * @typedef {{part: string, low: number[], high: number[], size: number[], area: number | null, volume: number | null, unit: string | null}} Measures
 *   part: its path, empty for the whole scene; low, high: the box along the axes, in the scene's unit; size: of the box; area:
 *   null unless all surfaces are triangles or NURBS faces, at most 1000 of a shape; volume: null unless they are closed
 * @typedef {{distance: number, offset: number[], angle: number, unit: string | null, ends: [string, string]}} Between
 *   two picks: offset: from the first to the second; angle: of their normals, in degrees; ends: both in words
 */
import { Tree as TreeOfParts, primitivesOf, withAllBelow } from "../tracing/parts.js";
import { inWords } from "./snaps.js";

export class Parts {
  #ask;
  #cut;
  /** @type {Promise<Tree | null> | undefined} */
  #tree;
  /** @type {WeakMap<Part, Promise<import("../tracing/scene.js").Measures | null>>} */
  #measures = new WeakMap();

  /**
   * @param {import("./viewing.js").Viewing["ask"]} ask
   * @param {(changes: {hidden?: number[], highlighted?: number[]}) => void} cut
   */
  constructor(ask, cut) {
    this.#ask = ask, this.#cut = cut;
  }

  /** @returns {Promise<Tree | null>} null if there is no scene */
  tree() {
    this.#tree ??= this.#ask("about").then((about) => {
      if (!about) this.#tree = undefined;
      return about && new TreeOfParts(about.labels, about.unit);
    });
    return this.#tree;
  }

  /** Forgets the scene, before another one is shown. */
  clear() {
    this.#tree = undefined;
  }

  /** @param {readonly (string | number)[]} which @returns {Promise<Part[]>} */
  async #find(which) {
    const tree = await this.tree();
    if (!tree) throw new Error("part: expected an open scene, got none");
    return which.map((one) => tree.find(one));
  }

  /** @param {readonly (string | number)[]} which @param {boolean} isHidden */
  async hide(which, isHidden) {
    for (const part of (await this.#find(which)).flatMap(withAllBelow)) part.isHidden = isHidden;
    await this.#show();
  }

  /** @param {readonly (string | number)[]} which empty: all are shown */
  async isolate(which) {
    const shown = new Set((await this.#find(which)).flatMap(withAllBelow));
    for (const part of (await this.tree())?.parts ?? []) part.isHidden = which.length > 0 && !shown.has(part);
    await this.#show();
  }

  async #show() {
    const hidden = (await this.tree())?.parts.filter(({ isHidden }) => isHidden) ?? [];
    this.#cut({ hidden: hidden.flatMap(({ own }) => own) });
  }

  /** @param {readonly (string | number)[]} which */
  async highlight(which) {
    this.#cut({ highlighted: primitivesOf(await this.#find(which)) });
  }

  /** @param {string | number} [which] if omitted, the whole scene @returns {Promise<Measures>} */
  async measure(which) {
    const tree = await this.tree(), [part] = which === undefined ? [tree?.root] : await this.#find([which]);
    if (!tree || !part) throw new Error("measure: expected an open scene, got none");
    const known = this.#measures.get(part) ?? this.#ask("measure", primitivesOf([part])), found = await known;
    if (!found) throw new Error("measure: expected an open scene, got none");
    this.#measures.set(part, known);
    const { low, high } = found;
    return { ...found, part: part.path, size: high.map((value, axis) => value - low[axis]), unit: tree.unit };
  }
}

/** @param {Picked} a @param {Picked} b @returns {Between} */
export function between(a, b) {
  const offset = b.point.map((value, axis) => value - a.point[axis]), along = a.normal.reduce((sum, value, axis) => sum + value * b.normal[axis], 0);
  const said = (/** @type {Picked} */ { snapped, radius, unit }) => inWords(snapped, radius, unit);
  return { distance: Math.hypot(...offset), offset, angle: Math.acos(Math.max(-1, Math.min(1, along))) * 180 / Math.PI, unit: a.unit, ends: [said(a), said(b)] };
}
