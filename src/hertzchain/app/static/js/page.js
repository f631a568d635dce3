/** The state of the page: its chains, their results, and its address. */

import { $ } from "./fields.js";
import { fixed, host, stored } from "./host.js";
import { FACTORS, USUAL } from "./numbers.js";
import { Results } from "./results.js";
import { History, VIEW, copy, fromLink, strikersBefore, toLink } from "./state.js";

/** @typedef {import("./state.js").Slot} Slot */

/** @type {Slot[]} */
export const SLOTS = ["A", "B"];
export const about = await host.about();
Object.assign(FACTORS, about.factors);
Object.assign(USUAL, about.ranges);
const linked = !stored && fromLink(location.hash);
/** @type {import("./state.js").State} */
export const state = linked || { A: about.document, B: about.view?.B ?? null, active: "A", view: { ...copy(VIEW), ...about.view?.view } };
if (!fixed && !linked) {
  const middle = Math.round((about.document.chain.beads ?? 2) / 2);
  Object.assign(state.view, { bead: middle + strikersBefore(about.document), sensors: about.view?.view.sensors ?? about.sensors ?? [middle] });
}
export const history = new History();
export const results = { A: new Results(), B: new Results() };
/** Measured data: their key on the server, their file, and the time [s] at which the simulation begins.
 * @type {{record: string, name: string, shift: number | null}} */
export const record = { record: "", name: "", shift: null, ...about.view?.record };
let written = location.hash;

export function own() {
  return results[state.active];
}

export function other() {
  return state.B ? results[state.active === "A" ? "B" : "A"] : null;
}

/** @param {string} text @param {boolean} [bad] */
export function say(text, bad = false) {
  $("status").textContent = text;
  $("status").classList.toggle("bad", bad);
}

export function keepAddress() {
  host.state({ A: state.A, B: state.B });
  // A link that was pasted in the meantime is not overwritten.
  if (stored || (location.hash !== written && fromLink(location.hash))) return;
  const hash = toLink(state);
  if (hash !== written) window.history.replaceState(null, "", hash);
  written = location.hash;
}

/** The chains of a pasted link are shown: the address may change with them. */
export function acceptAddress() {
  written = location.hash;
}
