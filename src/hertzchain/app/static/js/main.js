import { KINDS, readColours } from "./colour.js";
import { $, Controls, make } from "./controls.js";
import { SELECTS, listen } from "./events.js";
import { fixed, host, stored } from "./host.js";
import { Link } from "./link.js";
import { SpaceTime } from "./map.js";
import { FACTORS, USUAL, gapOf, inMillimetres, placeAt, plain, timeAt } from "./numbers.js";
import { Results } from "./results.js";
import { fillDialogs } from "./share.js";
import { Stage } from "./stage.js";
import { History, VIEW, changed, copy, fromLink, strikersBefore, toLink, withRadius } from "./state.js";
import { Views, showClock, whyBlank } from "./views.js";

/** @typedef {import("./state.js").Slot} Slot */

/** @type {Slot[]} */
const SLOTS = ["A", "B"];
/** Seconds that a run takes at speed 1. */
const DURATION = 8;
const SETTLE = 180;
const MAX_SENSORS = 4;
const about = await host.about();
Object.assign(FACTORS, about.factors);
Object.assign(USUAL, about.ranges);
const linked = !stored && fromLink(location.hash);
/** @type {import("./state.js").State} */
const state = linked || { A: about.document, B: stored?.view?.B ?? null, active: "A", view: { ...copy(VIEW), ...stored?.view?.view } };
if (!fixed && !linked) {
  const middle = Math.round((about.document.chain.beads ?? 2) / 2);
  Object.assign(state.view, { bead: middle + strikersBefore(about.document), sensors: [middle] });
}
const history = new History();
const results = { A: new Results(), B: new Results() };
/** For the tests and `benchmarks/app.py`. */
const answers = /** @type {any[]} */ ([]);
let u = 0, playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, last = 0, awake = false;
let settle = 0, asked = 0, draft = false, written = location.hash;
const dirty = { pulse: true, times: true, map: true, table: true };
/** @type {Record<Slot, boolean>} */
const moved = { A: false, B: false };

const controls = new Controls($("controls-body"), about, change, () => own().accepted);
const views = new Views(about, {
  bead: (bead) => select(Math.max(1, Math.min(own().beads.header?.beads ?? 1, bead))),
  time: goToTime,
  hide: (name) => view({ hidden: state.view.hidden.includes(name) ? state.view.hidden.filter((each) => each !== name) : [...state.view.hidden, name] }),
});
const map = new SpaceTime($("map"), (bead, time) => { select(bead); goToTime(time); });
/** @param {Slot} slot */
const stageOf = (slot) => new Stage($(`stage-${slot}`), {
  select: (bead) => { activate(slot); select(bead); },
  sensor: toggleSensor,
  resize,
  wall: (gap, moving) => { activate(slot); moveWall(gap, moving); },
});
const stages = { A: stageOf("A"), B: stageOf("B") };
/** @param {Slot} slot */
const linkOf = (slot) => new Link(slot, { part: (part, sent) => take(slot, part, sent), offline: (text) => say(text, true) });
const links = { A: linkOf("A"), B: linkOf("B") };

/** Results of the chain that the controls change. */
function own() {
  return results[state.active];
}

function other() {
  return state.B ? results[state.active === "A" ? "B" : "A"] : null;
}

const upper = (/** @type {string} */ text) => text.charAt(0).toUpperCase() + text.slice(1);

/** @param {string} text @param {boolean} [bad] */
function say(text, bad = false) {
  $("status").textContent = text;
  $("status").classList.toggle("bad", bad);
}

function snapshot() {
  return JSON.stringify({ A: state.A, B: state.B, sensors: state.view.sensors });
}

/** The document of the active chain has changed. @param {any} document @param {boolean} moving */
function change(document, moving) {
  history.note(snapshot(), moving);
  state[state.active] = document;
  controls.show(document);
  request([state.active], moving);
  showHistory();
}

