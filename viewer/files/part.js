// @ts-check
/**
 * Parts: the contents of a mesh file, as its reader found them.
 *
 * @typedef {{vertices: Float64Array, triangles: Int32Array, normals?: Float64Array, colors?: Float64Array,
 *   faceColors?: Float64Array, alphas?: Float64Array, uv?: Float64Array, surface?: import("./surface.js").Surface,
 *   runs?: [string[], number][]}} Part
 *   (V, 3), (T, 3), (V, 3): indices unchecked, numbers perhaps not finite; a missing normal is NaN. colors (V, 3) and
 *   faceColors (T, 3) are linear RGB, they and alphas (V,) 1 where they are not finite; uv (V, 2) from the texture's top left on;
 *   runs: paths in the tree of parts of all triangles, if the file names any
 * @typedef {(text: string) => void} Warn told what of a file was left out
 */
export {};
