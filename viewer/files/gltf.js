// @ts-check
/** What a glTF has to be before three.js reads it, which would take some of what is wrong for something else. */

import { unescaped } from "../core/addresses.js";
import { CoreError, brief, checkInteger, checkList, placedErrors } from "../core/errors.js";
import { checkCount } from "../tracing/description.js";
import { jsonOf } from "./text.js";

const LISTS = ["buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes"];
const TYPES = ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"];
const COMPONENTS = [5120, 5121, 5122, 5123, 5125, 5126];
/** Numbers of what places a node. */
const PLACES = { matrix: 16, translation: 3, rotation: 4, scale: 3 };
const TRIANGLES = 4, FAN = 6, MOST = 2 ** 32; // the first and last of the modes that draw some; bytes of a file

const HEAD = 12, CHUNK_HEAD = 8; // bytes
const MAGIC = 0x46546c67, JSON_CHUNK = 0x4e4f534a, BIN_CHUNK = 0x004e4942;

/**
 * A GLB without the chunks that do not matter: only its JSON, and its buffer if it has one.
 *
 * @param {ArrayBuffer} bytes
 * @returns {{json: any, glb: ArrayBuffer, size: number}} the JSON; the file of which it is a part; bytes of its buffer
 */
export function glbOf(bytes) {
  const view = new DataView(bytes), name = (/** @type {number} */ at) => new TextDecoder().decode(bytes.slice(at, at + 4));
  if (bytes.byteLength < HEAD + CHUNK_HEAD || name(0) !== "glTF") {
    throw new CoreError(`expected a GLB, which starts with 'glTF', got ${brief(name(0))}`);
  }
  const version = view.getUint32(4, true), size = view.getUint32(8, true), start = HEAD + CHUNK_HEAD;
  if (version !== 2) throw new CoreError(`expected a GLB of version 2, got ${version}`);
  let end = start + view.getUint32(12, true);
  if (Math.max(size, end) > bytes.byteLength || end > size) {
    throw new CoreError(`expected ${Math.max(size, end)} bytes, as its head says, got ${bytes.byteLength}`);
  }
  if (name(16) !== "JSON") throw new CoreError(`expected a first chunk of JSON, got one of ${brief(name(16))}`);
  const json = jsonOf(new Uint8Array(bytes, start, end - start));
  let buffer = end;
  if (end + CHUNK_HEAD <= size && name(end + 4) === "BIN\0") {
    buffer += CHUNK_HEAD;
    end += CHUNK_HEAD + view.getUint32(end, true);
    if (end > size) throw new CoreError(`expected ${end} bytes, as a chunk's head says, got ${size}`);
  }
  const glb = bytes.slice(0, end);
  new DataView(glb).setUint32(8, end, true);
  return { json, glb, size: end - buffer };
}

/**
 * A GLB of a glTF and of what it names, so that one reader does for both. A picture that is missing stays so.
 *
 * @param {ArrayBuffer} bytes
 * @param {import("./beside.js").Beside} beside
 * @returns {Promise<ArrayBuffer>}
 */
