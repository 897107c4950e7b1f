// @ts-check
/**
 * The core in a page or a worker: shapes, scenes, pixel orders, tracing and completion, by the names that they have in Python.
 *
 * Everything lies in the memory of one WebAssembly instance, which has no threads: a page starts as many module workers as it
 * likes, each with a core of its own. What `free` ends must not be used again. Typed arrays that a G-buffer shows are views of
 * that memory, which any call may move: ask for them anew.
 *
 * @typedef {{azimuth?: number, elevation?: number, roll?: number, zoom?: number, panX?: number, panY?: number}} Camera
 *   as bobrossnet.Camera, in degrees; the picture's centre is panX radii of the scene right of the scene's, and panY above it
 * @typedef {{shape: Shape, toShape: ArrayLike<number>, box: ArrayLike<number>, material: ArrayLike<number>}} Instance
 *   toShape (3, 4): from the scene's unit sphere to the shape's own coordinates; box (2, 3): low and high in the unit sphere;
 *   material (7): linear RGB, ambient, diffuse, specular, shininess
 * @typedef {{network: string, tensors: Map<string, {shape: number[], values: Float32Array}>}} Weights
 */

/** A module of one function that multiplies and adds with a single rounding: valid where relaxed SIMD is known. */
const RELAXED = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0,
  10, 19, 1, 17, 0, 65, 1, 253, 15, 65, 2, 253, 15, 65, 3, 253, 15, 253, 133, 2, 11,
]);

/** White, as bobrossnet.Material() has it. */
export const WHITE = Object.freeze([1, 1, 1, 0.1, 0.7, 0.2, 32]);

/** What the core says is wrong, in one line. */
export class CoreError extends Error {}

/**
 * Loads the core.
 *
 * @param {"core" | "complete"} [name] "complete" has networks alone and is a tenth as large
 * @param {boolean} [relaxed] in relaxed SIMD; by default where the browser has it
 * @returns {Promise<Core>}
 */
export async function loadCore(name = "core", relaxed = WebAssembly.validate(RELAXED)) {
  const url = new URL(`${name}${relaxed ? ".relaxed" : ""}.wasm`, import.meta.url);
  const response = await fetch(url);
  if (!response.ok) throw new CoreError(`${url.pathname}: ${response.status} ${response.statusText}`);
  const { instance } = await WebAssembly.instantiate(await response.arrayBuffer());
  return new Core(instance);
}

/**
 * Reads weights: a safetensors file as bobrossnet writes it.
 *
 * @param {ArrayBuffer} bytes
 * @returns {Weights}
 */
export function readWeights(bytes) {
  const size = Number(new DataView(bytes).getBigUint64(0, true));
  /** @type {Record<string, any>} */
  const { __metadata__: metadata, ...entries } = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 8, size)));
  if (metadata?.format !== "bobrossnet-1") {
    throw new CoreError(`weights: expected format bobrossnet-1, got ${metadata?.format}`);
  }
  const tensors = new Map();
  for (const [name, { dtype, shape, data_offsets: [begin, end] }] of Object.entries(entries)) {
    if (dtype !== "F32") throw new CoreError(`${name}: expected float32 values, got ${dtype}`);
    tensors.set(name, { shape, values: new Float32Array(bytes.slice(8 + size + begin, 8 + size + end)) });
  }
  return { network: metadata.network, tensors };
}

export class Core {
  /** @type {Record<string, any>} */
  #functions;
  /** @type {number[]} */
  #lent = [];

  /** @param {WebAssembly.Instance} instance */
  constructor(instance) {
    this.#functions = instance.exports;
    this.#functions._initialize();
  }

  // ---- Calls ----------------------------------------------------------------------------------------------

  /** The module's memory as it is now. @returns {ArrayBuffer} */
  get memory() {
    return this.#functions.memory.buffer;
  }

