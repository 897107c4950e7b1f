// @ts-check
/**
 * The worker that gathers samples, completes pictures and paints them.
 *
 * @typedef {{kind: "start", module: WebAssembly.Module, name: Model, weights: ArrayBuffer, uncertainty: ArrayBuffer}
 *   | {kind: "network", name: Model, weights: ArrayBuffer}
 *   | {kind: "connect", tracer: MessagePort}
 *   | {kind: "help", leader: MessagePort}
 *   | {kind: "helped", helper: MessagePort}
 *   | ({kind: "show"} & Showing)
 *   | {kind: "buffers"}} Request
 *   "start" comes once, with the network used until others arrive; "network" adds one; weights, uncertainty:
 *   safetensors files; "help" makes this worker a helper, which completes bands for a leader, and "helped" gives the
 *   leader its port; "show" repaints the last picture; "buffers" is answered by "buffers"
 *
 * @typedef {import("./tracer.js").Samples} Samples
 * @typedef {import("./tracer.js").Strips} Strips
 * @typedef {import("./tracer.js").Means} Means
 * @typedef {import("./lit.js").Lit} Lit
 * @typedef {import("./bands.js").Help} Help
 *
 * @typedef {{mode: import("../picture/paint.js").Mode, divider: number, isTransparent: boolean, exposure?: number}} Showing
 *   what to paint; divider: 0..1 of the picture's width; isTransparent: whether the background is transparent;
 *   exposure: factor of the light, 1 if omitted
 *
 * @typedef {import("./tracer.js").Batch} Batch
 * @typedef {import("../picture/planner.js").Model} Model the name of a network
 *
 * @typedef {{
 *   batch: Batch, bitmap: ImageBitmap, traced: number, isSmoothed: boolean, isLined: boolean, completing: number, total: number,
 *   backend: "wasm" | "gpu", model: Model, wanted: Model, error: number, expected: number
 * }} Picture
 *   batch: its newest batch; model: the network that completed it; wanted: the network requested; traced: number of
 *   pixels; isSmoothed: whether all edges are smoothed; isLined: whether it has all lines; completing: milliseconds of the network, on `backend`, 0 without one; total: milliseconds of this worker; error: mean of
 *   |first - image| of an exact picture, else NaN; expected: predicted mean error of the image if displayed, else NaN
 * @typedef {{
 *   height: number, width: number, planes: Float32Array, known: Float32Array, image: Float32Array, first: Float32Array
 * }} Buffers
 *   planes, known: (C, height, width), G-buffers of the traced pixels, and of the network's input, possibly with
 *   reprojected samples; image, and first, the view's first completed picture (height, width)
 * @typedef {{kind: "picture", picture: Picture, repainted: boolean} | {kind: "buffers", buffers: Buffers | null}
 *   | {kind: "failed", message: string}} Reply
 */
import { Completer } from "../completion/completer.js";
import { ErrorPredictor } from "../completion/predictor.js";
import { readWeights } from "../completion/weights.js";
import { Core } from "../core/core.js";
import { COLORED, GBUFFER } from "../picture/channels.js";
import { GBuffer } from "../picture/gbuffer.js";
import { enlargedLines, paintLines, withLines } from "../picture/lines.js";
import { enlarged, enlargedGray, paint, paintMeans, paintRest, paintStrip } from "../picture/paint.js";
import { paintLight } from "../picture/paint_light.js";
import { Helpers } from "./bands.js";

const MAPS = ["difference", "uncertain"]; // modes without lines
const WARM_UPS = 3;
const MOST_WHOLE = 2 ** 22; // pixels of resting pictures with a G-buffer, for their difference from the first one

/**
 * @typedef {{core: Core, completers: Map<Model, Completer>, standIn: Model, predictor: ErrorPredictor}} Networks
 *   completers: by network name; standIn: the network that is always available
 */
/** @type {(networks: Networks) => void} */
let start;
/** @type {Promise<Networks>} */
const starting = new Promise((resolve) => (start = resolve));
/**
 * @typedef {{
 *   batch: Batch, gbuffer: GBuffer, expected: GBuffer | null, coverage?: GBuffer, model: Model, completed: boolean, first: Float32Array,
 *   image: ImageData, isShared: boolean, covered: Uint8Array | null
 * }} View
 *   batch: its newest batch; expected: reprojected samples, overwritten by traced ones; coverage: if requested; model:
 *   the network that completed it last; image: as last painted; isShared: whether the helpers have all its samples;
 *   covered: by lines
 */
