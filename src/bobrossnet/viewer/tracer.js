// @ts-check
/**
 * A worker that traces pixels of a scene: some of each frame's, the others are other workers' part.
 *
 * It works in slices of a few milliseconds, between which it looks for messages, so that a frame that nobody waits for any more
 * ends at once. Samples go straight to the worker that completes the picture.
 *
 * @typedef {{
 *   id: number, view: number, parts: number, camera: import("./core.js").Camera, height: number, width: number,
 *   from: number, to: number, milliseconds: number
 * }} Frame
 *   The pixels `from` to `to` of the order, multiples of CHUNK or the order's end; chunks go in turn to each of `parts` tracers,
 *   which stop after so many milliseconds. Frames of one view have one camera and size, and add to one picture.
 *
 * @typedef {{kind: "samples", frame: Frame, pixels: Int32Array, values: Float32Array}} Samples
 *   to the completing worker: pixels (n,), row * width + column; values (n, 4), gray, depth, normal x and y
 *
 * @typedef {{kind: "start", module: WebAssembly.Module}
 *   | {kind: "connect", completing: MessagePort, reading: MessagePort}
 *   | {kind: "open", scene: import("./scene.js").SceneDescription}
 *   | {kind: "trace", frame: Frame, part: number}
 *   | {kind: "cancel"}} Request
 *   "start" and "connect" come once; "open", which may also come through the port `reading`, is answered by "opened" or "failed", and then
 *   the scene before stays; "trace" is answered by "traced", and after "cancel" at once.
 *
 * @typedef {{kind: "opened", memory: number}
 *   | {kind: "failed", message: string, broken: boolean}
 *   | {kind: "traced", frame: Frame, cancelled: boolean, reached: number, rays: number, milliseconds: number}} Reply
 *   memory: bytes of this worker's core; broken: the core can't go on; cancelled: no samples were sent; reached: this tracer's
 *   part of the order is traced up to there
 */
import { Core } from "./core.js";
import { CoreError } from "./errors.js";
import { CHUNK, Pace } from "./pace.js";
import { buildScene } from "./scene.js";

const SLICE_MS = 5;
const FIRST_SLICE = 32; // pixels, while nothing is known
const GROWTH = 8; // a slice has at most so many times the pixels of the last: a small one says little of a large one

/** @type {(core: Core) => void} */
let start;
/** @type {Promise<Core>} */
const starting = new Promise((resolve) => (start = resolve));
/** @type {MessagePort} */
let completing;
/** @type {import("./scene.js").BuiltScene | undefined} */
let scene;
/** @typedef {{height: number, width: number, gbuffer: import("./core.js").GBuffer, order: Int32Array}} Raster */
/** Of the two sizes that pictures have last had: in motion and at rest. @type {Raster[]} */
let rasters = [];
let pace = new Pace();
let cancelled = false;

/** @param {Reply} message */
const reply = (message) => postMessage(message);

const { port1: resumed, port2: resume } = new MessageChannel();

/** Lets messages in; a timer would take four milliseconds. */
const messages = () => new Promise((resolve) => {
  resumed.onmessage = resolve;
  resume.postMessage(0);
});

/** @param {import("./scene.js").SceneDescription} description */
async function open(description) {
  try {
    const core = await starting;
    const built = buildScene(core, description);
    scene?.free();
    scene = built;
    pace = new Pace();
    reply({ kind: "opened", memory: core.memory.byteLength });
  } catch (error) {
    const message = error instanceof Error ? error.message : String(error);
    reply(error instanceof CoreError ? { kind: "failed", message, broken: false }
                                     : { kind: "failed", message: `the scene is too much for this page: ${message}`, broken: true });
  }
}

/** The G-buffer and the order of a size. @param {number} height @param {number} width @returns {Promise<Raster>} */
async function rasterOf(height, width) {
  const core = await starting;
  const known = rasters.find((raster) => raster.height === height && raster.width === width);
  if (known) return known;
  for (const { gbuffer } of rasters.splice(1)) gbuffer.free();
  const order = core.pixelOrder("lattice", { height, width });
  rasters.unshift({ height, width, gbuffer: core.gbuffer(height, width), order });
  return rasters[0];
}

/** @param {Frame} frame @param {number} part */
async function trace(frame, part) {
  cancelled = false;
  const { camera, height, width, from, to, parts } = frame;
  const { gbuffer, order } = await rasterOf(height, width);
  const begin = performance.now(), end = begin + frame.milliseconds;
  if (!scene) throw new Error("trace: expected an open scene");
  const stride = CHUNK * parts;
  let chunk = CHUNK * (Math.ceil((from / CHUNK - part) / parts) * parts + part); // the first of this part
  const most = CHUNK * Math.ceil(Math.max(0, to - chunk) / stride);
  const indices = new Int32Array(most), values = new Float32Array(4 * most);
  let count = 0, last = FIRST_SLICE / GROWTH;
  while (chunk < to && !cancelled) {
    const begun = performance.now();
    if (begun >= end) break;
    const wanted = pace.known ? Math.min(pace.rate * Math.min(SLICE_MS, end - begun), GROWTH * last) : FIRST_SLICE;
    const first = count;
    do {
      for (let place = chunk; place < Math.min(chunk + CHUNK, to); ++place) {
        indices[count++] = order[2 * place] * width + order[2 * place + 1];
      }
      chunk += stride;
    } while (chunk < to && count - first < wanted);
    last = count - first;
    const pixels = new Int32Array(2 * last);
    for (let i = 0; i < last; ++i) {
      pixels[2 * i] = Math.floor(indices[first + i] / width), pixels[2 * i + 1] = indices[first + i] % width;
    }
    scene.trace(gbuffer, pixels, camera);
    const planes = gbuffer.planes, size = height * width;
    for (let i = first; i < count; ++i) {
      const pixel = indices[i];
      for (let channel = 0; channel < 4; ++channel) values[4 * i + channel] = planes[(channel + 1) * size + pixel];
    }
    pace.measured(last, performance.now() - begun);
    await messages();
  }
  if (!cancelled) {
    /** @type {Samples} */
    const samples = { kind: "samples", frame, pixels: indices.slice(0, count), values: values.slice(0, 4 * count) };
    completing.postMessage(samples, [samples.pixels.buffer, samples.values.buffer]);
  }
  const milliseconds = performance.now() - begin;
  reply({ kind: "traced", frame, cancelled, reached: Math.min(chunk, to), rays: count, milliseconds });
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
    trace(data.frame, data.part);
  } else {
    cancelled = true;
  }
}

onmessage = receive;