  /**
   * Calls a function of bindings/wasm.cpp or wasm_complete.cpp. Typed arrays are copied to the module, and texts, with their
   * size in bytes behind them.
   *
   * @param {string} name
   * @param {...(number | string | ArrayBufferView)} values
   * @returns {number}
   */
  call(name, ...values) {
    const before = this.#lent.length;
    try {
      const numbers = values.flatMap((value) => {
        if (typeof value === "number") return [value];
        const bytes = typeof value === "string" ? new TextEncoder().encode(value) : value;
        const address = this.#put(bytes);
        this.#lent.push(address);
        return typeof value === "string" ? [address, bytes.byteLength] : [address];
      });
      return Number(this.#functions[name](...numbers));
    } finally {
      for (const address of this.#lent.splice(before)) this.#functions.release(address);
    }
  }

  /** As `call`, of a function that returns 0 where it fails. @type {Core["call"]} */
  made(name, ...values) {
    const result = this.call(name, ...values);
    if (result === 0) throw new CoreError(this.#error());
    return result;
  }

  /** @param {number} bytes @returns {number} the address of memory, which `release` gives back */
  allocate(bytes) {
    const address = this.#functions.allocate(bytes) >>> 0;
    if (address === 0) throw new CoreError(this.#error());
    return address;
  }

  /** @param {number} address */
  release(address) {
    this.#functions.release(address);
  }

  #error() {
    const bytes = new Uint8Array(this.memory, this.#functions.error() >>> 0);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  /** @param {ArrayBufferView} array */
  #put(array) {
    const address = this.allocate(array.byteLength);
    new Uint8Array(this.memory, address).set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return address;
  }

  /**
   * What f writes to `count` numbers of the module's memory.
   *
   * @template {Float32Array | Float64Array | Int32Array} T
   * @param {{new (buffer: ArrayBufferLike, offset: number, length: number): T, BYTES_PER_ELEMENT: number}} type
   * @param {number} count
   * @param {(address: number) => void} f
   * @returns {T}
   */
  #written(type, count, f) {
    const address = this.allocate(count * type.BYTES_PER_ELEMENT);
    try {
      f(address);
      return /** @type {T} */ (new type(this.memory, address, count).slice());
    } finally {
      this.release(address);
    }
  }

  // ---- Shapes ---------------------------------------------------------------------------------------------

  /**
   * A triangle mesh.
   *
   * @param {ArrayLike<number>} vertices (V, 3), in any unit
   * @param {ArrayLike<number>} triangles (T, 3), anticlockwise seen from outside
   * @param {ArrayLike<number>} [normals] (V, 3)
   */
  mesh(vertices, triangles, normals) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < triangles.length; ++i) {
      for (let axis = 0; axis < 3; ++axis) {
        const value = vertices[3 * triangles[i] + axis];
        low[axis] = Math.min(low[axis], value), high[axis] = Math.max(high[axis], value);
      }
    }
    const center = low.map((value, axis) => value / 2 + high[axis] / 2);
    let radius = 0;
    for (let i = 0; i < triangles.length; ++i) {
      const [x, y, z] = center.map((value, axis) => vertices[3 * triangles[i] + axis] - value);
      radius = Math.max(radius, Math.hypot(x, y, z));
    }
    const scale = radius > 0 ? radius : 1;
    const scaled = Float32Array.from(vertices, (value, i) => (value - center[i % 3]) / scale);
    const handle = this.made("make_mesh", scaled, vertices.length / 3, Int32Array.from(triangles), triangles.length / 3,
                             normals ? Float32Array.from(normals) : 0);
    const shape = new Shape(this, handle, center, scale);
    shape.extent = { low, high, radius: (about) => Math.hypot(...about.map((v, axis) => v - center[axis])) + radius };
    return shape;
  }

  /** The shape that a script makes (docs/scripts.md). @param {string} source */
  script(source) {
    return this.#implicit(this.made("run_script", source));
  }

  /** The surface of a .vm formula, within bounds if it has none. @param {string} text @param {ArrayLike<number>} [bounds] (2, 3) */
  formula(text, bounds) {
    return this.#implicit(this.made("parse_vm", text), bounds);
  }

  /** @param {number} expression @param {ArrayLike<number>} [bounds] */
  #implicit(expression, bounds) {
    try {
      const box = bounds ? Float64Array.from(bounds)
                         : this.#written(Float64Array, 6, (address) => this.made("find_bounds", expression, address));
      let handle = 0;
      const [x, y, z, size] = this.#written(Float64Array, 4, (address) => {
        handle = this.made("make_implicit", expression, box, address);
      });
      return new Shape(this, handle, [x, y, z], size);
    } finally {
      this.call("free_expression", expression);
    }
  }

  /**
   * Trimmed NURBS surfaces, by the arrays of a scene file (CONVENTIONS.md), whose control points are homogeneous here.
   *
   * @param {{faces: Int32Array, controlPoints: Float64Array, knots: Float64Array, loops?: Int32Array, trims?: Int32Array,
   *          trimControlPoints?: Float64Array, trimKnots?: Float64Array, tolerance?: number}} arrays
   */
  brep({ faces, controlPoints, knots, loops, trims, trimControlPoints, trimKnots, tolerance = 0 }) {
    const handle = this.made("make_brep", faces, faces.length / 5, controlPoints, knots, loops ?? 0, trims ?? 0,
                             trimControlPoints ?? 0, trimKnots ?? 0, tolerance);
    return new Shape(this, handle, [0, 0, 0], 1);
  }

  /** A tube. @param {Float64Array} controlPoints (n, 5), w (x, y, z, radius, 1) @param {Float64Array} knots */
  tube(controlPoints, knots) {
    const count = controlPoints.length / 5;
    return new Shape(this, this.made("make_tube", controlPoints, count, knots, knots.length - count - 1), [0, 0, 0], 1);
  }

  // ---- Scenes ---------------------------------------------------------------------------------------------

  /**
   * A scene of instances whose maps and boxes are known, such as Python makes them.
   *
   * @param {Instance[]} instances
   */
  scene(instances) {
    const joined = (/** @type {"toShape" | "box" | "material"} */ name) => instances.flatMap((i) => Array.from(i[name]));
    const shapes = Uint32Array.from(instances, (i) => i.shape.handle);
    const handle = this.made("make_scene", shapes, instances.length, Float64Array.from(joined("toShape")),
                             Float32Array.from(joined("box")), Float32Array.from(joined("material")));
    return new Scene(this, handle);
  }

  /** A scene of one shape, which cameras orbit. @param {Shape} shape @param {ArrayLike<number>} [material] */
  sceneOf(shape, material = WHITE) {
    const { low, high } = shape.bounds();
    const center = low.map((value, axis) => value / 2 + high[axis] / 2);
    const radius = shape.radius(center), scale = radius / shape.size;
    const toShape = [0, 1, 2].flatMap((row) => [
      ...[0, 1, 2].map((column) => (row === column ? scale : 0)), (center[row] - shape.center[row]) / shape.size,
    ]);
    const box = [low, high].flatMap((corner) => corner.map((value, axis) => (value - center[axis]) / radius));
    return this.scene([{ shape, toShape, box, material }]);
  }

  /**
   * Pixels in the sequence in which they are traced.
   *
   * @param {"lattice" | "uniform" | "r2" | "blue-noise"} order
   * @param {{height: number, width: number, seed?: number | bigint, start?: number, count?: number}} which
   * @returns {Int32Array} (count, 2), row and column
   */
  pixelOrder(order, { height, width, seed = 0, start = 0, count = height * width - start }) {
    const bits = BigInt.asUintN(64, BigInt(seed));
    return this.#written(Int32Array, 2 * count, (address) => {
      this.made("pixel_order", order, Number(bits & 0xffffffffn), Number(bits >> 32n), height, width, start, address, count);
    });
  }

  /** @param {number} height @param {number} width */
  gbuffer(height, width) {
    return new GBuffer(this, height, width);
  }

  /** A network with its weights. @param {Weights} weights */
  network({ network, tensors }) {
    const weights = this.made("make_weights");
    /** @type {number[]} */
    const addresses = [];
    try {
      for (const [name, { shape, values }] of tensors) {
        const address = this.#put(values);
        addresses.push(address);
        this.made("add_tensor", weights, name, Int32Array.from(shape), shape.length, address);
      }
      return new Network(this, this.made("make_network", network, weights));
    } finally {
      this.call("free_weights", weights);
      for (const address of addresses) this.release(address);
    }
  }
}

