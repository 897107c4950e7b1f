// @ts-check
/** The tree of a scene's parts, by the names that its file gives, as bobrossnet.tracing.parts. */

import { oneLine } from "../core/errors.js";

/**
 * @typedef {import("./scene.js").Label} Label
 * @typedef {object} Part
 * @property {string} name different from its siblings'; empty for the root
 * @property {string} path names from the root down, with / between them
 * @property {number} number in the sequence of all parts, each before those below it; -1 for the root
 * @property {Part[]} children
 * @property {boolean} isHidden without regard to parts below it
 * @property {number[]} own (n, 3): an instance, the first of its primitives of this part alone, and the one after the last
 */

export class Tree {
  /** @type {Part} */
  root;
  /** All parts but the root, in sequence. @type {Part[]} */
  parts = [];
  /** @type {Map<number, [number, number, Part][]>} */
  #ofInstances = new Map();

  /** @param {Label[]} labels of the instances @param {string | null} unit of lengths */
  constructor(labels, unit) {
    this.unit = unit;
    this.labels = labels;
    /** @typedef {{children: Map<string, Node>, own: number[]}} Node */
    const made = () => /** @type {Node} */ ({ children: new Map(), own: [] }), root = made();
    const taken = new Set(labels.flatMap(({ pieces }) => pieces.map(([[first]]) => first)));
    /** @type {Map<string, number>} */
    const counts = new Map();
    const inFile = Array.from(labels.keys()).sort((a, b) => labels[a].number - labels[b].number);
    for (const instance of inFile) {
      const { name, kind, count, pieces } = labels[instance];
      const all = pieces.length ? pieces : [/** @type {Label["pieces"][0]} */ ([[ownName(name || kind, taken, counts)], null])];
      let start = 0;
      for (const [path, size] of all) {
        let node = root;
        for (const step of path) {
          const next = node.children.get(step) ?? made();
          node.children.set(step, next);
          node = next;
        }
        const stop = start + (size ?? count), { own } = node;
        if (own.at(-3) === instance && own.at(-1) === start) own.splice(-1, 1, stop);
        else own.push(instance, start, stop);
        start = stop;
      }
    }
    this.root = this.#part(root, "", "");
  }

  /** @param {{children: Map<string, any>, own: number[]}} node @param {string} name @param {string} path @returns {Part} */
  #part({ children, own }, name, path) {
    /** @type {Part} */
    const part = { name, path, number: this.parts.length - 1, children: [], own, isHidden: false };
    if (path) part.number = this.parts.push(part) - 1;
    for (let i = 0; i < own.length; i += 3) {
      const ranges = this.#ofInstances.get(own[i]) ?? [];
      ranges.push([own[i + 1], own[i + 2], part]);
      this.#ofInstances.set(own[i], ranges);
    }
    for (const [below, child] of children) part.children.push(this.#part(child, below, path ? `${path}/${below}` : below));
    return part;
  }

  /** The part of a primitive. @param {number} instance @param {number} primitive @returns {Part | undefined} */
  at(instance, primitive) {
    const ranges = this.#ofInstances.get(instance) ?? [];
    return ranges.length === 1 ? ranges[0][2] : ranges.find(([start, stop]) => start <= primitive && primitive < stop)?.[2];
  }

  /** @param {string | number} which a path, a name that no other part has, or a number @returns {Part} @throws {Error} of one line */
  find(which) {
    const { parts } = this, byPath = parts.filter(({ path }) => path === which), found = byPath.length ? byPath : parts.filter(({ name }) => name === which);
    if (typeof which === "number" && parts[which]) return parts[which];
    if (found.length === 1) return found[0];
    const shown = (found.length ? found : parts).slice(0, 5).map(({ path }) => path).join(", "), name = String(which).slice(0, 100);
    if (found.length) throw new Error(`part: expected a path, as ${found.length} parts are called '${name}': ${shown}`);
    throw new Error(`part: expected ${parts.length === 1 ? "the only part," : `one of the ${parts.length} parts, such as`} ${shown}, got '${name}'`);
  }
}

/** A new name for an instance without pieces. @param {string} first @param {Set<string>} taken @param {Map<string, number>} counts */
function ownName(first, taken, counts) {
  let name = first = oneLine(first);
  while (taken.has(name)) {
    counts.set(first, (counts.get(first) ?? 1) + 1);
    name = `${first} ${counts.get(first)}`;
  }
  taken.add(name);
  return name;
}

/** A part, and all below it. @param {Part} part @returns {Part[]} */
export const withAllBelow = (part) => [part, ...part.children.flatMap(withAllBelow)];

/** Primitives of parts and of those below them, (n, 3). @param {readonly Part[]} parts @returns {number[]} */
export const primitivesOf = (parts) => parts.flatMap(({ own, children }) => [...own, ...primitivesOf(children)]);
