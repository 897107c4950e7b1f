// @ts-check
/**
 * Channels of a pixel, as in core/picture/channels.h, and layouts that list them.
 *
 * @typedef {readonly string[]} Layout names of channels, in the order of the components of planes (C, height, width)
 *   and samples (n, C)
 */

/** Number of components of each channel. @type {Readonly<Record<string, number>>} */
const COMPONENTS = { mask: 1, gray: 1, depth: 1, normal: 2, color: 3, albedo: 3, alpha: 1, instance: 1, shadow: 1, variance: 1 };

/** Channels of a G-buffer. @type {Layout} */
export const GBUFFER = ["mask", "gray", "depth", "normal"];

/** The same of scenes with colours. @type {Layout} */
export const COLORED = [...GBUFFER, "color"];

/**
 * The layout of samples, with 1 for a hit as the mask, and of a tracer's planes. First the displayed channels, then the
 * inputs for shading a reprojected picture.
 *
 * @param {Layout} shown GBUFFER or COLORED
 * @returns {Layout}
 */
export const tracedLayout = (shown) => [...shown, ...(shown === COLORED ? ["albedo"] : []), "instance"];

/** Number of components of a layout. @param {Layout} layout */
export const widthOf = (layout) => layout.reduce((sum, channel) => sum + COMPONENTS[channel], 0);

/** Index of a channel's first component in a layout. @param {Layout} layout @param {string} channel */
export const placeOf = (layout, channel) => widthOf(layout.slice(0, layout.indexOf(channel)));
