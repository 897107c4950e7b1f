// @ts-check
/**
 * The camera's projection: places of points in a picture, and cameras that move them; as core/picture/camera.h.
 *
 * @typedef {import("./camera.js").Camera} Camera
 * @typedef {import("./camera.js").Size} Size
 * @typedef {[number, number, number]} Vector
 */
import { valid } from "./camera.js";

/** Side of a pixel, in radii of the scene; in perspective at the scene's centre. @param {Camera} camera @param {Size} size */
function pixelSize({ zoom, fov }, { height, width }) {
  const shorter = Math.min(width, height), slope = Math.tan(fov * Math.PI / 360) * shorter / height;
  return 2 * Math.hypot(1, slope) / (zoom * shorter);
}

const DEGREE = Math.PI / 180;

/** The camera's axes in the scene: right, up and towards it. @param {Pick<Camera, "azimuth" | "elevation" | "roll">} camera @returns {Vector[]} */
export function axesOf({ azimuth, elevation, roll }) {
  const [a, e, r] = [azimuth, elevation, roll].map((degrees) => degrees * DEGREE);
  const x = [-Math.sin(a), Math.cos(a), 0], y = [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)];
  const turned = (/** @type {number} */ c, /** @type {number} */ s) => /** @type {Vector} */ (x.map((_, k) => c * x[k] + s * y[k]));
  return [
    turned(Math.cos(r), Math.sin(r)), turned(-Math.sin(r), Math.cos(r)),
    [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)],
  ];
}

/**
 * Places of points in a picture, and the reverse. Points are in radii from the
 * scene's centre; places in pixels, x right and y down, from the upper left corner.
 *
 * @param {Camera} camera @param {Size} size
 */
export function projection({ azimuth, elevation, roll, zoom, panX, panY, fov }, { height, width }) {
  const axes = axesOf({ azimuth, elevation, roll }), half = fov / 2 * DEGREE, shorter = Math.min(height, width);
  const slope = 2 * Math.tan(half) / (zoom * height), high = Math.tan(half) * shorter / height, orbit = Math.hypot(1, high) / high;
  const pixel = 2 / (zoom * shorter), distance = Math.hypot(panX, panY, orbit), nearest = Math.max(0, distance - 1);
  /** In the camera's axes, right, up and towards it, to the scene's. @param {number[]} of @returns {Vector} */
  const inScene = (of) => /** @type {Vector} */ ([0, 1, 2].map((k) => of.reduce((sum, value, axis) => sum + value * axes[axis][k], 0)));
  /** The reverse. @param {ArrayLike<number>} point */
  const inCamera = (point) => axes.map((axis) => axis.reduce((sum, value, k) => sum + value * point[k], 0));
  /** The side of a pixel at a point, in radii; not positive behind the camera. @param {number} z towards the camera */
  const side = (z) => (fov ? slope * (orbit - z) : pixel);
  /** A unit vector towards the eye, in the camera's axes. @param {number} px @param {number} py place */
  const toEye = (px, py) => {
    const across = fov ? (px - width / 2) * slope : 0, above = fov ? (height / 2 - py) * slope : 0, scale = 1 / Math.hypot(1, across, above);
    return [-across * scale, -above * scale, scale];
  };
  return {
    /** @param {ArrayLike<number>} point @returns {{x: number, y: number, depth: number}} NaN behind the camera; depth as in a G-buffer */
    seen(point) {
      const [cx, cy, cz] = inCamera(point), unit = side(cz) > 0 ? side(cz) : NaN;
      const depth = fov ? 1 - (Math.hypot(cx - panX, cy - panY, orbit - cz) - nearest) / (distance + 1 - nearest) : (1 + cz) / 2;
      return { x: width / 2 + (cx - panX) / unit, y: height / 2 - (cy - panY) / unit, depth };
    },
    /** @param {number} px @param {number} py place @param {number} depth @returns {Vector} */
    point(px, py, depth) {
      if (!fov) return inScene([(px - width / 2) * pixel + panX, (height / 2 - py) * pixel + panY, 2 * depth - 1]);
      const far = nearest + (1 - depth) * (distance + 1 - nearest), eye = toEye(px, py);
      return inScene([panX - far * eye[0], panY - far * eye[1], orbit - far * eye[2]]);
    },
    /** The translation that shows a point at a place. @param {ArrayLike<number>} point @param {number} px @param {number} py */
    panTo(point, px, py) {
      const [cx, cy, cz] = inCamera(point), unit = side(cz);
      return { panX: cx - (px - width / 2) * unit, panY: cy + (py - height / 2) * unit };
    },
  };
}

/**
 * The camera that moves the picture to the right and down, in pixels.
 *
 * @param {Camera} camera @param {Size} size @param {number} right @param {number} down
 */
export function panned(camera, size, right, down) {
  const pixel = pixelSize(camera, size);
  return valid({ ...camera, panX: camera.panX - right * pixel, panY: camera.panY + down * pixel });
}

/**
 * The camera that magnifies the picture by a factor about a fixed place.
 *
 * @param {Camera} camera @param {Size} size
 * @param {number} factor
 * @param {number} right @param {number} down pixels from the picture's centre to the place
 */
export function zoomed(camera, size, factor, right, down) {
  const { zoom } = valid({ ...camera, zoom: camera.zoom * factor });
  const moved = pixelSize(camera, size) - pixelSize({ ...camera, zoom }, size);
  return valid({ ...camera, zoom, panX: camera.panX + right * moved, panY: camera.panY - down * moved });
}
