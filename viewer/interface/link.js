// @ts-check
/** Links to a scene and its camera: the state is in the fragment, which no server sees. */
import { expectation } from "../component/attributes.js";
import { FIELDS, valid } from "../picture/camera.js";

/**
 * @typedef {import("../picture/camera.js").Camera} Camera
 * @typedef {{gallery?: string, script?: string, camera?: Camera, light?: string, wrong?: string}} State
 *   gallery: the file of a built-in scene; script: the text of any other scene; light: if it is not the headlight; wrong: a
 *   sentence about a value that is left out
 */

/** Maximum bytes of a script, as in the core. A link of 1 MB may unpack to a thousand times its size. */
const MOST_BYTES = 1 << 20;

/** @param {Uint8Array<ArrayBuffer>} bytes @param {CompressionStream | DecompressionStream} stream */
const through = (bytes, stream) => new Blob([bytes]).stream().pipeThrough(stream);

/** @param {State & {camera: Camera}} state @returns {Promise<string>} a fragment, starting with "#" */
export async function toFragment({ gallery, script, camera, light }) {
  const values = new URLSearchParams();
  if (gallery) values.set("scene", gallery);
  if (script !== undefined) {
    const stream = through(new TextEncoder().encode(script), new CompressionStream("deflate-raw"));
    const packed = new Uint8Array(await new Response(stream).arrayBuffer());
    const text = btoa(Array.from(packed, (byte) => String.fromCharCode(byte)).join(""));
    values.set("script", text.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", ""));
  }
  values.set("camera", FIELDS.map((name) => Number(camera[name].toPrecision(6))).join("_"));
  if (light) values.set("light", light);
  return `#${values}`;
}

/**
 * @param {string} fragment
 * @returns {Promise<State>} its readable parts
 * @throws {Error} of one sentence, if its script is damaged or too long
 */
export async function fromFragment(fragment) {
  const values = new URLSearchParams(fragment.replace(/^#/, "")), of = values.get("camera");
  const texts = (of ?? "").split("_"), given = FIELDS.map((name, i) => [name, Number(texts[i])]);
  const isRight = texts.length === FIELDS.length && texts.every((text) => text !== "" && Number.isFinite(Number(text)));
  const camera = isRight ? valid(Object.fromEntries(given)) : undefined;
  const packed = values.get("script"), linked = values.get("light"), lit = expectation("light", linked);
  const light = lit ? undefined : linked ?? undefined;
  /** @param {string} name @param {string} expected @param {string | null} got */
  const sentence = (name, expected, got) => `${name}: expected ${expected}, got ${got?.slice(0, 100)}`;
  const wrong = of !== null && !isRight ? sentence("camera", `${FIELDS.length} numbers, ${FIELDS.join("_")}`, of) :
    lit ? sentence("light", lit, linked) : undefined;
  if (packed === null) return { gallery: values.get("scene") ?? undefined, camera, light, wrong };
  return { script: await unpacked(packed), camera, light, wrong };
}

/** @param {string} packed @returns {Promise<string>} the script */
async function unpacked(packed) {
  let script = "", left = MOST_BYTES;
  try {
    const bytes = Uint8Array.from(atob(packed.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
    const reader = through(bytes, new DecompressionStream("deflate-raw")).getReader(), decoder = new TextDecoder("utf-8", { fatal: true });
    for (let piece = await reader.read(); !piece.done && left >= 0; piece = await reader.read()) {
      script += decoder.decode(piece.value, { stream: true });
      left -= piece.value.length;
    }
    if (left < 0) reader.cancel();
    else script += decoder.decode();
  } catch {
    throw new Error("link: expected a script as this page packs it, got a damaged one; was the whole link copied?");
  }
  if (left < 0) throw new Error(`link: expected a script of at most ${MOST_BYTES} bytes, got a larger one`);
  return script;
}
