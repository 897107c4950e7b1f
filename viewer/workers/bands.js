// @ts-check
/**
 * Bands of a picture, each completed by another worker: one leads, and what the others complete is put into its picture.
 *
 * There is no shared memory, so each has all samples in a G-buffer of its own, and computes the coarse levels of the whole picture.
 *
 * @typedef {import("../completion/network.js").Band} Band
 * @typedef {import("../completion/network.js").Network} Network
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer
 * @typedef {import("../picture/planner.js").Model} Model
 * @typedef {import("./tracer.js").Samples} Samples
 *
 * @typedef {{kind: "samples", part: Samples} | {kind: "complete", model: Model, band: Band}} Help
 *   from the one that leads: all that was traced of a view; "complete" is answered by the band's rows of the completed picture, (n, width), or
 *   by null where that network has not come yet. A first null says that it can help from now on
 */

/** The workers that help the one that leads. */
export class Helpers {
  /** @type {MessagePort[]} */
  #ports = [];

  /** @param {MessagePort} port to one that can help */
  add(port) {
    this.#ports.push(port);
  }

  /**
   * Whether they save time in a view: not where the filling completes it, nor where earlier views let
   * expect it: these samples and planes take as long to copy as there is to gain.
   *
   * @param {Samples} part the view's first
   */
  areWorth({ model, expected }) {
    return this.#ports.length > 0 && expected === null && model !== "filling";
  }

  /** Gives them what was traced. @param {Samples} part */
  share({ pixels, samples, ...rest }) {
    for (const port of this.#ports) {
      const part = { ...rest, pixels: pixels.slice(), samples: samples.slice() };
      port.postMessage({ kind: "samples", part }, [part.pixels.buffer, part.samples.buffer]);
    }
  }

  /** Completes a picture of which they have all samples. @param {Model} model @param {Network} network of this name @param {GBuffer} gbuffer */
  async complete(model, network, gbuffer) {
    const { height, width } = gbuffer, begin = (/** @type {number} */ i) => Math.round(i * height / (this.#ports.length + 1));
    const answers = this.#ports.map((port, i) => new Promise((/** @type {(band: {begin: number, rows: Float32Array | null}) => void} */ resolve) => {
      const band = { begin: begin(i + 1), end: begin(i + 2) };
      port.onmessage = ({ data }) => resolve({ begin: band.begin, rows: data });
      port.postMessage({ kind: "complete", model, band });
    }));
    network.complete(gbuffer, { begin: 0, end: begin(1) });
    const others = await Promise.all(answers);
    if (others.some(({ rows }) => rows === null)) network.complete(gbuffer);
    else for (const { begin, rows } of others) rows && gbuffer.image.set(rows, begin * width);
  }
}
