// @ts-check
/**
 * 3x3 convolutions with zero padding, shared by all networks.
 *
 * An invocation computes 2x2 pixels of several output channels in registers. Each weight is used for four pixels, each
 * input for all these channels, and pooling and enlarging need no further pass. Neighbours read the same inputs at the
 * same time, so caches suffice: with a tile in workgroup memory, between barriers, a software GPU takes three times as
 * long to compile the kernel and six times to run it.
 *
 * @typedef {import("../weights.js").Weights} Weights
 * @typedef {import("./plan.js").Plan} Plan
 * @typedef {import("./plan.js").Image} Image
 */
import { GPUBufferUsage } from "./flags.js";
import { declarations } from "./kernel.js";

const THREADS = 8; // 8 x 8 invocations per workgroup
const MOST_OUTPUTS = 8; // per invocation: 32 sums, which leaves registers for the inputs

/** How a channel's 2x2 pixels are written; `value` has them row by row. @enum {string} */
export const Then = {
  nothing: `
    for (var i = 0; i < 4; i++) { output_put(channel, y + i / 2, x + i % 2, value[i]); }`,
  relu: `
    for (var i = 0; i < 4; i++) { output_put(channel, y + i / 2, x + i % 2, max(value[i], 0.)); }`,
  reluPool: `
    output_put(channel, y / 2, x / 2, max(max(max(value.x, value.y), max(value.z, value.w)), 0.));`,
  reluUpsample: `
    for (var i = 0; i < 16; i++) {
      output_put(channel, 2 * y + i / 4, 2 * x + i % 4, max(value[i / 8 * 2 + i % 4 / 2], 0.));
    }`,
  /** Channels 4c to 4c + 3 become the 2x2 pixels of channel c. */
  shuffle: `
    for (var i = 0; i < 4; i++) {
      output_put(channel / 4, 2 * (y + i / 2) + channel % 4 / 2, 2 * (x + i % 2) + channel % 2, value[i]);
    }`,
};

/** A convolution's weights, as in PyTorch's Conv2d, rearranged for the kernel. */
export class Conv3x3 {
  /**
   * @param {GPUDevice} device
   * @param {Weights} weights
   * @param {string} name
   * @param {number} inputs channels
   * @param {number} [outputs] by default those of the weights
   */
  constructor(device, { tensors }, name, inputs, outputs) {
    const weight = tensors.get(`${name}.weight`), bias = tensors.get(`${name}.bias`);
    if (!weight || !bias) throw new Error(`${name}: expected a weight and a bias among the weights, not found`);
    this.in = inputs;
    this.out = outputs ?? weight.shape[0];
    /** Input channels per output channel. */
    this.inputs = weight.shape[1];
    this.groups = inputs / this.inputs;
    if (weight.shape.join() !== [this.out, this.inputs, 3, 3].join() || !Number.isInteger(this.groups)
        || !Number.isInteger(this.out / this.groups) || bias.shape.join() !== `${this.out}`) {
      throw new Error(`${name}: expected a weight of shape (${this.out}, ${this.in} / groups, 3, 3) and a bias for `
                      + `each output, got (${weight.shape.join(", ")}) and (${bias.shape.join(", ")})`);
    }
    this.block = largestDivisor(this.out / this.groups, MOST_OUTPUTS);
    const packed = this.#pack(weight.values, bias.values);
    const size = packed.byteLength;
    this.weights = device.createBuffer({ size, usage: GPUBufferUsage.STORAGE, mappedAtCreation: true });
    new Float32Array(this.weights.getMappedRange()).set(packed);
    this.weights.unmap();
  }

  /**
   * Convolves `from`; output channel c is written to channel `position` of `to`.
   *
   * @param {Plan} plan
   * @param {Image} from has at least the convolution's input channels
   * @param {Image} to
   * @param {string} then of `Then`
   * @param {string} [position] in WGSL, of `convolved`, which is c
   */
  record(plan, from, to, then, position = "convolved") {
    const { block, inputs } = this, outputs = this.out / this.groups;
    const kernel = {
      source: source(block, then, position), images: ["input", "output"], numbers: ["inputs", "outputs"], over: "input",
      tile: 2 * THREADS, depth: this.out / block,
    };
    plan.step(kernel, { input: from, output: to }, { numbers: { inputs, outputs }, weights: this.weights });
  }

