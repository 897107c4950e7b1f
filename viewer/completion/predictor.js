// @ts-check
/** Prediction of the error of completed pictures. */
import { withWeights } from "./weights.js";

/**
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer of the same core
 * @typedef {import("./network.js").Network} Network
 */

export class ErrorPredictor {
  /** @param {Core} core @param {import("./weights.js").Weights} weights */
  constructor(core, weights) {
    this.core = core;
    this.handle = withWeights(core, weights, (handle) => core.made("make_predictor", handle));
  }

  /**
   * Predicts the absolute error of each pixel that a network completes, in gray; 0 where traced.
   *
   * @param {GBuffer} gbuffer
   * @param {Network} network
   * @returns {Float32Array} (height, width)
   */
  predict(gbuffer, network) {
    const { height, width } = gbuffer, size = height * width, memory = this.core.allocate(2 * 4 * size);
    try {
      network.predict(gbuffer, memory);
      this.core.made("predict_error", this.handle, gbuffer.address, memory, height, width, memory + 4 * size);
      return new Float32Array(this.core.memory, memory + 4 * size, size).slice();
    } finally {
      this.core.release(memory);
    }
  }

  free() {
    this.core.call("free_predictor", this.handle);
  }
}
