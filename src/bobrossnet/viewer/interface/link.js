// @ts-check
/** What a link restores: a scene and its camera, in the fragment, which no server sees. */
import { FIELDS, valid } from "../picture/camera.js";

/**
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {{gallery?: string, script?: string, camera?: Camera}} State
 *   gallery: the file of a built-in scene; script: the text of one that is not
 */

/** @param {Uint8Array<ArrayBuffer>} bytes @param {CompressionStream | DecompressionStream} stream */
async function through(bytes, stream) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

/** @param {State & {camera: Camera}} state @returns {Promise<string>} a fragment, from "#" on */
export async function toFragment({ gallery, script, camera }) {
  const values = new URLSearchParams();
  if (gallery) values.set("scene", gallery);
  if (script !== undefined) {
    const packed = await through(new TextEncoder().encode(script), new CompressionStream("deflate-raw"));
    const text = btoa(Array.from(packed, (byte) => String.fromCharCode(byte)).join(""));
    values.set("script", text.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", ""));
  }
  values.set("camera", FIELDS.map((name) => Number(camera[name].toPrecision(6))).join("_"));
  return `#${values}`;
}

/** @param {string} fragment @returns {Promise<State>} what of it can be read */
export async function fromFragment(fragment) {
  const values = new URLSearchParams(fragment.replace(/^#/, ""));
  const numbers = (values.get("camera") ?? "").split("_").map(Number);
  const given = FIELDS.map((name, i) => [name, numbers[i]]);
  const camera = numbers.length === FIELDS.length && numbers.every(Number.isFinite) ? valid(Object.fromEntries(given)) : undefined;
  const packed = values.get("script");
  if (packed === null) return { gallery: values.get("scene") ?? undefined, camera };
  const bytes = Uint8Array.from(atob(packed.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
  return { script: new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw"))), camera };
}
