/** Results of a chain, and their binary messages, which `messages.py` describes. */

/** @typedef {{header: any, arrays: Map<string, any>}} Part */

const VERSION = 1;
/** @type {Record<string, any>} */
const KINDS = { f8: Float64Array, f4: Float32Array, i2: Int16Array };

/** The arrays are views of the buffer. @param {ArrayBuffer} buffer @returns {Part} */
export function unpack(buffer) {
  const view = new DataView(buffer), length = view.getUint32(0, true);
  if (view.getUint32(4, true) !== VERSION) throw new Error("The page and the server have different versions; reload the page.");
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  /** @type {Map<string, any>} */
  const arrays = new Map();
  for (const [name, kind, shape, offset] of header.arrays) {
    const count = shape.reduce((/** @type {number} */ a, /** @type {number} */ b) => a * b, 1);
    arrays.set(name, new KINDS[kind](buffer, 8 + length + offset, count));
  }
  return { header, arrays };
}

/** Splits a stream of bytes into messages, each preceded by its length. */
export class Splitter {
  rest = new Uint8Array(0);

  /** @param {Uint8Array} chunk @returns {Part[]} */
  add(chunk) {
    const bytes = new Uint8Array(this.rest.length + chunk.length), view = new DataView(bytes.buffer), found = [];
    bytes.set(this.rest);
    bytes.set(chunk, this.rest.length);
    let at = 0;
    for (;;) {
      const end = at + 4 + (at + 4 > bytes.length ? 0 : view.getUint32(at, true));
      if (end > bytes.length) break;
      found.push(unpack(bytes.slice(at + 4, end).buffer));
      at = end;
    }
    this.rest = bytes.subarray(at);
    return found;
  }
}

const START = () => ({ header: /** @type {any} */ (null), arrays: /** @type {Map<string, any>} */ (new Map()) });

export class Results {
  beads = START();
  pulse = START();
  run = START();
  /** @type {import("./stage.js").Motion | null} */
  motion = null;
  /** The last document without an error.
   * @type {any} */
  accepted = null;
  /** Why there is no newer result. */
  problem = "";
  /** Fields of the errors in it. @type {Record<string, string>} */
  causes = {};
  /** @type {string[]} */
  pending = [];
  settled = false;
  /** Measured data at the times of the run.
   * @type {any} */
  measured = null;

  /** @param {Part} part @returns {string} */
  take(part) {
    const { header, arrays } = part, kind = header.part;
    if (kind === "status") this.pending = header.pending;
    if (kind === "error") this.problem = header.message;
    if (kind === "beads") {
      this.beads = part;
      this.problem = "";
      this.causes = {};
      // Results of another number of beads cannot be shown.
      if (this.motion && this.motion.beads !== header.beads) this.motion = null;
      if (this.exact("velocity") && this.exact("velocity").length !== header.beads) this.pulse = START();
    }
    if (kind === "pulse") this.pulse = part;
    if (kind === "run") {
      this.run = part;
      this.settled = !header.draft;
      if (this.settled) this.measured = header.record && { ...header.record, arrays };
      this.motion = {
        count: arrays.get("times").length, beads: this.beads.header.beads, times: arrays.get("times"),
        velocities: arrays.get("velocities"), speeds: arrays.get("velocities.scale"),
        forces: arrays.get("forces"), strengths: arrays.get("forces.scale"),
      };
    }
    return kind;
  }

  get ready() {
    return this.beads.header !== null;
  }

  get si() {
    return this.beads.header?.units === "SI";
  }

  /** @param {string} quantity */
  exact(quantity) {
    return this.pulse.arrays.get(`exact.${quantity}`);
  }

  /** All theories: label, refusal or note. @returns {[string, any][]} */
  get theories() {
    return Object.entries({ ...this.beads.header?.theories, ...this.pulse.header?.theories });
  }

  /** @param {string} name @param {string} quantity */
  theory(name, quantity) {
    const values = this.beads.arrays.get(`${name}.${quantity}`) ?? this.pulse.arrays.get(`${name}.${quantity}`);
    const beads = this.beads.header?.beads;
    return values && Math.abs(values.length - beads) <= 1 ? values : undefined;
  }

  /** Sentences about the validity of the results. @returns {string[]} */
  get warnings() {
    const note = this.pulse.header?.note, beads = this.beads.header, run = this.run.header;
    return [...new Set([...((run?.number === beads?.number ? run : beads)?.warnings ?? []), ...(note ? [note] : [])])];
  }

  /** Bead that the pulse reaches at a time, counted from 0, with a fraction. @param {number} time */
  front(time) {
    const arrival = this.exact("arrival");
    if (!arrival) return 0;
    const low = Math.max(0, arrival.findLastIndex((/** @type {number} */ each) => each <= time)), next = arrival[low + 1];
    return next > time ? low + (time - arrival[low]) / (next - arrival[low]) : low;
  }
}

/** @param {string} name */
export const title = (name) => name.replace("-printed", ", printed").replace("two-thirds", "2/3").replace(/-(?!rate)/g, " ").replace(/rate$/, "rate law").replace("bca", "BCA");
