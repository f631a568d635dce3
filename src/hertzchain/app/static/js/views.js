// @ts-check
/** Charts and the table of a chain's results, linked by one cursor. */

import { Chart, svg } from "./chart.js";
import { make } from "./controls.js";
import { prefixed, short } from "./numbers.js";
import { title } from "./results.js";

/** @typedef {import("./results.js").Results} Results */
/** @typedef {import("./chart.js").Series} Series */
/** @typedef {import("./state.js").State} State */

/** @param {string} id @returns {any} */
const $ = (id) => document.getElementById(id);
const MAX_ROWS = 2000;

/** @param {number} count @param {number} [first] */
function range(count, first = 1) {
  return Float64Array.from({ length: count }, (_, i) => i + first);
}

/** @param {ArrayLike<number>} values @param {number} factor */
function times(values, factor) {
  return factor === 1 ? values : Float64Array.from(values, (each) => each * factor);
}

/** @param {ArrayLike<number>} values */
function largest(values) {
  let most = 0;
  for (let i = 0; i < values.length; i++) if (Math.abs(values[i]) > most) most = Math.abs(values[i]);
  return most;
}

export class Views {
  /** @param {any} about @param {{bead: (bead: number) => void, u: (u: number) => void, hide: (name: string) => void}} on */
  constructor(about, on) {
    this.about = about;
    this.on = on;
    this.pulse = new Chart($("chart-pulse"), (x) => on.bead(Math.round(x)));
    this.error = new Chart($("chart-error"), (x) => on.bead(Math.round(x)));
    this.budget = new Chart($("chart-budget"), on.u);
    this.force = new Chart($("chart-force"), on.u);
    this.modes = new Chart($("chart-modes"), () => {});
  }

  /** @param {string} quantity @param {Results} results @param {number} most @returns {[number, string]} */
  unit(quantity, results, most) {
    const info = this.about.quantities[quantity];
    return results.si && info.unit !== "1" ? prefixed(most, info.unit) : [1, ""];
  }

  /** Leading pulse and errors. @param {State} state @param {Results} own @param {Results | null} other */
  drawPulse(state, own, other) {
    if (!own.ready) return;
    const { quantity, hidden } = state.view, info = this.about.quantities[quantity];
    const exact = own.exact(quantity), names = own.theories.map(([name]) => name);
    const shown = names.filter((name) => own.theory(name, quantity) && !hidden.includes(name));
    const compared = other?.exact(quantity);
    const all = [exact, compared, ...shown.map((name) => own.theory(name, quantity))].filter(Boolean);
    const [factor, unit] = this.unit(quantity, own, Math.max(...all.map(largest), 0));
    /** @type {Series[]} */
    const series = shown.map((name) => line(name, title(name), own.theory(name, quantity), factor));
    if (compared && other?.si === own.si && !hidden.includes("other")) series.unshift(line("other", "other chain", compared, factor));
    if (exact && !hidden.includes("exact")) series.unshift(line("exact", "simulation", exact, factor));
    const label = `${info.description}${unit ? ` [${unit}]` : ""}`;
    const message = series.length ? "" : this.reason(own, quantity);
    this.pulse.draw(series, { xLabel: info.per === "contact" ? "contact k" : "bead k", yLabel: label, log: state.view.log, message },
      `${label} along the chain: ${summary(series)}`);
    this.legend(own, other, quantity, hidden);
    this.drawErrors(state, own, other, shown);
  }

  /** Why no curve is shown. @param {Results} own @param {string} quantity */
  reason(own, quantity) {
    if (!own.pulse.header) return own.pending.length ? `Compiling ${own.pending[0]} …` : "Computing …";
    const refusal = own.theories.map(([, each]) => each.refusal).find(Boolean);
    return this.about.quantities[quantity].estimate ? "Only theories that estimate their own error have this quantity." : refusal ?? "No value";
  }

