/** The page shows its state: the chains, the views with their common cursor, titles and messages.
 * The chains change by controls, by drags, by undo, and when others are opened. */

import { clock, goToTime, part, placeOf, span, wake } from "./clock.js";
import { KINDS, readColours } from "./colour.js";
import { Controls } from "./controls.js";
import { $, make } from "./fields.js";
import { fixed } from "./host.js";
import { SpaceTime } from "./map.js";
import { gapOf, inMillimetres, metres, plain, prefixed, short, timeAt } from "./numbers.js";
import { SLOTS, about, history, keepAddress, other, own, results, say, state } from "./page.js";
import { showRecord } from "./record.js";
import { forget, request } from "./requests.js";
import { Results } from "./results.js";
import { Stage, around } from "./stage.js";
import { SELECTS, changed, copy, listed, withRadius } from "./state.js";
import { Views, showClock, whyBlank } from "./views.js";

/** @typedef {import("./state.js").Slot} Slot */
/** @typedef {"pulse" | "times" | "map" | "table"} Part */

const dirty = { pulse: true, times: true, map: true, table: true };

const controls = new Controls($("controls-body"), about, change, () => own().accepted);
const views = new Views(about, {
  bead: select,
  time: goToTime,
  range: (range) => view({ range }),
  hide: (name) => view({ hidden: state.view.hidden.includes(name) ? state.view.hidden.filter((each) => each !== name) : [...state.view.hidden, name] }),
});
const map = new SpaceTime($("map"), (bead, time) => { select(bead); goToTime(time); });
$("map").ondblclick = () => views.zoom(null);
/** @param {Slot} slot */
const stageOf = (slot) => new Stage($(`stage-${slot}`), {
  select: (bead) => { activate(slot); select(bead); },
  sensor: toggleSensor,
  resize,
  wall: (gap, moving) => { activate(slot); moveWall(gap, moving); },
});
export const stages = { A: stageOf("A"), B: stageOf("B") };

const dents = (/** @type {string} */ text) => text.includes("pressure / yield");
const upper = (/** @type {string} */ text) => text.charAt(0).toUpperCase() + text.slice(1);

/** @param {Partial<import("./state.js").View>} some */
export function view(some) {
  Object.assign(state.view, some);
  showView();
  keepAddress();
  redraw();
}

/** @param {Part[]} parts */
export function redraw(...parts) {
  for (const each of parts.length ? parts : /** @type {Part[]} */ (Object.keys(dirty))) dirty[each] = true;
  wake();
}

export function repaint() {
  readColours();
  redraw("map");
}

function showHistory() {
  $("undo").disabled = !history.past.length;
  $("redo").disabled = !history.future.length;
}

export function showAll() {
  document.body.classList.toggle("comparing", state.B !== null);
  $("compare").setAttribute("aria-pressed", String(state.B !== null));
  $("lane-B").hidden = $("tabs").hidden = state.B === null;
  for (const slot of SLOTS) {
    $(`tab-${slot}`).setAttribute("aria-pressed", String(slot === state.active));
    $(`lane-${slot}`).classList.toggle("active", slot === state.active && state.B !== null);
  }
  for (const each of document.querySelectorAll(".own")) each.textContent = state.B ? `, chain ${state.active}` : "";
  controls.last = "";
  controls.show(state[state.active]);
  showView();
  showHistory();
  redraw();
}

function showView() {
  const { view: v } = state;
  for (const [id, name] of SELECTS) $(id).value = v[name];
  const forces = v.map === "forces";
  const rows = forces ? ["of each contact", "of all contacts"] : ["of each bead", "of all beads"];
  for (const [i, text] of rows.entries()) $("map-scale").options[i].textContent = text;
  $("map-bar").classList.toggle("forces", forces);
  $("map-low").textContent = forces ? "0" : "back";
  $("map-high").textContent = forces ? "largest" : "forwards";
  $("speed").value = String(v.speed);
  $("log").checked = v.log;
  for (const slot of SLOTS) Object.assign(stages[slot], { camera: v.camera, scale: v.scale, sensors: v.sensors });
  $("bead").value = String(v.bead);
  // A new defect is the chosen bead.
  about.begin.other.bead = Math.max(1, ball());
  about.begin.size = own().beads.arrays.get("radii")?.[v.bead - 1];
  if (document.activeElement !== $("until")) $("until").value = v.until ? plain(own().si ? 1e3 * v.until : v.until) : "";
  $("until-unit").textContent = own().si ? "ms" : "";
}

/** Ball at the cursor: its number without the strikers. */
const ball = () => state.view.bead - stages[state.active].strikers;
/** Bead of a chain at the cursor: the same ball in both. @param {Slot} slot */
const beadIn = (slot) => Math.max(1, ball() + stages[slot].strikers);