export async function packed(bytes, beside) {
  const json = jsonOf(bytes);
  checkGltf(json);
  const { buffers = [], bufferViews = [], images = [] } = json;
  /** @type {Uint8Array[]} */
  const pieces = [];
  let size = 0;
  /** @param {Uint8Array} piece @returns {number} where it lies */
  const add = (piece) => {
    const at = size;
    pieces.push(piece);
    size += Math.ceil(piece.length / 4) * 4;
    return at;
  };
  const starts = [];
  for (const { uri } of buffers) starts.push(add(await contentOf(uri, beside)));
  for (const view of bufferViews) view.byteOffset = (view.byteOffset ?? 0) + starts[view.buffer], view.buffer = 0;
  for (const image of Array.isArray(images) ? images : []) {
    if (!isObject(image) || typeof image.uri !== "string") continue;
    try {
      const content = await contentOf(image.uri, beside);
      image.bufferView = bufferViews.push({ buffer: 0, byteOffset: add(content), byteLength: content.length }) - 1;
      delete image.uri;
    } catch (error) {
      if (!(error instanceof CoreError)) throw error;  // its texture is left out, with a warning
    }
  }
  if (size) Object.assign(json, { buffers: [{ byteLength: size }], bufferViews });
  const text = new TextEncoder().encode(JSON.stringify(json)), length = Math.ceil(text.length / 4) * 4;
  const start = HEAD + CHUNK_HEAD + length + CHUNK_HEAD, glb = new Uint8Array(start + size).fill(0x20, HEAD + CHUNK_HEAD, start);
  const view = new DataView(glb.buffer);
  [MAGIC, 2, start + size, length, JSON_CHUNK].forEach((value, i) => view.setUint32(4 * i, value, true));
  [size, BIN_CHUNK].forEach((value, i) => view.setUint32(start - CHUNK_HEAD + 4 * i, value, true));
  glb.set(text, HEAD + CHUNK_HEAD);
  let at = start;
  for (const piece of pieces) glb.set(piece, at), at += Math.ceil(piece.length / 4) * 4;
  return glb.buffer;
}

/** What an address holds of itself, or a file beside the glTF. @param {unknown} uri @param {import("./beside.js").Beside} beside */
async function contentOf(uri, beside) {
  if (typeof uri !== "string") throw new CoreError(`buffers: expected a uri, got ${brief(uri)}`);
  return uri.startsWith("data:") ? dataOf(uri) : beside.read(unescaped(uri));
}

/** What an address that starts with data: holds. @param {string} uri */
export function dataOf(uri) {
  try {
    return Uint8Array.from(atob(uri.slice(uri.indexOf(",") + 1)), (character) => character.charCodeAt(0));
  } catch {
    throw new CoreError("expected data in base64, got something else");
  }
}

/** Refuses a tree that is not as the specification says, or refers to something that isn't there. @param {any} json */
export function checkGltf(json) {
  if (!isObject(json)) throw new CoreError(`expected a glTF, which is an object, got ${brief(json)}`);
  const { asset, scene = 0 } = json;
  if (!(typeof asset?.version === "string" && asset.version.startsWith("2."))) {
    throw new CoreError(`asset: expected version 2.0, got ${asset?.version}`);
  }
  for (const name of LISTS) if (name in json) checkObjects(name, json[name]);
  const { buffers = [], bufferViews = [], accessors = [], meshes = [], nodes = [], scenes } = json;
  checkCount("nodes", nodes.length);

  /** @param {string} name @param {any} value @param {any[]} of @returns {any} */
  const item = (name, value, of) => of[checkInteger(name, value, 0, of.length - 1)];
  each("bufferViews", bufferViews, ({ buffer, byteLength, byteOffset = 0, byteStride = 4 }) => {
    item("buffer", buffer, buffers);
    checkInteger("byteLength", byteLength, 1, MOST);
    checkInteger("byteOffset", byteOffset, 0, MOST);
    checkInteger("byteStride", byteStride, 1, MOST);
  });
  each("accessors", accessors, ({ type, componentType, count, byteOffset = 0, bufferView }) => {
    if (!TYPES.includes(type) || !COMPONENTS.includes(componentType)) {
      const got = `${brief(type)} and ${brief(componentType)}`;
      throw new CoreError(`expected a type such as VEC3 and a componentType such as 5126, got ${got}`);
    }
    checkInteger("count", count, 0, Number.MAX_SAFE_INTEGER);
    checkInteger("byteOffset", byteOffset, 0, MOST);
    if (bufferView !== undefined) item("bufferView", bufferView, bufferViews);
  });
  each("meshes", meshes, ({ primitives }) => checkObjects("primitives", primitives).forEach((primitive) => {
    const { attributes, indices, mode = TRIANGLES } = primitive;
    if (!isObject(attributes) || !("POSITION" in attributes)) throw new CoreError("attributes: expected a POSITION, got none");
    for (const [name, value] of Object.entries(attributes)) item(name, value, accessors);
    for (const name of ["POSITION", "NORMAL"]) {
      if (name in attributes && accessors[attributes[name]].type !== "VEC3") {
        throw new CoreError(`${name}: expected vectors of type VEC3, got another`);
      }
    }
    checkInteger("mode", mode, 0, FAN);
    if (indices !== undefined) item("indices", indices, accessors);
  }));
  const primitives = (/** @type {any[]} */ of) => of.reduce((sum, mesh) => sum + mesh.primitives.length, 0);
  checkCount("primitives", primitives(meshes));
  each("nodes", nodes, (node) => {
    const { children = [], mesh } = node;
    for (const child of checkList("children", children)) item("children", child, nodes);
    if (mesh !== undefined) item("mesh", mesh, meshes);
    for (const [name, length] of Object.entries(PLACES)) if (name in node) checkNumbers(name, node[name], length);
  });
  checkCount("primitives", primitives(nodes.flatMap((/** @type {any} */ { mesh }) => (mesh === undefined ? [] : [meshes[mesh]]))));
  if (!scenes) return;
  const { nodes: roots = [] } = item("scene", scene, scenes);
  for (const root of checkList("nodes", roots)) item("nodes", root, nodes);
}

