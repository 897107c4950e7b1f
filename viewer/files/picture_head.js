// @ts-check
/**
 * Heads of pictures' files, of the formats that bobrossnet.adapters.surface reads: sizes, because a small file may hold a picture of any
 * size, which a browser would decode whole, and Exif.
 *
 * @typedef {{height: number, width: number}} Size
 */

/** @param {Uint8Array} bytes of a picture's file @returns {Size | undefined} nothing if it is of no such format, or cut short */
export function sizeOfPicture(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const text = (/** @type {number} */ at) => String.fromCharCode(...bytes.subarray(at, at + 4));
  const short = (/** @type {number} */ at) => view.getUint16(at, true), long = (/** @type {number} */ at) => view.getUint32(at, true);
  try {
    if (text(0) === "\x89PNG") return { width: view.getUint32(16), height: view.getUint32(20) };
    if (text(0) === "GIF8") return { width: short(6), height: short(8) };
    if (text(0).startsWith("BM")) {
      if (long(14) === 12) return { width: short(18), height: short(20) };
      return { width: long(18), height: Math.abs(view.getInt32(22, true)) };  // below 0 if the first row is the upper one
    }
    if (text(0) === "RIFF" && text(8) === "WEBP") return sizeOfWebp(text(12), short, long);
    if (text(0).startsWith("\xff\xd8")) return sizeOfJpeg(view);
    if (text(4) === "ftyp") return sizeOfAvif(view, text);
  } catch (error) {
    if (!(error instanceof RangeError)) throw error;
  }
  return undefined;
}

/**
 * @param {string} chunk the name of the first one
 * @param {(at: number) => number} short
 * @param {(at: number) => number} long
 * @returns {Size | undefined}
 */
function sizeOfWebp(chunk, short, long) {
  const ofBits = (/** @type {number} */ bits) => ({ width: (bits & 0x3fff) + 1, height: (bits >> 14 & 0x3fff) + 1 });
  switch (chunk) {
    case "VP8 ": return { width: short(26) & 0x3fff, height: short(28) & 0x3fff };
    case "VP8L": return ofBits(long(21));
    case "VP8X": return { width: (long(24) & 0xffffff) + 1, height: (long(26) >>> 8) + 1 };
    default: return undefined;
  }
}

/** @param {DataView} view @returns {Size | undefined} */
function sizeOfJpeg(view) {
  for (const [marker, at] of segmentsOfJpeg(view)) {
    const isFrame = marker >= 0xc0 && marker <= 0xcf && ![0xc4, 0xc8, 0xcc].includes(marker);
    if (isFrame) return { height: view.getUint16(at + 5), width: view.getUint16(at + 7) };
  }
  return undefined;
}

/** Markers of the segments before the picture's data, and their places. @param {DataView} view @returns {Generator<[number, number]>} */
function* segmentsOfJpeg(view) {
  for (let at = 2; at + 4 <= view.byteLength && view.getUint8(at) === 0xff;) {
    const marker = view.getUint8(at + 1);
    yield [marker, at];
    if (marker === 0xda) return;  // the data
    if (marker === 0xff) at += 1;  // a byte that fills
    else at += 2 + (marker === 0x01 || (marker >= 0xd0 && marker <= 0xd8) ? 0 : view.getUint16(at + 2));
  }
}

/**
 * A JPEG or PNG without Exif, whose orientation browsers apply: texture coordinates refer to the stored texels. Other files as they are.
 *
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function withoutExif(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const text = (/** @type {number} */ at) => String.fromCharCode(...bytes.subarray(at, at + 4));
  if (text(0) === "\x89PNG") {
    for (let at = 8; at + 12 <= bytes.length;) {
      const end = at + 12 + view.getUint32(at);
      if (text(at + 4) === "eXIf") {
        const result = new Uint8Array(at + Math.max(bytes.length - end, 0));
        result.set(bytes.subarray(0, at)), result.set(bytes.subarray(end), at);
        return result;
      }
      at = end;
    }
  }
  let result = bytes;
  if (text(0).startsWith("\xff\xd8")) {
    for (const [marker, at] of segmentsOfJpeg(view)) {
      if (marker !== 0xe1 || text(at + 4) !== "Exif") continue;
      if (result === bytes) result = bytes.slice();
      result[at + 1] = 0xfe;  // a comment
    }
  }
  return result;
}

/**
 * The largest picture that the boxes of an AVIF describe; of a picture in tiles, that is the whole.
 *
 * @param {DataView} view
 * @param {(at: number) => string} text
 * @returns {Size | undefined}
 */
function sizeOfAvif(view, text) {
  /** @type {Size | undefined} */
  let largest;
  /** The sizes of boxes that hold others, after their own bytes. @type {Record<string, number>} */
  const parents = { meta: 4, iprp: 0, ipco: 0 };
  for (let at = 0; at < view.byteLength;) {
    const size = view.getUint32(at), name = text(at + 4);
    if (name === "ispe") {
      const found = { width: view.getUint32(at + 12), height: view.getUint32(at + 16) };
      if (found.width * found.height > (largest ? largest.width * largest.height : 0)) largest = found;
    }
    if (name in parents) at += 8 + parents[name];
    else if (size >= 8) at += size;
    else return largest;  // the last one, up to the end, or too long for 32 bits
  }
  return largest;
}
