// @ts-check
/**
 * The page's state, in addition to the picture's (component/viewing.js): the initial state, later changed by the page's
 * modules.
 *
 * @typedef {{name: string, source: Blob | string, beside: File[], yUp: boolean | null}} Source a file, or its address, and
 *   files opened with it; yUp: whether y is up in it; null if unknown
 * @typedef {{title: string, gallery?: string, script?: string, edited?: string, address?: string, source?: Source}} OpenScene
 *   gallery: its file there; script: its text; edited: the title under which an edited script is kept (kept.js); address: of the file, from the page's address; without any of these
 *   there is no link; source: of a scene outside the gallery
 *
 * @typedef {object} State
 * @property {OpenScene} scene the displayed scene
 * @property {{file: string, title: string, kind: string}[]} gallery the built-in scenes
 * @property {{newest: string | null, busy: boolean, title: string | null}} edits newest: the editor's text not displayed
 *   yet; busy: whether a text is being opened; title: under which changes of the displayed script are kept, once there are any
 * @property {import("../picture/paint.js").Mode} mode the display mode
 */

/** @returns {State} */
export const createState = () => ({ scene: { title: "" }, gallery: [], edits: { newest: null, busy: false, title: null }, mode: "completed" });
