// @ts-check
/**
 * Trained weights, as in weight files.
 *
 * @typedef {{
 *   network: string, inputs: Layout, outputs: Layout, tensors: Map<string, {shape: number[], values: Float32Array}>
 * }} Weights
 *   network: its name; inputs: its input channels; outputs: the completed channels
 * @typedef {import("../picture/channels.js").Layout} Layout
 */
import { CoreError } from "../core/errors.js";
import { readContainer, readTensor } from "../files/safetensors.js";

/** Defaults of older files, as in bobrossnet/completion/weights.py. */
const DEFAULTS = { inputs: "mask,gray,depth,normal", outputs: "gray" };

/**
 * Makes an object from weights in the core's memory.
 *
 * @param {import("../core/core.js").Core} core
 * @param {Weights} weights
 * @param {(handle: number) => number} make called with the core's weights, which are freed afterwards
 * @returns {number} its result
 */
export function withWeights(core, { inputs, outputs, tensors }, make) {
  const handle = core.made("make_weights", inputs.join(), outputs.join());
  /** @type {number[]} */
  const addresses = [];
  try {
    for (const [name, { shape, values }] of tensors) {
      const address = core.put(values);
      addresses.push(address);
      core.made("add_tensor", handle, name, Int32Array.from(shape), shape.length, address);
    }
    return make(handle);
  } finally {
    core.call("free_weights", handle);
    for (const address of addresses) core.release(address);
  }
}

/**
 * Reads a safetensors file written by bobrossnet.
 *
 * @param {ArrayBuffer} bytes the tensors may be views of it
 * @returns {Weights}
 */
export function readWeights(bytes) {
  const container = readContainer(bytes), { metadata } = container;
  if (metadata?.format !== "bobrossnet-1") {
    throw new CoreError(`weights: expected format bobrossnet-1, got ${metadata?.format}`);
  }
  const tensors = new Map();
  for (const [name, entry] of Object.entries(container.entries)) {
    if (entry.dtype !== "F32") throw new CoreError(`${name}: expected float32 values, got ${entry.dtype}`);
    tensors.set(name, { shape: entry.shape, values: readTensor(container, name, entry) });
  }
  const { network, inputs, outputs } = { ...DEFAULTS, ...metadata };
  return { network, inputs: inputs.split(","), outputs: outputs.split(","), tensors };
}
