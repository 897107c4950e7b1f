// @ts-check
/** Networks, which complete what was traced in part. */
import { withWeights } from "./weights.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer of the same core
 */

/** Share of the pixels from which on the filling is as good as any network, be they traced or expected (docs/benchmarks.md). */
export const DENSE = 0.05;

export class Network {
  /** @param {Core} core @param {import("./weights.js").Weights} weights */
  constructor(core, weights) {
    this.core = core;
    this.handle = withWeights(core, weights, (handle) => core.made("make_network", weights.network, handle));
  }

  /** Fills in what was not traced. @param {GBuffer} gbuffer @returns {Float32Array} its `image` */
  complete(gbuffer) {
    this.fill(gbuffer);
    this.interpolate(gbuffer);
    return gbuffer.image;
  }

  /** By the network alone. @param {GBuffer} gbuffer @returns {Float32Array} its `image` */
  fill(gbuffer) {
    this.predict(gbuffer, gbuffer.imageAddress);
    this.core.made("keep_known", this.handle, gbuffer.address, gbuffer.height * gbuffer.width, gbuffer.imageAddress);
    return gbuffer.image;
  }

  /** The network's own output at every pixel. @param {GBuffer} gbuffer @param {number} output where it is written, (height, width) */
  predict({ address, height, width }, output) {
    this.core.made("run_network", this.handle, address, height, width, output);
  }

  /** Improves what was filled in where traced pixels around agree. @param {GBuffer} gbuffer */
  interpolate({ address, height, width, imageAddress }) {
    this.core.made("interpolate_lattice", this.handle, address, height, width, imageAddress);
  }

  free() {
    this.core.call("free_network", this.handle);
  }
}
