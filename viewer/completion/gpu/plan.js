// @ts-check
/**
 * The steps that complete pictures of one size, and the memory between them.
 *
 * @typedef {import("./kernel.js").Kernel} Kernel
 * @typedef {(source: string) => Promise<GPUComputePipeline>} Compile
 */
import { GPUBufferUsage } from "./flags.js";

/** Float32 on the GPU, (channels, height, width). */
export class Image {
  /**
   * @param {GPUBuffer} buffer
   * @param {{channels: number, height: number, width: number, first?: number}} size first: the buffer's channel that is
   *   channel 0 here
   */
  constructor(buffer, { channels, height, width, first = 0 }) {
    this.buffer = buffer;
    this.channels = channels;
    this.height = height;
    this.width = width;
    this.first = first;
  }

  /** The channels from `first` on, in the same memory. @param {number} first */
  from(first) {
    const { height, width } = this;
    return new Image(this.buffer, { channels: this.channels - first, height, width, first: this.first + first });
  }
}

export class Plan {
  /** @type {GPUBuffer[]} */
  #buffers = [];
  /** @type {Promise<{pipeline: GPUComputePipeline, bindings: GPUBindGroup, workgroups: [number, number, number]}>[]} */
  #recorded = [];

  /** @param {GPUDevice} device @param {Compile} compile */
  constructor(device, compile) {
    this.device = device;
    this.compile = compile;
  }

  /**
   * An image of zeros, or of `value`.
   *
   * @param {number} channels
   * @param {number} height
   * @param {number} width
   * @param {number} [value] replaces zero
   */
  image(channels, height, width, value = 0) {
    const size = 4 * channels * height * width, max = this.device.limits.maxStorageBufferBindingSize;
    if (size > max) {
      throw new Error(`picture: expected at most ${max} bytes of ${channels} channels for the GPU, got ${size}`);
    }
    const usage = GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST | GPUBufferUsage.COPY_SRC;
    const buffer = this.#buffer({ size, usage, mappedAtCreation: value !== 0 });
    if (value !== 0) {
      new Float32Array(buffer.getMappedRange()).fill(value);
      buffer.unmap();
    }
    return new Image(buffer, { channels, height, width });
  }

  /** A buffer for reading back results. @param {number} size in bytes */
  readback(size) {
    return this.#buffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
  }

  /**
   * Records a step.
   *
   * @param {Kernel} kernel
   * @param {Record<string, Image>} images by their names in the kernel; each is either read or written
   * @param {{numbers?: Record<string, number>, weights?: GPUBuffer}} [more] weights: the last binding
   */
  step(kernel, images, { numbers = {}, weights } = {}) {
    const used = kernel.images.map((name) => images[name]);
    const integers = used.flatMap(({ first, channels, height, width }) => [first, channels, height, width]);
    const bytes = 4 * (integers.length + kernel.numbers.length), size = Math.ceil(bytes / 16) * 16;
    const settings = this.#buffer({ size, usage: GPUBufferUsage.UNIFORM, mappedAtCreation: true });
    const mapped = settings.getMappedRange();
    new Int32Array(mapped).set(integers);
    new Float32Array(mapped).set(kernel.numbers.map((name) => numbers[name]), integers.length);
    settings.unmap();
    const buffers = [settings, ...used.map((image) => image.buffer), ...(weights ? [weights] : [])];
    const entries = buffers.map((buffer, binding) => ({ binding, resource: { buffer } }));
    const { height, width } = images[kernel.over];
    const [columns, rows] = [width, height].map((length) => Math.ceil(length / kernel.tile));
    const max = kernel.tile * this.device.limits.maxComputeWorkgroupsPerDimension;
    if (Math.max(height, width) > max) {
      throw new Error(`picture: expected at most ${max} rows and columns for the GPU, got ${height} and ${width}`);
    }
    this.#recorded.push(this.compile(kernel.source).then((pipeline) => ({
      pipeline,
      bindings: this.device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }),
      workgroups: [columns, rows, kernel.depth],
    })));
  }

  /** A function that runs all steps, once their pipelines are ready. @returns {Promise<(encoder: GPUCommandEncoder) => void>} */
  async finished() {
    const steps = await Promise.all(this.#recorded);
    return (encoder) => {
      const pass = encoder.beginComputePass();
      for (const { pipeline, bindings, workgroups } of steps) {
        pass.setPipeline(pipeline);
        pass.setBindGroup(0, bindings);
        pass.dispatchWorkgroups(...workgroups);
      }
      pass.end();
    };
  }

  free() {
    for (const buffer of this.#buffers) buffer.destroy();
  }

  /** @param {GPUBufferDescriptor} descriptor */
  #buffer(descriptor) {
    const buffer = this.device.createBuffer(descriptor);
    this.#buffers.push(buffer);
    return buffer;
  }
}
