// @ts-check
/**
 * Kernels in WGSL that read and write images by channel, row and column.
 *
 * @typedef {object} Kernel
 * @property {string} source the whole shader, the key of its pipeline
 * @property {string[]} images their names, in the order of their bindings, after the settings
 * @property {string[]} numbers names of numbers in the settings
 * @property {string} over the image whose pixels the invocations share
 * @property {number} tile rows and columns of it for each workgroup
 * @property {number} depth workgroups per tile
 */

/**
 * Declares the settings, and functions for each image NAME: NAME_at(channel, y, x), 0 outside the image; NAME_near(y,
 * x), the first channel with its edges repeated; for written images, NAME_put(channel, y, x, value), without effect
 * outside.
 *
 * @param {string[]} read
 * @param {string[]} written
 * @param {string[]} numbers float32
 */
export function declarations(read, written, numbers) {
  const images = [...read, ...written];
  const functions = images.map((name, i) => `
@group(0) @binding(${i + 1}) var<storage, ${i < read.length ? "read" : "read_write"}> ${name}: array<f32>;
fn ${name}_has(channel: i32, y: i32, x: i32) -> bool {
  let image = settings.${name};
  return channel < image.channels && y >= 0 && y < image.height && x >= 0 && x < image.width;
}
fn ${name}_index(channel: i32, y: i32, x: i32) -> i32 {
  let image = settings.${name};
  return ((image.first + channel) * image.height + y) * image.width + x;
}
fn ${name}_at(channel: i32, y: i32, x: i32) -> f32 {
  let has = ${name}_has(channel, y, x);
  return select(0., ${name}[select(0, ${name}_index(channel, y, x), has)], has);
}
fn ${name}_near(y: i32, x: i32) -> f32 {
  let image = settings.${name};
  return ${name}[${name}_index(0, clamp(y, 0, image.height - 1), clamp(x, 0, image.width - 1))];
}`);
  const puts = written.map((name) => `
fn ${name}_put(channel: i32, y: i32, x: i32, value: f32) {
  if (${name}_has(channel, y, x)) { ${name}[${name}_index(channel, y, x)] = value; }
}`);
  return `
struct Image { first: i32, channels: i32, height: i32, width: i32 }
struct Settings {
  ${[...images.map((name) => `${name}: Image`), ...numbers.map((name) => `${name}: f32`)].join(",\n  ")}
}
@group(0) @binding(0) var<uniform> settings: Settings;
${functions.join("")}${puts.join("")}
`;
}

/**
 * A kernel with one invocation per pixel (y, x) of the first image that it writes, and per channel.
 *
 * @param {{
 *   read: string[], write: string[], numbers?: string[], channels?: number, functions?: string, body: string
 * }} parts functions and body in WGSL
 * @returns {Kernel}
 */
export function kernel({ read, write, numbers = [], channels = 1, functions = "", body }) {
  const tile = 8, over = write[0];
  const source = `${declarations(read, write, numbers)}${functions}
@compute @workgroup_size(${tile}, ${tile})
fn main(@builtin(global_invocation_id) id: vec3u) {
  let y = i32(id.y);
  let x = i32(id.x);
  let channel = i32(id.z);
  if (y >= settings.${over}.height || x >= settings.${over}.width) { return; }
${body}
}
`;
  return { source, images: [...read, ...write], numbers, over, tile, depth: channels };
}
