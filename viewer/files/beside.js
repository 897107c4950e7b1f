// @ts-check
/**
 * Files that were opened together with a model: its textures, buffers and libraries of materials.
 *
 * A page knows their names alone, not their folders, so the last part of a model's path suffices, in upper or lower case.
 */

import { CoreError } from "../core/errors.js";

export class Beside {
  /** @param {readonly {name: string, arrayBuffer: () => Promise<ArrayBuffer>}[]} [files] */
  constructor(files = []) {
    this.files = files;
  }

  /** Whether there is a file of this name. @param {string} name as the model has it */
  has(name) {
    return this.#find(name) !== undefined;
  }

  /** A file's content. @param {string} name as the model has it @returns {Promise<Uint8Array<ArrayBuffer>>} */
  async read(name) {
    const found = this.#find(name);
    if (!found) throw new CoreError(`expected ${lastPart(name)} to be opened together with it, got no such file`);
    return new Uint8Array(await found.arrayBuffer());
  }

  /** @param {string} name */
  #find(name) {
    const last = lastPart(name).toLowerCase();
    return this.files.find((file) => file.name.toLowerCase() === last);
  }
}

/** @param {string} path with separators of any system */
const lastPart = (path) => path.trim().replaceAll("\\", "/").split("/").at(-1) ?? "";
