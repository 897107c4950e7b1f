// @ts-check
/** Cameras fitted to a scene, as bobrossnet.pictures.fitting: the silhouette fills the picture. */
import { panned, projection } from "../picture/projection.js";

/** @typedef {import("../picture/camera.js").Camera} Camera @typedef {import("../picture/camera.js").Size} Size */

const MARGIN = 0.05; // at each border, as a share of the picture
const LOOKS = 2; // one of the whole sphere, and one of the silhouette alone
const SHORTER = 128; // pixels of these pictures along the shorter side
const STEPS = 4; // in perspective, where near points move more than far ones

/**
 * @param {Camera} camera @param {Size} size of the picture
 * @param {(places: Float32Array, size: Size, camera: Camera) => Promise<import("./scene.js").Probe | null>} probe
 * @returns {Promise<Camera>} in the same direction; of zoom 1 if nothing is hit
 */
export async function fitted(camera, { height, width }, probe) {
  const scale = SHORTER / Math.min(height, width), size = { height: Math.round(height * scale), width: Math.round(width * scale) };
  const places = Float32Array.from({ length: 2 * size.height * size.width }, (_, i) =>
    (i % 2 ? Math.floor(i / 2 / size.width) : (i / 2) % size.width) + 0.5);
  /** @type {[number, number, number][]} */
  const points = [];
  let found = { ...camera, zoom: 1, panX: 0, panY: 0 };
  for (let look = 0; look < LOOKS; ++look) {
    const { point } = projection(found, size), depths = (await probe(places, size, found))?.depths ?? [];
    for (let i = 0; i < depths.length; ++i) {
      if (depths[i] >= 0) points.push(point(places[2 * i], places[2 * i + 1], depths[i]));
    }
    if (points.length > 0) found = around(points, found, size);
  }
  return found;
}

/** @param {[number, number, number][]} points @param {Camera} camera @param {Size} size @returns {Camera} */
function around(points, camera, size) {
  for (let step = camera.fov ? STEPS : 1; step > 0; --step) {
    const { seen } = projection(camera, size);
    let left = Infinity, right = -Infinity, top = Infinity, bottom = -Infinity;
    for (const point of points) {
      const { x, y } = seen(point);
      if (!(x === x)) continue;
      left = Math.min(left, x - 0.5), right = Math.max(right, x + 0.5), top = Math.min(top, y - 0.5), bottom = Math.max(bottom, y + 0.5);
    }
    const { panX, panY } = panned(camera, size, size.width / 2 - (left + right) / 2, size.height / 2 - (top + bottom) / 2);
    const times = (1 - 2 * MARGIN) * Math.min(size.height / (bottom - top), size.width / (right - left));
    camera = { ...camera, panX, panY, zoom: camera.zoom * times };
  }
  return camera;
}
