// @ts-check
/** Pixel orders: the sequence in which the pixels of a picture are traced. */

/**
 * Pixels in their order.
 *
 * @param {import("../core/core.js").Core} core
 * @param {string} order its name, as in bobrossnet.pixel_order, but for "default"
 * @param {{height: number, width: number, seed?: number | bigint, start?: number, count?: number}} which
 * @returns {Int32Array} (count, 2), row and column
 */
export function pixelOrder(core, order, { height, width, seed = 0, start = 0, count = height * width - start }) {
  const bits = BigInt.asUintN(64, BigInt(seed));
  return core.filled(new Int32Array(2 * count), (address) => {
    core.made("pixel_order", order, Number(bits & 0xffffffffn), Number(bits >> 32n), height, width, start, address, count);
  });
}
