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

import { IDENTITY, fromUnitSphere, product, singularValues, toUnitSphere } from "./affine.js";
import { compileCore } from "./compile.js";
import { CoreError } from "./errors.js";

export { CoreError };

/** @typedef {import("./affine.js").Matrix} Matrix */

/** Radius of a shape, in its own units, whose reciprocal float64 can hold. */
const SMALLEST = 1e-307;

/** Where to look for a formula without bounds; flat ones are extruded to a height, which ends within their square. */
const CUBE = [-1, -1, -1, 1, 1, 1], HEIGHT = 0.1, SQUARE = [-1, -1, -HEIGHT, 1, 1, HEIGHT];

/**
 * Loads the core.
 *
 * @param {"core" | "complete"} [name] "complete" has networks alone and is a tenth as large
 * @param {boolean} [relaxed] in relaxed SIMD; by default where the browser has it
 * @returns {Promise<Core>}
 */
export async function loadCore(name, relaxed) {
  return new Core(await WebAssembly.instantiate(await compileCore(name, relaxed)));
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
   * Calls a function of bindings/wasm.cpp or wasm_completion.cpp. Typed arrays are copied to the module, and texts, with their
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
        const address = this.put(bytes);
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

  /** @param {ArrayBufferView} array @returns {number} the address of a copy, which `release` gives back */
  put(array) {
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
  written(type, count, f) {
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
   * @param {ArrayLike<number>} vertices (V, 3), in any unit, finite
   * @param {ArrayLike<number>} triangles (T, 3), anticlockwise seen from outside
   * @param {ArrayLike<number>} [normals] (V, 3), of any length
   * @returns {Shape}
   */
  mesh(vertices, triangles, normals) {
    const points = new Points(this, as(Float64Array, vertices), as(Int32Array, triangles));
    try {
      const { low, high } = points.bounds(IDENTITY);
      const center = low.map((value, axis) => value / 2 + high[axis] / 2), radius = points.radius(center, IDENTITY);
      if (!Number.isFinite(radius)) throw new CoreError("vertices: expected finite numbers, got NaN or infinite ones");
      const size = radius > SMALLEST ? radius : 1;
      const handle = this.made("make_mesh", points.address, points.count, ...center, size, as(Int32Array, triangles),
                               triangles.length / 3, normals ? as(Float32Array, normals) : 0);
      return new Mesh(this, handle, center, size, points);
    } catch (error) {
      points.free();
      throw error;
    }
  }

  /** The shape that a script makes (docs/scripts.md). @param {string} source */
  script(source) {
    return this.#withExpression(this.made("run_script", source), (expression) => this.#implicit(expression));
  }

  /**
   * The surface of a .vm formula. Where it is bounded it is taken whole, else cut by the cube from -1 to 1; one without
   * z is extruded to a height of 0.1 (CONVENTIONS.md).
   *
   * @param {string} text
   * @param {ArrayLike<number>} [bounds] (2, 3), to look there
   */
  formula(text, bounds) {
    return this.#withExpression(this.made("parse_vm", text), (expression) => {
      if (!this.call("uses_z", expression)) {
        const solid = this.made("extruded", expression, HEIGHT);
        return this.#withExpression(solid, () => this.#implicit(solid, bounds ?? SQUARE));
      }
      if (bounds) return this.#implicit(expression, bounds);
      let box;
      try {
        box = this.#bounds(expression);
      } catch (error) {
        if (!(error instanceof CoreError)) throw error;
        box = CUBE;
      }
      return this.#implicit(expression, box);
    });
  }

  /**
   * The surface of a formula, by the arrays of a scene file (CONVENTIONS.md).
   *
   * @param {Uint8Array} ops (n,) @param {Uint32Array} operands (n, 3) @param {Float64Array} values (n,)
   * @param {ArrayLike<number>} [bounds] (2, 3)
   */
  implicit(ops, operands, values, bounds) {
    const expression = this.made("make_expression", ops, operands, values, ops.length);
    return this.#withExpression(expression, () => this.#implicit(expression, bounds));
  }

  /** Says what is wrong with a script, if anything is, without looking for its surface. @param {string} source */
  checkScript(source) {
    this.#withExpression(this.made("run_script", source), () => undefined);
  }

  /** The same of a .vm formula. @param {string} text */
  checkFormula(text) {
    this.#withExpression(this.made("parse_vm", text), () => undefined);
  }

  /**
   * The same of the arrays of a scene file.
   *
   * @param {Uint8Array} ops @param {Uint32Array} operands @param {Float64Array} values
   */
  checkNodes(ops, operands, values) {
    this.#withExpression(this.made("make_expression", ops, operands, values, ops.length), () => undefined);
  }

  /** @template T @param {number} expression @param {(expression: number) => T} f @returns {T} */
  #withExpression(expression, f) {
    try {
      return f(expression);
    } finally {
      this.call("free_expression", expression);
    }
  }

  /** @param {number} expression @param {ArrayLike<number>} [bounds] (2, 3) */
  #implicit(expression, bounds) {
    if (!bounds) {
      try {
        bounds = this.#bounds(expression);
      } catch (error) {
        throw error instanceof CoreError ? new CoreError(`shape: expected ${error.message}; cut it`) : error;
      }
    }
    if (Number.isNaN(bounds[0])) {
      const wanted = "a formula that is negative somewhere within 1e9 of the origin";
      throw new CoreError(`shape: expected ${wanted}, got one that never is`);
    }
    const box = as(Float64Array, bounds);
    let handle = 0;
    const [x, y, z, size] = this.written(Float64Array, 4, (address) => {
      handle = this.made("make_implicit", expression, box, address);
    });
    return new Shape(this, handle, [x, y, z], size);
  }

  /** @param {number} expression @returns {Float64Array} (2, 3), NaN where it is positive everywhere */
  #bounds(expression) {
    return this.written(Float64Array, 6, (address) => this.made("find_bounds", expression, address));
  }

  /**
   * Trimmed NURBS surfaces, by the arrays of a scene file (CONVENTIONS.md), whose control points are homogeneous here,
   * and moved and scaled to a sphere of size 1.
   *
   * @param {{faces: Int32Array, controlPoints: Float64Array, knots: Float64Array, loops?: Int32Array,
   *          trims?: Int32Array, trimControlPoints?: Float64Array, trimKnots?: Float64Array, tolerance?: number}} arrays
   * @param {number[]} [center] of that sphere before, and @param {number} [size]
   */
  brep(arrays, center = [0, 0, 0], size = 1) {
    const { faces, controlPoints, knots, loops, trims, trimControlPoints, trimKnots, tolerance = 0 } = arrays;
    const handle = this.made("make_brep", faces, faces.length / 5, controlPoints, knots, loops ?? 0, trims ?? 0,
                             trimControlPoints ?? 0, trimKnots ?? 0, tolerance);
    return new Shape(this, handle, center, size);
  }

  /**
   * A tube, moved and scaled to a sphere of size 1.
   *
   * @param {Float64Array} controlPoints (n, 5), w (x, y, z, radius, 1) @param {Float64Array} knots
   * @param {number[]} [center] of that sphere before, and @param {number} [size]
   */
  tube(controlPoints, knots, center = [0, 0, 0], size = 1) {
    const count = controlPoints.length / 5;
    return new Shape(this, this.made("make_tube", controlPoints, count, knots, knots.length - count - 1), center, size);
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

  /**
   * Pixels in the sequence in which they are traced.
   *
   * @param {"lattice" | "uniform" | "r2" | "blue-noise"} order
   * @param {{height: number, width: number, seed?: number | bigint, start?: number, count?: number}} which
   * @returns {Int32Array} (count, 2), row and column
   */
  pixelOrder(order, { height, width, seed = 0, start = 0, count = height * width - start }) {
    const bits = BigInt.asUintN(64, BigInt(seed));
    return this.written(Int32Array, 2 * count, (address) => {
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
        const address = this.put(values);
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
export class Shape {
  /**
   * @param {Core} core @param {number} handle
   * @param {number[]} center @param {number} size of the core's unit sphere
   */
  constructor(core, handle, center, size) {
    this.core = core;
    this.handle = handle;
    this.center = center;
    this.size = size;
  }

  /** From the shape's own units to the core's coordinates. */
  get toCore() {
    return toUnitSphere(this.center, this.size);
  }

  /** @param {Matrix} matrix @returns {number[]} from the core's coordinates to where a matrix places the shape */
  #fromCore(matrix) {
    return product(matrix, fromUnitSphere(this.center, this.size));
  }

  /**
   * The lowest and highest coordinates, placed by a matrix.
   *
   * @param {Matrix} matrix @returns {{low: number[], high: number[]}}
   */
  bounds(matrix) {
    const map = Float64Array.from(this.#fromCore(matrix).slice(0, 12));
    const box = Array.from(this.core.written(Float64Array, 6, (address) => {
      this.core.made("placed_bounds", this.handle, map, address);
    }));
    return { low: box.slice(0, 3), high: box.slice(3) };
  }

  /**
   * The distance from a point to the farthest one of the shape placed by a matrix.
   *
   * @param {number[]} about @param {Matrix} matrix
   */
  radius(about, matrix) {
    const whole = this.#fromCore(matrix), [largest] = singularValues(whole), map = Float64Array.from(whole.slice(0, 12));
    return this.core.made("placed_radius", this.handle, map, Float64Array.from(about), largest);
  }

  /** Scenes that have it keep it. */
  free() {
    this.core.call("free_shape", this.handle);
  }
}

/** A mesh, whose extents are those of the vertices that its triangles use. */
class Mesh extends Shape {
  /**
   * @param {Core} core @param {number} handle @param {number[]} center @param {number} size
   * @param {Points} points which end with it
   */
  constructor(core, handle, center, size, points) {
    super(core, handle, center, size);
    this.points = points;
  }

  /** @override @param {Matrix} matrix */
  bounds(matrix) {
    return this.points.bounds(matrix);
  }

  /** @override @param {number[]} about @param {Matrix} matrix */
  radius(about, matrix) {
    return this.points.radius(about, matrix);
  }

  /** @override */
  free() {
    super.free();
    this.points.free();
  }
}

/** The vertices of a mesh in its own units, in the core. */
class Points {
  /** @param {Core} core @param {Float64Array} vertices (V, 3) @param {Int32Array} triangles (T, 3) */
  constructor(core, vertices, triangles) {
    this.core = core;
    this.count = vertices.length / 3;
    this.address = core.put(vertices);
    this.used = core.allocate(this.count);
    try {
      core.made("mark_used", triangles, triangles.length / 3, this.used, this.count);
    } catch (error) {
      this.free();
      throw error;
    }
  }

  /** @param {Matrix} matrix @returns {{low: number[], high: number[]}} of those that a triangle uses, moved by a matrix */
  bounds(matrix) {
    const box = Array.from(this.core.written(Float64Array, 6, (address) => {
      this.core.call("point_bounds", this.address, this.used, this.count, Float64Array.from(matrix), address);
    }));
    return { low: box.slice(0, 3), high: box.slice(3) };
  }

  /** @param {number[]} about @param {Matrix} matrix @returns {number} the distance to the farthest, not finite where one is not */
  radius(about, matrix) {
    return this.core.call("point_radius", this.address, this.used, this.count, Float64Array.from(matrix), Float64Array.from(about));
  }

  free() {
    this.core.release(this.address);
    this.core.release(this.used);
  }
}

/**
 * An array as one of a type.
 *
 * @template T
 * @param {{new (values: ArrayLike<number>): T}} type @param {ArrayLike<number>} values @returns {T}
 */
const as = (type, values) => (values instanceof type ? values : new type(values));

class Scene {
  /** @param {Core} core @param {number} handle */
  constructor(core, handle) {
    this.core = core;
    this.handle = handle;
  }

  /**
   * Traces pixels of an image.
   *
   * @param {Int32Array} pixels (n, 2), row and column
   * @param {{height: number, width: number}} size of the image
   * @param {Camera} [camera]
   * @returns {Float32Array} samples, (n, 4): gray, depth, normal x and y, all 0 where a ray missed
   */
  trace(pixels, { height, width }, { azimuth = 30, elevation = 20, roll = 0, zoom = 1, panX = 0, panY = 0 } = {}) {
    const count = pixels.length / 2;
    return this.core.written(Float32Array, 4 * count, (address) => {
      this.core.made("trace", this.handle, azimuth, elevation, roll, zoom, panX, panY, height, width, pixels, count, address);
    });
  }

  free() {
    this.core.call("free_scene", this.handle);
  }
}

/** What was traced, (5, height, width): mask, gray, depth, normal x, normal y; and the picture completed from it. */
export class GBuffer {
  /** How many pixels are known, of those that were added. */
  traced = 0;

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
    this.traced = 0;
  }

  /** Takes what was traced. @param {Int32Array} pixels (n, 2) @param {Float32Array} samples (n, 4), as Scene.trace returns them */
  add(pixels, samples) {
    const count = pixels.length / 2;
    if (count > 0) this.traced = this.core.made("add_samples", pixels, samples, count, this.address, this.height, this.width);
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
