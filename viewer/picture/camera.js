// @ts-check
/**
 * The camera: its numbers, and the only place of the page that knows its projection, which is orthographic or, with a fov, in
 * perspective.
 *
 * @typedef {{azimuth: number, elevation: number, roll: number, zoom: number, panX: number, panY: number, fov: number}} Camera
 *   as bobrossnet.Camera, in degrees; it is moved panX radii of the scene to the right, and panY up
 * @typedef {{height: number, width: number}} Size of a picture, in pixels
 */

/** The view from the front; a camera's numbers in the order in which the core and links have them. @type {Readonly<Camera>} */
export const HOME = Object.freeze({ azimuth: 30, elevation: 20, roll: 0, zoom: 1, panX: 0, panY: 0, fov: 0 });

/** Degrees of the height, where perspective is switched on. */
export const PERSPECTIVE = 35;

export const FIELDS = /** @type {(keyof Camera)[]} */ (Object.keys(HOME));

/** A camera as the core takes it. @param {Partial<Camera>} camera that looks from the front where it does not say */
export const cameraValues = (camera) => Float32Array.from(FIELDS, (name) => camera[name] ?? HOME[name]);

/** @param {number} value @param {number} low @param {number} high */
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** @param {Camera} camera @returns {Camera} with angles as links have them, and within what can be traced */
export function valid({ azimuth, elevation, roll, zoom, panX, panY, fov }) {
  return {
    azimuth: ((azimuth % 360) + 360) % 360, elevation: clamp(elevation, -90, 90), roll: ((roll % 360) + 360) % 360,
    zoom: clamp(zoom, 0.2, 1000), panX: clamp(panX, -2, 2), panY: clamp(panY, -2, 2),
    fov: fov > 0 ? clamp(fov, 0.1, 175) : 0,
  };
}

/** Radii of the scene for a pixel, in perspective at the scene's centre. @param {Camera} camera @param {Size} size */
function pixelSize({ zoom, fov }, { height, width }) {
  const shorter = Math.min(width, height), slope = Math.tan(fov * Math.PI / 360) * shorter / height;
  return 2 * Math.hypot(1, slope) / (zoom * shorter);
}

/**
 * The camera that shows everything so many pixels farther right and down.
 *
 * @param {Camera} camera @param {Size} size @param {number} right @param {number} down
 */
export function panned(camera, size, right, down) {
  const pixel = pixelSize(camera, size);
  return valid({ ...camera, panX: camera.panX - right * pixel, panY: camera.panY + down * pixel });
}

/**
 * The camera that shows everything so many times as large about a place in the picture, which stays where it is.
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