  /** @param {State} state @param {Results} own @param {Results | null} other @param {string[]} shown */
  drawErrors(state, own, other, shown) {
    const { quantity, hidden } = state.view, exact = own.exact(quantity);
    const label = "error relative to the simulation";
    if (state.view.errors === "difference") {
      replace($("legend-error"), []);
      const theirs = other?.exact(quantity);
      const common = other && other.si === own.si && exact && theirs;
      const series = common ? [difference("other", "other chain", theirs, exact)] : [];
      const message = common ? "" : other ? "Chains in SI units and in scaled variables cannot be compared." : "Choose Compare to add a second chain.";
      this.error.draw(series, { xLabel: "bead k", yLabel: "other chain relative to this one", percent: true, message }, `Difference of the chains: ${summary(series)}`);
      return;
    }
    const series = exact ? shown.map((name) => difference(name, title(name), own.theory(name, quantity), exact, true)) : [];
    const estimate = quantity === "velocity" ? own.theory("local-rate", "velocity_error") : undefined;
    if (exact && estimate && !hidden.includes("local-rate")) series.push({ ...line("estimate", "estimate of the local-rate law", estimate, 100) });
    replace($("legend-error"), series.at(-1)?.name === "estimate" ? [key("estimate", "the law’s own estimate")] : []);
    const message = series.length ? "" : !own.pulse.header ? this.reason(own, quantity) : shown.length ? "The simulation has no values to compare with." : "No theory that is shown covers this chain.";
    this.error.draw(series, { xLabel: "bead k", yLabel: label, log: true, percent: true, message, most: 1000 }, `Errors of the theories: ${summary(series)}`);
  }

  /** Buttons that show and hide curves, with the largest errors, and what is not covered.
   * @param {Results} own @param {Results | null} other @param {string} quantity @param {string[]} hidden */
  legend(own, other, quantity, hidden) {
    const exact = own.exact(quantity);
    const entry = (/** @type {string} */ name, /** @type {string} */ text, /** @type {string} */ note) => {
      const button = make("button", { type: "button", title: note, "aria-pressed": String(!hidden.includes(name)), onclick: () => this.on.hide(name) }, sample(name), text);
      button.dataset.curve = name;
      return button;
    };
    const entries = own.pulse.header && own.exact(quantity) ? [entry("exact", "simulation", own.pulse.header.method ?? "")] : [];
    if (other?.si === own.si && other?.exact(quantity)) entries.push(entry("other", "other chain", other.beads.header.description));
    /** @type {Map<string, string[]>} */
    const reasons = new Map();
    for (const [name, each] of own.theories) {
      if (own.theory(name, quantity)) {
        const error = exact && !this.about.quantities[quantity].estimate ? worst(own.theory(name, quantity), exact) : NaN;
        entries.push(entry(name, title(name) + (error >= 0 ? ` ${short(error, 2)}%` : ""), each.note || "largest error from bead 2 on"));
        if (each.note) reasons.set(each.note, [...(reasons.get(each.note) ?? []), title(name)]);
      } else {
        const reason = each.refusal ?? `has no ${this.about.quantities[quantity].description}`;
        const brief = reason.replace(/ \(chain: .*\)$/, "");
        reasons.set(brief, [...(reasons.get(brief) ?? []), title(name)]);
      }
    }
    const pressed = (/** @type {HTMLElement} */ each) => each.getAttribute("aria-pressed") === "true";
    replace($("legend-pulse"), [...entries.filter(pressed), ...entries.filter((each) => !pressed(each))]);
    const notes = [...reasons].map(([reason, names]) => make("li", {}, make("b", {}, names.join(", ")), `: ${reason}`));
    $("notes-count").textContent = notes.length ? `${notes.length} note${notes.length > 1 ? "s" : ""} on theories` : "";
    $("notes").hidden = !notes.length;
    replace($("notes-list"), notes);
  }

  /** Energy or momentum by location, and forces. @param {State} state @param {Results} own @param {Results | null} other */
  drawTimes(state, own, other) {
    const motion = own.motion;
    if (!own.ready || !motion || !own.run.header) {
      const message = own.problem ? "" : own.pending.length ? `Compiling ${own.pending[0]}: once after an installation, about a minute …` : "Computing …";
      for (const chart of [this.budget, this.force]) chart.draw([], { xLabel: "time", yLabel: "", message }, message);
      return;
    }
    const u = Float64Array.from(motion.times, (_, i) => i / (motion.count - 1)), axis = this.timeAxis(own);
    this.drawBudget(state, own, u, axis);
    this.drawForces(own, other, u, axis);
    this.drawModes(own);
  }

  /** Ticks at equal frames, with their times. @param {Results} own */
  timeAxis(own) {
    const motion = /** @type {import("./stage.js").Motion} */ (own.motion), last = motion.count - 1;
    const [factor, unit] = own.si ? prefixed(motion.times[last], "s") : [1, ""];
    const xTicks = [0, 0.2, 0.4, 0.6, 0.8, 1].map((each) => ({ at: each, text: short(motion.times[Math.round(each * last)] * factor, 3) }));
    return { factor, label: `time${unit ? ` [${unit}]` : ""}`, xTicks };
  }

