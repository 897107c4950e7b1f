// @ts-check
/**
 * Networks on the GPU, by WebGPU: the same weights and steps as the core's, in a page or a worker.
 *
 * @typedef {import("./weights.js").Weights} Weights
 * @typedef {import("./gpu/plan.js").Image} Image
 *
 * @callback NetworkOfLayers A network in gpu/NAME.js: makes its layers, and a function that records the steps for one
 *   size
 * @param {(name: string, inputs: number, outputs?: number) => Conv3x3} layer
 * @param {Weights} weights
 * @returns {(plan: Plan, inputs: Image) => Image} (C, height, width), the channels of the weights, to (1, height,
 *   width), linear and not clamped
 *
 * @typedef {object} Picture The resources for pictures of one size
 * @property {(planes: Float32Array) => Promise<Float32Array>} complete
 * @property {() => void} free
 */
import { GBUFFER, placeOf, widthOf } from "../picture/channels.js";
import { Conv3x3 } from "./gpu/conv3x3.js";
import { GPUMapMode } from "./gpu/flags.js";
import { kernel } from "./gpu/kernel.js";
import { paper } from "./gpu/paper.js";
import { Plan } from "./gpu/plan.js";
import { pyramid } from "./gpu/pyramid.js";

/** @type {Record<string, NetworkOfLayers>} */
const NETWORKS = { paper, pyramid };

/** Sizes whose memory is kept: a page has few at a time. */
const MOST_SIZES = 3;

/** Restores the traced pixels; clamps the others to 0..1, and NaN to 0. @param {Weights["inputs"]} inputs */
const keepKnown = (inputs) => kernel({
  read: ["pixels", "completed"], write: ["gray"],
  body: `
  let completed = completed_at(0, y, x);
  var value = 0.;
  if (completed > 0.) { value = min(completed, 1.); }
  if (pixels_at(${placeOf(inputs, "mask")}, y, x) > 0.) { value = pixels_at(${placeOf(inputs, "gray")}, y, x); }
  gray_put(0, y, x, value);`,
});

/**
 * A network on the GPU, or null if there is no GPU, or no network of this name for WebGPU.
 *
 * @param {Weights} weights
 * @param {{software?: boolean}} [options] software: accept a GPU emulated in software, which is always slower
 * @returns {Promise<GpuNetwork | null>}
 * @throws {Error} if the weights do not fit the network
 */
export async function createGpuNetwork(weights, { software = false } = {}) {
  const adapter = await globalThis.navigator?.gpu?.requestAdapter();
  if (!adapter || adapter.info.isFallbackAdapter && !software || !Object.hasOwn(NETWORKS, weights.network)) return null;
  const { maxBufferSize, maxStorageBufferBindingSize } = adapter.limits; // for large pictures
  const device = await adapter.requestDevice({ requiredLimits: { maxBufferSize, maxStorageBufferBindingSize } });
  try {
    return new GpuNetwork(device, weights);
  } catch (error) {
    device.destroy();
    throw error;
  }
}

export class GpuNetwork {
  #inputs;
  #network;
  /** @type {Promise<never>} */
  #failure;
  /** @type {Promise<unknown>} */
  #last = Promise.resolve();
  /** @type {Map<string, Promise<GPUComputePipeline>>} */
  #pipelines = new Map();
  /** Most recently used last. @type {Map<string, Picture>} */
  #pictures = new Map();

  /** @param {GPUDevice} device @param {Weights} weights */
  constructor(device, weights) {
    this.device = device;
    this.#inputs = weights.inputs;
    this.#network = NETWORKS[weights.network]((...layer) => new Conv3x3(device, weights, ...layer), weights);
    /** The reason once the device is lost: then all calls fail, including those in progress. @type {Promise<string>} */
    this.lost = device.lost.then(({ message }) => message || "no reason given");
    this.#failure = this.lost.then((message) => {
      throw new Error(`the GPU was lost: ${message}`);
    });
    this.#failure.catch(() => {});
  }

  /**
   * Completes the untraced pixels. Pictures are completed one after the other.
   *
   * @param {Float32Array} planes (C, height, width), of a G-buffer, unchanged until the promise resolves
   * @param {number} height
   * @param {number} width
   * @returns {Promise<Float32Array>} (height, width), 0..1
   * @throws {Error} if the device is lost or out of memory
   */
  complete(planes, height, width) {
    const picture = Promise.race([this.#failure, this.#last.then(() => this.#complete(planes, height, width))]);
    this.#last = picture.catch(() => {});
    return picture;
  }

  /** Rejects all calls in progress. */
  free() {
    this.device.destroy();
  }

  /** @type {GpuNetwork["complete"]} */
  async #complete(planes, height, width) {
    const channels = widthOf(GBUFFER);
    if (planes.length !== channels * height * width) {
      throw new Error(`planes: expected shape (${channels}, ${height}, ${width}), got ${planes.length} values`);
    }
    const size = `${width}x${height}`;
    const picture = this.#pictures.get(size) ?? await this.#prepare(height, width);
    this.#pictures.delete(size);
    this.#pictures.set(size, picture);
    for (const [oldest, { free }] of [...this.#pictures].slice(0, -MOST_SIZES)) {
      free();
      this.#pictures.delete(oldest);
    }
    return picture.complete(planes);
  }

  /**
   * Memory and pipelines for pictures of one size.
   *
   * @param {number} height
   * @param {number} width
   * @returns {Promise<Picture>}
   */
  async #prepare(height, width) {
    const { device } = this, plan = new Plan(device, (source) => this.#compile(source));
    device.pushErrorScope("out-of-memory");
    device.pushErrorScope("validation");
    /** @type {Promise<Picture>} */
    const preparing = (async () => {
      const inputs = plan.image(widthOf(this.#inputs), height, width), gray = plan.image(1, height, width);
      const completed = this.#network(plan, inputs);
      plan.step(keepKnown(this.#inputs), { pixels: inputs, completed, gray });
      const readback = plan.readback(gray.buffer.size), run = await plan.finished();
      return {
        complete: async (planes) => {
          this.#write(inputs, planes);
          const encoder = device.createCommandEncoder();
          run(encoder);
          encoder.copyBufferToBuffer(gray.buffer, 0, readback, 0, readback.size);
          device.queue.submit([encoder.finish()]);
          await readback.mapAsync(GPUMapMode.READ);
          const result = new Float32Array(readback.getMappedRange()).slice();
          readback.unmap();
          return result;
        },
        free: () => plan.free(),
      };
    })();
    const failure = await preparing.then(() => null, (error) => error);
    const found = [failure, await device.popErrorScope(), await device.popErrorScope()].find((error) => error);
    if (!found) return preparing;
    plan.free();
    throw new Error(found.message.split("\n")[0]);
  }

  /** Copies the network's inputs from a G-buffer's planes. @param {Image} image @param {Float32Array} planes */
  #write({ buffer, height, width }, planes) {
    let at = 0;
    for (const channel of this.#inputs) {
      const size = widthOf([channel]) * height * width;
      this.device.queue.writeBuffer(buffer, 4 * at, planes, placeOf(GBUFFER, channel) * height * width, size);
      at += size;
    }
  }

  /** @param {string} source */
  #compile(source) {
    const found = this.#pipelines.get(source);
    if (found) return found;
    const module = this.device.createShaderModule({ code: source });
    const pipeline = this.device.createComputePipelineAsync({ layout: "auto", compute: { module } });
    this.#pipelines.set(source, pipeline);
    return pipeline;
  }
}
