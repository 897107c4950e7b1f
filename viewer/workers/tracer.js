// @ts-check
/**
 * A worker that traces pixels of a scene.
 *
 * Which pixels are next depends on what those before show. So one tracer leads each batch: it has the sequence of the view's
 * pixels and what they show so far, deals slices of a few milliseconds to the others and to itself, and sends all samples of
 * the batch to the worker that completes the picture. Between slices it looks for messages, so that a batch that nobody
 * waits for any more ends at once. Where workers may share memory there is one tracer, whose core others lend their threads.
 *
 * @typedef {import("../picture/camera.js").Size} Size
 * @typedef {import("../picture/camera.js").Camera} Camera
 *
 * @typedef {{
 *   id: number, view: number, parts: number, camera: Camera, height: number, width: number, to: number, milliseconds: number,
 *   carries: boolean, squares: boolean, sparse: import("./schedule.js").Model
 * }} Batch
 *   What `parts` threads add to a view: the pixels of its sequence up to the place `to`, or as many as they trace in so many
 *   milliseconds. Batches of one view have one camera and size, and add to one picture, to which a view
 *   that `carries` brings along what those before have seen, and any other is traced in the order of squares or the adaptive one; `sparse`
 *   completes it while little of it is known.
 *
 * @typedef {{kind: "samples", batch: Batch, isColored: boolean, count: number, pixels: Int32Array, samples: Float32Array,
 *   expected: Float32Array | null}} Samples
 *   to the completing worker, once for a batch: pixels (n, 2), row and column; samples (n, C), as Scene.trace returns them; of
 *   both the first `count` rows, since they are sent in the memory that they were written to; expected: with the first batch of a
 *   view, what those before let expect, and over it the samples, (C, height, width) of what is shown; null where they say nothing. The array comes back
 *
 * @typedef {{camera: Camera, size: Size, pixels: Int32Array}} Slice from the tracer that leads to another: pixels (n, 2)
 * @typedef {{pixels: Int32Array, samples: Float32Array, milliseconds: number}} TracedSlice its answer: samples (n, C)
 *
 * @typedef {{module: WebAssembly.Module, memory: WebAssembly.Memory}} Loan to those that lend their threads
 *
 * @typedef {{kind: "start", module: WebAssembly.Module}
 *   | {kind: "connect", completing: MessagePort, reading: MessagePort}
 *   | {kind: "borrow", lenders: MessagePort[]}
 *   | {kind: "open", scene: import("../tracing/description.js").SceneDescription, edition: number}
 *   | {kind: "lead", batch: Batch, others: MessagePort[]}
 *   | {kind: "help", leader: MessagePort}
 *   | {kind: "cancel"}} Request
 *   "start" and "connect" come once, and "borrow" once at most, with a port to each worker that lends its thread; "open", which may
 *   also come through the port `reading`, is answered by "opened" or "failed", in which case the previous scene stays, but not at all
 *   where that is of a later edition: what comes through the port, of edition 0, may have been overtaken; "lead", with a port to each
 *   other tracer of the batch, is answered by "traced", after "cancel" at once; "help" is not answered, but for "failed"
 *
 * @typedef {{kind: "opened", edition: number, warnings: string[]}
 *   | {kind: "failed", edition?: number, message: string, broken: boolean}
 *   | {kind: "traced", batch: Batch, cancelled: boolean, reached: number, rays: number, preparing: number, milliseconds: number,
 *      first: {rays: number, milliseconds: number}}} Reply
 *   edition: of the scene that was to be opened; warnings: a line each; broken: the core is unusable; cancelled: no samples
 *   were sent, and the view has to begin again; reached: how many pixels of the view's sequence are traced; rays: by all
 *   tracers of the batch; preparing: milliseconds for what earlier views let expect, before those of tracing; first: of those,
 *   what the first round took: it lies all over the picture
 */
import { Core, sharedMemoryFor } from "../core/core.js";
import { CoreError } from "../core/errors.js";
import { COLORED } from "../picture/channels.js";
import { History } from "../picture/history.js";
import { AdaptiveOrder, PixelSequence, SquaresOrder } from "../picture/order.js";
import { buildScene } from "../tracing/scene.js";
import { Pace } from "./pace.js";

const SLICE_MS = 5;
const FIRST_SLICE = 32; // pixels, while nothing is known
const GROWTH = 8; // times the largest slice so far, at most: a small slice says little about a large one
const AHEAD = 2; // slices that another tracer has, so that it need not wait while this one traces its own

