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
                   "picture/order", "picture/planner", "tracing/scene"];
  const [{ loadCore }, { Network }, { readWeights }, { readFile }, { GBuffer }, { History },
         { AdaptiveOrder, PixelSequence, SquaresOrder, WholeOrder }, { FramePlanner }, { buildScene }] =
    await Promise.all(modules.map((module) => import(`./${module}.js`)));
  const core = await loadCore();
  const fetched = async (path) => (await fetch(path)).arrayBuffer();
  const scene = buildScene(core, await readFile(core, file, await fetched(file)));
  const models = ["filling", "small", "default"];
  const networks = await Promise.all(models.map(async (name) =>
    new Network(core, readWeights(await fetched(`weights/${name}.safetensors`)))));
  const whole = new GBuffer(core, height, width, scene.layout);
  const complete = (network) => {
    const begin = performance.now();
    network.complete(whole);
    return performance.now() - begin;
  };
  const sequence = (Order, expected) =>
    new PixelSequence(core, { height, width }, scene.layout, expected ?? new Order(core, { height, width }, scene.layout));
  /** Milliseconds after each slice of a picture in an order. */
  const sequenced = (camera, Order, until = height * width) => {
    const pixels = sequence(Order);
    whole.clear();
    const milliseconds = slices(scene, whole, pixels, camera, until);
    pixels.free();
    return milliseconds;
  };
  /** Milliseconds that it takes to decide where 5 % of the pixels are, those included that go into reading what they show. */
  const decided = (camera) => {
    const order = sequence(AdaptiveOrder);
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
   * one. As viewer/workers/tracer.js and completing.js do it, one after the other, with a planner that knows what completing takes, and what
   * tracing took before.
   */
  const moving = (cameras, time, planner) => {
    const history = new History(core, { height, width }, scene.layout), size = { height, width }, pixels = height * width;
    let view, image, spare, reprojecting = NaN;
    for (const [i, camera] of cameras.entries()) {
      const begin = performance.now(), isFirst = i === 0 && cameras.length > 1;
      let mode = isFirst ? "whole" : planner.plan(view?.camera, camera, size, time, 1), known = 0;
      if (mode === "reproject") {
        known = history.move(scene.handle, view.camera, view.order.planes, camera, i) / pixels;
        reprojecting = performance.now() - begin;
        planner.reprojected(pixels, reprojecting);
        if (known === 0) mode = "adaptive";
      }
      view?.order.free();
      const isExpected = mode === "reproject", order = sequence(ORDERS[mode], isExpected ? history : undefined);
      const model = planner.completion(mode, known, time, 1), end = isFirst ? Infinity : begin + planner.forTracing(mode, model, time);
      view = { camera, order };
      whole.clear();
      for (let now; order.done < pixels && (now = performance.now()) < end;) {
        const wanted = isFirst ? SLICE : Math.max(32, Math.floor(planner.pixelsIn(mode, end - now)));
        const slice = order.next(Math.min(order.available(wanted), wanted, SLICE));
        const samples = scene.trace(slice, size, camera);
        order.add(slice, samples);
        if (!isExpected) whole.add(slice, samples);
        planner.traced(mode, slice.length / 2, performance.now() - now, mode !== "reproject" && order.rounds === 1);
      }
      if (isExpected) whole.set(spare = history.picture(spare));
      image = order.done === pixels ? whole.plane("gray") : networks[models.indexOf(model)].complete(whole);
    }
    const last = bytes(image);
    view.order.free(), history.free();
    return { image: last, carrying: reprojecting };
  };
  const ORDERS = { whole: WholeOrder, squares: SquaresOrder, adaptive: AdaptiveOrder, reproject: undefined };
  const orders = [SquaresOrder, AdaptiveOrder];
  for (let i = 0; i < 20; ++i) { // compiled by now
    for (const Order of orders) sequenced(cameras[0], Order, 0.2 * height * width);
    networks.forEach(complete);
  }
  const frames = [];
  for (const camera of cameras) {
    traced(scene, whole, camera);
    const exact = bytes(whole.plane("gray")), dense = Math.min(traced(scene, whole, camera), traced(scene, whole, camera));
    const completing = networks.map((network) => Math.min(complete(network), complete(network), complete(network)));
    const planner = new FramePlanner(core, false);
    planner.plan(undefined, camera, { height, width }, 1, 1); // which says the size
    models.forEach((model, i) => planner.completed(model, height * width, completing[i]));
    for (const mode of ["adaptive", "squares"]) { // what scenes of pages know after a while
      const took = sequenced(camera, ORDERS[mode], 0.2 * height * width);
      planner.traced(mode, SLICE * took.length, took.at(-1), false);
    }
    const shown = (path) => times.map((time) => moving(path, time, planner));
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
    frames.push({ exact, dense, filling: completing[0], completing: completing[2], deciding, anew: images(anew), inMotion: images(inMotion), carrying: inMotion[0].carrying, theirs });
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
