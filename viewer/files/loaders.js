// @ts-check
/** GLB and glTF, parsed by loaders of three.js, which are only fetched for such files. */

import { CoreError } from "../core/errors.js";
import { UPRIGHT, product } from "../shapes/affine.js";
import { checkBuffers, checkGltf, checkTree, glbOf, packed, prepareScenes } from "./gltf.js";
import { GltfSurfaces } from "./gltf_surfaces.js";

/** @typedef {import("./part.js").Part} Part */

/** Copies of one mesh can be many; this many vertices and triangles still fit into the memory of a page. */
const MAX_ITEMS = 50_000_000;

/** The loaders of three.js. @returns {Promise<any>} */
const three = () => import("../vendor/three/loaders.js");

/**
 * @param {ArrayBuffer} bytes
 * @param {import("./part.js").Warn} warn
 * @returns {Promise<Part[]>} the primitives that its scene shows, each where its nodes place it
 */
export async function readGlb(bytes, warn) {
  const { json, glb, size } = glbOf(bytes);
  checkGltf(json);
  prepareScenes(json);
  checkTree(json);
  checkBuffers(json, size);
  const surfaces = new GltfSurfaces(json, new Uint8Array(glb, glb.byteLength - size), warn);
  surfaces.begin((json.meshes ?? []).flatMap((/** @type {any} */ { primitives }) => primitives.map((/** @type {any} */ own) => own.material)));
  const { GLTFLoader, Material } = await three(), loader = new GLTFLoader();
  loader.register((/** @type {any} */ parser) => {
    prepareScenes(parser.json);
    return { name: "shapes alone", loadMaterial: async (/** @type {number} */ index) => {  // so that no picture is fetched
      const material = new Material();
      material.userData = { index };
      return material;
    } };
  });
  const { scene } = await loader.parseAsync(glb, "");
  scene.updateMatrixWorld(true);
  const meshes = meshesOf(scene);
  await surfaces.prepare(meshes.map(({ material }) => material.userData.index));
  let total = 0;
  return meshes.filter(({ material }) => (surfaces.of(material.userData.index).alphaCutoff ?? 0) <= 1).flatMap((mesh) => {
    const { geometry, matrixWorld, count = 1 } = mesh, look = lookOf(geometry, surfaces, mesh.material.userData.index);
    total += count * (geometry.attributes.position.count + (geometry.index?.count ?? 0) / 3);
    if (total > MAX_ITEMS) {
      throw new CoreError(`expected at most ${MAX_ITEMS} triangles and vertices in all its parts, got more`);
    }
    return Array.from({ length: count }, (_, i) => {
      const place = product(UPRIGHT, rows(matrixWorld.elements)); // glTF is y-up
      return { ...partOf(geometry, mesh.isInstancedMesh ? product(place, rows(mesh.instanceMatrix.array, 16 * i)) : place), ...look };
    });
  });
}

/**
 * What a geometry of three.js looks like.
 *
 * @param {any} geometry
 * @param {GltfSurfaces} surfaces
 * @param {number | undefined} material its number
 */
function lookOf({ attributes }, surfaces, material) {
  const set = surfaces.uvSet(material), uv = material === undefined ? undefined : attributes[set ? `uv${set}` : "uv"];
  const alphas = surfaces.isMasked(material) ? components(attributes.color, 1, 3) : undefined;
  return {
    colors: components(attributes.color, 3), alphas, uv: surfaces.onTexture(material, components(uv, 2)), surface: surfaces.of(material),
  };
}

/**
 * Components of an attribute, (n, width), those of integers in 0..1.
 *
 * @param {any} attribute
 * @param {number} width
 * @param {number} [first]
 */
function components(attribute, width, first = 0) {
  if (!(attribute?.itemSize >= first + width)) return undefined;
  const result = new Float64Array(width * attribute.count);
  for (let i = 0; i < result.length; ++i) result[i] = attribute.getComponent(Math.floor(i / width), first + i % width);
  return result;
}

/**
 * @param {ArrayBuffer} bytes
 * @param {import("./part.js").Warn} warn
 * @param {import("./beside.js").Beside} beside
 */
export async function readGltf(bytes, warn, beside) {
  return readGlb(await packed(bytes, beside), warn);
}

/** @param {any} object @returns {any[]} the meshes in it */
function meshesOf(object) {
  /** @type {any[]} */
  const meshes = [];
  object.traverse((/** @type {any} */ child) => child.isMesh && meshes.push(child));
  return meshes;
}

/** A matrix of three.js, which has columns first. @param {ArrayLike<number>} m @param {number} [start] */
const rows = (m, start = 0) => Array.from({ length: 16 }, (_, i) => m[start + 4 * (i % 4) + Math.floor(i / 4)]);

/**
 * A geometry of three.js, placed by a matrix.
 *
 * @param {any} geometry
 * @param {readonly number[]} matrix
 * @returns {Part}
 */
function partOf(geometry, matrix) {
  const { position, normal } = geometry.attributes, [a, b, c, , d, e, f, , g, h, i] = matrix;
  // The cofactors are det · inverse transpose, and exist where a part is pressed flat.
  const cofactors = [
    e * i - f * h, f * g - d * i, d * h - e * g,
    c * h - b * i, a * i - c * g, b * g - a * h,
    b * f - c * e, c * d - a * f, a * e - b * d,
  ];
  const determinant = a * cofactors[0] + b * cofactors[1] + c * cofactors[2], mirrored = determinant < 0;
  const [p, q, r, s, t, u, v, w, x] = mirrored ? cofactors.map((value) => -value) : cofactors;
  const count = geometry.index?.count ?? position.count, triangles = new Int32Array(count - count % 3);
  for (let n = 0; n < triangles.length; ++n) triangles[n] = geometry.index ? geometry.index.getX(n) : n;
  if (mirrored) triangles.reverse();  // the outside stays anticlockwise
  return {
    vertices: moved(position, [a, b, c, matrix[3], d, e, f, matrix[7], g, h, i, matrix[11]]),
    triangles,
    normals: normal?.count === position.count ? moved(normal, [p, q, r, 0, s, t, u, 0, v, w, x, 0]) : undefined,
  };
}

/**
 * An attribute of three.js, (n, 3), moved by the upper rows of a matrix.
 *
 * @param {any} attribute
 * @param {number[]} matrix
 * @returns {Float64Array}
 */
function moved(attribute, [a, b, c, d, e, f, g, h, i, j, k, l]) {
  const result = new Float64Array(3 * attribute.count);
  for (let n = 0, at = 0; at < result.length; ++n, at += 3) {
    const x = attribute.getX(n), y = attribute.getY(n), z = attribute.getZ(n);
    result[at] = a * x + b * y + c * z + d;
    result[at + 1] = e * x + f * y + g * z + h;
    result[at + 2] = i * x + j * y + k * z + l;
  }
  return result;
}
