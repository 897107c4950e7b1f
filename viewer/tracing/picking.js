// @ts-check
/** The surface at a place of a picture. */

/**
 * @typedef {{point: number[], normal: number[], instance: number, part: string | null, kind: string, face: number | null, section: number | null,
 *   unit: string | null, inSphere: import("../picture/projection.js").Vector}} Picked
 *   point: in the scene's coordinates; normal: of its triangle or face, of unit length; instance: its index in the file; part: its path in
 *   the tree of parts; kind: of its shape, mesh, brep, implicit or tube; face: the number of the triangle, or of the face, null of other shapes and of caps; section: of whose
 *   cap the point is; unit: of the scene; inSphere: the point in radii from the centre
 *
 * @param {{x: number, y: number}} place in pixels from the upper left corner
 * @param {import("../picture/camera.js").Size} size @param {import("../picture/camera.js").Camera} camera
 * @param {(place: {x: number, y: number}, size: import("../picture/camera.js").Size, camera: import("../picture/camera.js").Camera) => Promise<import("./scene.js").Hit | null>} pick as Scene.pick
 * @param {Promise<import("./parts.js").Tree | null>} parts of the scene
 * @returns {Promise<Picked | null>} null on the background
 */
export async function picked({ x, y }, size, camera, pick, parts) {
  if (!(x >= 0 && x < size.width && y >= 0 && y < size.height)) return null;
  const [hit, tree] = await Promise.all([pick({ x, y }, size, camera), parts]);
  if (!hit || !tree) return null;
  const { instance, primitive, section, point, normal, sphere: { center, radius } } = hit, { kind, number } = tree.labels[instance];
  return {
    point: center.map((value, axis) => value + radius * point[axis]), normal, instance: number, part: tree.at(instance, primitive)?.path ?? null,
    kind, face: /mesh|brep/.test(kind) && section === null ? primitive : null, section, unit: tree.unit,
    inSphere: /** @type {import("../picture/projection.js").Vector} */ (point),
  };
}
