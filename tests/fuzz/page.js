// @ts-check
/** The page's readers, in a worker as in the page: a message with a file becomes one that says what they make of it. */
import { Core } from "/core/core.js";
import { compileCore } from "/core/compile.js";
import { Network } from "/completion/network.js";
import { readWeights } from "/completion/weights.js";
import { readFile } from "/files/read.js";
import { buildScene } from "/tracing/scene.js";

const SIZE = { height: 6, width: 8 };
const PIXELS = Int32Array.from({ length: 2 * SIZE.height * SIZE.width }, (_, i) => i % 2 ? (i >> 1) % SIZE.width : Math.floor((i >> 1) / SIZE.width));
const MANY = 1 << 28; // bytes of memory, which an instance never gives back
const compiled = compileCore("core", false);
/** @type {Core | null} */
let core = null;

onmessage = async ({ data: { name, content } }) => {
  const answer = { loads: false, says: "", clear: true, seconds: 0 };
  const module = await compiled;
  core ??= new Core(module);
  const bytes = Uint8Array.from(atob(content), (letter) => letter.charCodeAt(0)).buffer, start = performance.now();
  try {
    if (name.endsWith(".safetensors")) {
      new Network(core, readWeights(bytes)).free();
    } else {
      const scene = buildScene(core, await readFile(core, name, bytes));
      scene.trace(PIXELS, SIZE);
      scene.free();
    }
    answer.loads = true;
  } catch (error) {
    answer.says = error instanceof Error ? error.message : String(error);
    answer.clear = error.constructor.name === "CoreError" && !/\p{C}/u.test(answer.says);
    if (error instanceof WebAssembly.RuntimeError) core = null;  // a trap leaves it in no state to go on with
  }
  answer.seconds = (performance.now() - start) / 1000;
  if (core && core.memory.byteLength > MANY) core = null;
  postMessage(answer);
};
