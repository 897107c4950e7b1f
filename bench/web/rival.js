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

/** Traces pixels of a sequence, into a G-buffer as well, until some place in it; milliseconds after each slice. */
function slices(scene, gbuffer, sequence, camera, until) {
  const milliseconds = [], begin = performance.now();
  while (sequence.done < until) {
    const pixels = sequence.next(Math.min(sequence.available(), SLICE)), samples = scene.trace(pixels, gbuffer, camera);
    sequence.add(pixels, samples), gbuffer.add(pixels, samples);
    milliseconds.push(performance.now() - begin);
  }
  return milliseconds;
}

/** 8-bit grays in base64. */
const bytes = (image) => new Uint8Array(Uint8ClampedArray.from(image, (value) => 255 * value).buffer).toBase64();

async function compare({ file, height, width, cameras, step, before, times, levels }) {
  const modules = ["core/load", "completion/network", "completion/weights", "files/read", "picture/gbuffer", "picture/history",
                   "picture/order", "tracing/scene", "workers/lattice"];
  const [{ loadCore }, { DENSE, Network }, { readWeights }, { readFile }, { GBuffer }, { History }, { AdaptiveOrder, PixelSequence },
         { buildScene }, { plan }] =
    await Promise.all(modules.map((module) => import(`./${module}.js`)));
  const core = await loadCore();
  const fetched = async (path) => (await fetch(path)).arrayBuffer();
  const scene = buildScene(core, await readFile(core, file, await fetched(file)));
  const networks = await Promise.all(["filling", "default"].map(async (name) =>
    new Network(core, readWeights(await fetched(`weights/${name}.safetensors`)))));
  const whole = new GBuffer(core, height, width, scene.layout);
  const complete = (network) => {
    const begin = performance.now();
    network.complete(whole);
    return performance.now() - begin;
  };
  const sequence = (step, expected) =>
    new PixelSequence(core, { height, width }, scene.layout, expected ?? new AdaptiveOrder(core, { height, width }, scene.layout, step));
  /** Milliseconds after each slice of a picture that begins with the lattice of a step. */
  const sequenced = (camera, step, until = height * width) => {
    const pixels = sequence(step);
    whole.clear();
    const milliseconds = slices(scene, whole, pixels, camera, until);
    pixels.free();
    return milliseconds;
  };
  /** Milliseconds that it takes to decide where 5 % of the pixels are, those included that go into reading what they show. */
  const decided = (camera) => {
    const order = sequence(0);
    let milliseconds = 0;
    const timed = (part) => {
      const begin = performance.now(), result = part();
      milliseconds += performance.now() - begin;
      return result;
    };
    while (order.done < 0.05 * height * width) {
      const pixels = timed(() => order.next(order.available())), samples = scene.trace(pixels, whole, camera);
      timed(() => order.add(pixels, samples));
    }
    order.free();
    return milliseconds;
  };
  /**
   * The picture of the last of some cameras, each with so many milliseconds, the first but with all pixels unless it is the only
   * one. As viewer/workers/tracer.js and completing.js do it, one after the other; where a whole picture takes `dense` ms, and
   * rays along edges are `rate` a millisecond.
   */
  const moving = (cameras, time, completing, dense, rate) => {
    const history = new History(core, { height, width }, scene.layout);
    let view, image, spare, carrying = 0, latticeStep = 1;
    for (const [i, camera] of cameras.entries()) {
      const begin = performance.now(), isFirst = i === 0 && cameras.length > 1;
      // As viewer/workers/schedule.js has it.
      const pace = { whole: dense / (height * width), lattice: dense / (height * width), rate }, ofAll = { whole: time, part: time - completing[0] };
      const { firstStep, lattice, others } = plan(height * width, pace, ofAll, latticeStep);
      const isDense = Math.max(lattice, others) >= DENSE * height * width;
      const isExpected = view && !isDense && history.move(view.camera, view.order.planes, camera, i);
      view?.order.free();
      if (isExpected) scene.shade(history.planes, { height, width }, camera);
      carrying = isExpected ? performance.now() - begin : NaN;
      latticeStep = isExpected ? 0 : firstStep;
      const end = begin + (isFirst ? Infinity : latticeStep === 1 ? time : time - completing[isExpected || isDense ? 0 : 1]);
      const order = sequence(latticeStep, isExpected ? history : undefined);
      view = { camera, order };
      whole.clear();
      // A whole picture that would not be there in time is completed instead.
      const isLate = (now) => latticeStep === 1 && !isFirst && now > end - completing[0] &&
        (now - begin) * (height * width - order.done) > (end - now) * order.done;
      for (let now; order.done < height * width && (now = performance.now()) < end && !isLate(now);) {
        const wanted = Math.max(32, isFirst ? Infinity : Math.floor(rate * (end - now)));
        const pixels = order.next(Math.min(order.available(wanted), wanted, SLICE));
        const samples = scene.trace(pixels, { height, width }, camera);
        order.add(pixels, samples);
        if (!isExpected) whole.add(pixels, samples);
      }
      if (isExpected) whole.set(spare = history.picture(spare));
      image = order.done === height * width ? whole.plane("gray") : networks[whole.traced < DENSE * height * width ? 1 : 0].complete(whole);
    }
    const last = bytes(image);
    view.order.free(), history.free();
    return { image: last, carrying };
  };
  for (let i = 0; i < 20; ++i) sequenced(cameras[0], 0, 0.2 * height * width), networks.forEach(complete);  // compiled by now
  const frames = [];
  for (const camera of cameras) {
    const edges = sequenced(camera, 0), dense = Math.min(sequenced(camera, 1).at(-1), sequenced(camera, 1).at(-1));
    const exact = bytes(whole.plane("gray"));
    // Rays a millisecond, of those that come first: they lie on surfaces.
    const rateIn = (time) => SLICE * Math.max(1, edges.filter((milliseconds) => milliseconds <= time).length) / time;
    const completing = networks.map((network) => Math.min(complete(network), complete(network), complete(network)));
    const shown = (path) => times.map((time) => moving(path, time, completing, dense, rateIn(time)));
    const anew = shown([camera]);
    const theirs = Array.from({ length: levels }, (_, level) => {
      const gbuffer = new GBuffer(core, height >> level, width >> level, scene.layout);
      const milliseconds = traced(scene, gbuffer, camera);
      const image = bytes(gbuffer.plane("gray"));
      gbuffer.free();
      return { milliseconds, image };
    });
    const inMotion = shown(Array.from({ length: before + 1 }, (_, i) => ({ ...camera, azimuth: camera.azimuth - step * (before - i) })));
    const deciding = Math.min(decided(camera), decided(camera), decided(camera));
    const images = (pictures) => pictures.map(({ image }) => image);
    frames.push({ exact, dense, filling: completing[0], completing: completing[1], deciding, anew: images(anew), inMotion: images(inMotion), carrying: inMotion[0].carrying, theirs });
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
