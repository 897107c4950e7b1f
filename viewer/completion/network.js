// @ts-check
/**
 * Networks that complete sparsely traced pictures.
 *
 * @typedef {{begin: number, end: number}} Band rows of a picture; `end` is excluded
 */
import { withWeights } from "./weights.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer of the same core
 */

export class Network {
  /** @param {Core} core @param {import("./weights.js").Weights} weights */
  constructor(core, weights) {
    this.core = core;
    this.handle = withWeights(core, weights, (handle) => core.made("make_network", weights.network, handle));
  }

  /**
   * Completes the untraced pixels.
   *
   * @param {GBuffer} gbuffer @param {Band} [band] rows to finish
   * @returns {Float32Array} its `image`
   */
  complete(gbuffer, band) {
    this.fill(gbuffer, band);
    this.interpolate(gbuffer, band);
    return gbuffer.image;
  }

  /**
   * With the network alone, without interpolation.
   *
   * @param {GBuffer} gbuffer @param {Band} [band] @returns {Float32Array} its `image`
   */
  fill(gbuffer, band) {
    this.predict(gbuffer, gbuffer.imageAddress, band);
    this.core.made("keep_known", this.handle, gbuffer.address, gbuffer.height * gbuffer.width, gbuffer.imageAddress);
    return gbuffer.image;
  }

  /**
   * The network's own output at every pixel.
   *
   * @param {GBuffer} gbuffer @param {number} output address of the result, (height, width) @param {Band} [band]
   */
  predict({ address, height, width }, output, { begin, end } = { begin: 0, end: height }) {
    this.core.made("run_network", this.handle, address, height, width, output, begin, end);
  }

  /** Interpolates the completed image where nearby traced pixels agree. @param {GBuffer} gbuffer @param {Band} [band] */
  interpolate({ address, height, width, imageAddress }, { begin, end } = { begin: 0, end: height }) {
    this.core.made("interpolate_lattice", this.handle, address, height, width, imageAddress, begin, end);
  }

  free() {
    this.core.call("free_network", this.handle);
  }
}