/**
 * Shows all nodes where there is no scene, and leaves out what makes no triangles: points and lines, and cameras, which
 * may be damaged.
 *
 * @param {any} json
 */
export function prepareScenes(json) {
  for (const mesh of json.meshes ?? []) {
    mesh.primitives = mesh.primitives.filter((/** @type {any} */ { mode = TRIANGLES }) => mode >= TRIANGLES);
  }
  const { nodes = [] } = json, children = new Set(nodes.flatMap((/** @type {any} */ node) => node.children ?? []));
  json.scenes ??= [{ nodes: [...nodes.keys()].filter((node) => !children.has(node)) }];
  for (const node of nodes) delete node.camera;
}

/**
 * Refuses nodes that do not form a tree, as the specification requires: they could be reached in 2ⁿ ways.
 *
 * @param {any} json
 */
export function checkTree({ nodes = [], scenes = [] }) {
  const children = nodes.flatMap((/** @type {any} */ { children = [] }) => children);
  const seen = new Set(children), roots = scenes.flatMap((/** @type {any} */ { nodes = [] }) => nodes);
  if (seen.size < children.length || roots.some((/** @type {number} */ root) => seen.has(root))) {
    throw new CoreError("expected nodes that form a tree, got one with two parents or inside itself");
  }
}

/**
 * Refuses what is not in the file itself: a page has no files beside it, and should not fetch them from strangers.
 *
 * @param {any} json
 * @param {number} size bytes of the file's own buffer
 */
export function checkBuffers({ buffers = [], bufferViews = [] }, size) {
  for (const { uri } of buffers) {
    if (uri !== undefined) throw new CoreError(`expected its data within the file, got it at ${brief(uri)}`);
  }
  if (bufferViews.some((/** @type {any} */ { byteOffset = 0, byteLength }) => byteOffset + byteLength > size)) {
    throw new CoreError("expected buffers that hold what the bufferViews say, got one that is shorter");
  }
}

/** @param {string} name @param {any[]} items @param {(item: any) => void} check whose errors say which item */
function each(name, items, check) {
  items.forEach((item, i) => placedErrors(`${name}[${i}]`, () => check(item)));
}

/** @param {any} value */
const isObject = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/** @param {string} name @param {any} value @returns {any[]} */
function checkObjects(name, value) {
  if (!(Array.isArray(value) && value.every(isObject))) throw new CoreError(`${name}: expected a list of objects, got another`);
  return value;
}

/** @param {string} name @param {any} value @param {number} length */
function checkNumbers(name, value, length) {
  const other = checkList(name, value).find((item) => typeof item !== "number");
  if (other !== undefined) throw new CoreError(`${name}: expected lists of numbers, got ${brief(other)}`);
  if (value.length !== length) throw new CoreError(`${name}: expected shape (${length},), got (${value.length},)`);
}