/** @type {View | undefined} */
let view;
/**
 * The picture at rest, if it is shown: a view whose rows are all traced, one after the other.
 *
 * @typedef {{
 *   batch: Batch, isColored: boolean, look: Showing, image: ImageData, rows: number, isSmoothed: boolean, isLined: boolean, gbuffer: GBuffer | null,
 *   first: Float32Array | null, error: number, covered: Uint8Array | null, before: {height: number, width: number, image: Float32Array} | null
 * }} Rest
 *   look: at its beginning; image: the displayed pixels without lines, of an enlarged or completed picture below the traced rows; gbuffer,
 *   first: of pictures that are not too large; covered: by lines, those of the moving picture until the exact ones are drawn; before: the
 *   previous completed picture; `first` is enlarged from it
 * @type {Rest | undefined}
 */
let rest;
/** The picture with lights, if it is shown; the tracer completed it. @type {Lit | undefined} */
let lit;
/** @type {Picture | undefined} */
let picture;
/** @type {Showing} */
let showing = { mode: "completed", divider: 0.5, isTransparent: false };
/** Workers that complete bands of this worker's pictures. */
const helpers = new Helpers();
/** Messages are handled one after the other, even if that means waiting. */
let queue = Promise.resolve();

/** @param {Reply} message @param {Transferable[]} [transfer] */
const reply = (message, transfer = []) => postMessage(message, { transfer });

/** @param {Extract<Request, {kind: "start"}>} request */
async function begin({ module, name, weights, uncertainty }) {
  try {
    const core = new Core(module), completer = await completerOf(core, weights);
    const predictor = new ErrorPredictor(core, readWeights(uncertainty));
    start({ core, completers: new Map([[name, completer]]), standIn: name, predictor });
  } catch (error) {
    fail(error);
  }
}

/** @param {Core} core @param {ArrayBuffer} weights */
async function completerOf(core, weights) {
  const completer = new Completer(core, readWeights(weights));
  const small = new GBuffer(core, 64, 64); // browsers compile functions on first call: do it before anyone waits
  for (let i = 0; i < WARM_UPS; ++i) await completer.complete(small);
  small.free();
  return completer;
}

/** Whether there is a newer batch. @param {Batch} batch */
const isOld = (batch) => Math.max(view?.batch.id ?? 0, rest?.batch.id ?? 0, lit?.batch.id ?? 0) > batch.id;

/** The G-buffer that a view is completed from. @param {View} view */
const shown = ({ gbuffer, expected }) => expected ?? gbuffer;

/** Adds the samples of the newest view. @param {Networks} networks @param {Samples} part @param {boolean} isShared @returns {View} */
function taken({ core, standIn }, { batch, isColored, pixels, samples, expected, covered }, isShared) {
  const { height, width } = batch, layout = isColored ? COLORED : GBUFFER;
  if (view?.gbuffer.height !== height || view.gbuffer.width !== width || view.gbuffer.layout !== layout) {
    view?.gbuffer.free(), view?.expected?.free(), view?.coverage?.free();
    const gbuffer = new GBuffer(core, height, width, layout);
    const first = new Float32Array(height * width), image = new ImageData(width, height);
    view = { batch, gbuffer, expected: null, model: standIn, completed: false, first, image, isShared, covered };
  } else if (view.batch.view !== batch.view) {
    view.gbuffer.clear();
    view.completed = false;
    if (!expected) {
      view.expected?.free();
      view.expected = null;
    }
  }
  if (expected) {
    view.expected ??= new GBuffer(core, height, width, layout);
    view.expected.set(expected);
  }
  view.batch = batch;
  view.covered = covered;
  view.isShared = isShared;
  for (const gbuffer of [view.gbuffer, view.expected]) {
    gbuffer?.add(pixels, samples);
  }
  return view;
}

/** @param {Help} asked @param {MessagePort} leader */
async function help(asked, leader) {
  const networks = await starting;
  if (asked.kind === "samples") {
    taken(networks, asked.part, false);
  } else {
    const { model, band } = asked, network = networks.completers.get(model)?.network;
    if (!network || !view) return leader.postMessage(null);
    const { width } = view.gbuffer, rows = network.complete(view.gbuffer, band).slice(band.begin * width, band.end * width);
    leader.postMessage(rows, [rows.buffer]);
  }
}

/** @param {Samples} part @param {MessagePort} tracer that sent it */
async function gather(part, tracer) {
  const { batch, expected } = part, { height, width } = batch;
  if (isOld(batch)) return;
  const networks = await starting, { completers, standIn } = networks;
  const begun = performance.now(), isNew = view?.batch.view !== batch.view;
  const isShared = isNew ? helpers.areWorth(part) : view?.isShared === true;
  if (isShared) helpers.share(part);
  endRest();
  lit = undefined;
  const current = taken(networks, part, isShared);
  if (expected) tracer.postMessage(expected, [expected.buffer]);

  const { traced } = current.gbuffer, wanted = part.model;
  current.model = completers.has(wanted) ? wanted : standIn;
  const completer = /** @type {Completer} */ (completers.get(current.model));
  const completing = performance.now();
  const inBands = () => helpers.complete(current.model, completer.network, current.gbuffer);
  const image = await completer.complete(shown(current), isShared ? inBands : undefined);
  const completed = performance.now();
  if (!current.completed) current.first.set(image);
  current.completed = true;
  const error = traced === height * width ? meanDifference(current.first, image) : NaN;
  picture = {
    batch, ...await painted(current), traced, isSmoothed: false, isLined: false, completing: completed - completing, total: performance.now() - begun,
    backend: completer.backend, model: current.model, wanted, error,
  };
  reply({ kind: "picture", picture, repainted: false }, [picture.bitmap]);
}

