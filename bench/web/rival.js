/**
 * Two ways to show a moving scene in a given time, in one thread: some pixels, completed by the network; and all pixels of a
 * picture of half the resolution, or a quarter, and so on.
 */
const SLICE = 1024; // pixels between two looks at the clock

/** All pixels of a picture row by row, (H * W, 2). */
function rows(height, width) {
  const pixels = new Int32Array(2 * height * width);
  for (let i = 0; i < height * width; ++i) pixels[2 * i] = Math.floor(i / width), pixels[2 * i + 1] = i % width;
  return pixels;
}

/** Traces pixels into a G-buffer; milliseconds after each slice. */
function timed(scene, gbuffer, pixels, camera) {
  const milliseconds = [], begin = performance.now();
  for (let first = 0; first < pixels.length; first += 2 * SLICE) {
    const slice = pixels.subarray(first, first + 2 * SLICE);
    gbuffer.add(slice, scene.trace(slice, gbuffer, camera));
    milliseconds.push(performance.now() - begin);
  }
  return milliseconds;
}

/** 8-bit grays in base64. */
const bytes = (image) => new Uint8Array(Uint8ClampedArray.from(image, (value) => 255 * value).buffer).toBase64();

async function compare({ file, height, width, cameras, times, levels }) {
  const modules = ["core/load", "completion/network", "completion/weights", "files/read", "picture/gbuffer", "picture/order",
                   "tracing/scene"];
  const [{ loadCore }, { Network }, { readWeights }, { readFile }, { GBuffer }, { pixelOrder }, { buildScene }] =
    await Promise.all(modules.map((module) => import(`./${module}.js`)));
  const core = await loadCore();
  const fetched = async (path) => (await fetch(path)).arrayBuffer();
  const scene = buildScene(core, await readFile(core, file, await fetched(file)));
  const network = new Network(core, readWeights(await fetched("weights/default.safetensors")));
  const order = pixelOrder(core, "lattice", { height, width });
  const whole = new GBuffer(core, height, width), part = new GBuffer(core, height, width);
  const complete = () => {
    const begin = performance.now();
    network.complete(part);
    return performance.now() - begin;
  };
  for (let i = 0; i < 20; ++i) timed(scene, whole, order.subarray(0, 20 * SLICE), cameras[0]), complete();  // compiled by now
  const frames = [];
  for (const camera of cameras) {
    const milliseconds = timed(scene, whole, order, camera), completing = Math.min(complete(), complete(), complete());
    const ours = times.map((time) => {
      if (milliseconds[milliseconds.length - 1] <= time) return { fraction: 1, image: bytes(whole.plane("gray")) };
      const slices = milliseconds.filter((spent) => spent + completing <= time).length;
      if (slices === 0) return null;
      part.clear();
      const pixels = order.subarray(0, 2 * SLICE * slices);
      part.add(pixels, scene.trace(pixels, part, camera));
      return { fraction: SLICE * slices / (height * width), image: bytes(network.complete(part)) };
    });
    const theirs = Array.from({ length: levels }, (_, level) => {
      const gbuffer = new GBuffer(core, height >> level, width >> level);
      const spent = timed(scene, gbuffer, rows(gbuffer.height, gbuffer.width), camera);
      const image = bytes(gbuffer.plane("gray"));
      gbuffer.free();
      return { milliseconds: spent[spent.length - 1], image };
    });
    frames.push({ exact: bytes(whole.plane("gray")), completing, ours, theirs });
  }
  return frames;
}

onmessage = async ({ data }) => {
  try {
    postMessage(await compare(data));
  } catch (error) {
    postMessage({ error: String(error?.stack ?? error) });
  }
};
