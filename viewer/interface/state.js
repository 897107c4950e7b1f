// @ts-check
/**
 * The page's state, beside that of its picture (component/viewing.js): what the page opens with, and then what its modules write there.
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
 * @property {import("../picture/paint.js").Mode} mode what is shown of pictures
 */

/** @returns {State} */
export const createState = () => ({ scene: { title: "" }, gallery: [], edits: { newest: null, busy: false }, mode: "completed" });