function endRest() {
  rest?.gbuffer?.free();
  rest = undefined;
}

/**
 * Begins a resting picture with the last one, enlarged.
 *
 * @param {Networks} networks @param {Batch} batch @param {boolean} isColored
 * @returns {Promise<Rest>}
 */
async function beginRest({ core }, batch, isColored) {
  const { height, width } = batch, layout = isColored ? COLORED : GBUFFER;
  if (!rest && view?.completed && (showing.mode !== "completed" || view.covered)) await paintView(view, "completed"); // has no lines
  const last = rest ?? view, image = last ? enlarged(last.image, height, width) : new ImageData(width, height);
  const covered = last?.covered ? enlargedLines(last.covered, last.image, batch) : null;
  endRest();
  const gbuffer = height * width <= MOST_WHOLE ? new GBuffer(core, height, width, layout) : null;
  const before = gbuffer && view?.completed ? { height: view.gbuffer.height, width: view.gbuffer.width, image: view.first } : null;
  /** @type {Rest} */
  const begun = { batch, isColored, look: showing, image, rows: 0, isSmoothed: false, isLined: false, gbuffer, first: null, error: NaN, covered, before };
  if (batch.phase !== "rows" && gbuffer && view) { // all was traced in motion
    gbuffer.copy(view.gbuffer);
    finishRest(begun, gbuffer);
  }
  return begun;
}

/** All rows are traced. @param {Rest} rest @param {GBuffer} gbuffer */
function finishRest(rest, gbuffer) {
  const { before } = rest;
  gbuffer.image.set(gbuffer.plane("gray"));
  rest.rows = gbuffer.height;
  rest.first = before && enlargedGray(before, gbuffer.height, gbuffer.width);
  rest.error = rest.first ? meanDifference(rest.first, gbuffer.image) : NaN;
}

/** @param {Strips | Means} part */
async function gatherRest(part) {
  const { batch, isColored } = part, { height, width } = batch;
  if (isOld(batch)) return;
  const networks = await starting, begun = performance.now();
  lit = undefined;
  if (rest?.batch.view !== batch.view) rest = await beginRest(networks, batch, isColored);
  const current = rest, { gbuffer, image } = current;
  current.batch = batch;
  if (part.kind === "rows") {
    for (const strip of part.strips) {
      paintStrip(strip, isColored, current.look, image);
      gbuffer?.setRows(strip);
      current.rows = strip.end;
    }
    current.covered ??= batch.thickness > 0 ? new Uint8Array(height * width) : null;
    for (const { begin, covered } of part.bands) current.covered?.set(covered, begin * width);
    current.isLined = part.isLined;
    if (gbuffer && part.strips.length > 0 && current.rows === height) finishRest(current, gbuffer);
  } else {
    paintMeans(part, current.look, image);
    current.rows = height;
    current.isSmoothed = part.isLast;
  }
  const { model } = view ?? { model: networks.standIn };
  picture = {
    batch, bitmap: await restPainted(current), expected: NaN, traced: current.rows * width, isSmoothed: current.isSmoothed, isLined: current.isLined, completing: 0,
    total: performance.now() - begun, backend: "wasm", model, wanted: model, error: current.error,
  };
  reply({ kind: "picture", picture, repainted: false }, [picture.bitmap]);
}

/** @param {Lit} part @param {MessagePort} tracer that sent it */
async function gatherLight(part, tracer) {
  const { batch, traced, isLast, milliseconds } = part;
  if (isOld(batch)) return;
  const { standIn } = await starting, begun = performance.now();
  const covered = lit?.batch.view === batch.view ? lit.covered : null; // exact lines come once
  if (lit) tracer.postMessage({ lit: lit.planes }, [lit.planes.buffer]);
  endRest();
  view?.gbuffer.free(), view?.expected?.free(), view?.coverage?.free();
  view = undefined;
  lit = { ...part, covered: part.covered ?? covered };
  picture = {
    batch, bitmap: await lightPainted(lit), expected: NaN, traced, isSmoothed: isLast, isLined: isLast, completing: 0,
    total: milliseconds + performance.now() - begun, backend: "wasm", model: standIn, wanted: standIn, error: NaN,
  };
  reply({ kind: "picture", picture, repainted: false }, [picture.bitmap]);
}

