// @ts-check
/** The surface at a place of a picture. */

/**
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/camera.js").Size} Size
 * @typedef {{x: number, y: number}} PlaceInPicture in pixels from the upper left corner
 * @typedef {{point: number[], normal: number[], instance: number, part: string | null, kind: string, face: number | null, section: number | null,
 *   unit: string | null, inSphere: import("../picture/projection.js").Vector, snapped: import("./scene.js").Snap["kind"] | null, radius: number | null}} Picked
 *   point: in the scene's coordinates; normal: of its triangle or face, of unit length; instance: its index in the file; part: its path in
 *   the tree of parts; kind: of its shape, mesh, brep, implicit or tube; face: the number of the triangle, or of the face, null of other shapes and of caps; section: the section
 *   whose cap was hit, or null; unit: of the scene; inSphere: the point in radii from the centre;
 *   snapped: the kind of feature; radius: of the circle whose centre or edge that is
 *
 * @typedef {{
 *   pick: (place: PlaceInPicture, size: Size, camera: Camera) => Promise<import("./scene.js").Hit | null>,
 *   snap: (place: PlaceInPicture, size: Size, camera: Camera, reach: number) => Promise<import("./scene.js").Snap | null>
 * }} Asked as Scene.pick and Scene.snap
 *
 * @param {PlaceInPicture} place
 * @param {Size} size @param {Camera} camera
 * @param {number} reach pixels within which the point snaps to corners, centres and edges; 0 turns snapping off
 * @param {Asked} ask the scene
 * @param {() => Promise<import("./parts.js").Tree | null>} parts of the scene; asked last, since snapping may open it in another core
 * @returns {Promise<Picked | null>} null on the background
 */
export async function picked({ x, y }, size, camera, reach, ask, parts) {
  if (!(x >= 0 && x < size.width && y >= 0 && y < size.height)) return null;
  const snapped = reach > 0 ? await ask.snap({ x, y }, size, camera, reach) : null;
  const [hit, tree] = await Promise.all([ask.pick(snapped?.place ?? { x, y }, size, camera), parts()]);
  if (!hit || !tree) return null;
  const { instance, primitive, section, normal, sphere: { center, radius } } = hit, { kind, number } = tree.labels[instance], { point } = snapped ?? hit;
  return {
    point: center.map((value, axis) => value + radius * point[axis]), normal, instance: number, part: tree.at(instance, primitive)?.path ?? null,
    kind, face: /mesh|brep/.test(kind) && section === null ? primitive : null, section, unit: tree.unit,
    inSphere: /** @type {import("../picture/projection.js").Vector} */ (point), snapped: snapped?.kind ?? null,
    radius: snapped?.radius ? snapped.radius * radius : null,
  };
}
