// @ts-check
/**
 * The page's state, all of it: what the page opens with, and then what its modules write there.
 *
 * @typedef {import("../workers/pool.js").Pool} Pool
 *
 * @typedef {{name: string, source: Blob | string, beside: File[], yUp: boolean}} Source a file, or its address, and what was opened with it
 * @typedef {{title: string, gallery?: string, script?: string, address?: string, source?: Source}} OpenScene
 *   gallery: which file of it; script: its text; address: of the file in the page's own; one without any has no link;
 *   source: of what is not in the gallery
 *
 * @typedef {object} State
 * @property {OpenScene} scene that is shown
 * @property {{file: string, title: string, kind: string}[]} gallery the built-in scenes
 * @property {{newest: string | null, busy: boolean}} edits newest: the text of the editor that is not yet shown; busy: whether
 *   one is being opened
 * @property {{shown?: Pool, coming?: Pool, spare?: Pool}} pools the workers that have the scene, those that will have the next,
 *   and those for the one after that, started ahead: that takes longer than opening most scenes
 * @property {Schedule} schedule which has camera, size and time for a picture
 * @property {{mode: import("../picture/paint.js").Mode, divider: number}} showing divider: 0..1 of the picture's width
 * @property {import("./statistics.js").Statistics} statistics of the last picture
 * @property {number[]} times when pictures of the last second were shown, in milliseconds
 * @property {((buffers: import("../workers/completing.js").Buffers | null) => void)[]} waiting called with what the completing
 *   worker answers
 */
import { HOME } from "../picture/camera.js";
import { Schedule } from "../workers/schedule.js";

/** @param {{workers: number, scales: boolean}} settings scales: whether moving pictures may be smaller @returns {State} */
export function createState({ workers, scales }) {
  return {
    scene: { title: "" },
    gallery: [],
    edits: { newest: null, busy: false },
    pools: {},
    schedule: new Schedule(HOME, scales),
    showing: { mode: "completed", divider: 0.5 },
    statistics: {
      pictures: 0, fraction: 0, completing: 0, backend: "wasm", model: "default", framesPerSecond: 0, raysPerSecond: 0, exact: false, error: NaN, expected: NaN,
      workers,
    },
    times: [],
    waiting: [],
  };
}
