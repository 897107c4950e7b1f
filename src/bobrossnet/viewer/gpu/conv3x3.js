// @ts-check
/**
 * 3x3 convolutions with zero padding: the arithmetic of every network here.
 *
 * An invocation computes 2x2 pixels of several output channels, which stay in registers: so each input that it reads counts
 * for four pixels, each weight too, and pooling and enlarging need no further pass. A workgroup's inputs lie in its own memory, a
 * few channels at a time.
 *
 * @typedef {import("../core.js").Weights} Weights
 * @typedef {import("./plan.js").Plan} Plan
 * @typedef {import("./plan.js").Image} Image
 */
import { GPUBufferUsage } from "./flags.js";
import { declarations } from "./kernel.js";

const THREADS = 8; // a workgroup has 8 x 8 invocations
const TILE = 2 * THREADS; // and as many pairs of rows and of columns
const PAIRS = TILE / 2 + 1; // of columns in a row of inputs, with one column more on each side
const ROWS = TILE + 2;
const CHANNELS = 4; // of the inputs at once: 5 KB, so that a GPU can hold several workgroups at a time
const MOST_OUTPUTS = 12; // of an invocation: 48 sums, which leaves registers for the inputs

/** What is done with a channel's 2x2 pixels before they are written: `value` has those of a row first. @enum {string} */
export const Then = {
  nothing: `
    for (var i = 0; i < 4; i++) { output_put(channel, y + i / 2, x + i % 2, value[i]); }`,
  relu: `
    for (var i = 0; i < 4; i++) { output_put(channel, y + i / 2, x + i % 2, max(value[i], 0)); }`,
  reluPool: `
    output_put(channel, y / 2, x / 2, max(max(max(value.x, value.y), max(value.z, value.w)), 0));`,
  reluUpsample: `
    for (var i = 0; i < 16; i++) { output_put(channel, 2 * y + i / 4, 2 * x + i % 4, max(value[i / 8 * 2 + i % 4 / 2], 0)); }`,
  /** Channels 4c to 4c + 3 become the 2x2 pixels of channel c. */
  shuffle: `
    for (var i = 0; i < 4; i++) {
      output_put(channel / 4, 2 * (y + i / 2) + channel % 4 / 2, 2 * (x + i % 2) + channel % 2, value[i]);
    }`,
};

/** A convolution's weights, as PyTorch's Conv2d has them, rearranged for the kernel. */
export class Conv3x3 {
  /**
   * @param {GPUDevice} device
   * @param {Weights} weights
   * @param {string} name
   * @param {number} inputs channels
   * @param {number} [outputs] by default as many as the weights have
   */
  constructor(device, { tensors }, name, inputs, outputs) {
    const weight = tensors.get(`${name}.weight`), bias = tensors.get(`${name}.bias`);
    if (!weight || !bias) throw new Error(`${name}: expected a weight and a bias among the weights, not found`);
    this.in = inputs;
    this.out = outputs ?? weight.shape[0];
    /** Input channels of an output channel. */
    this.inputs = weight.shape[1];
    this.groups = inputs / this.inputs;
    if (weight.shape.join() !== [this.out, this.inputs, 3, 3].join() || !Number.isInteger(this.groups)
        || !Number.isInteger(this.out / this.groups) || bias.shape.join() !== `${this.out}`) {
      throw new Error(`${name}: expected a weight of shape (${this.out}, ${this.in} / groups, 3, 3) and a bias for each `
                      + `output, got (${weight.shape.join(", ")}) and (${bias.shape.join(", ")})`);
    }
    this.block = largestDivisor(this.out / this.groups, MOST_OUTPUTS);
    const packed = this.#pack(weight.values, bias.values);
    /** In uniform memory, which all invocations read alike, as far as that goes. */
    this.space = packed.byteLength <= device.limits.maxUniformBufferBindingSize ? "uniform" : "storage";
    const usage = this.space === "uniform" ? GPUBufferUsage.UNIFORM : GPUBufferUsage.STORAGE;
    this.weights = device.createBuffer({ size: packed.byteLength, usage, mappedAtCreation: true });
    new Float32Array(this.weights.getMappedRange()).set(packed);
    this.weights.unmap();
  }

  /**
   * Convolves `from`; output channel c is written to the channel `position` of `to`.
   *
   * @param {Plan} plan
   * @param {Image} from at least as many channels as the convolution has inputs
   * @param {Image} to
   * @param {string} then of `Then`
   * @param {string} [position] in WGSL, of `convolved`, which is c
   */
  record(plan, from, to, then, position = "convolved") {
    const source = this.#source(then, position), depth = this.out / this.block;
    const kernel = { source, images: ["input", "output"], numbers: [], over: "input", tile: TILE, depth };
    plan.step(kernel, { input: from, output: to }, { weights: this.weights });
  }

