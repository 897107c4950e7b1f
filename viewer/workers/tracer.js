// @ts-check
/**
 * A worker that traces pixels of a scene.
 *
 * The next pixels depend on earlier samples. So one tracer leads each batch: it has the view's pixel sequence and
 * samples, and distributes slices of a few milliseconds to the others and to itself. It sends all samples of the batch
 * to the worker that completes the picture. Between slices it checks for messages, so that an obsolete batch ends at
 * once. If workers may share memory, there is one tracer, and others lend its core their threads.
 *
 * @typedef {import("../picture/camera.js").Size} Size
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {import("../picture/planner.js").Mode} Mode
 * @typedef {import("../picture/planner.js").Model} Model
 *
 * @typedef {"some" | "rows" | "edges" | "light"} Phase some: pixels in an order, which a network completes; rows: all
 *   pixels and lines, row by row; edges: several rays in each pixel at edges; light: pictures with lights (lit.js)
 * @typedef {{
 *   id: number, view: number, phase: Phase, parts: number, camera: Camera, height: number, width: number, scale: number | null,
 *   side: number, milliseconds: number, completed: Completed[], lights: import("../tracing/light.js").Choice | null, rests: boolean,
 *   cutaway: import("../tracing/cutaway.js").Cutaway, thickness: number
 * }} Batch
 *   The work of `parts` threads on a view in `milliseconds`. Batches of one view have one camera and size, and add to
 *   one picture. `side`: of the grid of rays in a pixel at edges; `completed`: completing
 *   times since the last batch; `lights`: in the phase "light"; `rests`: whether the camera does; `thickness`: of lines, in pixels.
 *   The page asks for the picture at rest, whose size the leading tracer divides by `scale`; null: as the planner chooses
 * @typedef {{model: Model, pixels: number, milliseconds: number}} Completed
 * @typedef {"probe" | "pick" | "snap" | "about" | "measure"} Question a method of Scene, with its values
 *
 * @typedef {{kind: "samples", batch: Batch, isColored: boolean, model: Model, pixels: Int32Array, samples: Float32Array,
 *   expected: Float32Array | null, covered: Uint8Array | null}} Samples
 *   to the completing worker, once per batch: model: the network for the picture; pixels (n, 2), row and column;
 *   samples (n, C), from Scene.trace; expected: with the first batch of a view, reprojected samples overwritten by
 *   traced ones, (C, height, width) of the displayed channels; null if there are no reprojected samples. The array is
 *   returned. covered: the share of each pixel that coarse lines cover, 0..255, if the batch has a thickness
 * @typedef {import("../picture/gbuffer.js").Strip} Strip
 * @typedef {{begin: number, end: number, covered: Uint8Array}} Band of rows: the share of pixels that exact lines cover, 0..255
 * @typedef {{kind: "rows", batch: Batch, isColored: boolean, strips: Strip[], bands: Band[], isLined: boolean}} Strips
 *   the same in the phase "rows"; isLined: whether no lines are left
 * @typedef {{kind: "means", batch: Batch, isColored: boolean, pixels: Int32Array, means: Float32Array, isLast: boolean}} Means
 *   the same in the phase "edges": pixels (n, 2); means (n, 5), from Scene.means; isLast: whether no edges are left
 *
 * @typedef {{camera: Camera, size: Size} & ({pixels: Int32Array, side?: number} | {rows: [number, number], thickness?: number})
 *   | import("./lit.js").Paths} Slice
 *   from the leader to another tracer: pixels (n, 2), to be traced once, or side x side times; or rows, begin and end,
 *   of lines if they have a thickness; or light paths
 * @typedef {{slice: Slice, values: Float32Array | Uint8Array, milliseconds: number}} TracedSlice its answer: samples (n, C), means
 *   (n, 5), planes (C, rows, width) of the traced layout, bytes (rows, width), or light (n, 7)
 *
 * @typedef {{module: WebAssembly.Module, memory: WebAssembly.Memory}} Loan to workers that lend their threads
 *
 * @typedef {{kind: "start", module: WebAssembly.Module}
 *   | {kind: "connect", completing: MessagePort}
 *   | {kind: "read", element: number, edition: number, reading: MessagePort}
 *   | {kind: "borrow", lenders: MessagePort[]}
 *   | {kind: "open", element: number, edition: number, scene: import("../tracing/description.js").SceneDescription}
 *   | {kind: "forget", element: number}
 *   | {kind: "lead", element: number, batch: Batch, others: MessagePort[]}
 *   | {kind: "help", element: number, leader: MessagePort, cutaway: import("../tracing/cutaway.js").Cutaway}
 *   | {kind: "ask", element: number, id: number, question: Question, values: any[]}
 *   | {kind: "cancel"}} Request
 *   "start" and "connect" come once, and "borrow" at most once, with a port to each worker that lends its thread.
 *   A tracer keeps a scene for each element until "forget". "open" is answered by "opened" or "failed", and then the
 *   element's previous scene stays. So is "read", whose scene comes through the port `reading`. There is no answer if
 *   the element has a scene of a later edition. "lead", with a port to each other tracer of the batch, is answered by
 *   "traced", after "cancel" at once; "help" is only answered by "failed"; "ask", at any time, is answered by
 *   "answered", with null if the element has no scene
 *
 * @typedef {{kind: "opened", element: number, edition: number, warnings: string[], memory: number}
 *   | {kind: "failed", edition?: number, message: string, broken: boolean}
 *   | {kind: "answered", id: number, answer: any}
 *   | {kind: "traced", batch: Batch, cancelled: boolean, left: number, rays: number, milliseconds: number}} Reply
 *   edition: of the requested scene; warnings: a line each; memory: bytes of the core; broken: the core is unusable; cancelled: no samples
 *   were sent, and the view has to begin again; left: pixels left in the batch's phase; rays: by all tracers of the batch
 */
