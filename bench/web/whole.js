/** All pixels of pictures traced at once, on some threads: milliseconds for each size, the least of a few runs. */
import { canLendThreads, compileCore } from "./core/compile.js";
import { Core, sharedMemoryFor } from "./core/core.js";
import { readFile } from "./files/read.js";
import { tracedLayout, widthOf } from "./picture/channels.js";
import { buildScene } from "./tracing/scene.js";

const RUNS = 3;

async function whole({ file, camera, sizes, threads }) {
  const isShared = canLendThreads(), name = /[.](ply|obj|stl|off|glb|gltf)$/.test(file) ? "core.mesh" : "core";
  const module = await compileCore(isShared ? `${name}.threads` : name);
  const memory = sharedMemoryFor(module), core = new Core(module, memory);
  for (let i = 1; isShared && i < threads; ++i) {
    const worker = new Worker(new URL("workers/thread.js", import.meta.url), { type: "module" }), { port1, port2 } = new MessageChannel();
    worker.postMessage(port1, [port1]);
    port2.postMessage({ module, memory });
  }
  if (isShared) core.call("set_threads", threads);
  const scene = buildScene(core, await readFile(core, file, await (await fetch(file)).arrayBuffer()));
  return sizes.map((size) => {
    const { height, width } = size, address = core.allocate(4 * widthOf(tracedLayout(scene.layout)) * height * width);
    const times = Array.from({ length: RUNS }, () => {
      const begin = performance.now();
      scene.traceRows(0, height, size, camera, { address, top: 0, rows: height });
      return performance.now() - begin;
    });
    core.release(address);
    return Math.min(...times);
  });
}

onmessage = async ({ data }) => {
  try {
    postMessage(await whole(data));
  } catch (error) {
    postMessage({ error: String(error?.stack ?? error) });
  }
};
