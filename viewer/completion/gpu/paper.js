// @ts-check
/**
 * The report's network: a U-Net of six 3x3 convolutions.
 *
 * The same, step for step, as learn/networks/paper.py and core/completion/paper.cpp.
 */
import { widthOf } from "../../picture/channels.js";
import { Then } from "./conv3x3.js";
import { kernel } from "./kernel.js";

/** Pads the inputs to the size of the images. @param {number} channels */
const pad = (channels) => kernel({
  read: ["pixels"], write: ["padded"], channels,
  body: "  padded_put(channel, y, x, pixels_at(channel, y, x));",
});

/** @type {import("../gpu.js").NetworkOfLayers} */
export function paper(layer, weights) {
  const inputs = widthOf(weights.inputs);
  const encode1 = layer("encode1", inputs, 20);
  const encode2 = layer("encode2", 20, 80);
  const encoded = layer("encoded", 80, 20);
  const decode1 = layer("decode1", 20, 5);
  const decode2 = layer("decode2", 20 + 5, 5);
  const output = layer("output", 5 + inputs, 1);

  // As in ShuffleNet: every group of the next layer sees channels of all groups.
  const groups = encode2.groups, size = 80 / groups;
  const shuffled = `convolved % ${size} * ${groups} + convolved / ${size}`;

  return (plan, gbuffer) => {
    const [height, width] = [gbuffer.height, gbuffer.width].map((length) => Math.ceil(length / 4) * 4);
    const full = plan.image(5 + inputs, height, width); // decode2, upsampled (5) | input
    const half = plan.image(5 + 20, height / 2, width / 2); // decode1, upsampled (5) | encode1, pooled (20)
    const quarter = plan.image(80, height / 4, width / 4); // encode2, pooled and shuffled (80)
    const code = plan.image(20, height / 4, width / 4); // encoded (20)
    const result = plan.image(1, gbuffer.height, gbuffer.width); // output (1)

    plan.step(pad(inputs), { pixels: gbuffer, padded: full.from(5) });
    encode1.record(plan, full.from(5), half.from(5), Then.reluPool);
    encode2.record(plan, half.from(5), quarter, Then.reluPool, shuffled);
    encoded.record(plan, quarter, code, Then.relu);
    decode1.record(plan, code, half, Then.reluUpsample);
    decode2.record(plan, half, full, Then.reluUpsample);
    output.record(plan, full, result, Then.nothing);
    return result;
  };
}