import { Core, sharedMemoryFor } from "../core/core.js";
import { CoreError } from "../core/errors.js";
import { COLORED } from "../picture/channels.js";
import { History } from "../picture/history.js";
import { AdaptiveOrder, PixelSequence, SquaresOrder, WholeOrder } from "../picture/order.js";
import { FramePlanner } from "../picture/planner.js";
import { Rows } from "../tracing/rows.js";
import { buildScene } from "../tracing/scene.js";
import { BAND, LINES_SHARE, coarseLines } from "./lined.js";
import { SceneLight, areLightPaths } from "./lit.js";

const SLICE_MS = 5;
const LONG_SLICE_MS = 30; // at rest: fewer slices take less time, but movement waits for the one under way, often soon
const LARGEST_SLICE = 2 ** 18; // pixels, at rest
const TILE = 8; // rows that are fast together
const LEAST = 32; // minimum pixels of a slice
const THINNEST = 0.5; // pixels, of lines: thinner ones, in moving pictures of less than a third of the size, are too faint
const AHEAD = 2; // slices queued at another tracer, so that it need not wait while this one traces

/** Number of threads of its core. */
let threads = 1;
/** @type {(core: Core) => void} */
let start;
/** @type {Promise<Core>} */
const starting = new Promise((resolve) => (start = resolve));
/** The loan for workers that lend their threads. @type {Loan | undefined} */
let loan;
/** @type {MessagePort} */
let completing;
/** Port to the leading tracer, if that is another one. @type {MessagePort | undefined} */
let leading;
/** The scene of the element at work, to which the variables below belong. @type {import("../tracing/scene.js").Scene | undefined} */
let scene;
let edition = -1; // of the scene
/**
 * The view led by this tracer, its reprojected samples not sent yet, and the share of its pixels with one.
 *
 * @type {{id: number, mode: Mode, camera: Camera, size: Size, scale: number, sequence: PixelSequence, expected: History | null, known: number, ended: boolean} | undefined}
 */
let view;
/**
 * The picture at rest: its rows, its pixels at edges, (n, 2), once known, the number of smoothed ones, and
 * milliseconds for one; the number of rows with lines.
 *
 * @type {{id: number, rows: Rows, edges?: Int32Array, smoothed: number, pixelMs: number, lined: number} | undefined}
 */
