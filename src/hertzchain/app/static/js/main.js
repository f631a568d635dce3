/** Connect the parts of the page and its events, and ask for the first results. */

import { clock, eachFrame, goTo, part, play } from "./clock.js";
import { readColours } from "./colour.js";
import { $, make } from "./fields.js";
import { fixed } from "./host.js";
import { SLOTS, about, acceptAddress, own, results, state } from "./page.js";
import { handleRecords } from "./record.js";
import { answers, eachAnswer, noteShown, request } from "./requests.js";
import { fillDialogs } from "./share.js";
import { activate, compare, draw, grow, open, openAs, redo, redraw, repaint, select, showAll, showPart, stages, toggleSensor, undo, view } from "./show.js";
import { SELECTS, fromLink } from "./state.js";

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

const toggle = () => play(!clock.playing);

function listen() {
  for (const name of Object.keys(about.quantities)) {
    if (!about.quantities[name].estimate) $("quantity").append(make("option", { value: name }, name.replaceAll("_", " ")));
  }
  for (const [id, name, again] of SELECTS) {
    $(id).onchange = () => {
      view({ [name]: $(id).value });
      if (again) repeat();
    };
  }
  $("speed").onchange = () => view({ speed: Number($("speed").value) });
  $("log").onchange = () => view({ log: $("log").checked });
  $("bead").onchange = () => select(Math.round(Number($("bead").value)) || 1);
  $("until").onchange = () => {
    // Times that cannot be used are not shown any longer, as the run ends by itself.
    if (!(Number($("until").value) > 0)) $("until").value = "";
    view({ until: Number($("until").value) / (own().si ? 1e3 : 1) });
    repeat();
  };
  $("sensor").onclick = toggleSensor;
  $("play").onclick = toggle;
  $("time").oninput = () => goTo(Number($("time").value) / 1000);
  $("undo").onclick = undo;
  $("redo").onclick = redo;
  $("compare").onclick = compare;
  for (const slot of SLOTS) $(`tab-${slot}`).onclick = () => activate(slot);
  $("theme").onclick = () => {
    const root = document.documentElement, dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    repaint();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  $("table-details").ontoggle = () => redraw("table");
  const sizes = new ResizeObserver(() => redraw("pulse", "times"));
  for (const plot of document.querySelectorAll(".plot")) sizes.observe(plot);
  addEventListener("hashchange", () => {
    const next = fromLink(location.hash);
    if (!next) return;
    acceptAddress();
    open(next);
  });
  addEventListener("input", ({ target }) => { if (target) edited.add(target); }, true);
  addEventListener("change", ({ target }) => { if (target) edited.delete(target); }, true);
  addEventListener("keydown", keys);
}

/** Fields whose text is not complete, in which the browser undoes letters.
 * @type {WeakSet<EventTarget>} */
const edited = new WeakSet();

/** @param {KeyboardEvent} event */
function keys(event) {
  const target = /** @type {HTMLElement} */ (event.target), typing = target.matches("input:not([type=range]):not([type=checkbox])");
  if (document.querySelector("dialog[open]")) return;
  if ((event.ctrlKey || event.metaKey) && !edited.has(target) && event.key.toLowerCase() === "z") {
    event.preventDefault();
    if (event.shiftKey) redo();
    else undo();
    return;
  }
  if (event.ctrlKey || event.metaKey || event.altKey || typing || (target.matches("select") && event.key !== "?")) return;
  const onStage = target.matches(".lane");
  if (onStage && /^(Arrow|Home|End)/.test(event.key)) activate(/** @type {any} */ (target.id.slice(-1)));
  const { bead, camera } = state.view, move = (/** @type {number} */ by) => goTo(part() + by);
  /** @type {Record<string, () => void>} */
  const actions = {
    " ": toggle, ",": () => move(-1 / 320), ".": () => move(1 / 320), s: toggleSensor,
    f: () => view({ camera: camera === "follow" ? "whole" : "follow" }), "?": () => $("help").showModal(),
    ...(onStage ? {
      ArrowLeft: () => select(bead - 1), ArrowRight: () => select(bead + 1),
      Home: () => select(1), End: () => select(Infinity),
      ArrowUp: () => grow(1.05), ArrowDown: () => grow(1 / 1.05),
    } : {}),
  };
  if (event.key === " " && target.matches("button, summary, input")) return;
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

if (fixed) showSaved();
narrow.onchange = arrange;
arrange();
readColours();
eachAnswer(showPart);
eachFrame(() => {
  draw();
  noteShown();
});
listen();
fillDialogs();
handleRecords({
  changed: (sensors) => {
    view({ sensors });
    repeat();
  },
  shifted: () => redraw("times"),
  opened: (document) => openAs(state.active, document, null, state.view.sensors),
});
play(clock.playing);
showAll();
repeat();
Object.assign(window, { hertzchain: { about, state, results, answers, get u() { return clock.u; }, get playing() { return clock.playing; },
  placeOf: (/** @type {Slot} */ slot, /** @type {number} */ bead) => stages[slot].placeOf(bead) } });
