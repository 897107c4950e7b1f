/**
 * Ways to show a scene in a given time, in one thread: some pixels, completed, of a picture that is new or of one that carries
 * along what the ones before have seen; and all pixels of a picture of half the resolution, or a quarter, and so on.
 */
const SLICE = 1024; // pixels between two looks at the clock
const LONGEST_CARRYING = 0.75; // as viewer/workers/schedule.js has it

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
                   "picture/order", "tracing/scene", "workers/plan"];
  const [{ loadCore }, { DENSE, Network }, { readWeights }, { readFile }, { GBuffer }, { History },
         { AdaptiveOrder, PixelSequence, SquaresOrder }, { buildScene }, { LATTICE, plan }] =
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
   * one. As viewer/workers/tracer.js and completing.js do it, one after the other, where so many rays a millisecond fit into that time,
   * in the order of squares and in the adaptive one; and the first round of squares takes so many milliseconds.
   */
  const moving = (cameras, time, completing, rates, lattice) => {
    const history = new History(core, { height, width }, scene.layout), part = time - completing[0];
    let view, image, spare, carrying = 0, carries = false, isExpected = false;
    for (const [i, camera] of cameras.entries()) {
      const begin = performance.now(), isFirst = i === 0 && cameras.length > 1;
      // As viewer/workers/schedule.js has it.
      const first = LATTICE * height * width / lattice, { squares, adaptive: others } = rates;
      const { isFast, showsMore } = plan(height * width, { squares, others, first }, part, 1, carrying, carries);
      carries = showsMore && carrying <= LONGEST_CARRYING * time;
      isExpected = Boolean(view) && carries && history.move(scene.handle, view.camera, view.order.planes, camera, i);
      view?.order.free();
      if (isExpected) carrying = performance.now() - begin;
      const rate = isFast && !isExpected ? rates.squares : rates.adaptive, isSparse = !isExpected && !isFast && rate * part < DENSE * height * width;
      const end = begin + (isFirst ? Infinity : time - completing[isSparse ? 1 : 0]);
      const order = sequence(isFast ? SquaresOrder : AdaptiveOrder, isExpected ? history : undefined);
      view = { camera, order };
      whole.clear();
      for (let now; order.done < height * width && (now = performance.now()) < end;) {
        const wanted = Math.max(32, isFirst ? Infinity : Math.floor(rate * (end - now)));
        const pixels = order.next(Math.min(order.available(wanted), wanted, SLICE));
        const samples = scene.trace(pixels, { height, width }, camera);
        order.add(pixels, samples);
        if (!isExpected) whole.add(pixels, samples);
      }
      if (isExpected) whole.set(spare = history.picture(spare));
      image = order.done === height * width ? whole.plane("gray") : networks[whole.traced < DENSE * height * width && !(isFast && !isExpected) ? 1 : 0].complete(whole);
    }
    const last = bytes(image);
    view.order.free(), history.free();
    return { image: last, carrying: isExpected ? carrying : NaN };
  };
  const orders = [SquaresOrder, AdaptiveOrder];
  for (let i = 0; i < 20; ++i) { // compiled by now
    for (const Order of orders) sequenced(cameras[0], Order, 0.2 * height * width);
    networks.forEach(complete);
  }
  const frames = [];
  for (const camera of cameras) {
    traced(scene, whole, camera);
    const exact = bytes(whole.plane("gray")), dense = Math.min(traced(scene, whole, camera), traced(scene, whole, camera));
    const [squares, adaptive] = orders.map((Order) => sequenced(camera, Order));
    // Rays a millisecond, of those that come first: they lie on surfaces.
    const rateIn = (milliseconds, time) => SLICE * Math.max(1, milliseconds.filter((each) => each <= time).length) / time;
    const lattice = squares[Math.ceil(height * width * LATTICE / SLICE) - 1];
    const completing = networks.map((network) => Math.min(complete(network), complete(network), complete(network)));
    const shown = (path) => times.map((time) =>
      moving(path, time, completing, { squares: rateIn(squares, time), adaptive: rateIn(adaptive, time) }, lattice));
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
