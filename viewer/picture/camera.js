// @ts-check
/**
 * The camera: its parameters, which no other place of the page checks. It is orthographic or, with a
 * fov, perspective.
 *
 * @typedef {{azimuth: number, elevation: number, roll: number, zoom: number, panX: number, panY: number, fov: number}} Camera
 *   as bobrossnet.Camera, in degrees; panX and panY translate it to the right and up, in radii of the scene
 * @typedef {{height: number, width: number}} Size of a picture, in pixels
 */

/** The default view; parameters in the order of the core and of links. @type {Readonly<Camera>} */
export const HOME = Object.freeze({ azimuth: 30, elevation: 20, roll: 0, zoom: 1, panX: 0, panY: 0, fov: 0 });

/** The default view of a scene with a front, 30 degrees to the right of it, as bobrossnet.picture.camera.FRONT. @type {Readonly<Camera>} */
export const FRONT = Object.freeze({ ...HOME, azimuth: 300 });

/** Vertical field of view when perspective is switched on, in degrees. */
export const PERSPECTIVE = 35;

export const FIELDS = /** @type {(keyof Camera)[]} */ (Object.keys(HOME));

/** A camera in the core's form. @param {Partial<Camera>} camera missing parameters default to the default view */
export const cameraValues = (camera) => Float32Array.from(FIELDS, (name) => camera[name] ?? HOME[name]);

/** @param {number} value @param {number} low @param {number} high */
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** @param {Camera} camera @returns {Camera} with angles normalised as in links, and clamped to the tracer's limits */
export function valid({ azimuth, elevation, roll, zoom, panX, panY, fov }) {
  return {
    azimuth: ((azimuth % 360) + 360) % 360, elevation: clamp(elevation, -90, 90), roll: ((roll % 360) + 360) % 360,
    zoom: clamp(zoom, 0.2, 1000), panX: clamp(panX, -2, 2), panY: clamp(panY, -2, 2),
    fov: fov > 0 ? clamp(fov, 0.1, 175) : 0,
  };
}

/**
 * The parameters that a page gives, as numbers.
 *
 * @param {Partial<Camera>} camera undefined ones are missing @returns {Partial<Camera>}
 * @throws {TypeError} unless they are finite numbers
 */
export function given(camera) {
  const names = FIELDS.filter((name) => camera[name] !== undefined), wrong = names.find((name) => !Number.isFinite(Number(camera[name])));
  if (wrong) throw new TypeError(`camera: expected finite numbers, got ${String(camera[wrong]).slice(0, 100)} as ${wrong}`);
  return Object.fromEntries(names.map((name) => [name, Number(camera[name])]));
}
