// @ts-check
/** Display of the pictures' statistics. */
import { ERROR_GAIN } from "../picture/paint.js";

/** @typedef {import("../component/statistics.js").Statistics} Statistics */

const EVERY_MS = 250; // a few times a second, slow enough to read

/**
 * Keeps the displayed statistics up to date.
 *
 * @param {Statistics} statistics
 * @param {import("./state.js").State} state
 * @param {Record<"fraction" | "rays" | "network" | "rate" | "note", HTMLElement>} elements
 */
export function display(statistics, state, { note, ...elements }) {
  setInterval(() => {
    if (statistics.pictures > 0) {
      const texts = textsOf(statistics);
      for (const name of /** @type {(keyof typeof texts)[]} */ (Object.keys(texts))) {
        if (elements[name].textContent !== texts[name]) elements[name].textContent = texts[name];
      }
    }
    note.textContent = noteOf(state.mode, statistics);
  }, EVERY_MS);
}

/** @param {Statistics} statistics */
function textsOf({ fraction, raysPerSecond, completing, backend, exact, isSmoothed, enlarged, framesPerSecond }) {
  const percent = 100 * fraction, share = `${percent.toFixed(percent < 10 ? 1 : 0)} %`;
  return {
    fraction: exact ? `100 %, ${isSmoothed ? "smoothed" : "exact"}` : enlarged ? `${share} of ${enlarged}, enlarged` : share,
    rays: raysPerSecond >= 1e6 ? `${(raysPerSecond / 1e6).toFixed(2)} M` : `${Math.round(raysPerSecond / 1000)} k`,
    network: completing > 0 ? `${completing.toFixed(0)} ms${backend === "gpu" ? ", GPU" : ""}` : "–",
    rate: framesPerSecond > 1 ? String(framesPerSecond) : "at rest",
  };
}

/** @param {import("./state.js").State["mode"]} mode @param {Statistics} statistics */
function noteOf(mode, { exact, error, expected }) {
  /** @param {number} mean */
  const onAverage = (mean) => `${ERROR_GAIN} times as bright; on average ${(255 * mean).toFixed(1)} of 255.`;
  if (mode === "uncertain" && exact) return "Nothing is uncertain: the picture is exact.";
  if (mode === "uncertain") return `How wrong the picture is expected to be, ${onAverage(expected)}`;
  if (mode !== "difference") return "";
  if (!exact) return "The difference is shown once the picture is exact.";
  if (Number.isNaN(error)) return "The picture is too large for its difference.";
  return `First completed picture against the exact one, ${onAverage(error)}`;
}
