// @ts-check
/** Lines of a batch, for tracers. */

/** Rows of exact lines in a slice: each looks at a few rows more, and movement waits for the slice under way. */
export const BAND = 64;

/** Share of a moving picture's time for its lines. */
export const LINES_SHARE = 0.4;

/** The same under lights, where first hits and completing take most of the time. */
export const LIT_LINES_SHARE = 0.2;

const STEPS = [1, 2, 3, 4, 6, 8]; // pixels between first hits of coarse lines

/**
 * Coarse lines of a picture in motion.
 *
 * @param {import("../tracing/scene.js").Scene} scene @param {import("./tracer.js").Batch} batch @param {number} milliseconds at most, if possible
 * @returns {Uint8Array} (height, width), the share of each pixel that lines cover, 0..255
 */
export function coarseLines(scene, { camera, height, width, thickness }, milliseconds) {
  const hits = (/** @type {number} */ step) => height * width / step ** 2, begin = performance.now();
  const step = STEPS.find((each) => scene.lineMs * hits(each) < milliseconds) ?? STEPS[STEPS.length - 1];
  const covered = scene.coarseLines({ height, width }, camera, thickness, step);
  scene.lineMs = (performance.now() - begin) / hits(step);
  return covered;
}
