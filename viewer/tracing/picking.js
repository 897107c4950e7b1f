// @ts-check
/** The surface at a place of a picture. */
import { projection } from "../picture/projection.js";

/**
 * @typedef {{point: number[], normal: number[], instance: number, part: string | null, inSphere: import("../picture/projection.js").Vector}} Picked
 *   point: in the scene's coordinates; normal: of unit length; instance: its index; part: its name in the file;
 *   inSphere: the point in radii from the centre
 *
 * @param {{x: number, y: number}} place in pixels from the upper left corner
 * @param {import("../picture/camera.js").Size} size @param {import("../picture/camera.js").Camera} camera
 * @param {(places: number[], size: import("../picture/camera.js").Size, camera: import("../picture/camera.js").Camera) => Promise<import("./scene.js").Probe | null>} probe
 * @returns {Promise<Picked | null>} null if there is none
 */
export async function picked({ x, y }, size, camera, probe) {
  if (!(x >= 0 && x < size.width && y >= 0 && y < size.height)) return null;
  const found = await probe([x, y], size, camera), [depth, nx, ny, instance] = found?.samples ?? [NaN];
  if (!found || !(depth === depth)) return null;
  const { point, normal } = projection(camera, size), inSphere = point(x, y, depth), { center, radius } = found.sphere;
  return {
    point: center.map((value, axis) => value + radius * inSphere[axis]), normal: normal(nx, ny, x, y), instance,
    part: found.names.get(instance) ?? null, inSphere,
  };
}