/** @param {Slot} slot */
export function activate(slot) {
  if (slot === state.active || !state[slot]) return;
  clock.u = placeOf(slot);
  state.view.bead = beadIn(slot);
  state.active = slot;
  showAll();
  showStatus();
}

/** @param {number} bead */
export function select(bead) {
  bead = Math.max(1, Math.min(own().beads.header?.beads ?? 1, bead));
  if (bead === state.view.bead) return;
  state.view.bead = bead;
  showView();
  keepAddress();
  redraw("table");
}

/** Show a part of the results. @param {Slot} slot @param {string} kind */
export function showPart(slot, kind) {
  const found = results[slot];
  if (kind === "beads" || kind === "run") {
    if (found.beads.header) stages[slot].chain(found.beads, gapOf(state[slot]));
    if (kind === "beads" && slot === state.active) showView();
    stages[slot].motion = found.motion;
  }
  if (kind === "run") {
    dirty.map = true;
    document.body.classList.toggle("draft", SLOTS.some((each) => state[each] && !results[each].settled));
  }
  problem(slot);
  redraw("pulse", "times", "table");
}

/** @param {Slot} slot */
function problem(slot) {
  const found = results[slot], text = found.problem, stale = text !== "";
  $(`lane-${slot}`).classList.toggle("stale", stale);
  if (stale && !found.ready) $(`title-${slot}`).replaceChildren(make("span", { className: "bad" }, text));
  if (slot === state.active) showStatus();
}

/** How the run of the active chain ended, or why there is none. */
function showStatus() {
  const found = own(), text = found.problem;
  document.body.classList.toggle("stale", text !== "");
  controls.problem(text, found.causes);
  if (text) return say(text, true);
  const { message, energy_drift, success } = found.run.header ?? {};
  if (found.pending.length && !found.motion) say(whyBlank(found));
  else if (message) say(`${upper(state.B ? `chain ${state.active}: ${message}` : message)}; energy adds up within ${energy_drift.toExponential(0)}.`, !success);
}

export function draw() {
  const found = own(), time = found.motion ? timeAt(found.motion.times, placeOf(state.active)) : 0;
  if (dirty.pulse || dirty.times) showTitles();
  drawStages();
  $("sensor").setAttribute("aria-pressed", String(state.view.sensors.includes(ball())));
  map.motion = found.motion;
  $("map-note").textContent = found.motion ? "" : whyBlank(found);
  if (dirty.map && found.motion) {
    map.paint(found.motion, /** @type {any} */ (state.view.map), state.view.scale, span());
    dirty.map = false;
  }
  const axis = found.motion ? views.timeAxis(found) : { factor: 1, unit: "", label: "" };
  map.draw(time, state.view.bead, axis);
  if (dirty.pulse) {
    views.drawPulse(state, found, other());
    dirty.pulse = false;
  }
  if (dirty.times) {
    views.drawTimes(state, found, other());
    showRecord();
    dirty.times = false;
  }
  if (dirty.table && $("table-details").open) views.drawTable(state, found);
  dirty.table = false;
  views.cursor(state.view.bead, time);
  showClock(found.motion ? time : undefined, axis, part(), clock.playing);
}

/** The chains, one below the other at the same scale if they have the same units. */
function drawStages() {
  const alike = state.B && results.A.ready && results.B.ready && results.A.si === results.B.si;
  const shared = alike ? around(stages.A.room, stages.B.room) : null;
  const given = SLOTS.filter((slot) => state[slot] && results[slot].ready);
  const front = (/** @type {Slot} */ slot) => results[slot].front(results[slot].motion ? timeAt(results[slot].motion.times, placeOf(slot)) : 0);
  const least = shared ? Math.max(...given.map((slot) => stages[slot].near(front(slot))[0])) : 0;
  for (const slot of given) {
    Object.assign(stages[slot], { shared, least, bead: beadIn(slot) });
    stages[slot].draw(placeOf(slot) * ((results[slot].motion?.count ?? 1) - 1), front(slot));
  }
}

/** First ball in which two chains with the same description differ. @param {Slot} slot */
function difference(slot) {
  const { header, arrays } = results[slot].beads, that = results[slot === "A" ? "B" : "A"].beads;
  if (!state.B || !that.header || header.description !== that.header.description) return "";
  for (const name of ["radii", "masses"]) {
    const mine = arrays.get(name), theirs = that.arrays.get(name), k = mine.findIndex((/** @type {number} */ each, /** @type {number} */ i) => each !== theirs[i]);
    if (k < 0) continue;
    const ball = k + 1 - header.strikers, place = ball > 0 ? `ball ${ball}` : `bead ${k + 1}`;
    const [value, si] = name === "radii" ? [2 * mine[k], "m"] : [1e3 * mine[k], "g"], [factor, unit] = prefixed(value, si);
    return `; ${place}: ${header.units === "SI" ? `${short(value * factor)} ${unit}` : `${name === "radii" ? "radius" : "mass"} ${short(mine[k])}`}`;
  }
  return "";
}

