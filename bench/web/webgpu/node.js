/** Measures in Node with Dawn, `node node.js DAWN.node SETTINGS`, and prints messages as lines of JSON. */
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { isMainThread, parentPort, Worker } from "node:worker_threads";

globalThis.fetch = async (url) => new Response(await readFile(new URL(url)));

if (isMainThread) {
  const [dawn, settings] = process.argv.slice(2), { create, globals } = createRequire(import.meta.url)(dawn);
  const gpu = create(["enable-dawn-features=allow_unsafe_apis", "disable-dawn-features=timestamp_quantization"]);
  Object.assign(globalThis, globals);
  Object.defineProperty(globalThis, "navigator", { value: { gpu } });
  const report = (message) => console.log(JSON.stringify(message));
  try {
    const { measure } = await import("./measure.js");
    await measure(JSON.parse(settings), () => new Worker(new URL(import.meta.url)), report);
    report({ done: true });
  } catch (error) {
    report({ error: String(error?.stack ?? error) });
  }
  process.exit();
} else { // the globals of a browser's worker
  globalThis.onmessage = null;
  globalThis.postMessage = (message, { transfer } = {}) => parentPort.postMessage(message, transfer);
  globalThis.ImageData = class {
    constructor(width, height) {
      this.data = new Uint8ClampedArray(4 * width * height);
    }
  };
  await import("./workers/completing.js");
  parentPort.on("message", (data) => globalThis.onmessage({ data }));
}
