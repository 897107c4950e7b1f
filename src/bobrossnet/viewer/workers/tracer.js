// @ts-check
/**
 * A worker that traces pixels of a scene: some of each batch's, the others are other workers' part.
 *
 * It works in slices of a few milliseconds, between which it looks for messages, so that a batch that nobody waits for any more
 * ends at once. Samples go straight to the worker that completes the picture.
 *
 * @typedef {{
 *   id: number, view: number, parts: number, camera: import("../picture/camera.js").Camera, height: number, width: number,
 *   from: number, to: number, milliseconds: number
 * }} Batch
 *   The pixels `from` to `to` of the order, multiples of CHUNK or the order's end; chunks go in turn to each of `parts` tracers,
 *   which stop after so many milliseconds. Batches of one view have one camera and size, and add to one picture.
 *
 * @typedef {{kind: "samples", batch: Batch, count: number, pixels: Int32Array, samples: Float32Array}} Samples
 *   to the completing worker: pixels (n, 2), row and column; samples (n, C), as Scene.trace returns them; of both the first
 *   `count` rows, since they are sent in the memory that they were written to
 *
 * @typedef {{kind: "start", module: WebAssembly.Module}
 *   | {kind: "connect", completing: MessagePort, reading: MessagePort}
 *   | {kind: "open", scene: import("../tracing/description.js").SceneDescription}
 *   | {kind: "trace", batch: Batch, part: number}
 *   | {kind: "cancel"}} Request
 *   "start" and "connect" come once; "open", which may also come through the port `reading`, is answered by "opened" or
 *   "failed", in which case the previous scene stays; "trace" is answered by "traced", after "cancel" at once, or by
 *   "failed".
 *
 * @typedef {{kind: "opened", warnings: string[]}
 *   | {kind: "failed", message: string, broken: boolean}
 *   | {kind: "traced", batch: Batch, cancelled: boolean, reached: number, rays: number, milliseconds: number}} Reply
 *   warnings: a line each; broken: the core is unusable; cancelled: no samples were sent; reached: this tracer's part of the order is traced up to
 *   there
 */
import { Core } from "../core/core.js";
import { CoreError } from "../core/errors.js";
import { WIDTH } from "../picture/channels.js";
import { pixelOrder } from "../picture/order.js";
import { buildScene } from "../tracing/scene.js";
import { CHUNK, Pace } from "./pace.js";

const SLICE_MS = 5;
const FIRST_SLICE = 32; // pixels, while nothing is known
const GROWTH = 8; // times the last slice's pixels, at most: a small slice says little about a large one

/** @type {(core: Core) => void} */
let start;
/** @type {Promise<Core>} */
const starting = new Promise((resolve) => (start = resolve));
/** @type {MessagePort} */
let completing;
/** @type {import("../tracing/scene.js").Scene | undefined} */
let scene;
/** Pixel orders by size: of the two that pictures have last had, in motion and at rest. @type {Map<string, Int32Array>} */
const orders = new Map();
let pace = new Pace();
let cancelled = false;

/** @param {Reply} message */
const reply = (message) => postMessage(message);

const { port1: resumed, port2: resume } = new MessageChannel();

/** Lets messages be handled; a timer would take four milliseconds. */
const messages = () => new Promise((resolve) => {
  resumed.onmessage = resolve;
  resume.postMessage(0);
});

/** @param {import("../tracing/description.js").SceneDescription} description */
async function open(description) {
  try {
    const core = await starting;
    const built = buildScene(core, description);
    scene?.free();
    scene = built;
    pace = new Pace();
    reply({ kind: "opened", warnings: built.warnings });
  } catch (error) {
    fail(error);
  }
}

/** Any error that the core does not report itself is fatal: mostly, it ran out of memory. @param {unknown} error */
function fail(error) {
  const message = error instanceof Error ? error.message : String(error);
  reply(error instanceof CoreError ? { kind: "failed", message, broken: false }
                                   : { kind: "failed", message: `the scene is too much for this page: ${message}`, broken: true });
}

/** @param {Core} core @param {Batch} batch @returns {Int32Array} all pixels of its size, (n, 2), as they are traced */
function orderOf(core, { height, width }) {
  const size = `${height}x${width}`, order = orders.get(size) ?? pixelOrder(core, "lattice", { height, width });
  orders.delete(size);
  for (const other of [...orders.keys()].slice(0, -1)) orders.delete(other);
  orders.set(size, order);
  return order;
}

/** @param {Batch} batch @param {number} part */
async function trace(batch, part) {
  cancelled = false;
  const core = await starting;
  if (!scene) throw new Error("trace: expected an open scene");
  const { camera, from, to, parts } = batch, order = orderOf(core, batch);
  const begin = performance.now(), end = begin + batch.milliseconds;
  const stride = CHUNK * parts;
  let chunk = CHUNK * (Math.ceil((from / CHUNK - part) / parts) * parts + part); // the first of this part
  const most = CHUNK * Math.ceil(Math.max(0, to - chunk) / stride);
  const pixels = new Int32Array(2 * most), samples = new Float32Array(WIDTH * most);
  let count = 0, last = FIRST_SLICE / GROWTH;
  while (chunk < to && !cancelled) {
    const begun = performance.now();
    if (begun >= end) break;
    const wanted = pace.known ? Math.min(pace.rate * Math.min(SLICE_MS, end - begun), GROWTH * last) : FIRST_SLICE;
    const first = count;
    do {
      const stop = Math.min(chunk + CHUNK, to);
      pixels.set(order.subarray(2 * chunk, 2 * stop), 2 * count);
      count += stop - chunk, chunk += stride;
    } while (chunk < to && count - first < wanted);
    last = count - first;
    const written = samples.subarray(WIDTH * first, WIDTH * count);
    scene.trace(pixels.subarray(2 * first, 2 * count), batch, camera, written);
    pace.measured(last, performance.now() - begun);
    await messages();
  }
  if (!cancelled) {
    /** @type {Samples} */
    const message = { kind: "samples", batch, count, pixels, samples };
    completing.postMessage(message, [pixels.buffer, samples.buffer]);
  }
  const milliseconds = performance.now() - begin;
  reply({ kind: "traced", batch, cancelled, reached: Math.min(chunk, to), rays: count, milliseconds });
}

/** @param {MessageEvent<Request>} event */
function receive({ data }) {
  if (data.kind === "start") {
    start(new Core(new WebAssembly.Instance(data.module)));
  } else if (data.kind === "connect") {
    completing = data.completing;
    data.reading.onmessage = receive;
  } else if (data.kind === "open") {
    cancelled = true;
    open(data.scene);
  } else if (data.kind === "trace") {
    trace(data.batch, data.part).catch(fail);
  } else {
    cancelled = true;
  }
}

onmessage = receive;