  /** @param {State} state @param {Results} own @param {Float64Array} u @param {any} axis */
  drawBudget(state, own, u, axis) {
    const of = state.view.budget, arrays = own.run.arrays, prefix = `${of}.`;
    const names = [...arrays.keys()].filter((name) => name.startsWith(prefix)).map((name) => name.slice(prefix.length));
    if (!names.length) return; // Drafts of long chains have none: keep the last one.
    const unit = own.si ? (of === "energy" ? "J" : "kg m/s") : "";
    const total = Math.max(...names.map((name) => largest(arrays.get(prefix + name))));
    const [factor, shown] = prefixed(total, unit);
    const above = new Float64Array(u.length), below = new Float64Array(u.length);
    const series = names.map((name) => {
      const values = arrays.get(prefix + name), y = new Float64Array(u.length), base = new Float64Array(u.length);
      for (let i = 0; i < u.length; i++) {
        const side = values[i] < 0 ? below : above;
        base[i] = side[i];
        side[i] += values[i] * factor;
        y[i] = side[i];
      }
      return { name: `part ${name.replaceAll(" ", "-")}`, label: name, x: u, y, base };
    });
    this.budget.draw(series, { xLabel: axis.label, yLabel: `${of}${shown ? ` [${shown}]` : ""}`, xTicks: axis.xTicks }, `${of} by location: ${names.join(", ")}`);
    replace($("legend-budget"), names.map((name) => make("span", { className: "key" }, make("i", { className: `swatch part ${name.replaceAll(" ", "-")}` }), name)));
  }

  /** @param {Results} own @param {Results | null} other @param {Float64Array} u @param {any} axis */
  drawForces(own, other, u, axis) {
    const traces = forcesOf(own), theirs = other?.motion && other.si === own.si ? forcesOf(other) : [];
    const most = Math.max(...[...traces, ...theirs].map((each) => largest(each.values)), 0);
    const [factor, unit] = own.si ? prefixed(most, "N") : [1, ""];
    const series = traces.map((each) => ({ name: each.name, label: each.label, x: u, y: times(each.values, factor) }));
    for (const each of theirs) {
      const count = each.values.length;
      series.push({ name: `${each.name} faint`, label: `other chain, ${each.label}`, x: Float64Array.from({ length: count }, (_, i) => i / (count - 1)), y: times(each.values, factor) });
    }
    const message = series.length ? "" : "Click a bead for a sensor, or add a wall.";
    this.force.draw(series, { xLabel: axis.label, yLabel: `force${unit ? ` [${unit}]` : ""}`, xTicks: axis.xTicks, message }, `Forces: ${summary(series)}`);
    const peaks = own.run.header.peaks;
    replace($("legend-force"), traces.map((each) => {
      const peak = peaks[each.key], text = peak.first !== null ? `${each.side ? "peak" : "first maximum"} ${short(peak.first * factor)}` : `largest so far ${short((peak.largest ?? 0) * factor)}`;
      return key(each.name, `${each.label}: ${text}${unit ? ` ${unit}` : ""}`);
    }));
  }

  /** Frequencies of small oscillations. @param {Results} own */
  drawModes(own) {
    const frequencies = own.run.arrays.get("modes.frequency"), message = own.run.header.spectrum;
    if (own.run.header.draft && !frequencies && !message) return;
    const [factor, unit] = frequencies && own.si ? prefixed(largest(frequencies), "Hz") : [1, ""];
    const series = frequencies ? [{ name: "modes", label: "modes", x: range(frequencies.length), y: times(frequencies, factor), points: true }] : [];
    this.modes.draw(series, { xLabel: "mode", yLabel: `frequency${unit ? ` [${unit}]` : ""}`, message: frequencies ? "" : `No spectrum: ${message}.`.replace(/\.\.$/, ".") }, frequencies ? `Spectrum: ${summary(series)}` : "No spectrum");
  }

  /** @param {number} bead @param {number} u */
  cursor(bead, u) {
    this.pulse.cursor(bead || null);
    this.error.cursor(bead || null);
    this.budget.cursor(u);
    this.force.cursor(u);
  }

