// @ts-check
/**
 * The default network: a pyramid of means over the traced pixels, completed from coarse to fine.
 *
 * The same, step for step, as learn/networks/pyramid.py and core/completion/pyramid.cpp.
 */
import { placeOf } from "../../picture/channels.js";
import { Then } from "./conv3x3.js";
import { kernel } from "./kernel.js";

const SOFTNESS = 0.05;

/** The input channels. */
const INPUTS = ["mask", "gray", "depth", "normal"];
const MASK = placeOf(INPUTS, "mask"), GRAY = placeOf(INPUTS, "gray");

// Channels of a level's inputs: gray and the features of traced pixels. Channels from the coarser level follow.
const KNOWN = 8;
// Channels of level 1's inputs: gray, normal x, normal y, and the phases of the mask and of the surprise. Phases are the 2x2 pixels of
// each block.
const KNOWN_FINEST = 11, FIRST_MASK = 3, FIRST_SURPRISE = 7;

// A level's sums over the traced pixels of a block: number, gray, depth, normal x and normal y, and offsets from the
// block's centre, right and down.
const SUMS = ["count", "gray", "depth", "normal_x", "normal_y", "right", "down"];
const PLACES = SUMS.map((name, i) => `const ${name} = ${i};\n`).join("");

/** Sums of a level from the finer one, or from the G-buffer, which lacks right and down: they are 0. */
const pull = kernel({
  read: ["finer"], write: ["sums"], numbers: ["quarter"], channels: SUMS.length,
  functions: `${PLACES}
fn block(channel: i32, y: i32, x: i32) -> vec4f {
  return vec4f(finer_at(channel, 2 * y, 2 * x), finer_at(channel, 2 * y, 2 * x + 1),
               finer_at(channel, 2 * y + 1, 2 * x), finer_at(channel, 2 * y + 1, 2 * x + 1));
}
fn total(p: vec4f) -> f32 { return (p.x + p.y) + (p.z + p.w); }
`,
  body: `
  let counts = block(count, y, x);
  var shift = 0.;
  if (channel == right) { shift = (counts.y + counts.w) - (counts.x + counts.z); }
  if (channel == down) { shift = (counts.z + counts.w) - (counts.x + counts.y); }
  sums_put(channel, y, x, total(block(channel, y, x)) + settings.quarter * shift);`,
});

/** Pixel (y, x) of the doubled picture `coarse`, with weights 3/4 for a pixel and 1/4 for the nearer neighbour. */
const DOUBLED = `
fn doubled(y: i32, x: i32) -> f32 {
  let here = vec2i(y, x) / 2;
  let beside = here + 2 * (vec2i(y, x) % 2) - 1;
  let near = 0.75 * coarse_near(here.x, here.y) + 0.25 * coarse_near(beside.x, here.y);
  let far = 0.75 * coarse_near(here.x, beside.y) + 0.25 * coarse_near(beside.x, beside.y);
  return 0.75 * near + 0.25 * far;
}
`;

/**
 * Inputs of a level's blocks: the gray so far (the coarser picture, doubled, plus the correction channel after the
 * known ones), the surface mask, and the features from `written`.
 */
const know = (/** @type {number} */ known, /** @type {string} */ written) => kernel({
  read: ["sums", "coarse", "coarse_surface"], write: ["inputs", "corrected", "surface"], numbers: ["side"],
  functions: `${PLACES}${DOUBLED}
/// 0 where in each of 3x3 blocks pixels were traced, and all are background; else 1.
fn spread(y: i32, x: i32) -> f32 {
  var result = 0.;
  for (var i = 0; i < 9; i++) {
    let row = y + i / 3 - 1;
    let column = x + i % 3 - 1;
    if (sums_has(count, row, column) && (sums_at(count, row, column) <= 0. || sums_at(gray, row, column) != 0.)) {
      result = 1.;
    }
  }
  return result;
}
`,
  body: `
  let guess = doubled(y, x) + inputs_at(${known}, y, x);
  let traced = sums_at(count, y, x);
  let per_pixel = 1. / max(traced, 1.);
  var surprise = 0.;
  if (traced > 0.) { surprise = sums_at(gray, y, x) * per_pixel - guess; }
  inputs_put(0, y, x, guess);${written}
  corrected_put(0, y, x, guess + surprise);
  surface_put(0, y, x, coarse_surface_near(y / 2, x / 2) * spread(y, x));`,
});

const knowLevel = know(KNOWN, `
  inputs_put(1, y, x, surprise);
  inputs_put(2, y, x, sums_at(depth, y, x) * per_pixel);
  inputs_put(3, y, x, sums_at(normal_x, y, x) * per_pixel);
  inputs_put(4, y, x, sums_at(normal_y, y, x) * per_pixel);
  inputs_put(5, y, x, traced / (traced + 1.));
  inputs_put(6, y, x, sums_at(right, y, x) * per_pixel / settings.side);
  inputs_put(7, y, x, sums_at(down, y, x) * per_pixel / settings.side);`);
