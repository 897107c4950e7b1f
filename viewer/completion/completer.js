// @ts-check
/**
 * Completes pictures in WebAssembly, or on the GPU where that is measured to take at most half of the time.
 *
 * For each size of pictures: WebAssembly completes the first ones, and gets faster in doing so. Then the GPU is given
 * one of them while the page continues; if it succeeds and agrees, both complete the next few, and one of them does
 * the rest. If anything goes wrong on the GPU, at any time, WebAssembly takes over for that size.
 *
 * @typedef {import("../core/core.js").Core} Core
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer
 * @typedef {import("./weights.js").Weights} Weights
 * @typedef {Pick<import("./gpu.js").GpuNetwork, "complete" | "free">} Rival
 *
 * @typedef {object} Trial What is known of one size of pictures
 * @property {"waiting" | "preparing" | "comparing" | "wasm" | "gpu"} state the last two are decisions
 * @property {number} pictures so far
 * @property {number[]} wasm milliseconds of the pictures that both completed
 * @property {number[]} gpu
 */
import { Network } from "./network.js";

/** Pictures before a GPU is looked for and tried: the first are urgent, and some sizes soon change again. */
const FIRST = 5;
/** Pictures that both complete. */
const RUNS = 5;
/** Between gray levels of 0..1, at any pixel. */
const TOLERANCE = 1e-4;
/**
 * How many times as fast the GPU must be as one worker. An H200 was 2.3 to 3.4 times with the default network, and as fast as 1.9
 * to 2.4 such workers that share a picture; with the small network 1.7 times (docs/viewer.md). A smaller factor buys little for
 * a first picture that waits up to .6 s for the GPU's compiler.
 */
const GAIN = 2;

/** The GPU code is only fetched when it is tried. @param {Weights} weights */
const createLater = async (weights) => (await import("./gpu.js")).createGpuNetwork(weights);

export class Completer {
  /** What completed the latest picture. @type {"wasm" | "gpu"} */
  backend = "wasm";
  #createRival;
  /** Undefined until it was requested, null if there is none. @type {Rival | null | undefined} */
  #rival;
  /** By size. @type {Map<string, Trial>} */
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
   * Fills in what was not traced: one picture at a time.
   *
   * @param {GBuffer} gbuffer which stays as it is until the promise resolves
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

  /** By the network, where it was decided. @param {GBuffer} gbuffer @param {Trial} trial */
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

  /** Later pictures have it. */
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
   * The GPU's first picture, which nothing waits for: compiling takes long.
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
    if (gpu > wasm) trial.state = "wasm"; // a picture waits for each try
    else if (trial.gpu.length === RUNS) trial.state = GAIN * gpu <= wasm ? "gpu" : "wasm";
  }
}

/** @param {number[]} numbers */
function median(numbers) {
  return numbers.toSorted((a, b) => a - b)[numbers.length >> 1];
}