  /**
   * @param {Float32Array} weight (out, inputs, 3, 3)
   * @param {Float32Array} bias (out,)
   * @returns {Float32Array} for each block of outputs its biases, then the nine taps of each input, (9, block); both
   *   padded to a multiple of four
   */
  #pack(weight, bias) {
    const { block, inputs } = this, sizes = sizesOf(block), stride = sizes.bias + inputs * sizes.taps;
    const packed = new Float32Array(stride * (this.out / block));
    for (let output = 0; output < this.out; ++output) {
      const place = output % block, begin = stride * Math.floor(output / block);
      packed[begin + place] = bias[output];
      for (let input = 0; input < inputs; ++input) {
        for (let tap = 0; tap < 9; ++tap) {
          const at = begin + sizes.bias + input * sizes.taps + tap * block + place;
          packed[at] = weight[9 * (output * inputs + input) + tap];
        }
      }
    }
    return packed;
  }
}

/** Numbers per block of outputs: its biases, and its taps for one input. @param {number} block */
const sizesOf = (block) => ({ bias: Math.ceil(block / 4) * 4, taps: Math.ceil(9 * block / 4) * 4 });

/** @param {number} count @param {(i: number) => string} line */
const each = (count, line) => Array.from({ length: count }, (_, i) => line(i)).join("");

/** The kernel's source. @param {number} block outputs per invocation @param {string} then @param {string} position */
function source(block, then, position) {
  const sizes = sizesOf(block), component = (/** @type {number} */ i) => "xyzw"[i % 4];
  const tap = (/** @type {number} */ i) => { // the inputs of tap i for the 2x2 pixels
    const row = Math.floor(i / 3), columns = ["xy", "yz", "zw"][i % 3];
    return `vec4f(input${row}.${columns}, input${row + 1}.${columns})`;
  };
  return `${declarations(["input"], ["output"], ["inputs", "outputs"])}
@group(0) @binding(3) var<storage, read> weights: array<vec4f>;

fn finish(convolved: i32, y: i32, x: i32, value: vec4f) {
  let channel = ${position};${then}
}

@compute @workgroup_size(${THREADS}, ${THREADS})
fn main(@builtin(global_invocation_id) id: vec3u) {
  let y = i32(id.y) * 2;
  let x = i32(id.x) * 2;
  let size = settings.input;
  if (y >= size.height || x >= size.width) { return; }
  let inputs = i32(settings.inputs);

  // Where the inputs of these pixels are, 4x4, and which are inside of the image.
  let columns = x + vec4i(-1, 0, 1, 2);
  let inside = (columns >= vec4i(0)) & (columns < vec4i(size.width));
  let nearest = clamp(columns, vec4i(0), vec4i(size.width - 1));
${each(4, (i) => `
  let y${i} = y + ${i - 1};
  let inside${i} = inside & vec4<bool>(y${i} >= 0 && y${i} < size.height);
  let row${i} = nearest + clamp(y${i}, 0, size.height - 1) * size.width;`)}

  let first_output = i32(id.z) * ${block};
  let first_input = size.first + first_output / i32(settings.outputs) * inputs;
  var at = i32(id.z) * (${sizes.bias / 4} + inputs * ${sizes.taps / 4});
${each(block, (i) => `
  var sum${i} = vec4f(weights[at + ${i >> 2}].${component(i)});`)}
  at += ${sizes.bias / 4};
  for (var channel = first_input; channel < first_input + inputs; channel++) {
    let plane = channel * size.height * size.width;
${each(4, (i) => `
    let at${i} = plane + row${i};
    let values${i} = vec4f(input[at${i}.x], input[at${i}.y], input[at${i}.z], input[at${i}.w]);
    let input${i} = select(vec4f(), values${i}, inside${i});`)}
${each(9 * block, (i) => `${i % block ? "" : `
    let tap${i / block} = ${tap(i / block)};`}${i % 4 ? "" : `
    let weights${i / 4} = weights[at + ${i / 4}];`}
    sum${i % block} += weights${i >> 2}.${component(i)} * tap${Math.floor(i / block)};`)}
    at += ${sizes.taps / 4};
  }

  var sums = array<vec4f, ${block}>(${each(block, (i) => `${i ? ", " : ""}sum${i}`)});
  for (var i = 0; i < ${block}; i++) { finish(first_output + i, y, x, sums[i]); }
}
`;
}

/** @param {number} number @param {number} max */
function largestDivisor(number, max) {
  let divisor = Math.min(number, max);
  while (number % divisor) --divisor;
  return divisor;
}