/** A surface. The core knows it in coordinates of its own, in which it is about 1 in size. */
class Shape {
  /** @type {{low: number[], high: number[], radius: (about: number[]) => number} | undefined} */
  extent;

  /** @param {Core} core @param {number} handle @param {number[]} center @param {number} size of the core's unit sphere */
  constructor(core, handle, center, size) {
    this.core = core;
    this.handle = handle;
    this.center = center;
    this.size = size;
  }

  /** From the core's coordinates to the shape's. */
  get #map() {
    const [x, y, z] = this.center, s = this.size;
    return Float64Array.of(s, 0, 0, x, 0, s, 0, y, 0, 0, s, z);
  }

  /** The lowest and highest coordinates. @returns {{low: number[], high: number[]}} */
  bounds() {
    if (this.extent) return this.extent;
    const address = this.core.allocate(48);
    try {
      this.core.made("placed_bounds", this.handle, this.#map, address);
      const box = Array.from(new Float64Array(this.core.memory, address, 6));
      return { low: box.slice(0, 3), high: box.slice(3) };
    } finally {
      this.core.release(address);
    }
  }

  /** The distance from a point to the farthest one of the shape. @param {number[]} about */
  radius(about) {
    return this.extent?.radius(about)
      ?? this.core.made("placed_radius", this.handle, this.#map, Float64Array.from(about), this.size);
  }

  free() {
    this.core.call("free_shape", this.handle);
  }
}

class Scene {
  /** @param {Core} core @param {number} handle */
  constructor(core, handle) {
    this.core = core;
    this.handle = handle;
  }

  /**
   * Traces pixels into a G-buffer.
   *
   * @param {GBuffer} gbuffer
   * @param {Int32Array} pixels (n, 2), row and column
   * @param {Camera} [camera]
   */
  trace(gbuffer, pixels, { azimuth = 30, elevation = 20, roll = 0, zoom = 1, panX = 0, panY = 0 } = {}) {
    this.core.made("trace", this.handle, azimuth, elevation, roll, zoom, panX, panY, gbuffer.height, gbuffer.width,
                   pixels, pixels.length / 2, gbuffer.address);
  }

  /** The shapes stay. */
  free() {
    this.core.call("free_scene", this.handle);
  }
}

/** What was traced, (5, height, width): mask, gray, depth, normal x, normal y; and the picture completed from it. */
class GBuffer {
  /** @param {Core} core @param {number} height @param {number} width */
  constructor(core, height, width) {
    this.core = core;
    this.height = height;
    this.width = width;
    this.address = core.allocate(6 * 4 * height * width);
    this.clear();
  }

  /** (5, height, width) */
  get planes() {
    return new Float32Array(this.core.memory, this.address, 5 * this.height * this.width);
  }

  /** (height, width), 0..1, once a network has completed it */
  get image() {
    return new Float32Array(this.core.memory, this.#imageAddress, this.height * this.width);
  }

  get #imageAddress() {
    return this.address + 20 * this.height * this.width;
  }

  /** Forgets all pixels. */
  clear() {
    this.planes.fill(0);
  }

  /** Fills in what was not traced. @param {Network} network @returns {Float32Array} `image` */
  complete(network) {
    this.predict(network);
    this.core.call("keep_known", this.address, this.height * this.width, this.#imageAddress);
    return this.image;
  }

  /** The network's own output at every pixel. @param {Network} network @returns {Float32Array} `image` */
  predict(network) {
    this.core.made("run_network", network.handle, this.address, this.height, this.width, this.#imageAddress);
    return this.image;
  }

  free() {
    this.core.release(this.address);
  }
}

class Network {
  /** @param {Core} core @param {number} handle */
  constructor(core, handle) {
    this.core = core;
    this.handle = handle;
  }

  free() {
    this.core.call("free_network", this.handle);
  }
}