let resting;
/** Milliseconds that a thread takes for a pixel at rest; 0 before the first one. Moving pictures take longer for one. */
let restingMs = 0;
/** The last array sent as `expected` and returned. @type {Float32Array | undefined} */
let spare;
/** The samples of earlier views, of one size. @type {History | undefined} */
let history;
/** The scene's planner. @type {FramePlanner | undefined} */
let planner;
/** The scene's light, if it is lit. @type {SceneLight | undefined} */
let light;

/**
 * @typedef {{
 *   scene: typeof scene, edition: number, view: typeof view, resting: typeof resting, restingMs: number, history: typeof history, planner: typeof planner,
 *   light: typeof light
 * }} Kept the state of an element
 */
/** @type {Kept} */
const NOTHING = { scene: undefined, edition: -1, view: undefined, resting: undefined, restingMs: 0, history: undefined, planner: undefined, light: undefined };
let element = 0; // at work
/** The state of the other elements. @type {Map<number, Kept>} */
const kept = new Map();

/** Goes on with an element. @param {number} next */
function turnTo(next) {
  if (next === element) return;
  if (light?.isDone) light.forget(); // pictures at rest need no more of it, and it is large
  kept.set(element, { scene, edition, view, resting, restingMs, history, planner, light });
  element = next;
  const own = kept.get(next) ?? NOTHING;
  ({ scene, edition, view, resting, restingMs, history, planner, light } = own);
  kept.delete(next);
}

/** Frees an element's scene. @param {number} which */
function forget(which) {
  if (which === element) {
    cancel();
    help(undefined);
    turnTo(0); // which has no scene
  }
  const own = kept.get(which);
  kept.delete(which);
  own?.view?.sequence.free();
  own?.history?.free();
  own?.planner?.free();
  own?.light?.free();
  own?.scene?.free();
}

let cancelled = false;
/** Wakes the wait for other tracers. */
let wake = () => {};

/** @param {Reply} message */
const reply = (message) => postMessage(message);

const { port1: resumed, port2: resume } = new MessageChannel();

/** Handles pending messages; a timer would take four milliseconds. */
const messages = () => new Promise((resolve) => {
  resumed.onmessage = resolve;
  resume.postMessage(0);
});

