// @ts-check
/** The files of a drop, and of the folders in it. */

/** @param {DataTransfer} data @returns {Promise<File[]>} */
export async function droppedFiles(data) {
  // Asked at once: later the drop is empty.
  const found = Array.from(data.items, (item) => {
    const entry = item.webkitGetAsEntry(), file = item.getAsFile();
    return entry?.isDirectory ? filesIn(/** @type {FileSystemDirectoryEntry} */ (entry)) : file ? [file] : [];
  });
  return (await Promise.all(found)).flat();
}

/** @param {FileSystemDirectoryEntry} folder @returns {Promise<File[]>} also of the folders below */
async function filesIn(folder) {
  const reader = folder.createReader(), files = [];
  for (;;) {
    /** @type {FileSystemEntry[]} */
    const entries = await new Promise((resolve, reject) => reader.readEntries(resolve, reject)); // a hundred at most
    if (entries.length === 0) return files;
    for (const entry of entries) files.push(...await filesOf(entry));
  }
}

/** @param {FileSystemEntry} entry @returns {Promise<File[]>} */
function filesOf(entry) {
  if (entry.isDirectory) return filesIn(/** @type {FileSystemDirectoryEntry} */ (entry));
  return new Promise((resolve, reject) => /** @type {FileSystemFileEntry} */ (entry).file((file) => resolve([file]), reject));
}
