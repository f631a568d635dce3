/** Binary messages of the server; `messages.py` describes their layout. */

/** @typedef {{header: any, arrays: Map<string, any>}} Part */

const VERSION = 1;
/** @type {Record<string, any>} */
const KINDS = { f8: Float64Array, f4: Float32Array, i2: Int16Array, i8: BigInt64Array };

/** The arrays are views of the buffer. @param {ArrayBuffer} buffer @param {number} [start]
 * @returns {Part} */
export function unpack(buffer, start = 0) {
  const view = new DataView(buffer, start);
  const length = view.getUint32(0, true);
  if (view.getUint32(4, true) !== VERSION) throw new Error("The page and the server have different versions; reload the page.");
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, start + 8, length)));
  /** @type {Map<string, any>} */
  const arrays = new Map();
  for (const [name, kind, shape, offset] of header.arrays) {
    const count = shape.reduce((/** @type {number} */ a, /** @type {number} */ b) => a * b, 1);
    arrays.set(name, new KINDS[kind](buffer, start + 8 + length + offset, count));
  }
  return { header, arrays };
}

/** Splits a stream of bytes into messages, each preceded by its length. */
export class Splitter {
  constructor() {
    /** @type {Uint8Array[]} */
    this.chunks = [];
    this.size = 0;
  }

  /** @param {Uint8Array} chunk @returns {Part[]} */
  add(chunk) {
    this.chunks.push(chunk);
    this.size += chunk.length;
    const found = [];
    for (;;) {
      const head = this.peek(4);
      if (!head) return found;
      const length = new DataView(head.buffer).getUint32(0, true);
      if (this.size < 4 + length) return found;
      this.take(4);
      found.push(unpack(this.take(length).buffer));
    }
  }

  /** @param {number} count @returns {Uint8Array<ArrayBuffer> | null} */
  peek(count) {
    if (this.size < count) return null;
    const result = new Uint8Array(count);
    let at = 0;
    for (const chunk of this.chunks) {
      const part = chunk.subarray(0, count - at);
      result.set(part, at);
      at += part.length;
      if (at === count) break;
    }
    return result;
  }

  /** @param {number} count @returns {Uint8Array<ArrayBuffer>} */
  take(count) {
    const result = new Uint8Array(count);
    let at = 0;
    while (at < count) {
      const chunk = this.chunks[0];
      const part = chunk.subarray(0, count - at);
      result.set(part, at);
      at += part.length;
      if (part.length === chunk.length) this.chunks.shift();
      else this.chunks[0] = chunk.subarray(part.length);
    }
    this.size -= count;
    return result;
  }
}