const knowFinest = know(KNOWN_FINEST, `
  inputs_put(1, y, x, sums_at(normal_x, y, x) * per_pixel);
  inputs_put(2, y, x, sums_at(normal_y, y, x) * per_pixel);`);

/** The phases of the mask, and of the traced gray minus the doubled picture. */
const compare = kernel({
  read: ["coarse", "pixels"], write: ["inputs"], functions: DOUBLED,
  body: `
  for (var i = 0; i < 4; i++) {
    let row = 2 * y + i / 2;
    let column = 2 * x + i % 2;
    let mask = pixels_at(${MASK}, row, column);
    inputs_put(${FIRST_MASK} + i, y, x, mask);
    inputs_put(${FIRST_SURPRISE} + i, y, x, mask * (pixels_at(${GRAY}, row, column) - doubled(row, column)));
  }`,
});

/** The network's output: the doubled picture plus the interpolated surprise nearby and the correction. */
const finish = kernel({
  read: ["coarse", "inputs", "correction", "surface"], write: ["result"],
  functions: `${DOUBLED}
/// A pixel of the plane whose phases are the inputs from \`first\` on.
fn phase(first: i32, y: i32, x: i32) -> f32 { return inputs_at(first + (y & 1) * 2 + (x & 1), y >> 1, x >> 1); }
/// The sum of 3x3 pixels with the Gaussian's weights 1, 2, 1 in each direction, not divided by 16.
fn gaussian_sum(first: i32, y: i32, x: i32) -> f32 {
  var result = 0.;
  for (var i = 0; i < 9; i++) {
    let weight = f32((2 - abs(i / 3 - 1)) * (2 - abs(i % 3 - 1)));
    result += weight * phase(first, y + i / 3 - 1, x + i % 3 - 1);
  }
  return result;
}
`,
  body: `
  let mean = gaussian_sum(${FIRST_SURPRISE}, y, x) / (gaussian_sum(${FIRST_MASK}, y, x) + ${16 * SOFTNESS});
  result_put(0, y, x, (doubled(y, x) + mean + correction_at(0, y, x)) * surface_near(y / 2, x / 2));`,
});

/** @type {import("../gpu.js").NetworkOfLayers} */
export function pyramid(layer, weights) {
  if (weights.inputs.join() !== INPUTS.join()) {
    throw new Error(`pyramid: expected weights for ${INPUTS.join(", ")}, got some for ${weights.inputs.join(", ")}`);
  }
  const known = (/** @type {number} */ level) => (level === 1 ? KNOWN_FINEST : KNOWN);
  let count = 1;
  while (weights.tensors.has(`features${count + 1}.weight`)) ++count;
  /** Layers by level. @type {{features: import("./conv3x3.js").Conv3x3, finer: import("./conv3x3.js").Conv3x3}[]} */
  const layers = [];
  for (let level = count, handed = 0; level >= 1; --level) {
    const features = layer(`features${level}`, known(level) + handed);
    const finer = layer(`finer${level}`, features.out, level === 1 ? 4 : undefined);
    layers[level] = { features, finer };
    handed = finer.out / 4;
  }

  return (plan, gbuffer) => {
    /** Sums by level, like all arrays below; level 0 is the pixels. */
    const sums = [gbuffer];
    for (let level = 1; level <= count; ++level) {
      const { height, width } = sums[level - 1];
      sums.push(plan.image(SUMS.length, Math.ceil(height / 2), Math.ceil(width / 2)));
      plan.step(pull, { finer: sums[level - 1], sums: sums[level] }, { numbers: { quarter: 2 ** (level - 2) } });
    }

    const inputs = layers.map(({ features }, level) => plan.image(features.in, sums[level].height, sums[level].width));
    const correction = plan.image(1, gbuffer.height, gbuffer.width); // to the pixels, of level 1
    let coarse = plan.image(1, 1, 1), surface = plan.image(1, 1, 1, 1); // of a level coarser than all
    for (let level = count; level >= 1; --level) {
      const { height, width } = sums[level], layer = layers[level];
      const features = plan.image(layer.features.out, height, width);
      const corrected = plan.image(1, height, width); // gray + surprise
      const present = plan.image(1, height, width); // 0 where there is certainly no surface
      plan.step(level > 1 ? knowLevel : knowFinest, {
        sums: sums[level], coarse, coarse_surface: surface, inputs: inputs[level], corrected, surface: present,
      }, { numbers: { side: 2 ** level } });
      if (level === 1) plan.step(compare, { coarse: corrected, pixels: gbuffer, inputs: inputs[1] });
      layer.features.record(plan, inputs[level], features, Then.relu);
      const handed = level > 1 ? inputs[level - 1].from(known(level - 1)) : correction;
      layer.finer.record(plan, features, handed, Then.shuffle);
      [coarse, surface] = [corrected, present];
    }

    const result = plan.image(1, gbuffer.height, gbuffer.width);
    plan.step(finish, { coarse, inputs: inputs[1], correction, surface, result });
    return result;
  };
}
