// @ts-check
/** Networks, which complete what was traced in part. */

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer of the same core
 */

export class Network {
  /** @param {Core} core @param {import("./weights.js").Weights} weights */
  constructor(core, { network, inputs, outputs, tensors }) {
    this.core = core;
    const weights = core.made("make_weights", inputs.join(), outputs.join());
    /** @type {number[]} */
    const addresses = [];
    try {
      for (const [name, { shape, values }] of tensors) {
        const address = core.put(values);
        addresses.push(address);
        core.made("add_tensor", weights, name, Int32Array.from(shape), shape.length, address);
      }
      this.handle = core.made("make_network", network, weights);
    } finally {
      core.call("free_weights", weights);
      for (const address of addresses) core.release(address);
    }
  }

  /** Fills in what was not traced. @param {GBuffer} gbuffer @returns {Float32Array} its `image` */
  complete(gbuffer) {
    this.predict(gbuffer);
    this.core.made("keep_known", this.handle, gbuffer.address, gbuffer.height * gbuffer.width, gbuffer.imageAddress);
    return gbuffer.image;
  }

  /** The network's own output at every pixel. @param {GBuffer} gbuffer @returns {Float32Array} its `image` */
  predict(gbuffer) {
    const { address, height, width, imageAddress } = gbuffer;
    this.core.made("run_network", this.handle, address, height, width, imageAddress);
    return gbuffer.image;
  }

  free() {
    this.core.call("free_network", this.handle);
  }
}