  /** @param {State} state @param {Results} own */
  drawTable(state, own) {
    if (!own.ready) return;
    const { quantity } = state.view, info = this.about.quantities[quantity];
    const unit = (/** @type {string} */ text) => (own.si && text !== "1" ? ` [${text}]` : "");
    const columns = /** @type {[string, any][]} */ ([[`radius${unit("m")}`, own.beads.arrays.get("radii")], [`mass${unit("kg")}`, own.beads.arrays.get("masses")],
      ...["velocity", "arrival", "residence", "peak_force"].map((name) => [`${name.replace("_", " ")}${unit(this.about.quantities[name].unit)}`, own.exact(name)]),
      ...own.theories.map(([name]) => [`${quantity.replace("_", " ")}, ${title(name)}${unit(info.unit)}`, own.theory(name, quantity)])]).filter(([, values]) => values);
    const head = make("tr", {}, ...["bead", ...columns.map(([name]) => name)].map((text) => make("th", { scope: "col" }, text)));
    const rows = Array.from({ length: Math.min(own.beads.header.beads, MAX_ROWS) }, (_, k) => {
      const row = make("tr", { className: k + 1 === state.view.bead ? "chosen" : "" }, make("th", { scope: "row" }, String(k + 1)));
      for (const [, values] of columns) row.append(make("td", {}, k < values.length && Number.isFinite(values[k]) ? String(+values[k].toPrecision(7)) : ""));
      return row;
    });
    $("table").replaceChildren(make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)));
  }
}

/** A piece of a curve. @param {string} name */
function sample(name) {
  const drawing = svg("svg", { viewBox: "0 0 26 8", class: "sample", "aria-hidden": "true" });
  drawing.append(svg("path", { class: `line ${name}`, d: "M1 4H25" }));
  return drawing;
}

/** @param {string} name @param {string} text */
function key(name, text) {
  return make("span", { className: "key" }, sample(name), text);
}

/** Replace children only if they differ, so that a button in use is not replaced.
 * @param {HTMLElement} host @param {HTMLElement[]} children */
function replace(host, children) {
  const fresh = make("div", {}, ...children);
  if (fresh.innerHTML !== host.innerHTML) {
    const focused = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset.curve;
    host.replaceChildren(...children);
    if (focused) /** @type {HTMLElement | null} */ (host.querySelector(`[data-curve="${focused}"]`))?.focus();
  }
}

/** @param {string} name @param {string} label @param {ArrayLike<number>} values @param {number} factor @returns {Series} */
function line(name, label, values, factor) {
  return { name, label, x: range(values.length), y: times(values, factor) };
}

/** Relative difference in percent, as `Comparison.errors` defines it.
 * @param {string} name @param {string} label @param {ArrayLike<number>} values @param {ArrayLike<number>} reference
 * @param {boolean} [absolute] @returns {Series} */
function difference(name, label, values, reference, absolute = false) {
  const count = Math.min(values.length, reference.length), y = new Float64Array(count);
  for (let i = 0; i < count; i++) {
    const error = (100 * (values[i] - reference[i])) / (reference[i] === 0 ? 1 : reference[i]);
    y[i] = absolute ? Math.abs(error) : error;
  }
  return { name, label, x: range(count), y };
}

/** @param {Results} results */
function forcesOf(results) {
  const sensors = results.run.header.sensors, found = [];
  for (const [key, values] of results.run.arrays) {
    const name = key.startsWith("force.") ? key.slice(6) : "";
    if (!name) continue;
    const side = name === "left" || name === "right";
    found.push({ key: name, side, values, name: side ? `wall-${name}` : `sensor${sensors.indexOf(Number(name))}`, label: side ? `${name} wall` : `sensor in bead ${name}` });
  }
  return found;
}

/** Largest error from bead 2 on in percent, as `Comparison.worst`; NaN if there is none.
 * @param {ArrayLike<number>} values @param {ArrayLike<number>} exact */
function worst(values, exact) {
  const { y } = difference("", "", values, exact, true);
  let most = NaN;
  for (let i = 1; i < y.length; i++) if (!(y[i] <= most) && Number.isFinite(y[i])) most = y[i];
  return most;
}

/** Curves in words. @param {Series[]} series */
function summary(series) {
  return series.map((each) => {
    const last = each.y[each.y.length - 1];
    return `${each.label}, at the end ${short(last)}, largest ${short(largest(each.y))}`;
  }).join("; ") || "no curves";
}