/** @param {Extract<Request, {kind: "open"}>} request */
async function open(request) {
  const core = await starting;
  const isAtWork = request.element === element;
  turnTo(request.element);
  if (request.edition < edition) return;
  if (isAtWork) {
    cancel();
    help(undefined);
  }
  try {
    useThreads(core, threads);
    const built = buildScene(core, request.scene);
    light?.free();
    light = undefined;
    forgetViews();
    scene?.free();
    scene = built;
    edition = request.edition;
    restingMs = 0;
    planner?.free();
    planner = new FramePlanner(core, navigator.hardwareConcurrency > 1);
    reply({ kind: "opened", element, edition, warnings: built.warnings, memory: core.memory.byteLength });
  } catch (error) {
    const broken = !(error instanceof CoreError); // any error the core does not report is fatal, usually out of memory
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
  light?.forget();
  view = history = resting = undefined;
}

const ORDERS = { whole: WholeOrder, squares: SquaresOrder, adaptive: AdaptiveOrder };

/**
 * Begins the view of a batch, with reprojected samples of earlier views.
 *
 * @param {import("../tracing/scene.js").Scene} scene @param {FramePlanner} planner @param {Batch} batch
 */
function beginView(scene, planner, { view: id, camera, height, width, scale, milliseconds, parts }) {
  const size = { height, width }, pixels = height * width;
  if (view?.size.height !== height || view.size.width !== width) forgetViews();
  const before = view, mode = planner.plan(before?.camera, camera, size, milliseconds, parts);
  let expected = null, known = 0;
  if (before && mode === "reproject") {
    const begin = performance.now();
    history ??= new History(scene.core, size, scene.layout);
    known = history.move(scene.handle, before.camera, before.sequence.planes, camera, id) / pixels;
    if (known > 0) expected = history;
    planner.reprojected(pixels, performance.now() - begin);
  }
  before?.sequence.free();
  const own = mode === "reproject" ? "adaptive" : mode;
  const sequence = new PixelSequence(scene.core, size, scene.layout, expected ?? new ORDERS[own](scene.core, size, scene.layout));
  return view = { id, mode: expected ? mode : own, camera, size, scale: scale ?? 1, sequence, expected, known, ended: false };
}

/** @param {Slice} slice @returns {TracedSlice} */
function traceSlice(slice) {
  if (!scene) throw new Error("trace: expected an open scene");
  const begin = performance.now(), { camera, size } = slice;
  const values = areLightPaths(slice) ? lightOf(scene).trace(slice) : "rows" in slice
    ? slice.thickness ? scene.lines(...slice.rows, size, camera, slice.thickness) : scene.rows(...slice.rows, size, camera)
    : slice.side === undefined ? scene.trace(slice.pixels, size, camera) : scene.means(slice.pixels, size, camera, slice.side);
  return { slice, values, milliseconds: performance.now() - begin };
}

/** @param {import("../tracing/scene.js").Scene} scene @returns {SceneLight} */
const lightOf = (scene) => (light ??= new SceneLight(scene));

/**
 * The work of a batch.
 *
 * @typedef {object} Work
 * @property {() => Slice | undefined} deal returns the next slice; undefined without work, or once time is over
 * @property {(traced: TracedSlice, began?: number) => void} keep began: the time when its pixels were chosen
 * @property {(slice: Slice) => TracedSlice} [trace] instead of traceSlice, while this tracer is alone
 * @property {() => number} left number of pixels
 * @property {() => {message: Samples | Strips | Means | import("./lit.js").Lit, transfer: Transferable[]}} result
 *
 * @typedef {object} Circumstances of a batch
 * @property {import("../tracing/scene.js").Scene} scene
 * @property {FramePlanner} planning
 * @property {Batch} batch
 * @property {number} lent threads of this tracer
 * @property {number} others number of other tracers
 * @property {number} begin
 */

/** @param {Circumstances} circumstances @returns {Work} on pixels in an order */
function somePixels({ scene, planning, batch, lent, others, begin }) {
  const { camera, parts, height, width } = batch, total = height * width;
  const of = view?.id === batch.view && !view.ended ? view : beginView(scene, planning, batch);
  const { sequence, size, mode } = of, known = Math.max(of.known, sequence.done / total);
  const model = planning.completion(mode, known, batch.milliseconds, parts);
  const end = begin + planning.forTracing(mode, model, (batch.thickness > 0 ? 1 - LINES_SHARE : 1) * batch.milliseconds);
  /** @type {{pixels: Int32Array, samples: Float32Array}[]} */
  const slices = [];
  return {
    deal() {
      const time = end - performance.now(), isLate = time <= 0 && slices.length > 0;
      if (isLate || sequence.done === total) return;
      const wanted = Math.max(LEAST, planning.pixelsIn(mode, lent * Math.min(SLICE_MS, Math.max(time, 0))));
      const left = sequence.available(Math.max(wanted, planning.pixelsIn(mode, parts * Math.max(time, 0))));
      if (left === 0) return;
      // Slices shrink towards the end of a round, when all tracers wait for each other.
      const share = others > 0 ? left / (AHEAD * parts) : left;
      return { camera, size, pixels: sequence.next(Math.min(left, Math.ceil(Math.max(LEAST, Math.min(wanted, share))))) };
    },
    keep({ slice, values, milliseconds }, began) {
      const { pixels } = /** @type {{pixels: Int32Array}} */ (slice);
      const samples = /** @type {Float32Array} */ (values);
      sequence.add(pixels, samples);
      slices.push({ pixels, samples });
      const spent = began === undefined ? milliseconds : performance.now() - began;
      planning.traced(mode, pixels.length / 2, lent * spent, mode !== "reproject" && sequence.rounds === 1);
    },
    left: () => total - sequence.done,
    result() {
      const expected = of.expected?.picture(spare) ?? null;
      if (expected) spare = undefined;
      of.expected = null;
      const pixels = joined(Int32Array, slices.map((slice) => slice.pixels));
      const samples = joined(Float32Array, slices.map((slice) => slice.samples));
      const covered = batch.thickness > 0 ? coarseLines(scene, batch, LINES_SHARE * batch.milliseconds) : null;
      const message = { kind: /** @type {const} */ ("samples"), batch, isColored: scene.layout === COLORED, model, pixels, samples, expected, covered };
      return { message, transfer: [pixels, samples, expected, covered].flatMap((array) => (array ? [array.buffer] : [])) };
    },
  };
}

/** The picture at rest of a batch. @param {Circumstances} circumstances */
function restOf({ scene, batch }) {
  if (resting?.id !== batch.view) resting = { id: batch.view, rows: new Rows(scene, batch), smoothed: 0, pixelMs: 0, lined: 0 };
  return resting;
}

/** @param {Circumstances} circumstances @returns {Work} on all rows; a band of lines follows when its rows are dealt */
function allRows(circumstances) {
  const { scene, batch, lent, others, begin } = circumstances, { camera, parts, height, width, thickness } = batch, size = { height, width };
  const rest = restOf(circumstances), { rows } = rest, end = begin + batch.milliseconds;
  // Movement from here starts with all pixels, if it has this size.
  const sequence = view?.id === batch.view ? view.sequence : undefined;
  /** @type {Strip[]} */
  const strips = [];
  /** @type {Band[]} */
  const bands = [];
  /** Strips that came before those above them, by their first rows. @type {Map<number, TracedSlice>} */
  const early = new Map();
  const { done } = rows; // before the batch
  let dealt = done, lined = thickness > 0 ? rest.lined : height, slices = 0;

  /** @param {number} last @param {Float32Array} [traced] */
  const add = (last, traced) => {
    const first = rows.done;
    strips.push({ begin: first, end: last, planes: rows.add(last, camera, traced, sequence?.planes) });
    if (last === height) sequence?.finish();
  };
  return {
    deal() {
      const first = dealt, below = Math.min(height, lined + BAND), isBand = lined < height && below <= dealt;
      if ((dealt === height && !isBand) || (performance.now() > end && slices > 0)) return;
      ++slices;
      if (isBand) return { camera, size, rows: [lined, lined = below], thickness };
      const milliseconds = done > 0 ? LONG_SLICE_MS : Math.min(LONG_SLICE_MS, SLICE_MS + (performance.now() - begin) / 4);
      const wanted = Math.min(restingMs > 0 ? lent * milliseconds / restingMs : LEAST, LARGEST_SLICE) / width;
      const share = others > 0 ? (height - dealt) / (AHEAD * parts) : Infinity;
      dealt = Math.min(height, dealt + TILE * Math.max(1, Math.round(Math.min(wanted, share) / TILE)));
      return { camera, size, rows: [first, dealt] };
    },
    trace: others > 0 ? undefined : (slice) => {
      if ("thickness" in slice) return traceSlice(slice);
      const began = performance.now(), [, last] = /** @type {{rows: [number, number]}} */ (slice).rows;
      add(last);
      return { slice, values: new Float32Array(0), milliseconds: performance.now() - began };
    },
    keep(traced) {
      const { rows: [first, last], thickness } = /** @type {{rows: [number, number], thickness?: number}} */ (traced.slice);
      if (thickness) {
        bands.push({ begin: first, end: last, covered: /** @type {Uint8Array} */ (traced.values) });
        rest.lined += last - first;
        return;
      }
      restingMs = lent * traced.milliseconds / ((last - first) * width);
      if (others === 0) return;
      early.set(first, traced);
      for (let next; (next = early.get(rows.done)); ) {
        early.delete(rows.done);
        add(/** @type {{rows: [number, number]}} */ (next.slice).rows[1], /** @type {Float32Array} */ (next.values));
      }
    },
    left: () => (height - rows.done + (thickness > 0 ? height - rest.lined : 0)) * width,
    result: () => ({
      message: { kind: "rows", batch, isColored: scene.layout === COLORED, strips, bands, isLined: rest.lined === height },
      transfer: [...strips.map(({ planes }) => planes.buffer), ...bands.map(({ covered }) => covered.buffer)],
    }),
  };
}

/** @param {Circumstances} circumstances @returns {Work} on pixels at edges */
function atEdges(circumstances) {
  const { scene, batch, lent, others, begin } = circumstances, { camera, parts, height, width, side } = batch, size = { height, width };
  const rest = restOf(circumstances), end = begin + batch.milliseconds, { rows } = rest;
  // A picture that was whole while it moved has no rows yet.
  if (rows.done < height && view?.id === batch.view && view.sequence.done === height * width) {
    rest.edges = scene.edges(0, height, width, { address: view.sequence.planes, top: 0, rows: height });
  } else if (rows.done < height) {
    cancelled = true;
  }
  const edges = rest.edges ??= joined(Int32Array, rows.edges);
  rows.edges = [];
  /** @type {{pixels: Int32Array, means: Float32Array}[]} */
  const slices = [];
  let dealt = rest.smoothed;
  return {
    deal() {
      const left = edges.length / 2 - dealt;
      if (left === 0 || (performance.now() > end && slices.length > 0)) return;
      const wanted = Math.min(rest.pixelMs > 0 ? lent * LONG_SLICE_MS / rest.pixelMs : LEAST, LARGEST_SLICE / side ** 2);
      const count = Math.min(left, Math.ceil(Math.max(LEAST, Math.min(wanted, others > 0 ? left / (AHEAD * parts) : left))));
      const pixels = edges.slice(2 * dealt, 2 * (dealt += count));
      return { camera, size, pixels, side };
    },
    keep({ slice, values, milliseconds }) {
      const { pixels } = /** @type {{pixels: Int32Array}} */ (slice);
      rest.pixelMs = lent * milliseconds / (pixels.length / 2);
      rest.smoothed += pixels.length / 2;
      slices.push({ pixels, means: /** @type {Float32Array} */ (values) });
    },
    left: () => edges.length / 2 - rest.smoothed,
    result() {
      const pixels = joined(Int32Array, slices.map((slice) => slice.pixels)), means = joined(Float32Array, slices.map((slice) => slice.means));
      const message = { kind: /** @type {const} */ ("means"), batch, isColored: scene.layout === COLORED, pixels, means, isLast: rest.smoothed === edges.length / 2 };
      return { message, transfer: [pixels.buffer, means.buffer] };
    },
  };
}

/** @type {Record<Phase, (circumstances: Circumstances) => Work>} */
const WORKS = {
  some: somePixels, rows: allRows, edges: atEdges,
  light: (circumstances) => lightOf(circumstances.scene).work(circumstances),
};

/** The batch in its picture's size. @param {import("../tracing/scene.js").Scene} scene @param {FramePlanner} planner @param {Batch} batch */
function sized(scene, planner, batch) {
  const { camera, height, width, phase, milliseconds, parts, thickness } = batch;
  const scale = batch.scale ?? (phase === "light" ? lightOf(scene).scale(batch) : planner.scale(view, camera, { height, width }, milliseconds, parts));
  const scaled = (/** @type {number} */ length) => Math.max(1, Math.round(length / scale));
  return { ...batch, scale, height: scaled(height), width: scaled(width), thickness: thickness && Math.max(thickness / scale, THINNEST) };
}

/** @param {Extract<Request, {kind: "lead"}>} request with ports to the other tracers */
async function lead({ element: own, batch: asked, others: ports }) {
  cancelled = false;
  await starting;
  turnTo(own);
  if (!scene) throw new Error("lead: expected an open scene");
  if (scene.cut(asked.cutaway)) forgetViews();
  const lent = threads > 1 ? asked.parts : 1; // including this one
  useThreads(scene.core, lent);
  const planning = /** @type {FramePlanner} */ (planner), begin = performance.now();
  for (const { model, pixels, milliseconds } of asked.completed) planning.completed(model, pixels, milliseconds);
  const batch = sized(scene, planning, asked);
  const work = WORKS[batch.phase]({ scene, planning, batch, lent, others: ports.length, begin });
  let rays = 0;
  const deal = () => (cancelled ? undefined : work.deal());

  /** @param {TracedSlice} traced @param {number} [began] */
  const keep = (traced, began) => {
    const { slice } = traced;
    rays += areLightPaths(slice) ? slice.wanted.length / 3 * slice.paths
      : "rows" in slice ? (slice.rows[1] - slice.rows[0]) * batch.width : slice.pixels.length / 2 * (slice.side ?? 1) ** 2;
    work.keep(traced, began);
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
        const slice = other.slices === slices && deal();
        if (!slice) continue;
        ++other.slices;
        other.port.postMessage(slice, "pixels" in slice ? [slice.pixels.buffer] : []);
      }
    }
    const began = performance.now(), slice = deal();
    if (slice) {
      keep((work.trace ?? traceSlice)(slice), began);
      await messages();
      turnTo(own);
    } else if (others.some(({ slices }) => slices > 0)) {
      await new Promise((resolve) => (wake = () => resolve(undefined)));
      turnTo(own);
    } else {
      break;
    }
  }
  for (const { port } of others) port.close();
  const milliseconds = performance.now() - begin;
  if (cancelled) {
    if (view) view.ended = true;
    resting = undefined;
  } else {
    const { message, transfer } = work.result();
    completing.postMessage(message, transfer);
  }
  reply({ kind: "traced", batch, cancelled, left: work.left(), rays, milliseconds });
}

