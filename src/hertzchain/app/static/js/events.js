/** Events of the page: its choices, buttons and keys. */

import { $, make } from "./fields.js";
import { fromLink } from "./state.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {"pulse" | "times" | "map" | "table"} Part */
/** @typedef {{about: any, state: State, view: (some: any) => void, request: () => void, select: (bead: number) => void,
 *   toggleSensor: () => void, play: () => void, goTo: (u: number) => void, step: (by: number) => void, until: (given: number) => void,
 *   undo: () => void, redo: () => void, compare: () => void, activate: (slot: "A" | "B") => void, repaint: () => void,
 *   radiusOf: (bead: number) => number, resize: (bead: number, radius: number, moving: boolean) => void,
 *   beads: () => number, redraw: (...what: Part[]) => void, open: (next: State) => void}} App */

/** Choices of the view; another clock needs another run.
 * @type {[string, keyof import("./state.js").View, boolean?][]} */
export const SELECTS = [["quantity", "quantity"], ["camera", "camera"], ["map-of", "map"], ["map-scale", "scale"], ["budget-of", "budget"], ["force-scale", "forces"], ["errors", "errors"], ["clock", "clock", true]];

/** @param {App} app */
export function listen(app) {
  const { about, view } = app;
  for (const name of Object.keys(about.quantities)) {
    if (!about.quantities[name].estimate) $("quantity").append(make("option", { value: name }, name.replaceAll("_", " ")));
  }
  for (const [id, name, again] of SELECTS) {
    $(id).onchange = () => {
      view({ [name]: $(id).value });
      if (again) app.request();
    };
  }
  $("speed").onchange = () => view({ speed: Number($("speed").value) });
  $("log").onchange = () => view({ log: $("log").checked });
  $("bead").onchange = () => app.select(Math.max(1, Math.min(app.beads(), Math.round(Number($("bead").value)) || 1)));
  $("until").onchange = () => {
    // Times that cannot be used are not shown any longer, as the run ends by itself.
    if (!(Number($("until").value) > 0)) $("until").value = "";
    app.until(Number($("until").value));
  };
  $("sensor").onclick = app.toggleSensor;
  $("play").onclick = () => app.play();
  $("time").oninput = () => app.goTo(Number($("time").value) / 1000);
  $("undo").onclick = app.undo;
  $("redo").onclick = app.redo;
  $("compare").onclick = app.compare;
  for (const slot of /** @type {const} */ (["A", "B"])) $(`tab-${slot}`).onclick = () => app.activate(slot);
  $("theme").onclick = () => {
    const root = document.documentElement, dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    app.repaint();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", app.repaint);
  $("table-details").ontoggle = () => app.redraw("table");
  const sizes = new ResizeObserver(() => app.redraw("pulse", "times"));
  for (const plot of document.querySelectorAll(".plot")) sizes.observe(plot);
  addEventListener("hashchange", () => {
    const next = fromLink(location.hash);
    if (next) app.open(next);
  });
  addEventListener("input", ({ target }) => { if (target) edited.add(target); }, true);
  addEventListener("change", ({ target }) => { if (target) edited.delete(target); }, true);
  addEventListener("keydown", (event) => keys(event, app));
}

/** Fields whose text is not complete, in which the browser undoes letters.
 * @type {WeakSet<EventTarget>} */
const edited = new WeakSet();

/** @param {KeyboardEvent} event @param {App} app */
function keys(event, app) {
  const target = /** @type {HTMLElement} */ (event.target), typing = target.matches("input:not([type=range]):not([type=checkbox])");
  if (document.querySelector("dialog[open]")) return;
  if ((event.ctrlKey || event.metaKey) && !edited.has(target) && event.key.toLowerCase() === "z") {
    event.preventDefault();
    if (event.shiftKey) app.redo();
    else app.undo();
    return;
  }
  if (event.ctrlKey || event.metaKey || event.altKey || typing || (target.matches("select") && event.key !== "?")) return;
  const onStage = target.matches(".lane");
  if (onStage && /^(Arrow|Home|End)/.test(event.key)) app.activate(/** @type {any} */ (target.id.slice(-1)));
  const { bead, camera } = app.state.view, beads = app.beads();
  /** @type {Record<string, () => void>} */
  const actions = {
    " ": () => app.play(), ",": () => app.step(-1 / 320), ".": () => app.step(1 / 320), s: app.toggleSensor,
    f: () => app.view({ camera: camera === "follow" ? "whole" : "follow" }), "?": () => $("help").showModal(),
    ...(onStage ? {
      ArrowLeft: () => app.select(Math.max(1, bead - 1)), ArrowRight: () => app.select(Math.min(beads, bead + 1)),
      Home: () => app.select(1), End: () => app.select(beads),
      ArrowUp: () => app.resize(bead, app.radiusOf(bead) * 1.05, false),
      ArrowDown: () => app.resize(bead, app.radiusOf(bead) / 1.05, false),
    } : {}),
  };
  if (event.key === " " && target.matches("button, summary, input")) return;
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}
