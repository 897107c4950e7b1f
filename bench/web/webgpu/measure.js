/** Milliseconds to complete a sparse picture on the GPU, in one worker and in two: in a page's worker or in Node. */
import { GpuNetwork } from "./completion/gpu.js";
import { GPUBufferUsage, GPUMapMode } from "./completion/gpu/flags.js";
import { Network } from "./completion/network.js";
import { readWeights } from "./completion/weights.js";
import { compileCore } from "./core/compile.js";
import { Core } from "./core/core.js";
import { readFile } from "./files/read.js";
import { GBuffer } from "./picture/gbuffer.js";
import { AdaptiveOrder, PixelSequence } from "./picture/order.js";
import { buildScene } from "./tracing/scene.js";
import { Helpers } from "./workers/bands.js";

const BLOCK = 5; // pictures in a row by one way, since a GPU's clock rises under load
const WARM_UP_MS = 500; // until browsers have optimized the code
const QUERY_BYTES = 16;

const fetched = async (path) => (await fetch(new URL(path, import.meta.url))).arrayBuffer();

/** @param {number[]} milliseconds */
function summary(milliseconds) {
  const sorted = milliseconds.toSorted((a, b) => a - b);
  return { median: sorted[sorted.length >> 1], min: sorted[0], max: sorted.at(-1), n: sorted.length };
}

async function timed(run) {
  const begin = performance.now();
  await run();
  return performance.now() - begin;
}

const largestDifference = (a, b) => a.reduce((max, value, i) => Math.max(max, Math.abs(value - b[i])), 0);

/** The first pixels of the adaptive order, and their samples. */
function traced(core, scene, { height, width, share }) {
  const size = { height, width }, camera = { azimuth: 30, elevation: 20, roll: 0, zoom: 1, panX: 0, panY: 0, fov: 0 };
  const sequence = new PixelSequence(core, size, scene.layout, new AdaptiveOrder(core, size, scene.layout));
  const count = Math.round(share * height * width), pixels = new Int32Array(2 * count);
  const samples = new Float32Array(scene.sampleWidth * count);
  while (sequence.done < count) {
    const { done } = sequence, next = sequence.next(Math.min(sequence.available(), count - done));
    const values = scene.trace(next, size, camera);
    sequence.add(next, values);
    pixels.set(next, 2 * done), samples.set(values, scene.sampleWidth * done);
  }
  return { count, pixels, samples };
}

/** A device with the limits of the viewer's, and timestamps. */
async function requestDevice() {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) throw new Error("navigator.gpu: expected an adapter, got none");
  const { maxBufferSize, maxStorageBufferBindingSize } = adapter.limits;
  const { vendor, architecture, device: name, description, isFallbackAdapter } = adapter.info;
  const requiredFeatures = adapter.features.has("timestamp-query") ? ["timestamp-query"] : [];
  const device = await adapter.requestDevice({ requiredLimits: { maxBufferSize, maxStorageBufferBindingSize }, requiredFeatures });
  const facts = { vendor, architecture, name, description, isFallbackAdapter, maxBufferSize, maxStorageBufferBindingSize };
  return { device, adapter: { ...facts, hasTimestamps: requiredFeatures.length > 0 } };
}

/**
 * Milliseconds of each step of a network on the GPU. The GPU's own clock measures its computation.
 *
 * @param {GPUDevice} device @param {(planes: Float32Array) => Promise<Float32Array>} complete on it
 * @param {Float32Array} planes @param {number} pixels @param {number} runs
 */
