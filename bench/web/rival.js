/**
 * Ways to show a scene in a given time, in one thread: some pixels, completed, of a picture that is new or of one that carries
 * along what the ones before have seen; and all pixels of a picture of half the resolution, or a quarter, and so on.
 */
const SLICE = 1024; // pixels between two looks at the clock

/** All pixels of a picture row by row, (H * W, 2). */
function rows(height, width) {
  const pixels = new Int32Array(2 * height * width);
  for (let i = 0; i < height * width; ++i) pixels[2 * i] = Math.floor(i / width), pixels[2 * i + 1] = i % width;
  return pixels;
}

/** Traces all pixels row by row into a G-buffer; how many milliseconds that took. */
function traced(scene, gbuffer, camera) {
  const pixels = rows(gbuffer.height, gbuffer.width), begin = performance.now();
  for (let first = 0; first < pixels.length; first += 2 * SLICE) {
    const slice = pixels.subarray(first, first + 2 * SLICE);
    gbuffer.add(slice, scene.trace(slice, gbuffer, camera));
  }
  return performance.now() - begin;
}

/** Traces pixels of a sequence, into a G-buffer as well, until a time is over; the slices, with the milliseconds after each. */
function slices(scene, gbuffer, sequence, camera, time = Infinity) {
  const found = [], begin = performance.now();
  for (let left; (left = sequence.available()) > 0;) {
    const pixels = sequence.next(Math.min(left, SLICE)), samples = scene.trace(pixels, gbuffer, camera);
    sequence.add(pixels, samples), gbuffer.add(pixels, samples);
    const milliseconds = performance.now() - begin;
    found.push({ pixels, samples, milliseconds });
    if (milliseconds > time) break;
  }
  return found;
}

/** 8-bit grays in base64. */
const bytes = (image) => new Uint8Array(Uint8ClampedArray.from(image, (value) => 255 * value).buffer).toBase64();

async function compare({ file, height, width, cameras, step, before, times, levels }) {
  const modules = ["core/load", "completion/network", "completion/weights", "files/read", "picture/gbuffer", "picture/history",
                   "picture/order", "tracing/scene"];
  const [{ loadCore }, { DENSE, Network }, { readWeights }, { readFile }, { GBuffer }, { History }, { PixelSequence }, { buildScene }] =
    await Promise.all(modules.map((module) => import(`./${module}.js`)));
  const core = await loadCore();
  const fetched = async (path) => (await fetch(path)).arrayBuffer();
  const scene = buildScene(core, await readFile(core, file, await fetched(file)));
  const networks = await Promise.all(["filling", "default"].map(async (name) =>
    new Network(core, readWeights(await fetched(`weights/${name}.safetensors`)))));
  const whole = new GBuffer(core, height, width, scene.layout), part = new GBuffer(core, height, width, scene.layout);
  const complete = (network) => {
    const begin = performance.now();
    network.complete(part);
    return performance.now() - begin;
  };
  const sequenced = (camera, time) => {
    const sequence = new PixelSequence(core, { height, width }, scene.layout);
    whole.clear();
    const found = slices(scene, whole, sequence, camera, time);
    sequence.free();
    return found;
  };
  /** Milliseconds that it takes to decide where 5 % of the pixels are, those included that go into reading what they show. */
  const decided = (camera) => {
    const sequence = new PixelSequence(core, { height, width }, scene.layout);
    let milliseconds = 0;
    const timed = (part) => {
      const begin = performance.now(), result = part();
      milliseconds += performance.now() - begin;
      return result;
    };
    while (sequence.done < 0.05 * height * width) {
      const pixels = timed(() => sequence.next(sequence.available())), samples = scene.trace(pixels, whole, camera);
      timed(() => sequence.add(pixels, samples));
    }
    sequence.free();
    return milliseconds;
  };
  /**
   * The picture of the last of some cameras, each with so many milliseconds, the first but with all pixels; where all of them were
   * traced in time, it is exact. As viewer/workers/tracer.js and completing.js do it, one after the other.
   */
  const moving = (cameras, time, completing, rate) => {
    const history = new History(core, { height, width }, scene.layout);
    let view, image, spare, carrying = 0;
    for (const [i, camera] of cameras.entries()) {
      const begin = performance.now(), end = begin + (i > 0 ? time - completing : Infinity);
      const isDense = rate * (time - completing) >= DENSE * height * width;  // as viewer/workers/schedule.js
      const isExpected = view && !isDense && history.move(view.camera, view.sequence.planes, camera, i);
      view?.sequence.free();
      if (isExpected) scene.shade(history.planes, { height, width }, camera);
      carrying = isExpected ? performance.now() - begin : NaN;
      const sequence = new PixelSequence(core, { height, width }, scene.layout, isExpected ? history : undefined);
      view = { camera, sequence };
      whole.clear();
      for (let now; sequence.done < height * width && (now = performance.now()) < end;) {
        const wanted = Math.max(32, i > 0 ? Math.floor(rate * (end - now)) : Infinity);
        const pixels = sequence.next(Math.min(sequence.available(wanted), wanted, SLICE));
        const samples = scene.trace(pixels, { height, width }, camera);
        sequence.add(pixels, samples);
        if (!isExpected) whole.add(pixels, samples);
      }
      if (isExpected) whole.set(spare = history.picture(spare));
      image = sequence.done === height * width ? whole.plane("gray") : networks[whole.traced < DENSE * height * width ? 1 : 0].complete(whole);
    }
    const last = bytes(image);
    view.sequence.free(), history.free();
    return { image: last, carrying };
  };
  for (let i = 0; i < 20; ++i) sequenced(cameras[0], 50), networks.forEach(complete);  // compiled by now
  const frames = [];
  for (const camera of cameras) {
    const all = sequenced(camera);
    const completing = networks.map((network) => Math.min(complete(network), complete(network), complete(network)));
    const ours = times.map((time) => {
      if (all[all.length - 1].milliseconds <= time) return { fraction: 1, image: bytes(whole.plane("gray")) };
      for (const [which, network] of networks.entries()) {  // the first one if enough pixels are traced, as in the page
        const fitting = all.filter(({ milliseconds }) => milliseconds + completing[which] <= time);
        part.clear();
        for (const { pixels, samples } of fitting) part.add(pixels, samples);
        const fraction = part.traced / (height * width);
        if (fraction >= DENSE || (which > 0 && fraction > 0)) return { fraction, image: bytes(network.complete(part)) };
      }
      return null;
    });
    const theirs = Array.from({ length: levels }, (_, level) => {
      const gbuffer = new GBuffer(core, height >> level, width >> level, scene.layout);
      const milliseconds = traced(scene, gbuffer, camera);
      const image = bytes(gbuffer.plane("gray"));
      gbuffer.free();
      return { milliseconds, image };
    });
    // Rays a millisecond, of those that come first: they lie on surfaces.
    const rateIn = (time) => SLICE * Math.max(1, all.filter(({ milliseconds }) => milliseconds <= time).length) / time;
    const turned = (i) => ({ ...camera, azimuth: camera.azimuth - step * i });
    const path = Array.from({ length: before + 1 }, (_, i) => turned(before - i)), exact = bytes(whole.plane("gray"));
    const inMotion = times.map((time) => moving(path, time, completing[0], rateIn(time)));
    const deciding = Math.min(decided(camera), decided(camera), decided(camera));
    frames.push({ exact, filling: completing[0], completing: completing[1], deciding, ours, inMotion: inMotion.map(({ image }) => image), carrying: inMotion[0].carrying, theirs });
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
