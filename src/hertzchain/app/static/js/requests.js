/** Requests for the results of both chains, and their answers. */

import { Link } from "./link.js";
import { SLOTS, keepAddress, results, say, state } from "./page.js";

/** @typedef {import("./state.js").Slot} Slot */

/** Milliseconds without a change after which the exact results are requested. */
const SETTLE = 180;
/** For the tests and `benchmarks/app.py`. */
export const answers = /** @type {any[]} */ ([]);
/** Answers that no frame has shown yet. @type {any[]} */
const waiting = [];
/** @type {Record<Slot, boolean>} */
const moved = { A: false, B: false };
let settle = 0, asked = 0, draft = false, later = 0;
/** @type {(slot: Slot, kind: string) => void} */
let received = () => {};

/** @param {Slot} slot */
const linkOf = (slot) => new Link(slot, { part: (part, sent) => take(slot, part, sent), offline: (text) => say(text, true) });
const links = { A: linkOf("A"), B: linkOf("B") };

/** Call a function after each part of the results. @param {(slot: Slot, kind: string) => void} shown */
export function eachAnswer(shown) {
  received = shown;
}

/** Forget the requests of a chain that has been replaced. @param {Slot} slot */
export function forget(slot) {
  links[slot].current = links[slot].waiting = null;
}

/** Ask for results: a draft during a drag, the exact ones when it has settled.
 * @param {Slot[]} slots @param {boolean} moving */
export function request(slots, moving) {
  const input = performance.now();
  for (const slot of slots) if (state[slot]) moved[slot] = true;
  document.body.dataset.settled = "no";
  draft = moving;
  asked ||= requestAnimationFrame(() => {
    asked = 0;
    for (const slot of SLOTS) if (moved[slot] && state[slot]) links[slot].ask(requestOf(slot, draft, input));
  });
  clearTimeout(settle);
  const finish = () => {
    if (asked || SLOTS.some((slot) => links[slot].busy)) {
      settle = setTimeout(finish, 30);
      return;
    }
    keepAddress();
    if (draft) for (const slot of SLOTS) if (moved[slot] && state[slot]) links[slot].ask(requestOf(slot, false, performance.now()));
    draft = false;
    for (const slot of SLOTS) moved[slot] = false;
    if (document.body.dataset.settled === "no") wakeLater();
  };
  settle = setTimeout(finish, moving ? SETTLE : 20);
}

/** @param {Slot} slot @param {boolean} rough @param {number} input */
function requestOf(slot, rough, input) {
  return {
    document: state[slot], draft: rough, frames: rough ? 160 : 320, rtol: rough ? 1e-6 : 1e-9, clock: state.view.clock,
    sensors: state.view.sensors, run_until: state.view.until, input,
  };
}

/** @param {Slot} slot @param {any} part @param {any} sent */
function take(slot, part, sent) {
  const kind = results[slot].take(part);
  if (kind === "beads") results[slot].accepted = sent.document;
  const record = { part: kind, draft: sent.draft, input: sent.input, shown: 0 };
  answers.push(record);
  if (answers.length > 2000) answers.splice(0, 1000);
  waiting.push(record);
  received(slot, kind);
}

/** Note when the answers of this frame are on the screen. */
export function noteShown() {
  if (!waiting.length) return;
  const shown = waiting.splice(0);
  setTimeout(() => {
    for (const record of shown) record.shown = performance.now();
    wakeLater();
  });
}

function settled() {
  return !moved.A && !moved.B && !asked && SLOTS.every((slot) => !state[slot] || ((results[slot].settled || results[slot].problem) && !links[slot].busy));
}

function wakeLater() {
  clearTimeout(later);
  later = setTimeout(() => {
    if (settled()) document.body.dataset.settled = "yes";
    else wakeLater();
  }, 30);
}
