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
 * @typedef {{shape: Shape, transform: ArrayLike<number>, material: ArrayLike<number>}} Instance
 *   transform (4, 4): from the shape's own units to the scene's; material (7): linear RGB, ambient, diffuse, specular, shininess
 * @typedef {{network: string, tensors: Map<string, {shape: number[], values: Float32Array}>}} Weights
 */

import { compileCore } from "./compile.js";
import { CoreError } from "./errors.js";

export { CoreError };

/** How many bytes the module is handed at once to make a digest of. */
const PIECE = 1 << 20;

/** How numpy calls arrays. */
const DTYPES = new Map(/** @type {[Function, string][]} */ ([
  [Float64Array, "<f8"], [Float32Array, "<f4"], [Int32Array, "<i4"], [Uint32Array, "<u4"], [Uint8Array, "|u1"],
]));

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
   * @template {Float32Array | Float64Array | Int32Array | Uint8Array} T
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
    return new Shape(this, this.made("make_mesh", as(Float64Array, vertices), vertices.length / 3, as(Int32Array, triangles),
                                     triangles.length / 3, normals ? as(Float32Array, normals) : 0));
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
      return new Shape(this, this.made("make_vm_solid", expression, bounds ? as(Float64Array, bounds) : 0));
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

  /** @param {number} expression @param {ArrayLike<number>} [bounds] (2, 3), which are found without */
  #implicit(expression, bounds) {
    return new Shape(this, this.made("make_implicit", expression, bounds ? as(Float64Array, bounds) : 0));
  }

  /** Trimmed NURBS surfaces, by the arrays of a scene file. @param {import("./splines.js").BrepTensors} tensors */
  brep({ faces, control_points, knots, loops, trims, trim_control_points, trim_knots, tolerance }) {
    return new Shape(this, this.made("make_brep", faces, faces.length / 5, control_points, knots, loops, trims,
                                     trim_control_points, trim_knots, tolerance?.[0] ?? 0));
  }

  /**
   * A tube.
   *
   * @param {Float64Array} controlPoints (n, 5), x, y, z, radius and weight @param {Float64Array} knots
   */
  tube(controlPoints, knots) {
    const count = controlPoints.length / 5;
    return new Shape(this, this.made("make_tube", controlPoints, count, knots, knots.length - count - 1));
  }

  // ---- What shapes and files are ----------------------------------------------------------------------------

  /** SHA-256 of bytes. @param {Uint8Array} bytes @returns {Uint8Array} (32,) */
  sha256(bytes) {
    const hash = this.made("make_sha256");
    for (let at = 0; at < bytes.length; at += PIECE) {
      const piece = bytes.subarray(at, at + PIECE);
      this.call("add_bytes", hash, piece, piece.length);
    }
    return this.written(Uint8Array, 32, (address) => this.call("end_sha256", hash, address));
  }

  /**
   * SHA-256 of what a shape is, as Python's Shape.digest.
   *
   * @param {string} kind
   * @param {[name: string, value: unknown, columns: number][]} fields arrays, of rows of so many columns, or of single numbers
   *   where these are 0; all else counts as text
   * @returns {Uint8Array} (32,)
   */
  shapeDigest(kind, fields) {
    const digest = this.made("make_digest", kind);
    for (const [name, value, columns] of fields.sort(([a], [b]) => (a < b ? -1 : 1))) {
      if (ArrayBuffer.isView(value)) {
        const array = /** @type {Float64Array} */ (value), type = /** @type {string} */ (DTYPES.get(array.constructor));
        this.call("digest_tensor", digest, name, type, array.length / (columns || 1), columns, array, array.byteLength);
      } else {
        this.call("digest_text", digest, name, `${value}`);
      }
    }
    return this.written(Uint8Array, 32, (address) => this.call("end_digest", digest, address));
  }

  /**
   * The order in which the core must get the instances of a scene, so that pictures do not depend on that in which they stand.
   *
   * @param {{digest: Uint8Array, transform: ArrayLike<number>, material: ArrayLike<number>}[]} instances
   *   digest: of the shape; transform (4, 4); material (7)
   * @returns {number[]} which comes first, second, ..
   */
  canonicalOrder(instances) {
    const joined = (/** @type {"digest" | "transform" | "material"} */ name) => instances.flatMap((i) => Array.from(i[name]));
    return Array.from(this.written(Int32Array, instances.length, (address) => {
      this.made("canonical_order", Uint8Array.from(joined("digest")), Float64Array.from(joined("transform")),
                Float64Array.from(joined("material")), instances.length, address);
    }));
  }

  /** How much longer vectors become by a map, (4, 4), the largest first. @param {ArrayLike<number>} map */
  singularValues(map) {
    return Array.from(this.written(Float64Array, 3, (address) => {
      this.call("singular_values", Float64Array.from(map), address);
    }));
  }

  // ---- Scenes ---------------------------------------------------------------------------------------------

  /** A scene; where surfaces coincide, the first of the instances is seen. @param {Instance[]} instances */
  scene(instances) {
    const joined = (/** @type {"transform" | "material"} */ name) => instances.flatMap((i) => Array.from(i[name]));
    const shapes = Uint32Array.from(instances, (i) => i.shape.handle);
    const handle = this.made("make_scene", shapes, instances.length, Float64Array.from(joined("transform")),
                             Float32Array.from(joined("material")));
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

/** A surface, in units of its own. */
export class Shape {
  /** @param {Core} core @param {number} handle */
  constructor(core, handle) {
    this.core = core;
    this.handle = handle;
  }

  /** Scenes that have it keep it. */
  free() {
    this.core.call("free_shape", this.handle);
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
