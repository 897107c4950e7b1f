// @ts-check
/**
 * Completes pictures in WebAssembly, or on the GPU where that is measured to take at most half of the time.
 *
 * Decided for each size of pictures. WebAssembly completes the first ones and gets faster meanwhile. Then the GPU is
 * given one of them while the page continues. If it succeeds and agrees, both complete the next few, and the faster one
 * does the rest. If anything goes wrong on the GPU, at any time, WebAssembly takes over for that size.
 *
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer
 * @typedef {import("./weights.js").Weights} Weights
 * @typedef {Pick<import("./gpu.js").GpuNetwork, "complete" | "free">} Rival
 *
 * @typedef {object} Trial The state of one size of pictures
 * @property {"waiting" | "preparing" | "comparing" | "wasm" | "gpu"} state the last two are decisions
 * @property {number} pictures completed so far
 * @property {number[]} wasm milliseconds of the pictures completed by both
 * @property {number[]} gpu
 */
import { Network } from "./network.js";

/** Pictures before the GPU is tried: the first are urgent, and some sizes soon change again. */
const FIRST = 5;
/** Pictures completed by both. */
const RUNS = 5;
/** Maximum difference of gray levels 0..1 at any pixel. */
const TOLERANCE = 1e-4;
/**
 * Minimum speed of the GPU relative to one worker.
 *
 * With the default network an H200 was 2.3 to 3.4 times as fast as one worker, or as fast as 1.9 to 2.4 workers that
 * share a picture; with the small network, 1.7 times as fast (docs/viewer.md). A smaller factor buys little for a first
 * picture that waits up to .6 s for the GPU's compiler.
 */
const GAIN = 2;

/** Fetches the GPU code only when it is tried. @param {Weights} weights */
const createLater = async (weights) => (await import("./gpu.js")).createGpuNetwork(weights);

export class Completer {
  /** The backend of the latest picture. @type {"wasm" | "gpu"} */
  backend = "wasm";
  #createRival;
  /** Undefined before the request, null if unavailable. @type {Rival | null | undefined} */
  #rival;
  /** Trials by size. @type {Map<string, Trial>} */
  #trials = new Map();

  /**
   * @param {Core} core whose G-buffers are completed
   * @param {Weights} weights
   * @param {(weights: Weights) => Promise<Rival | null>} [createRival]
   */
  constructor(core, weights, createRival = createLater) {
    this.network = new Network(core, weights);
    this.#createRival = () => createRival(weights);
  }

  /**
   * Completes the untraced pixels, one picture at a time.
   *
   * @param {GBuffer} gbuffer unchanged until the promise resolves
   * @param {() => Promise<void>} [inBands] completes it in WebAssembly as `network` does, together with other workers
   * @returns {Promise<Float32Array>} its `image`
   */
  async complete(gbuffer, inBands) {
    const { height, width } = gbuffer, size = `${width}x${height}`;
    if (gbuffer.traced === height * width) {
      gbuffer.image.set(gbuffer.plane("gray"));
      return gbuffer.image;
    }
    const trial = this.#trials.get(size) ?? { state: "waiting", pictures: 0, wasm: [], gpu: [] };
    this.#trials.set(size, trial);
    const isTried = trial.state === "gpu" || trial.state === "comparing" || trial.state === "waiting" && this.#rival !== null;
    if (inBands && !isTried) {
      await inBands();
      this.backend = "wasm";
    } else {
      await this.#fill(gbuffer, trial);
      this.network.interpolate(gbuffer);
    }
    return gbuffer.image;
  }

  /** Completes with the network on the chosen backend. @param {GBuffer} gbuffer @param {Trial} trial */
  async #fill(gbuffer, trial) {
    if (trial.state === "gpu" && await this.#fillOnGpu(gbuffer, trial)) return;

    const begin = performance.now();
    this.network.fill(gbuffer);
    const milliseconds = performance.now() - begin;
    this.backend = "wasm";
    ++trial.pictures;
    if (trial.state === "waiting" && trial.pictures >= FIRST) {
      if (this.#rival) this.#prepare(this.#rival, gbuffer, trial);
      else if (this.#rival === undefined) this.#askForRival();
    } else if (this.#rival && trial.state === "comparing") {
      trial.wasm.push(milliseconds);
      await this.#compare(this.#rival, gbuffer, trial);
    }
  }

  free() {
    this.network.free();
    this.#rival?.free();
  }

  /** Requests the GPU network for later pictures. */
  #askForRival() {
    this.#rival = null;
    this.#createRival().then((rival) => { this.#rival = rival; }, () => {});
  }

  /** @param {GBuffer} gbuffer @param {Trial} trial @returns {Promise<boolean>} whether it did */
  async #fillOnGpu(gbuffer, trial) {
    try {
      const picture = await /** @type {Rival} */ (this.#rival).complete(gbuffer.planes, gbuffer.height, gbuffer.width);
      gbuffer.image.set(picture);
      this.backend = "gpu";
      return true;
    } catch {
      trial.state = "wasm";
      return false;
    }
  }

  /**
   * Completes the GPU's first picture in the background: compiling takes long.
   *
   * @param {Rival} rival
   * @param {GBuffer} gbuffer
   * @param {Trial} trial
   */
  async #prepare(rival, { planes, image, height, width }, trial) {
    trial.state = "preparing";
    const expected = image.slice();
    try {
      const picture = await rival.complete(planes.slice(), height, width);
      trial.state = expected.every((gray, i) => Math.abs(gray - picture[i]) <= TOLERANCE) ? "comparing" : "wasm";
    } catch {
      trial.state = "wasm";
    }
  }

  /** @param {Rival} rival @param {GBuffer} gbuffer @param {Trial} trial */
  async #compare(rival, { planes, height, width }, trial) {
    try {
      const begin = performance.now();
      await rival.complete(planes, height, width);
      trial.gpu.push(performance.now() - begin);
    } catch {
      trial.state = "wasm";
      return;
    }
    const wasm = median(trial.wasm), gpu = median(trial.gpu);
    if (gpu > wasm) trial.state = "wasm"; // each trial delays a picture
    else if (trial.gpu.length === RUNS) trial.state = GAIN * gpu <= wasm ? "gpu" : "wasm";
  }
}

/** @param {number[]} numbers */
function median(numbers) {
  return numbers.toSorted((a, b) => a - b)[numbers.length >> 1];
}