/** How many threads its core has. */
let threads = 1;
/** @type {(core: Core) => void} */
let start;
/** @type {Promise<Core>} */
const starting = new Promise((resolve) => (start = resolve));
/** What workers need that lend its core their threads. @type {Loan | undefined} */
let loan;
/** @type {MessagePort} */
let completing;
/** To the tracer that leads, where another one does. @type {MessagePort | undefined} */
let leading;
/** @type {import("../tracing/scene.js").Scene | undefined} */
let scene;
let edition = -1; // of the scene
/**
 * What is traced of the view where this tracer leads, and what is expected of it that was not sent yet.
 *
 * @type {{id: number, camera: Camera, size: Size, sequence: PixelSequence, expected: History | null, ended: boolean} | undefined}
 */
let view;
/** What was sent to the completing worker as `expected`, and came back. @type {Float32Array | undefined} */
let spare;
/** What its earlier views have seen, of one size. @type {History | undefined} */
let history;
let pace = new Pace();
let cancelled = false;
/** Ends the waiting for other tracers. */
let wake = () => {};

/** @param {Reply} message */
const reply = (message) => postMessage(message);

const { port1: resumed, port2: resume } = new MessageChannel();

/** Lets messages be handled; a timer would take four milliseconds. */
const messages = () => new Promise((resolve) => {
  resumed.onmessage = resolve;
  resume.postMessage(0);
});

/** @param {Extract<Request, {kind: "open"}>} request */
async function open(request) {
  const core = await starting;
  if (request.edition < edition) return;
  cancel();
  help(undefined);
  try {
    useThreads(core, threads);
    const built = buildScene(core, request.scene);
    scene?.free();
    scene = built;
    edition = request.edition;
    forgetViews();
    pace = new Pace();
    reply({ kind: "opened", edition, warnings: built.warnings });
  } catch (error) {
    const broken = !(error instanceof CoreError); // what the core does not report itself is fatal: mostly, it ran out of memory
    fail(error, broken, request.edition);
  }
}

/** @param {unknown} error @param {boolean} [broken] @param {number} [edition] of a scene that was not opened */
function fail(error, broken = true, edition) {
  const message = error instanceof Error ? error.message : String(error);
  reply({ kind: "failed", edition, message: broken ? `the scene is too much for this page: ${message}` : message, broken });
}

/** @param {Core} core @param {number} count */
function useThreads(core, count) {
  if (threads > 1) core.call("set_threads", count);
}

function cancel() {
  cancelled = true;
  wake();
}

function forgetViews() {
  view?.sequence.free();
  history?.free();
  view = history = undefined;
}

/** Begins the view of a batch, with what those before let expect. @param {import("../tracing/scene.js").Scene} scene @param {Batch} batch */
function beginView(scene, { view: id, camera, height, width, carries, squares }) {
  const size = { height, width };
  if (view?.size.height !== height || view.size.width !== width) forgetViews();
  let expected = null;
  if (view && carries) {
    history ??= new History(scene.core, size, scene.layout);
    if (history.move(scene.handle, view.camera, view.sequence.planes, camera, id)) expected = history;
  }
  view?.sequence.free();
  const order = expected ?? new (squares ? SquaresOrder : AdaptiveOrder)(scene.core, size, scene.layout);
  return view = { id, camera, size, sequence: new PixelSequence(scene.core, size, scene.layout, order), expected, ended: false };
}

/** @param {Int32Array} pixels (n, 2) @param {Size} size @param {Camera} camera @returns {TracedSlice} */
function traceSlice(pixels, size, camera) {
  if (!scene) throw new Error("trace: expected an open scene");
  const begin = performance.now(), samples = scene.trace(pixels, size, camera);
  return { pixels, samples, milliseconds: performance.now() - begin };
}