/** @param {Partial<import("./state.js").View>} some */
function view(some) {
  Object.assign(state.view, some);
  showView();
  keepAddress();
  redraw();
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

const undo = () => restore(history.undo(snapshot()));
const redo = () => restore(history.redo(snapshot()));

function showHistory() {
  $("undo").disabled = !history.past.length;
  $("redo").disabled = !history.future.length;
}

function showAll() {
  document.body.classList.toggle("comparing", state.B !== null);
  $("compare").setAttribute("aria-pressed", String(state.B !== null));
  $("lane-B").hidden = $("tabs").hidden = state.B === null;
  for (const slot of SLOTS) {
    $(`tab-${slot}`).setAttribute("aria-pressed", String(slot === state.active));
    $(`lane-${slot}`).classList.toggle("active", slot === state.active && state.B !== null);
  }
  for (const each of document.querySelectorAll(".own")) each.textContent = state.B ? `, chain ${state.active}` : "";
  controls.show(state[state.active]);
  showView();
  showHistory();
  redraw();
}

function redraw() {
  dirty.pulse = dirty.times = dirty.map = dirty.table = true;
  wake();
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
  // The unit is known with the first results.
  if (document.activeElement !== $("until")) $("until").value = v.until ? plain(own().si ? 1e3 * v.until : v.until) : "";
  $("until-unit").textContent = own().si ? "ms" : "";
}

/** Ball at the cursor: its number without the strikers. */
const ball = () => state.view.bead - stages[state.active].strikers;
/** Bead of a chain at the cursor: the same ball in both. @param {Slot} slot */
const beadIn = (slot) => Math.max(1, ball() + stages[slot].strikers);

/** @param {Slot} slot */
function activate(slot) {
  if (slot === state.active || !state[slot]) return;
  u = placeOf(slot);
  state.view.bead = beadIn(slot);
  state.active = slot;
  showAll();
  showStatus();
}

/** @param {number} bead */
function select(bead) {
  if (bead === state.view.bead) return;
  state.view.bead = bead;
  dirty.table = true;
  showView();
  keepAddress();
  wake();
}

function toggleSensor() {
  if (fixed) return;
  const { sensors } = state.view;
  history.note(snapshot(), false);
  state.view.sensors = sensors.includes(ball()) ? sensors.filter((each) => each !== ball()) : [...sensors, ball()].slice(-MAX_SENSORS);
  showView();
  showHistory();
  request(SLOTS, false);
}

/** @param {number} bead @param {number} radius NaN at the end of a drag @param {boolean} moving */
function resize(bead, radius, moving) {
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
function moveWall(gap, moving) {
  const document = /** @type {any} */ (state[state.active]);
  if (!own().si) return say("Gaps of a scaled chain are too small to be seen; use the control of the wall.", true);
  change(changed(document, ["chain", "right_wall", "gap"], inMillimetres(gap)), moving);
}

/** Ask for results: a draft during a drag, the exact ones when it has settled.
 * @param {Slot[]} slots @param {boolean} moving */
function request(slots, moving) {
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
  const found = results[slot], kind = found.take(part);
  if (kind === "beads") found.accepted = sent.document;
  if (kind === "beads" || kind === "run") {
    if (found.beads.header) stages[slot].chain(found.beads, gapOf(state[slot]));
    if (kind === "beads" && slot === state.active) showView();
    stages[slot].motion = found.motion;
  }
  if (kind === "run") {
    dirty.map = true;
    document.body.classList.toggle("draft", SLOTS.some((each) => state[each] && !results[each].settled));
  }
  dirty.pulse = dirty.times = dirty.table = true;
  const record = { part: kind, draft: sent.draft, input: sent.input, shown: 0 };
  answers.push(record);
  if (answers.length > 2000) answers.splice(0, 1000);
  waiting.push(record);
  problem(slot);
  wake();
}
/** @type {any[]} */
const waiting = [];

/** @param {Slot} slot */
function problem(slot) {
  const found = results[slot], text = found.problem, stale = text !== "";
  $(`lane-${slot}`).classList.toggle("stale", stale);
  // The message may be far below.
  if (stale && !found.ready) $(`title-${slot}`).replaceChildren(make("span", { className: "bad" }, text));
  if (slot === state.active) showStatus();
}

/** How the run of the active chain ended, or why there is none. */
function showStatus() {
  const found = own(), text = found.problem;
  document.body.classList.toggle("stale", text !== "");
  controls.problem(text);
  if (text) return say(text, true);
  const { message, energy_drift, success } = found.run.header ?? {};
  if (found.pending.length && !found.motion) say(whyBlank(found));
  else if (message) say(`${upper(state.B ? `chain ${state.active}: ${message}` : message)}; energy adds up within ${energy_drift.toExponential(0)}.`, !success);
}

function wake() {
  if (awake) return;
  awake = true;
  requestAnimationFrame(tick);
}

/** The chains have one time. @param {Slot} slot */
function placeOf(slot) {
  const place = Math.min(1, u), mine = own().motion, { motion, si } = results[slot];
  return mine && motion && slot !== state.active && si === own().si ? placeAt(motion.times, timeAt(mine.times, place)) : place;
}

/** @param {number} now */
function tick(now) {
  awake = false;
  if (playing && last) u += (Math.min(100, now - last) / 1000 / DURATION) * state.view.speed;
  if (u >= 1.06) u = 0;
  last = playing ? now : 0;
  draw();
  if (waiting.length) {
    const shown = waiting.splice(0);
    setTimeout(() => {
      for (const record of shown) record.shown = performance.now();
      wakeLater();
    });
  }
  if (playing && results.A.motion) wake();
}

function settled() {
  return !moved.A && !moved.B && !asked && SLOTS.every((slot) => !state[slot] || ((results[slot].settled || results[slot].problem) && !links[slot].busy));
}

let later = 0;
function wakeLater() {
  clearTimeout(later);
  later = setTimeout(() => {
    if (settled()) document.body.dataset.settled = "yes";
    else wakeLater();
  }, 30);
}

function draw() {
  const found = own(), time = found.motion ? timeAt(found.motion.times, u) : 0;
  if (dirty.pulse || dirty.times) showTitles();
  const alike = state.B && results.A.ready && results.B.ready && results.A.si === results.B.si;
  for (const slot of SLOTS) {
    if (!state[slot] || !results[slot].ready) continue;
    stages[slot].most = alike ? Math.min(stages.A.room.whole, stages.B.room.whole) : Infinity;
    const { motion } = results[slot], place = placeOf(slot);
    stages[slot].bead = beadIn(slot);
    stages[slot].draw(place * ((motion?.count ?? 1) - 1), results[slot].front(motion ? timeAt(motion.times, place) : 0));
  }
  $("sensor").setAttribute("aria-pressed", String(state.view.sensors.includes(ball())));
  map.motion = found.motion;
  $("map-note").textContent = found.motion ? "" : whyBlank(found);
  if (dirty.map && found.motion) {
    map.paint(found.motion, /** @type {any} */ (state.view.map), state.view.scale);
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
    dirty.times = false;
  }
  if (dirty.table && $("table-details").open) views.drawTable(state, found);
  dirty.table = false;
  views.cursor(state.view.bead, time);
  showClock(found.motion ? time : undefined, axis, Math.min(1, u), playing);
}

function showTitles() {
  const names = [...new Set(SLOTS.flatMap((slot) => (state[slot] && results[slot].beads.header?.kinds) || []).map(([name]) => name))];
  for (const slot of SLOTS) {
    const header = results[slot].beads.header;
    if (!header) continue;
    const colours = stages[slot].colours = header.kinds.map((/** @type {string[]} */ [name]) => names.indexOf(name));
    const kinds = colours.map((/** @type {number} */ i, /** @type {number} */ n) => make("span", { className: "key" },
      make("i", { className: "ring", style: `color:var(--m${i % KINDS});${i < KINDS ? "" : "border-style:dashed"}` }), header.kinds[n].join(", ")));
    $(`title-${slot}`).replaceChildren((state.B ? `${slot}: ` : "") + header.description, ...(kinds.length ? [make("span", { className: "legend" }, ...kinds)] : []));
  }
  const beads = own().beads.header?.beads, list = SLOTS.flatMap((slot) => state[slot] ? results[slot].warnings.map((text) => (state.B ? `${slot}: ` : "") + upper(text)) : []);
  $("chain-file").textContent = own().beads.header?.chain_file ?? "";
  if (beads) $("bead").max = String(beads);
  if (beads < state.view.bead) select(beads);
  $("warnings").hidden = !list.length;
  $("warnings-count").textContent = list.length > 1 ? `${list.length} warnings: ${list[0]}` : list.join();
  $("warnings-list").replaceChildren(...list.slice(1).map((text) => make("li", {}, text)));
}

/** @param {boolean} on */
function play(on) {
  playing = on;
  if (on && u >= 1) u = 0;
  last = 0;
  $("play").setAttribute("aria-label", on ? "Pause" : "Play");
  $("play").textContent = on ? "❚❚" : "▶";
  wake();
}

/** @param {number} place */
function goTo(place) {
  u = Math.max(0, Math.min(1, place));
  play(false);
}

/** @param {number} time */
function goToTime(time) {
  const { motion } = own();
  if (motion) goTo(placeAt(motion.times, time));
}

function keepAddress() {
  host.state({ A: state.A, B: state.B });
  // A link that was pasted in the meantime is not overwritten.
  if (stored || (location.hash !== written && fromLink(location.hash))) return;
  const hash = toLink(state);
  if (hash !== written) window.history.replaceState(null, "", hash);
  written = location.hash;
}

function compare() {
  history.note(snapshot(), false);
  if (state.B) Object.assign(state, { A: state[state.active], B: null, active: "A" });
  else Object.assign(state, { B: copy(state.A), active: "B" });
  view({ errors: state.B ? "difference" : "theories" });
  showAll();
  request(SLOTS, false);
}

function repaint() {
  readColours();
  dirty.map = true;
  wake();
}

/** Show other chains. @param {Partial<import("./state.js").State>} next */
function open(next) {
  history.note(snapshot(), false);
  Object.assign(state, next);
  for (const slot of SLOTS) {
    if (!(slot in next)) continue;
    results[slot] = new Results();
    links[slot].current = links[slot].waiting = null;
  }
  controls.last = "";
  u = 0;
  showAll();
  request(SLOTS, false);
}

/** Open a chain as B, or as A with its own chain B, if any.
 * @param {Slot} slot @param {any} document @param {any} other @param {number[]} sensors @param {number} [until] */
function openAs(slot, document, other, sensors, until = 0) {
  const view = { ...state.view, sensors, until, errors: slot === "B" || other ? "difference" : "theories" };
  open(slot === "B" ? { B: document, active: slot, view } : { A: document, B: other, active: slot, view });
}

function start() {
  document.body.classList.toggle("saved", fixed);
  readColours();
  listen({
    about, state, view, request: () => request(SLOTS, false), select, toggleSensor, play: () => play(!playing), goTo, step: (by) => goTo(u + by),
    undo, redo, compare, activate, repaint, radiusOf: (bead) => own().beads.arrays.get("radii")[bead - 1], resize,
    beads: () => own().beads.header?.beads ?? 1,
    until: (given) => {
      view({ until: given > 0 && given < Infinity ? given / (own().si ? 1e3 : 1) : 0 });
      request(SLOTS, false);
    },
    redraw: (...what) => { for (const each of what) dirty[each] = true; wake(); },
    open: (next) => {
      written = location.hash;
      open(next);
    },
  });
  fillDialogs(about, {
    open: (example, slot) => {
      const { document, other = null } = copy(example), sensors = example.view.sensors ?? (slot === "B" ? state.view.sensors : []);
      openAs(slot, document, other, sensors, example.view.until);
      say(example.look_for);
    },
    document: () => state[state.active],
    request: () => {
      const other = state.B && state[state.active === "A" ? "B" : "A"];
      return {
        slot: state.active, sensors: state.view.sensors, quantity: state.view.quantity, clock: state.view.clock, frames: 320,
        run_until: state.view.until, until: own().run.header?.peaks.right?.first && !state.view.until ? undefined : own().motion?.times.at(-1), other, view: { view: state.view, B: other },
      };
    },
    opened: (document) => openAs(state.active, document, null, state.view.sensors),
    say,
    link: () => (stored ? "http://127.0.0.1:8765/" : location.origin + location.pathname) + toLink(state),
  });
  play(playing);
  showAll();
  request(SLOTS, false);
}

start();
Object.assign(window, { hertzchain: { about, state, results, answers, get u() { return u; }, get playing() { return playing; },
  placeOf: (/** @type {Slot} */ slot, /** @type {number} */ bead) => stages[slot].placeOf(bead) } });
