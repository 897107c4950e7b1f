/**
 * Completes one picture with each contender in turn, on this worker's thread alone, or on the GPU if there is one. A classic
 * worker, since TensorFlow.js and onnxruntime-web are scripts.
 */
const packages = "packages/";
importScripts(`${packages}@tensorflow/tfjs-core/dist/tf-core.min.js`,
              `${packages}@tensorflow/tfjs-backend-wasm/dist/tf-backend-wasm.min.js`,
              `${packages}onnxruntime-web/dist/ort.wasm.min.js`);

const bytes = async (url) => (await fetch(url)).arrayBuffer();

/** The core, in one instruction set. */
async function ours(viewer, weights, stack, height, width, relaxed) {
  const core = await viewer.loadCore("complete", relaxed);
  const network = new viewer.Network(core, weights), gbuffer = new viewer.GBuffer(core, height, width);
  return () => {
    gbuffer.planes.set(stack);
    network.predict(gbuffer, gbuffer.imageAddress);
    return gbuffer.image;
  };
}

async function onnx(name, stack, height, width) {
  ort.env.wasm.numThreads = 1;
  ort.env.wasm.wasmPaths = new URL(`${packages}onnxruntime-web/dist/`, self.location).href;
  const session = await ort.InferenceSession.create(`${name}.onnx`, { executionProviders: ["wasm"] });
  const input = new ort.Tensor("float32", stack, [1, 5, height, width]);
  return async () => (await session.run({ [session.inputNames[0]]: input }))[session.outputNames[0]].data;
}

/** The report's network in TensorFlow.js, by the names of learn/networks/paper.py. */
async function tensorflow({ tensors }, stack, height, width) {
  tf.wasm.setWasmPaths(`${packages}@tensorflow/tfjs-backend-wasm/dist/`);
  tf.wasm.setThreadsCount(1);
  await tf.setBackend("wasm");
  const layers = {};
  for (const name of ["encode1", "encode2", "encoded", "decode1", "decode2", "output"]) {
    const { shape, values } = tensors.get(`${name}.weight`);
    layers[name] = {
      inputs: shape[1],
      weight: tf.transpose(tf.tensor4d(values, shape), [2, 3, 1, 0]),  // height, width, in, out
      bias: tf.tensor1d(tensors.get(`${name}.bias`).values),
    };
  }
  const convolve = (x, name, activation = "relu") => {
    const { weight, bias, inputs } = layers[name];
    const groups = x.shape[3] / inputs;
    if (groups === 1) return tf.fused.conv2d({ x, filter: weight, strides: 1, pad: "same", bias, activation });
    const parts = tf.split(x, groups, 3), filters = tf.split(weight, groups, 3), biases = tf.split(bias, groups);
    return tf.concat(parts.map((part, g) => tf.fused.conv2d(
      { x: part, filter: filters[g], strides: 1, pad: "same", bias: biases[g], activation })), 3);
  };
  const shuffle = (x, groups) => {
    const [n, h, w, c] = x.shape;
    return tf.reshape(tf.transpose(tf.reshape(x, [n * h * w, groups, c / groups]), [0, 2, 1]), [n, h, w, c]);
  };
  const pool = (x) => tf.maxPool(x, 2, 2, "valid");
  const upsample = (x) => tf.image.resizeNearestNeighbor(x, [2 * x.shape[1], 2 * x.shape[2]]);
  const channelsLast = new Float32Array(stack.length), plane = height * width;
  for (let i = 0; i < stack.length; ++i) channelsLast[5 * (i % plane) + Math.floor(i / plane)] = stack[i];
  return () => {
    const result = tf.tidy(() => {
      const input = tf.tensor4d(channelsLast, [1, height, width, 5]);
      const half = pool(convolve(input, "encode1"));
      const quarter = shuffle(pool(convolve(half, "encode2")), 20 / layers.encode2.inputs);
      const code = convolve(quarter, "encoded");
      const decoded1 = upsample(convolve(code, "decode1"));
      const decoded2 = upsample(convolve(tf.concat([decoded1, half], 3), "decode2"));
      return convolve(tf.concat([decoded2, input], 3), "output", "linear");
    });
    const values = result.dataSync();
    result.dispose();
    return values;
  };
}

onmessage = async ({ data: { name, height, width, runs } }) => {
  try {
    const modules = ["core/load", "completion/gpu", "completion/network", "completion/weights", "picture/gbuffer"];
    const viewer = Object.assign({}, ...await Promise.all(modules.map((module) => import(`./viewer/${module}.js`))));
    const stack = new Float32Array(await bytes("input.bin")), weights = viewer.readWeights(await bytes(`${name}.safetensors`));
    const contenders = {
      "core, relaxed-simd": await ours(viewer, weights, stack, height, width, true),
      "core, simd128": await ours(viewer, weights, stack, height, width, false),
      "onnxruntime-web": await onnx(name, stack, height, width),
    };
    const gpu = await viewer.createGpuNetwork(weights);
    if (gpu) contenders["WebGPU, there and back"] = () => gpu.complete(stack, height, width);
    if (weights.network === "paper") contenders["TensorFlow.js"] = await tensorflow(weights, stack, height, width);
    const results = {};
    for (const [contender, run] of Object.entries(contenders)) {
      results[contender] = { milliseconds: [], image: Array.from(await run()) };
    }
    for (let i = 0; i < runs; ++i) {
      for (const [contender, run] of Object.entries(contenders)) {
        const begin = performance.now();
        await run();
        results[contender].milliseconds.push(performance.now() - begin);
      }
    }
    postMessage(results);
  } catch (error) {
    postMessage({ error: String(error?.stack ?? error) });
  }
};
