// @ts-check
/** Pictures on meshes: meshes with the same arrays share one. */

/** @typedef {import("./description.js").MeshDescription} MeshDescription */

/** Values made once for each picture. @template T */
export class OfPictures {
  /** Values by texels, then by alpha. @type {Map<Uint8Array | undefined, Map<Uint8Array | undefined, T>>} */
  #made = new Map();

  /**
   * @param {Pick<MeshDescription, "texture" | "texture_alpha">} mesh
   * @param {() => T} make
   * @returns {T}
   */
  get({ texture, texture_alpha }, make) {
    const of = this.#made.get(texture) ?? new Map();
    if (!of.has(texture_alpha)) of.set(texture_alpha, make());
    this.#made.set(texture, of);
    return of.get(texture_alpha);
  }

  /** @returns {T[]} */
  get all() {
    return [...this.#made.values()].flatMap((of) => [...of.values()]);
  }
}

/**
 * A mesh's picture in the core, to be freed; 0 if it has no picture.
 *
 * @param {import("../core/core.js").Core} core
 * @param {MeshDescription} mesh
 */
export function pictureOf(core, { texture, texture_layout, texture_alpha }) {
  if (!texture || !texture_layout) return 0;
  const [height, width] = texture_layout;
  return core.made("make_picture", texture, height, width, texture_alpha ?? 0);
}
