// @ts-check
/**
 * What is measured of pictures, and how the page says it.
 *
 * @typedef {object} Statistics
 * @property {number} pictures so far
 * @property {number} fraction of the pixels that are traced
 * @property {number} completing milliseconds of the network, on `backend`
 * @property {import("../workers/schedule.js").Model} model the network's name
 * @property {"wasm" | "gpu"} backend
 * @property {number} framesPerSecond
 * @property {number} raysPerSecond
 * @property {boolean} exact whether the picture is the exact one of what is wanted
 * @property {number} error of the first completed picture, on average, once the picture is exact; else NaN
 * @property {number} expected error of the picture, on average, where that is shown; else NaN
 * @property {number} workers that trace
 */
import { ERROR_GAIN } from "../picture/paint.js";

/** @typedef {import("./state.js").State} State */

const EVERY_MS = 250; // a few times a second, which can be read

/** Takes in a picture that is shown now. @param {State} state @param {import("../workers/completing.js").Picture} picture */
export function countPicture(state, picture) {
  const { statistics, schedule } = state, { batch, traced, completing, model, backend, error } = picture;
  const exact = schedule.completed(picture), now = performance.now();
  state.times = [...lastSecond(state.times, now), now];
  Object.assign(statistics, {
    pictures: statistics.pictures + 1, fraction: traced / (batch.height * batch.width), completing, model,
    backend, raysPerSecond: schedule.raysPerSecond, exact, error,
  });
}

/** @param {number[]} times @param {number} now */
const lastSecond = (times, now) => times.filter((time) => time > now - 1000);

/**
 * Keeps what the page says of its pictures up to date.
 *
 * @param {State} state
 * @param {Record<"fraction" | "rays" | "network" | "rate" | "note", HTMLElement>} elements
 */
export function display(state, { note, ...elements }) {
  setInterval(() => {
    state.times = lastSecond(state.times, performance.now());
    state.statistics.framesPerSecond = state.times.length;
    if (state.statistics.pictures > 0) {
      const texts = textsOf(state.statistics);
      for (const name of /** @type {(keyof typeof texts)[]} */ (Object.keys(texts))) {
        if (elements[name].textContent !== texts[name]) elements[name].textContent = texts[name];
      }
    }
    note.textContent = noteOf(state);
  }, EVERY_MS);
}

/** @param {Statistics} statistics */
function textsOf({ fraction, raysPerSecond, completing, backend, exact, framesPerSecond }) {
  const percent = 100 * fraction;
  return {
    fraction: exact ? "100 %, exact" : `${percent.toFixed(percent < 10 ? 1 : 0)} %`,
    rays: raysPerSecond >= 1e6 ? `${(raysPerSecond / 1e6).toFixed(2)} M` : `${Math.round(raysPerSecond / 1000)} k`,
    network: `${completing.toFixed(0)} ms${backend === "gpu" ? ", GPU" : ""}`,
    rate: framesPerSecond > 1 ? String(framesPerSecond) : "at rest",
  };
}

/** @param {State} state */
function noteOf({ showing: { mode }, statistics: { exact, error, expected } }) {
  /** @param {number} mean */
  const onAverage = (mean) => `${ERROR_GAIN} times as bright; on average ${(255 * mean).toFixed(1)} of 255.`;
  if (mode === "uncertain" && exact) return "Nothing is uncertain: the picture is exact.";
  if (mode === "uncertain") return `How wrong the picture is expected to be, ${onAverage(expected)}`;
  if (mode !== "difference") return "";
  if (!exact) return "The difference is shown once the picture is exact.";
  return `First completed picture against the exact one, ${onAverage(error)}`;
}