/** @param {Lit} lit */
function lightPainted({ batch: { height, width }, planes, mask, covered }) {
  const image = new ImageData(width, height);
  paintLight(showing, planes, mask, image);
  if (covered) paintLines(covered, image);
  return createImageBitmap(image);
}

/** @param {Rest} rest */
function restPainted({ image, rows, gbuffer, first, covered }) {
  return createImageBitmap(paintRest({ ...showing, rows, gray: gbuffer?.image ?? null, first }, withLines(image, covered)));
}

/** @param {View} view */
async function painted(view) {
  const errors = await paintView(view, showing.mode);
  if (view.covered && !MAPS.includes(showing.mode)) paintLines(view.covered, view.image);
  return { bitmap: await createImageBitmap(view.image), expected: errors ? errors.reduce((sum, error) => sum + error, 0) / errors.length : NaN };
}

/** @param {View} view @param {import("../picture/paint.js").Mode} mode @returns {Promise<Float32Array | null>} predicted errors, if displayed */
async function paintView(view, mode) {
  const { core, completers, predictor } = await starting, { gbuffer, model, first, image } = view, { height, width, traced } = gbuffer;
  const { network } = /** @type {Completer} */ (completers.get(model)), known = shown(view);
  const errors = mode === "uncertain" ? predictor.predict(gbuffer, network) : null;
  if (showing.isTransparent) {
    view.coverage ??= new GBuffer(core, height, width);
    view.coverage.takeCoverage(known);
    network.complete(view.coverage);
  }
  const completedColor = known.completeColor(); // before there are views of memory that it may move
  paint({
    ...showing, mode, image: known.image, first, expected: errors, mask: gbuffer.plane("mask"),
    gray: gbuffer.plane("gray"), exact: traced === height * width, color: gbuffer.color, completedColor,
    alpha: showing.isTransparent && view.coverage ? view.coverage.image : null,
  }, image);
  return errors;
}

/** @param {Float32Array} a @param {Float32Array} b */
function meanDifference(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; ++i) sum += Math.abs(a[i] - b[i]);
  return sum / a.length;
}

/** @param {Exclude<Request, {kind: "start"}>} request */
async function answer(request) {
  if (request.kind === "connect") {
    const { tracer } = request;
    /** @param {MessageEvent<Samples | Strips | Means | Lit>} event */
    tracer.onmessage = ({ data }) => inTurn(() => (
      data.kind === "samples" ? gather(data, tracer) : data.kind === "lit" ? gatherLight(data, tracer) : gatherRest(data)));
  } else if (request.kind === "help") {
    const { leader } = request;
    /** @param {MessageEvent<Help>} event */
    leader.onmessage = ({ data }) => inTurn(() => help(data, leader));
    await starting;
    leader.postMessage(null);
  } else if (request.kind === "helped") {
    const { helper } = request;
    helper.onmessage = () => inTurn(async () => {
      helpers.add(helper);
      if (view) view.isShared = false;
    });
  } else if (request.kind === "network") {
    const { core, completers } = await starting;
    completers.set(request.name, await completerOf(core, request.weights));
  } else if (request.kind === "show") {
    showing = request;
    if (!picture || !(lit || rest || view?.completed)) return;
    const bitmap = lit ? await lightPainted(lit) : rest ? await restPainted(rest) : null;
    picture = { ...picture, ...bitmap ? { bitmap, expected: NaN } : await painted(/** @type {View} */ (view)) };
    reply({ kind: "picture", picture, repainted: true }, [picture.bitmap]);
  } else {
    if (rest?.gbuffer && rest.rows === rest.gbuffer.height) {
      const { height, width, planes, image } = rest.gbuffer, first = rest.first ?? image;
      return reply({ kind: "buffers", buffers: { height, width, planes: planes.slice(), known: planes.slice(), image: image.slice(), first: first.slice() } });
    }
    if (!view?.completed || rest && !rest.gbuffer) return reply({ kind: "buffers", buffers: null });
    const { height, width, planes } = view.gbuffer, { planes: known, image } = shown(view), { first } = view;
    reply({ kind: "buffers", buffers: { height, width, planes: planes.slice(), known: known.slice(), image: image.slice(), first } });
  }
}

/** @param {unknown} error */
const fail = (error) => reply({ kind: "failed", message: error instanceof Error ? error.message : String(error) });

/** @param {() => Promise<void>} handle */
function inTurn(handle) {
  queue = queue.then(handle).catch(fail);
}

/** @param {MessageEvent<Request>} event */
onmessage = ({ data }) => {
  if (data.kind === "start") begin(data);
  else inTurn(() => answer(data));
};
