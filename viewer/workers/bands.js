// @ts-check
/**
 * Bands of a picture, each completed by another worker. One worker leads and gathers the bands.
 *
 * There is no shared memory: each worker has all samples in a separate G-buffer, and computes the coarse levels of the
 * whole picture.
 *
 * @typedef {import("../completion/network.js").Band} Band
 * @typedef {import("../completion/network.js").Network} Network
 * @typedef {import("../picture/gbuffer.js").GBuffer} GBuffer
 * @typedef {import("../picture/planner.js").Model} Model
 * @typedef {import("./tracer.js").Samples} Samples
 *
 * @typedef {{kind: "samples", part: Samples} | {kind: "complete", model: Model, band: Band}} Help
 *   from the leader: all samples of a view; "complete" is answered by the band's rows of the completed picture, (n,
 *   width), or by null if the network has not arrived yet. An initial null reports that the helper is ready
 */

/** The workers that help the leader. */
export class Helpers {
  /** @type {MessagePort[]} */
  #ports = [];

  /** @param {MessagePort} port to a helper that is ready */
  add(port) {
    this.#ports.push(port);
  }

  /**
   * Whether they save time in a view. They do not with the filling, nor with reprojected samples: copying samples and
   * planes costs the gain.
   *
   * @param {Samples} part the view's first
   */
  areWorth({ model, expected }) {
    return this.#ports.length > 0 && expected === null && model !== "filling";
  }

  /** Sends them the samples. @param {Samples} part */
  share({ pixels, samples, ...rest }) {
    for (const port of this.#ports) {
      const part = { ...rest, pixels: pixels.slice(), samples: samples.slice() };
      port.postMessage({ kind: "samples", part }, [part.pixels.buffer, part.samples.buffer]);
    }
  }

  /**
   * Completes a picture whose samples they all have.
   *
   * @param {Model} model @param {Network} network of this name @param {GBuffer} gbuffer
   */
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
