/** Chain files, state of the views, undo, and links.  Pure functions. */

/** @typedef {Record<string, any>} Document a chain file as JSON: `chain` and, perhaps, `materials` */
/** @typedef {"A" | "B"} Slot */
/** @typedef {{quantity: string, log: boolean, bead: number, sensors: number[], camera: string, forces: string,
 *   clock: string, speed: number, map: string, scale: string, budget: string, errors: string, until: number,
 *   hidden: string[], range: number[]}} View; range of times, [0] for all, or [] by default */
/** @typedef {{A: Document, B: Document | null, active: Slot, view: View}} State */

/** @type {View} */
export const VIEW = {
  quantity: "velocity", log: false, bead: 1, sensors: [], camera: "whole", clock: "beads", speed: 1,
  forces: "all", map: "velocities", scale: "bead", budget: "energy", errors: "theories", until: 0, range: [],
  hidden: ["hard-sphere", "two-thirds-bca", "modified-bca-printed"],
};

/** Selects of the page and their choices of the view; another clock needs another run.
 * @type {[string, keyof View, boolean?][]} */
export const SELECTS = [["quantity", "quantity"], ["camera", "camera"], ["map-of", "map"], ["map-scale", "scale"], ["budget-of", "budget"], ["force-scale", "forces"], ["errors", "errors"], ["clock", "clock", true]];

/** @template T @param {T} item @returns {T} */
export const copy = (item) => structuredClone(item);

/** @param {any} item @param {(string | number)[]} path */
export function at(item, path) {
  for (const name of path) item = item?.[name];
  return item;
}

/** A document with another value at a path; undefined removes it, with tables that become empty
 * if they were made for it. @param {Document} document @param {(string | number)[]} path
 * @param {any} value @returns {Document} */
export function changed(document, path, value) {
  const result = copy(document);
  let table = result;
  path.slice(0, -1).forEach((name, i) => {
    if (typeof table[name] !== "object" || table[name] === null) {
      table[name] = typeof path[i + 1] === "number" ? [] : {};
    }
    table = table[name];
  });
  const last = path[path.length - 1];
  if (value !== undefined) table[last] = value;
  else if (Array.isArray(table)) table.splice(Number(last), 1);
  else delete table[last];
  return result;
}

/** The tables of a section that may be repeated, as a list. @param {any} entry @returns {any[]} */
export const listed = (entry) => entry === undefined ? [] : Array.isArray(entry) ? entry : [entry];

/** Number of beads that strikers add in front. @param {Document} document */
export const strikersBefore = (document) => listed(document.chain?.struck_by).reduce((sum, each) => sum + (each.count ?? 1), 0);

/** A document in which a bead has another radius, as a defect.
 * @param {Document} document @param {number} bead number on the stage, from 1
 * @param {number | string} radius */
export function withRadius(document, bead, radius) {
  const own = bead - strikersBefore(document), defects = listed(document.chain.with_defects);
  const kept = { ...defects.find((each) => each.bead === own), bead: own, radius };
  // A radius replaces a diameter.
  delete kept.diameter;
  return changed(document, ["chain", "with_defects"], [...defects.filter((each) => each.bead !== own), kept]);
}

/** Undo and redo of documents; changes of one drag are one step. */
export class History {
  /** @type {string[]} */
  past = [];
  /** @type {string[]} */
  future = [];
  open = false;

  /** Note a state before it changes. @param {string} before @param {boolean} dragging */
  note(before, dragging) {
    if (!this.open && this.past.at(-1) !== before) this.past.push(before);
    if (this.past.length > 200) this.past.shift();
    this.open = dragging;
    this.future = [];
  }

  /** @param {string} now @returns {string | undefined} */
  undo(now) {
    this.open = false;
    const found = this.past.pop();
    if (found !== undefined) this.future.push(now);
    return found;
  }

  /** @param {string} now @returns {string | undefined} */
  redo(now) {
    const found = this.future.pop();
    if (found !== undefined) this.past.push(now);
    return found;
  }
}