/**
 * Concatenates arrays.
 *
 * @template {Int32Array | Float32Array} T
 * @param {{new (length: number): T}} type @param {T[]} arrays @returns {T}
 */
function joined(type, arrays) {
  const all = new type(arrays.reduce((length, array) => length + array.length, 0));
  let at = 0;
  for (const array of arrays) all.set(array, at), at += array.length;
  return all;
}

/**
 * @param {MessagePort | undefined} port to the current leader
 * @param {number} [own] the element
 * @param {import("../tracing/cutaway.js").Cutaway} [cutaway]
 */
function help(port, own = element, cutaway) {
  leading?.close();
  leading = port;
  if (!port) return;
  /** @param {MessageEvent<Slice>} event */
  port.onmessage = ({ data: slice }) => {
    if (port !== leading) return; // from a batch that has ended
    turnTo(own);
    try {
      if (cutaway && scene?.cut(cutaway)) forgetViews();
      const traced = traceSlice(slice);
      port.postMessage(traced, [traced.values.buffer, ...("pixels" in slice ? [slice.pixels.buffer] : [])]);
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
    completing.onmessage = ({ data }) => {
      if (data.lit) light && (light.spare = data.lit);
      else spare = data;
    };
  } else if (data.kind === "read") {
    const { reading, element, edition } = data;
    reading.onmessage = ({ data: scene }) => open({ kind: "open", element, edition, scene });
  } else if (data.kind === "forget") {
    forget(data.element);
  } else if (data.kind === "borrow") {
    threads = 1 + data.lenders.length;
    starting.then(() => data.lenders.forEach((port) => port.postMessage(loan)));
  } else if (data.kind === "open") {
    open(data);
  } else if (data.kind === "lead") {
    lead(data).catch((error) => fail(error));
  } else if (data.kind === "help") {
    help(data.leader, data.element, data.cutaway);
  } else if (data.kind === "ask") {
    const { id, question, values } = data, of = data.element === element ? scene : kept.get(data.element)?.scene;
    reply({ kind: "answered", id, answer: of ? /** @type {any} */ (of)[question](...values) : null });
  } else {
    cancel();
  }
}

onmessage = receive;