async function stepsOf(device, complete, planes, pixels, runs) {
  const { COPY_DST, COPY_SRC, MAP_READ, STORAGE } = GPUBufferUsage, usage = STORAGE | COPY_DST | COPY_SRC;
  const input = device.createBuffer({ size: planes.byteLength, usage }), output = device.createBuffer({ size: 4 * pixels, usage });
  const mapped = device.createBuffer({ size: 4 * pixels, usage: COPY_DST | MAP_READ });
  const copied = async (from, to, size) => {
    const encoder = device.createCommandEncoder();
    encoder.copyBufferToBuffer(from, 0, to, 0, size);
    device.queue.submit([encoder.finish()]);
    await to.mapAsync(GPUMapMode.READ);
    const bytes = to.getMappedRange().slice(0);
    to.unmap();
    return bytes;
  };
  const steps = { upload: [], readback: [], compute: [] };
  for (let i = -1; i < runs; ++i) {
    const upload = await timed(() => {
      device.queue.writeBuffer(input, 0, planes);
      device.queue.submit([]);
      return device.queue.onSubmittedWorkDone();
    });
    const readback = await timed(() => copied(output, mapped, 4 * pixels));
    if (i >= 0) steps.upload.push(upload), steps.readback.push(readback);
  }
  if (device.features.has("timestamp-query")) {
    const querySet = device.createQuerySet({ type: "timestamp", count: 2 });
    const resolved = device.createBuffer({ size: QUERY_BYTES, usage: COPY_SRC | 0x200 }); // QUERY_RESOLVE
    const times = device.createBuffer({ size: QUERY_BYTES, usage: COPY_DST | MAP_READ });
    const create = device.createCommandEncoder;
    device.createCommandEncoder = () => {
      const encoder = create.call(device), begin = encoder.beginComputePass;
      encoder.beginComputePass = () => begin.call(encoder, {
        timestampWrites: { querySet, beginningOfPassWriteIndex: 0, endOfPassWriteIndex: 1 },
      });
      return encoder;
    };
    for (let i = -1; i < runs; ++i) {
      await complete(planes);
      const encoder = create.call(device);
      encoder.resolveQuerySet(querySet, 0, 2, resolved, 0);
      device.queue.submit([encoder.finish()]);
      const [begin, end] = new BigInt64Array(await copied(resolved, times, QUERY_BYTES));
      if (i >= 0) steps.compute.push(Number(end - begin) / 1e6);
    }
    delete device.createCommandEncoder;
  }
  for (const buffer of [input, output, mapped]) buffer.destroy();
  return steps;
}

/**
 * @param {{sizes: [number, number][], models: string[], share: number, runs: number}} settings sizes: height and width
 * @param {() => Worker} startCompleting a worker of workers/completing.js
 * @param {(message: object) => void} report {adapter} once, then {row} for each size and model
 */
export async function measure({ sizes, models, share, runs }, startCompleting, report) {
  const module = await compileCore(), core = new Core(module), file = "gallery/happy_tree.bob";
  const scene = buildScene(core, await readFile(core, file, await fetched(file)));
  const uncertainty = await fetched("weights/uncertainty.safetensors");
  report({ adapter: (await requestDevice()).adapter });
  for (const [height, width] of sizes) {
    const part = traced(core, scene, { height, width, share }), gbuffer = new GBuffer(core, height, width);
    gbuffer.add(part.pixels, part.samples);
    for (const model of models) {
      const bytes = await fetched(`weights/${model}.safetensors`), weights = readWeights(bytes), network = new Network(core, weights);
      const helpers = new Helpers(), worker = startCompleting(), { port1: port, port2: leader } = new MessageChannel();
      await new Promise((resolve) => {
        port.onmessage = resolve;
        worker.postMessage({ kind: "start", module, name: model, weights: bytes, uncertainty });
        worker.postMessage({ kind: "help", leader }, [leader]);
      });
      helpers.add(port);
      const { device } = await requestDevice(), gpu = new GpuNetwork(device, weights);
      const onGpu = (planes) => gpu.complete(planes, height, width);
      /** @type {string[]} */
      const failures = [];
      device.onuncapturederror = ({ error }) => failures.push(error.message);

      let view = 0;
      const ways = {
        one: async () => network.complete(gbuffer),
        two: async () => {
          const batch = { id: ++view, view, parts: 1, height, width, sparse: model };
          helpers.share({ batch, isColored: false, expected: null, ...part });
          await helpers.complete(model, network, gbuffer);
        },
        gpu: async () => { // as completion/completer.js
          gbuffer.image.set(await onGpu(gbuffer.planes));
          network.interpolate(gbuffer);
        },
        gpuNetwork: async () => gbuffer.image.set(await onGpu(gbuffer.planes)),
        interpolation: async () => network.interpolate(gbuffer),
      };
      const images = {}, milliseconds = {}, first = await timed(ways.gpu);
      for (const [way, run] of Object.entries(ways)) {
        let total = 0;
        while (total < WARM_UP_MS) total += await timed(run);
        images[way] = gbuffer.image.slice();
        milliseconds[way] = [];
      }
      for (let done = 0; done < runs; done += BLOCK) {
        for (const [way, run] of Object.entries(ways)) {
          await run();
          for (let i = done; i < Math.min(done + BLOCK, runs); ++i) milliseconds[way].push(await timed(run));
        }
      }
      Object.assign(milliseconds, await stepsOf(device, onGpu, gbuffer.planes.slice(), height * width, runs));
      const times = Object.fromEntries(Object.entries(milliseconds).filter(([, all]) => all.length > 0).map(([way, all]) => [way, summary(all)]));
      const differences = {
        network: largestDifference(images.gpuNetwork, network.fill(gbuffer)), gpu: largestDifference(images.gpu, images.one),
        two: largestDifference(images.two, images.one),
      };
      report({ row: { height, width, model, traced: part.count, first, times, differences, failures } });
      gpu.free(), network.free(), worker.terminate(), port.close();
    }
    gbuffer.free();
  }
}