function showTitles() {
  const names = [...new Set(SLOTS.flatMap((slot) => (state[slot] && results[slot].beads.header?.kinds) || []).map(([name]) => name))];
  for (const slot of SLOTS) {
    const header = results[slot].beads.header;
    if (!header) continue;
    $(`title-${slot}`).title = header.description.includes("mixed exponents") ? "Contacts have different exponents: 3/2 between spheres, 1 at pads and load cells" : "";
    const colours = stages[slot].colours = header.kinds.map((/** @type {string[]} */ [name]) => names.indexOf(name));
    const kinds = colours.map((/** @type {number} */ i, /** @type {number} */ n) => make("span", { className: "key" },
      make("i", { className: "ring", style: `color:var(--m${i % KINDS});${i < KINDS ? "" : "border-style:dashed"}` }), header.kinds[n].join(", ")));
    $(`title-${slot}`).replaceChildren((state.B ? `${slot}: ` : "") + header.description + difference(slot), ...(header.file ? [make("small", {}, header.file)] : []), ...(kinds.length ? [make("span", { className: "legend" }, ...kinds)] : []));
  }
  const beads = own().beads.header?.beads, given = SLOTS.filter((slot) => state[slot]);
  // First those of the chain with the controls; dents change all its forces.
  const list = [...new Set([state.active, ...given].flatMap((slot) => results[slot].warnings.sort((one, two) => Number(dents(two)) - Number(dents(one)))))].map((text) => (state.B ? `${given.filter((slot) => results[slot].warnings.includes(text)).join(" and ")}: ` : "") + upper(text));
  $("chain-file").textContent = own().beads.header?.chain_file ?? "";
  if (beads) {
    $("bead").max = String(beads);
    select(state.view.bead);
  }
  $("warnings").hidden = !list.length;
  $("warnings-count").textContent = list.length > 1 ? `${list.length} warnings: ${list[0]}` : list.join();
  $("warnings-list").replaceChildren(...list.slice(1).map((text) => make("li", {}, text)));
}

const MAX_SENSORS = 4;

function snapshot() {
  return JSON.stringify({ A: state.A, B: state.B, sensors: state.view.sensors });
}

/** The document of the active chain has changed; if it is the same, nothing is computed again.
 * @param {any} given @param {boolean} moving */
function change(given, moving) {
  const same = JSON.stringify(given) === JSON.stringify(state[state.active]);
  if (same) history.open &&= moving;
  else history.note(snapshot(), moving);
  state[state.active] = given;
  controls.show(given);
  if (!same || document.body.dataset.settled !== "yes") request([state.active], moving);
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

const chosen = () => /** @type {any} */ (state[state.active]);

/** @param {number} bead @param {number} radius NaN at the end of a drag @param {boolean} moving */
export function resize(bead, radius, moving) {
  if (fixed) return;
  const document = chosen(), si = own().si;
  if (!Number.isFinite(radius)) {
    history.open = false;
    request([state.active], false);
    return;
  }
  if (document.chain.with_scatter) return say("Remove the random scatter to drag radii.", true);
  if (!si && bead === 1 + own().beads.header.strikers) return say("Bead 1 is the unit of length; change the others, or choose a material.", true);
  change(withRadius(document, bead, si ? inMillimetres(radius) : +radius.toPrecision(3)), moving);
}

/** A pending radius grows, too. @param {number} factor */
export function grow(factor) {
  const { bead } = state.view, radius = listed(chosen().chain.with_defects).find((each) => each.bead === ball())?.radius;
  resize(bead, metres(radius, own().beads.arrays.get("radii")[bead - 1]) * factor, false);
}

/** @param {number} gap @param {boolean} moving */
function moveWall(gap, moving) {
  if (!own().si) return say("Gaps of a scaled chain are too small to be seen; use the control of the wall.", true);
  change(changed(chosen(), ["chain", "right_wall", "gap"], inMillimetres(gap)), moving);
}

export function compare() {
  history.note(snapshot(), false);
  if (state.B) Object.assign(state, { A: state[state.active], B: null, active: "A" });
  else Object.assign(state, { B: copy(state.A), active: "B" });
  state.view.errors = state.B ? "difference" : "theories";
  showAll();
  request(SLOTS, false);
}

/** @param {Partial<import("./state.js").State>} next */
export function open(next) {
  history.note(snapshot(), false);
  Object.assign(state, next);
  for (const slot of SLOTS) {
    if (!(slot in next)) continue;
    results[slot] = new Results();
    forget(slot);
  }
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