const FORBIDDEN = ["__proto__", "constructor", "prototype"];

/** @param {any} item @param {string} path @returns {[string, string][]} */
function flat(item, path) {
  const scalars = Array.isArray(item) && item.every((each) => typeof each !== "object");
  if (scalars || typeof item !== "object" || item === null) return [[path, text(item)]];
  // A name may contain the separator, as materials may.
  const word = (/** @type {string} */ name) => name.replaceAll("%", "%25").replaceAll(".", "%2E");
  return Object.entries(item).flatMap(([name, value]) => flat(value, path ? `${path}.${word(name)}` : word(name)))
    .concat(Object.keys(item).length ? [] : [[path, "{}"]]);
}

/** @param {any} value */
function text(value) {
  if (typeof value !== "string") return JSON.stringify(value);
  return /^[A-Za-z][^=&]*$|^[-+.\d]+ ?[A-Za-zµ]/.test(value) && !["true", "false", "null"].includes(value) ? value : JSON.stringify(value);
}

/** @param {string} given */
function value(given) {
  try {
    return JSON.parse(given);
  } catch {
    return given;
  }
}

/** `#taper=...&rate=...`, then B's with `b.` and the view's with `~`. @param {State} state */
export function toLink(state) {
  const pairs = flat(state.A.chain, "");
  if (state.A.materials) pairs.push(...flat(state.A.materials, "own"));
  if (state.B) {
    pairs.push(...flat(state.B.chain, "b"));
    if (state.B.materials) pairs.push(...flat(state.B.materials, "b-own"));
  }
  for (const [name, each] of Object.entries(state.view)) {
    if (JSON.stringify(each) !== JSON.stringify(VIEW[/** @type {keyof View} */ (name)])) pairs.push([`~${name}`, text(each)]);
  }
  return "#" + pairs.map(([name, each]) => `${encodeURIComponent(name)}=${encodeURIComponent(each)}`
    .replaceAll("%20", "+").replace(/%2[CF]|%5[BD]/g, decodeURIComponent)).join("&");
}

/** The state that a link describes, or null if there is none. @param {string} hash
 * @returns {State | null} */
export function fromLink(hash) {
  const pairs = hash.replace(/^#/, "").split("&").filter((each) => each.includes("="));
  if (!pairs.length) return null;
  /** @type {any} */
  const tables = { a: {}, own: {}, b: {}, "b-own": {} };
  /** @type {any} */
  const view = copy(VIEW);
  for (const pair of pairs) {
    const split = pair.indexOf("=");
    let name, content, words;
    try {
      name = decodeURIComponent(pair.slice(0, split).replaceAll("+", " "));
      words = name.split(".").map(decodeURIComponent);
      content = value(decodeURIComponent(pair.slice(split + 1).replaceAll("+", " ")));
    } catch {
      continue;
    }
    if (name.startsWith("~")) {
      const key = name.slice(1);
      if (Object.hasOwn(VIEW, key) && typeof content === typeof view[key] && Array.isArray(content) === Array.isArray(view[key])) view[key] = content;
      continue;
    }
    const root = Object.hasOwn(tables, words[0]) && words[0] !== "a" ? words.shift() ?? "a" : "a";
    if (!words.length || words.some((each) => FORBIDDEN.includes(each) || each === "") || words.slice(1).some((each) => +each > 2000)) continue;
    tables[root] = changed(tables[root], words.map((each) => /^(0|[1-9]\d*)$/.test(each) ? +each : each), content);
  }
  const documentOf = (/** @type {string} */ chain, /** @type {string} */ own) => Object.keys(tables[chain]).length
    ? { chain: tables[chain], ...(Object.keys(tables[own]).length ? { materials: tables[own] } : {}) } : null;
  const first = documentOf("a", "own");
  if (!first) return null;
  return { A: first, B: documentOf("b", "b-own"), active: "A", view };
}