/** @param {Batch} batch @param {MessagePort[]} ports to the other tracers */
async function lead(batch, ports) {
  cancelled = false;
  await starting;
  if (!scene) throw new Error("lead: expected an open scene");
  const lent = threads > 1 ? batch.parts : 1; // and this one
  useThreads(scene.core, lent);
  const asked = performance.now(), of = view?.id === batch.view && !view.ended ? view : beginView(scene, batch);
  const begin = performance.now(), end = begin + batch.milliseconds;
  const { sequence, size } = of, components = scene.sampleWidth, { camera, to, parts } = batch;
  const most = to - sequence.done, all = { pixels: new Int32Array(2 * most), samples: new Float32Array(components * most) };
  const first = { rays: 0, milliseconds: 0 };
  let count = 0, largest = FIRST_SLICE / GROWTH;

  const deal = () => {
    const time = end - performance.now();
    if (cancelled || time <= 0 || sequence.done === to) return;
    const left = Math.min(sequence.available(to - sequence.done), to - sequence.done);
    if (left === 0) return;
    const wanted = pace.known ? Math.min(lent * pace.rate * Math.min(SLICE_MS, time), GROWTH * largest) : FIRST_SLICE;
    // Towards the end of a round, after which all wait for each other, slices are smaller.
    const share = ports.length > 0 ? left / (AHEAD * parts) : left;
    return sequence.next(Math.min(left, Math.ceil(Math.max(FIRST_SLICE, Math.min(wanted, share)))));
  };

  /** @param {TracedSlice} slice */
  const keep = ({ pixels, samples, milliseconds }) => {
    const rays = pixels.length / 2;
    sequence.add(pixels, samples);
    all.pixels.set(pixels, 2 * count), all.samples.set(samples, components * count);
    count += rays;
    largest = Math.max(largest, rays);
    pace.measured(rays, lent * milliseconds);
    if (!of.expected && sequence.rounds === 1) {
      first.rays += rays;
      first.milliseconds = performance.now() - begin;
    }
  };

  const others = ports.map((port) => ({ port, slices: 0 }));
  for (const other of others) {
    other.port.onmessage = ({ data }) => {
      if (cancelled) return;
      --other.slices;
      keep(data);
      wake();
    };
  }
  while (!cancelled) {
    for (let slices = 0; slices < AHEAD; ++slices) {
      for (const other of others) {
        const pixels = other.slices === slices && deal();
        if (!pixels) continue;
        ++other.slices;
        other.port.postMessage({ camera, size, pixels }, [pixels.buffer]);
      }
    }
    const pixels = deal();
    if (pixels) {
      keep(traceSlice(pixels, size, camera));
      await messages();
    } else if (others.some(({ slices }) => slices > 0)) {
      await new Promise((resolve) => (wake = () => resolve(undefined)));
    } else {
      break;
    }
  }
  for (const { port } of others) port.close();
  const milliseconds = performance.now() - begin;
  if (cancelled) {
    of.ended = true;
  } else {
    const expected = of.expected?.picture(spare) ?? null;
    if (expected) spare = undefined;
    of.expected = null;
    /** @type {Samples} */
    const message = { kind: "samples", batch, isColored: scene.layout === COLORED, count, ...all, expected };
    completing.postMessage(message, [all.pixels.buffer, all.samples.buffer, ...(expected ? [expected.buffer] : [])]);
  }
  reply({ kind: "traced", batch, cancelled, reached: sequence.done, rays: count, preparing: begin - asked, milliseconds, first });
}

/** @param {MessagePort | undefined} port to the tracer that leads now */
function help(port) {
  leading?.close();
  leading = port;
  if (!port) return;
  /** @param {MessageEvent<Slice>} event */
  port.onmessage = ({ data: { camera, size, pixels } }) => {
    if (port !== leading) return; // of a batch that has ended
    try {
      const traced = traceSlice(pixels, size, camera);
      port.postMessage(traced, [traced.pixels.buffer, traced.samples.buffer]);
    } catch (error) {
      fail(error);
    }
  };
}

/** @param {MessageEvent<Request>} event */
function receive({ data }) {
  if (data.kind === "start") {
    const { module } = data, memory = sharedMemoryFor(module);
    loan = memory && { module, memory };
    start(new Core(module, memory));
  } else if (data.kind === "connect") {
    completing = data.completing;
    completing.onmessage = ({ data: array }) => (spare = array);
    data.reading.onmessage = receive;
  } else if (data.kind === "borrow") {
    threads = 1 + data.lenders.length;
    starting.then(() => data.lenders.forEach((port) => port.postMessage(loan)));
  } else if (data.kind === "open") {
    open(data);
  } else if (data.kind === "lead") {
    lead(data.batch, data.others).catch((error) => fail(error));
  } else if (data.kind === "help") {
    help(data.leader);
  } else {
    cancel();
  }
}

onmessage = receive;
