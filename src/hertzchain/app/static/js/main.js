/** Connect the parts of the page, and ask for the first results. */

import { change, compare, moveWall, open, openAs, redo, resize, toggleSensor, undo } from "./changes.js";
import { clock, eachFrame, goTo, part, play } from "./clock.js";
import { readColours } from "./colour.js";
import { $ } from "./fields.js";
import { listen } from "./events.js";
import { fixed, stored } from "./host.js";
import { SLOTS, about, acceptAddress, own, record, results, say, state } from "./page.js";
import { handleRecords } from "./record.js";
import { answers, eachAnswer, noteShown, request } from "./requests.js";
import { fillDialogs } from "./share.js";
import { activate, changeBy, draw, redraw, repaint, select, showAll, showPart, stages, view } from "./show.js";
import { copy, toLink } from "./state.js";

/** @typedef {import("./state.js").Slot} Slot */

const narrow = matchMedia("(max-width: 700px)");
const repeat = () => request(SLOTS, false);

/** A saved page has no controls; both of its chains can still be shown by all views. */
function showSaved() {
  document.body.classList.add("saved");
  $("tabs").setAttribute("aria-label", "Chain that the views show");
  $("lane-A").before($("tabs"));
}

/** In a narrow window, the forces and the controls follow the chain, also for the keyboard. */
function arrange() {
  const controls = $("controls"), views = $("views"), force = $("chart-force").parentElement;
  if (narrow.matches) views.firstElementChild.after(force, controls);
  else {
    views.before(controls);
    $("map").closest("section").after(force);
  }
}

function handleEvents() {
  listen({
    about, state, view, request: repeat, select, toggleSensor, play: () => play(!clock.playing), goTo, step: (by) => goTo(part() + by),
    undo, redo, compare, activate, repaint, radiusOf: (bead) => own().beads.arrays.get("radii")[bead - 1], resize,
    beads: () => own().beads.header?.beads ?? 1,
    until: (given) => {
      view({ until: given > 0 && given < Infinity ? given / (own().si ? 1e3 : 1) : 0 });
      repeat();
    },
    redraw,
    open: (next) => {
      acceptAddress();
      open(next);
    },
  });
}

function handleDialogs() {
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
        run_until: state.view.until, record: record.record, until: own().run.header?.peaks.right?.first && !state.view.until ? undefined : own().motion?.times.at(-1), other, view: { view: state.view, B: other, record: { shift: record.shift } },
      };
    },
    say,
    link: () => (stored ? "http://127.0.0.1:8765/" : location.origin + location.pathname) + toLink(state),
  });
  handleRecords({
    changed: (sensors) => {
      view({ sensors });
      repeat();
    },
    shifted: () => redraw("times"),
    opened: (document) => openAs(state.active, document, null, state.view.sensors),
  });
}

if (fixed) showSaved();
narrow.onchange = arrange;
arrange();
readColours();
changeBy({ change, toggleSensor, resize, moveWall });
eachAnswer(showPart);
eachFrame(() => {
  draw();
  noteShown();
});
handleEvents();
handleDialogs();
play(clock.playing);
showAll();
repeat();
Object.assign(window, { hertzchain: { about, state, results, answers, get u() { return clock.u; }, get playing() { return clock.playing; },
  placeOf: (/** @type {Slot} */ slot, /** @type {number} */ bead) => stages[slot].placeOf(bead) } });
