// @ts-check
/**
 * Scenes as plain objects, which messages between workers can carry.
 *
 * @typedef {import("../shapes/description.js").ShapeDescription} ShapeDescription
 * @typedef {{color: ArrayLike<number>, ambient: number, diffuse: number, specular: number, shininess: number,
 *   metallic?: number | null, roughness?: number | null, emissive?: ArrayLike<number>, clearcoat?: number,
 *   clearcoat_roughness?: number, transmission?: number, ior?: number, attenuation?: ArrayLike<number>, distance?: number, thin?: boolean}} Material
 *   color, emissive, attenuation: linear RGB; Blinn-Phong if roughness is omitted; from transmission on as bobrossnet.Glass
 * @typedef {{shape: number, transform?: ArrayLike<number>, material?: Material, name?: string | null, number?: number,
 *   pieces?: import("./scene.js").Label["pieces"]}} InstanceDescription
 *   shape: index of the shape; transform: (4, 4), from its units to the scene's, by default the identity; white by
 *   default; number: in the order of the file, by default its index in the array
 * @typedef {{shapes: ShapeDescription[], instances: InstanceDescription[], warnings?: string[], unit?: string | null,
 *   hasFront?: boolean, stoodUp?: boolean, lights?: import("./light.js").SceneLights | null}} SceneDescription
 *   warnings: parts of a file left out or shown differently, a line each; unit: of lengths, such as "mm";
 *   hasFront: whether -y is known to be the front; stoodUp: whether meshes that seemed to lie on their back were turned
 */

import { IDENTITY, UPRIGHT, product, scaling } from "../shapes/affine.js";

/** As bobrossnet.Material(). @type {Material} */
export const WHITE = { color: [1, 1, 1], ambient: 0.1, diffuse: 0.7, specular: 0.2, shininess: 32 };

/**
 * A scene of one shape, in the shape's coordinates.
 *
 * @param {ShapeDescription} shape
 * @param {string | null} [name]
 * @returns {SceneDescription}
 */
export function sceneOf(shape, name = null) {
  return { shapes: [shape], instances: [{ shape: 0, transform: IDENTITY, material: WHITE, name }] };
}

/** @param {import("../core/core.js").Core} core @param {string} unit */
function metresOf(core, unit) {
  const name = new TextEncoder().encode(unit.slice(0, 100));
  return core.made("unit_metres", name, name.length);
}

/**
 * Several scenes as one, in the unit of the first that has one, as by bobrossnet.load.
 *
 * @param {import("../core/core.js").Core} core
 * @param {readonly SceneDescription[]} scenes
 * @param {readonly string[]} names of their files
 * @returns {SceneDescription}
 */
export function together(core, scenes, names) {
  if (scenes.length === 1) return scenes[0];
  const unit = scenes.find((scene) => scene.unit)?.unit ?? null;
  /** @type {Required<Omit<SceneDescription, "lights">>} */
  const all = { shapes: [], instances: [], warnings: [], unit, hasFront: scenes.some((scene) => scene.hasFront), stoodUp: scenes.some((scene) => scene.stoodUp) };
  scenes.forEach(({ shapes, instances, warnings = [], unit: own, lights }, number) => {
    const before = all.shapes.length, first = all.instances.length, isOther = unit && own && own !== unit;
    const scale = isOther ? scaling(metresOf(core, own) / metresOf(core, unit)) : null;
    all.instances = all.instances.concat(instances.map((instance, i) => ({
      ...instance, shape: before + instance.shape, number: first + (instance.number ?? i),
      ...(scale && { transform: product(scale, instance.transform ?? IDENTITY) }),
    })));
    all.shapes = all.shapes.concat(shapes);
    all.warnings = all.warnings.concat(warnings);
    if (lights) all.warnings.push(`${names[number]}: its lights are not shown, because other shapes are opened with it`);
    if (unit && !own) all.warnings.push(`${names[number]}: its lengths are taken as ${unit}, the unit of the other files; it does not say its own`);
  });
  return all;
}

/**
 * The same scene, rotated; by UPRIGHT it is bobrossnet.Scene.turned_upright, with +z of the file as its front.
 *
 * @param {SceneDescription} scene @param {import("../shapes/affine.js").Matrix} turn
 * @returns {SceneDescription}
 */
export function turned(scene, turn) {
  const instances = scene.instances.map((instance) => ({
    ...instance, transform: product(turn, instance.transform ?? IDENTITY),
  }));
  return { ...scene, instances, hasFront: scene.hasFront || String(turn) === String(UPRIGHT) };
}

/**
 * The numbers of the core's Material, in its order.
 *
 * @param {Material} material
 */
export function materialValues({
  color, ambient, diffuse, specular, shininess, metallic, roughness, emissive = [0, 0, 0],
  clearcoat = 0, clearcoat_roughness = 0, transmission = 0, ior = 1.5, attenuation = [1, 1, 1], distance = Infinity, thin = false,
}) {
  const reflection = [...Array.from(color), ambient, diffuse, specular, shininess, metallic ?? 0, roughness ?? -1, ...Array.from(emissive)];
  return [...reflection, clearcoat, clearcoat_roughness, transmission, ior, ...Array.from(attenuation), distance, Number(thin)];
}
