// @ts-check
/**
 * What is known of a pixel, channel by channel, as core/picture/channels.h has it; and the layouts that list channels.
 *
 * @typedef {readonly string[]} Layout names of channels, in the order in which planes (C, height, width) and samples (n, C)
 *   have their components
 */

/** How many components each channel has. @type {Readonly<Record<string, number>>} */
const COMPONENTS = { mask: 1, gray: 1, depth: 1, normal: 2, color: 3, albedo: 3, alpha: 1, instance: 1, shadow: 1, variance: 1 };

/** Of a G-buffer. @type {Layout} */
export const GBUFFER = ["mask", "gray", "depth", "normal"];

/** The same of scenes with colours. @type {Layout} */
export const COLORED = [...GBUFFER, "color"];

/**
 * Of samples, in which the mask says whether the ray hit, and of the planes in which a tracer keeps them: behind what a picture
 * shows, what a moving camera needs to shade it anew.
 *
 * @param {Layout} shown GBUFFER or COLORED
 * @returns {Layout}
 */
export const tracedLayout = (shown) => [...shown, ...(shown === COLORED ? ["albedo"] : []), "instance"];

/** How many components a layout has in all. @param {Layout} layout */
export const widthOf = (layout) => layout.reduce((sum, channel) => sum + COMPONENTS[channel], 0);

/** Where a layout has a channel's first component. @param {Layout} layout @param {string} channel */
export const placeOf = (layout, channel) => widthOf(layout.slice(0, layout.indexOf(channel)));