  /** Of four numbers each: a block's biases, and the nine taps of all its outputs for each input. */
  get #sizes() {
    const biases = Math.ceil(this.block / 4), taps = Math.ceil(9 * this.block / 4);
    return { biases, taps, block: biases + this.inputs * taps };
  }

  /**
   * @param {Float32Array} weight (out, inputs, 3, 3)
   * @param {Float32Array} bias (out,)
   * @returns {Float32Array} (out / block, biases | taps of input 0 | taps of input 1 ...), a block's outputs side by side
   */
  #pack(weight, bias) {
    const sizes = this.#sizes, packed = new Float32Array(4 * sizes.block * (this.out / this.block));
    for (let output = 0; output < this.out; ++output) {
      const place = output % this.block, begin = 4 * sizes.block * Math.floor(output / this.block);
      packed[begin + place] = bias[output];
      for (let input = 0; input < this.inputs; ++input) {
        for (let tap = 0; tap < 9; ++tap) {
          packed[begin + 4 * (sizes.biases + input * sizes.taps) + tap * this.block + place]
            = weight[9 * (output * this.inputs + input) + tap];
        }
      }
    }
    return packed;
  }

  /** @param {string} then @param {string} position */
  #source(then, position) {
    const { block, inputs } = this, sizes = this.#sizes;
    const number = (/** @type {number} */ i) => `weights[at + ${Math.floor(i / 4)}].${"xyzw"[i % 4]}`;
    const each = (/** @type {number} */ count, /** @type {(i: number) => string} */ f) =>
      Array.from({ length: count }, (_, i) => f(i)).join("\n");
    return `${declarations(["input"], ["output"], [])}
@group(0) @binding(3) var<${this.space === "uniform" ? "uniform" : "storage, read"}> weights: array<vec4f, ${
  sizes.block * (this.out / block)}>;
var<workgroup> tile: array<vec2f, ${CHANNELS * ROWS * PAIRS}>;

fn finish(convolved: i32, y: i32, x: i32, value: vec4f) {
  let channel = ${position};${then}
}

@compute @workgroup_size(${THREADS}, ${THREADS})
fn main(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) id: vec3u,
        @builtin(local_invocation_index) index: u32) {
  let first_output = i32(group.z) * ${block};
  let first_input = first_output / ${this.out / this.groups} * ${inputs};
  let top = i32(group.y) * ${TILE};
  let left = i32(group.x) * ${TILE};
  let begin = i32(group.z) * ${sizes.block};
  var at = begin;
${each(block, (i) => `  var sum${i} = vec4f(${number(i)});`)}
  for (var first = 0; first < ${inputs}; first += ${CHANNELS}) {
    let channels = min(${CHANNELS}, ${inputs} - first);
    workgroupBarrier();
    for (var i = i32(index); i < channels * ${ROWS * PAIRS}; i += ${THREADS * THREADS}) {
      let channel = first_input + first + i / ${ROWS * PAIRS};
      let y = top + i / ${PAIRS} % ${ROWS} - 1;
      let x = left + i % ${PAIRS} * 2 - 1;
      tile[i] = vec2f(input_at(channel, y, x), input_at(channel, y, x + 1));
    }
    workgroupBarrier();
    for (var channel = 0; channel < channels; channel++) {
      at = begin + ${sizes.biases} + (first + channel) * ${sizes.taps};
      let corner = (channel * ${ROWS} + 2 * i32(id.y)) * ${PAIRS} + i32(id.x);
${each(4, (row) => `      let a${row} = tile[corner + ${row * PAIRS}];
      let b${row} = tile[corner + ${row * PAIRS + 1}];`)}
${each(3, (row) => `      let tap${3 * row} = vec4f(a${row}, a${row + 1});
      let tap${3 * row + 1} = vec4f(a${row}.y, b${row}.x, a${row + 1}.y, b${row + 1}.x);
      let tap${3 * row + 2} = vec4f(b${row}, b${row + 1});`)}
${each(9 * block, (i) => `      sum${i % block} += ${number(i)} * tap${Math.floor(i / block)};`)}
    }
  }
  let y = top + 2 * i32(id.y);
  let x = left + 2 * i32(id.x);
${each(block, (i) => `  finish(first_output + ${i}, y, x, sum${i});`)}
}
`;
  }
}

/** @param {number} number @param {number} most */
function largestDivisor(number, most) {
  let divisor = Math.min(number, most);
  while (number % divisor) --divisor;
  return divisor;
}
