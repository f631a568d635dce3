/** Changes of the chains: by controls, by drags, by undo, and by opening others. */

import { clock } from "./clock.js";
import { fixed } from "./host.js";
import { inMillimetres } from "./numbers.js";
import { SLOTS, history, own, results, say, state } from "./page.js";
import { forget, request } from "./requests.js";
import { Results } from "./results.js";
import { ball, controls, showAll, showHistory, showView, view } from "./show.js";
import { changed, copy, withRadius } from "./state.js";

/** @typedef {import("./state.js").Slot} Slot */

const MAX_SENSORS = 4;

function snapshot() {
  return JSON.stringify({ A: state.A, B: state.B, sensors: state.view.sensors });
}

/** The document of the active chain has changed. @param {any} document @param {boolean} moving */
export function change(document, moving) {
  history.note(snapshot(), moving);
  state[state.active] = document;
  controls.show(document);
  request([state.active], moving);
  showHistory();
}

/** @param {string | undefined} found */
function restore(found) {
  if (found === undefined) return;
  const { A, B, sensors } = JSON.parse(found);
  Object.assign(state, { A, B, active: B ? state.active : "A" });
  state.view.sensors = sensors;
  showAll();
  request(SLOTS, false);
}

export const undo = () => restore(history.undo(snapshot()));
export const redo = () => restore(history.redo(snapshot()));

export function toggleSensor() {
  if (fixed) return;
  const { sensors } = state.view;
  history.note(snapshot(), false);
  state.view.sensors = sensors.includes(ball()) ? sensors.filter((each) => each !== ball()) : [...sensors, ball()].slice(-MAX_SENSORS);
  showView();
  showHistory();
  request(SLOTS, false);
}

/** @param {number} bead @param {number} radius NaN at the end of a drag @param {boolean} moving */
export function resize(bead, radius, moving) {
  if (fixed) return;
  const document = /** @type {any} */ (state[state.active]), si = own().si;
  if (!Number.isFinite(radius)) {
    history.open = false;
    request([state.active], false);
    return;
  }
  if (document.chain.with_scatter) return say("Remove the random scatter to drag radii.", true);
  if (!si && bead === 1 + own().beads.header.strikers) return say("Bead 1 is the unit of length; change the others, or choose a material.", true);
  change(withRadius(document, bead, si ? inMillimetres(radius) : +radius.toPrecision(3)), moving);
}

/** @param {number} gap @param {boolean} moving */
export function moveWall(gap, moving) {
  const document = /** @type {any} */ (state[state.active]);
  if (!own().si) return say("Gaps of a scaled chain are too small to be seen; use the control of the wall.", true);
  change(changed(document, ["chain", "right_wall", "gap"], inMillimetres(gap)), moving);
}

export function compare() {
  history.note(snapshot(), false);
  if (state.B) Object.assign(state, { A: state[state.active], B: null, active: "A" });
  else Object.assign(state, { B: copy(state.A), active: "B" });
  view({ errors: state.B ? "difference" : "theories" });
  showAll();
  request(SLOTS, false);
}

/** Show other chains. @param {Partial<import("./state.js").State>} next */
export function open(next) {
  history.note(snapshot(), false);
  Object.assign(state, next);
  for (const slot of SLOTS) {
    if (!(slot in next)) continue;
    results[slot] = new Results();
    forget(slot);
  }
  controls.last = "";
  clock.u = 0;
  showAll();
  request(SLOTS, false);
}

/** Open a chain as B, or as A with its own chain B, if any.
 * @param {Slot} slot @param {any} document @param {any} other @param {number[]} sensors @param {number} [until] */
export function openAs(slot, document, other, sensors, until = 0) {
  const view = { ...state.view, sensors, until, range: [], errors: slot === "B" || other ? "difference" : "theories" };
  open(slot === "B" ? { B: document, active: slot, view } : { A: document, B: other, active: slot, view });
}
