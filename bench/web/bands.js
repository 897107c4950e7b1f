/** Milliseconds of the completing worker for a picture, alone and with others that complete bands of it. */
async function measureBands({ file, height, width, share, model, helpers, runs }) {
  const modules = ["core/compile", "core/load", "files/read", "picture/order", "tracing/scene"];
  const [{ compileCore }, { loadCore }, { readFile }, { AdaptiveOrder, PixelSequence }, { buildScene }] =
    await Promise.all(modules.map((module) => import(`./${module}.js`)));
  const fetched = async (path) => (await fetch(path)).arrayBuffer();
  const core = await loadCore(), scene = buildScene(core, await readFile(core, file, await fetched(file)));
  const size = { height, width }, camera = { azimuth: 30, elevation: 20, roll: 0, zoom: 1, panX: 0, panY: 0, fov: 0 };
  const sequence = new PixelSequence(core, size, scene.layout, new AdaptiveOrder(core, size, scene.layout, 8));
  const count = Math.round(share * height * width), pixels = new Int32Array(2 * count), samples = new Float32Array(scene.sampleWidth * count);
  while (sequence.done < count) {
    const { done } = sequence, next = sequence.next(Math.min(sequence.available(), count - done)), traced = scene.trace(next, size, camera);
    sequence.add(next, traced);
    pixels.set(next, 2 * done), samples.set(traced, scene.sampleWidth * done);
  }

  const module = await compileCore(), weights = await fetched(`weights/${model}.safetensors`);
  const uncertainty = await fetched("weights/uncertainty.safetensors");
  const started = () => {
    const worker = new Worker("workers/completing.js", { type: "module" });
    worker.postMessage({ kind: "start", module, name: model, weights, uncertainty });
    return worker;
  };
  const leader = started(), { port1: tracer, port2 } = new MessageChannel();
  leader.postMessage({ kind: "connect", tracer: port2 }, [port2]);
  const others = Array.from({ length: helpers }, () => {
    const helper = started(), { port1, port2 } = new MessageChannel();
    helper.postMessage({ kind: "help", leader: port1 }, [port1]);
    leader.postMessage({ kind: "helped", helper: port2 }, [port2]);
    return helper;
  });
  await new Promise((resolve) => setTimeout(resolve, 1500)); // all have started
  const milliseconds = [];
  for (let id = 1; id <= runs; ++id) {
    if (id === runs / 3 + 1) await measured(); // all code is compiled
    const picture = new Promise((resolve, reject) => {
      leader.onmessage = ({ data }) => (data.kind === "picture" ? resolve(data.picture) : reject(new Error(data.message)));
    });
    const batch = { id, view: id, parts: 1, height, width, sparse: model };
    const message = { kind: "samples", batch, isColored: false, count, pixels: pixels.slice(), samples: samples.slice(), expected: null };
    tracer.postMessage(message, [message.pixels.buffer, message.samples.buffer]);
    const { total, bitmap } = await picture;
    bitmap.close();
    milliseconds.push(total);
  }
  await measured();
  for (const worker of [leader, ...others]) worker.terminate();
  return milliseconds.slice(runs / 3).toSorted((a, b) => a - b)[Math.floor(runs / 3)];
}
