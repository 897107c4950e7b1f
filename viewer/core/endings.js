// @ts-check
/** Endings of files with scenes, in lower case. */

/** Meshes whose formats don't say which axis is up. */
const SILENT = [".ply", ".obj", ".stl", ".off"];

/** Meshes, which the smaller core reads. */
const MESHES = [...SILENT, ".glb", ".gltf"];

/** Files that the page reads. */
export const ENDINGS = [...MESHES, ".3mf", ".json", ".sdf", ".vm", ".bob"];

/** Files that only the Python package reads. */
export const CONVERTED = [".xml", ".bpt", ".cpt", ".3dm", ".step", ".stp", ".iges", ".igs"];

/** @param {string} name of a file */
export const endingOf = (name) => /\.[^.]*$/.exec(name)?.[0].toLowerCase() ?? "";

/** @param {string} name of a file */
export const isSilent = (name) => SILENT.includes(endingOf(name));

/** @param {string} name of a file */
export const isMesh = (name) => MESHES.includes(endingOf(name));

/** Whether a file has a scene, and is not a texture or something else beside one. @param {string} name */
export const isModel = (name) => [...ENDINGS, ...CONVERTED].includes(endingOf(name));
