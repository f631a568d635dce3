/** Charts and the table of a chain's results, linked by one cursor. */

import { CIRCLE, Chart, svg } from "./chart.js";
import { $, make } from "./fields.js";
import { fixed } from "./host.js";
import { full, percent, placeAt, prefixed, short } from "./numbers.js";
import { record } from "./page.js";
import { title } from "./results.js";

/** @typedef {import("./results.js").Results} Results */
/** @typedef {import("./chart.js").Series} Series */
/** @typedef {import("./state.js").State} State */

/** @param {number} count */
const range = (count) => Float64Array.from({ length: count }, (_, i) => i + 1);

/** @param {ArrayLike<number>} values @param {number} factor */
const times = (values, factor) => factor === 1 ? values : Float64Array.from(values, (each) => each * factor);

/** @param {ArrayLike<number>} values */
const pairs = (values) => Array.from({ length: values.length / 2 }, (_, i) => [values[2 * i], values[2 * i + 1]]);

/** @param {ArrayLike<number>} values */
function largest(values) {
  let most = 0;
  for (let i = 0; i < values.length; i++) if (Math.abs(values[i]) > most && Number.isFinite(values[i])) most = Math.abs(values[i]);
  return most;
}

const SIMULATION = "simulation", RELATIVE = "(B − A) / A";
/** Letters before names of curves. @param {State} state */
const letters = ({ active, B }) => !B ? ["", ""] : active === "A" ? ["A, ", "B, "] : ["B, ", "A, "];

/** Final velocities below this part of the largest are 0: they are errors of the simulation. */
const AT_REST = 1e-7;
/** Words of peaks with contacts that yield, and labels of those at the largest yield pressure. */
const OF_YIELD = /yield|at [\d.]+ Y/, AT_MOST = /2\.8 Y/;
/** Ratio of the durations of two runs from which the shorter one is shown alone. */
const MUCH = 3;
const BEADS = { xLabel: "bead k", counted: true };

export class Views {
  /** @param {any} about @param {{bead: (bead: number) => void, time: (time: number) => void, hide: (name: string) => void, range: (range: number[]) => void}} on */
  constructor(about, on) {
    this.about = about;
    this.on = on;
    this.pulse = new Chart($("chart-pulse"), (x) => on.bead(Math.round(x)));
    this.error = new Chart($("chart-error"), (x) => on.bead(Math.round(x)));
    this.factor = 1;
    const picked = (/** @type {number} */ x) => on.time(x / this.factor);
    this.budget = new Chart($("chart-budget"), picked);
    this.force = new Chart($("chart-force"), picked);
    this.cut = false;
    this.zoom = (/** @type {number[] | null} */ range) => on.range(range ? range.map((x) => +(x / this.factor).toPrecision(6)) : this.cut ? [0] : []);
    for (const chart of [this.budget, this.force]) chart.zoomable(this.zoom);
    $("whole").onclick = () => {
      this.zoom(null);
      $("chart-force").focus();
    };
    this.modes = new Chart($("chart-modes"), () => {});
    this.waves = new Chart($("chart-waves"), () => {});
  }

  /** Leading pulse and errors. @param {State} state @param {Results} own @param {Results | null} other */
  drawPulse(state, own, other) {
    if (!own.ready) return;
    const { quantity, hidden } = state.view, info = this.about.quantities[quantity];
    const exact = own.exact(quantity), names = own.theories.map(([name]) => name);
    const shown = names.filter((name) => own.theory(name, quantity) && !hidden.includes(name));
    const compared = theirs(own, other, quantity);
    const all = [exact, compared, ...shown.map((name) => own.theory(name, quantity))].filter(Boolean);
    const [factor, unit] = own.si ? prefixed(Math.max(...all.map(largest), 0), info.unit) : [1, ""], [mine, their] = letters(state);
    /** @type {Series[]} */
    const series = shown.map((name) => line(name, mine + title(name), own.theory(name, quantity), factor));
    if (compared && !hidden.includes("other")) series.unshift(line("other", their + SIMULATION, compared, factor));
    if (exact && !hidden.includes("exact")) series.unshift(line("exact", mine + SIMULATION, exact, factor));
    for (const each of series) each.apart = each.name === "other" ? jumps(other, other?.exact(quantity)) : jumps(own, each.y);
    const label = inUnit(info.description, unit);
    const message = series.length ? "" : this.reason(own);
    if (state.active === "B" && series[1]?.name === "other") series.unshift(...series.splice(1, 1));
    this.pulse.draw(series, { xLabel: info.per === "contact" ? "contact k" : series.some((each) => each.apart) ? "bead k (dot: free end)" : "bead k", counted: true, yLabel: label, log: state.view.log, message },
      `${label} along the chain: ${summary(series)}`);
    this.legend(own, other, state);
    this.drawErrors(state, own, other, shown);
    for (const [name, { note }] of own.theories) for (const each of document.querySelectorAll(`.plot .${name}`)) each.classList.toggle("pale", !!note);
  }

  /** @param {Results} own */
  reason(own) {
    if (!own.pulse.header) return whyBlank(own);
    const refusal = own.theories.map(([, each]) => each.refusal).find(Boolean);
    return refusal ?? "No value";
  }

  /** @param {State} state @param {Results} own @param {Results | null} other @param {string[]} shown */
  drawErrors(state, own, other, shown) {
    const { quantity, hidden } = state.view, exact = own.exact(quantity);
    const card = $("h-error").closest("section");
    card.hidden = false;
    if (state.view.errors === "difference") {
      const late = [own, other].find((each) => each && !each.pulse.header);
      if (!other || late) replace($("legend-error"), []);
      const compared = exact && inner(other, theirs(own, other, quantity), quantity), mine = inner(own, exact, quantity), [a, b] = state.active === "A" ? [mine, compared] : [compared, mine];
      const series = compared ? [difference("other", RELATIVE, b, a)] : [];
      const message = compared ? "" : !other ? "Choose Compare to add a second chain." : late ? whyBlank(late) : other.si === own.si ? "No value" : "Chains in SI units and in scaled variables cannot be compared.";
      this.error.draw(series, { ...BEADS, yLabel: `${quantity.replaceAll("_", " ")}: ${RELATIVE}`, percent: true, message }, `Difference of the chains: ${summary(series)}`);
      return;
    }
    const known = inner(own, exact, quantity);
    const series = exact ? shown.map((name) => difference(name, title(name), own.theory(name, quantity), known, true)) : [];
    const estimate = quantity === "velocity" ? own.theory("local-rate", "velocity_error") : undefined;
    if (exact && estimate && !hidden.includes("local-rate")) series.push(line("estimate", "estimate of the local-rate law", estimate.slice(0, known.length), 100));
    replace($("legend-error"), series.at(-1)?.name === "estimate" ? [key("estimate", "error estimated by the law")] : []);
    card.hidden = !series.length && !other && !!own.pulse.header;
    const message = series.length ? "" : !own.pulse.header ? this.reason(own) : shown.length ? "No values to compare with." : "None of the theories shown supports this chain.";
    this.error.draw(series, { ...BEADS, yLabel: "error relative to the simulation", log: true, percent: true, message, most: 1000 }, `Errors of the theories: ${summary(series)}`);
  }

  /** Buttons that show and hide curves, and notes.
   * @param {Results} own @param {Results | null} other @param {State} state */
  legend(own, other, state) {
    const { quantity, hidden } = state.view, [mine, their] = letters(state);
    // Theories do not describe the last bead of a free end.
    const exact = own.exact(quantity), free = ends(own, exact);
    const entry = (/** @type {string} */ name, /** @type {string} */ text, /** @type {string} */ note) => {
      const button = make("button", { title: note, "aria-pressed": String(!hidden.includes(name)), onclick: () => this.on.hide(name) }, sample(name), text);
      button.dataset.curve = name;
      return button;
    };
    const entries = own.pulse.header && exact ? [entry("exact", mine + SIMULATION, own.pulse.header.method ?? "")] : [];
    if (theirs(own, other, quantity)) entries[state.active === "A" ? "push" : "unshift"](entry("other", their + SIMULATION, other?.beads.header.description));
    /** @type {Map<string, string[]>} */
    const reasons = new Map();
    for (const [name, each] of own.theories) {
      if (own.theory(name, quantity)) {
        const error = exact ? worst(own.theory(name, quantity), exact, free) : NaN;
        entries.push(entry(name, mine + title(name) + (error >= 0 ? ` ${percent(error, 2)}` : ""), each.note || `largest error from bead 2 on${free ? ", without the last bead" : ""}`));
        if (each.note) reasons.set(each.note, [...(reasons.get(each.note) ?? []), title(name)]);
      } else {
        const reason = each.refusal ?? `has no ${this.about.quantities[quantity].description}`;
        reasons.set(reason, [...(reasons.get(reason) ?? []), title(name)]);
      }
    }
    const off = (/** @type {HTMLElement} */ each) => Number(each.getAttribute("aria-pressed") === "false");
    replace($("legend-pulse"), entries.sort((a, b) => off(a) - off(b)));
    const notes = [...reasons].map(([reason, names]) => make("li", {}, make("b", {}, names.join(", ")), `: ${reason}`));
    const missing = new Set([...reasons.keys()].map((reason) => reason.replace(/.* does not support /, ""))), none = missing.size === 1 ? `No theory supports ${[...missing][0]}` : "No theory supports this chain";
    $("notes-count").textContent = own.theories.every(([, { refusal }]) => refusal) ? none : notes.length ? `${notes.length} note${notes.length > 1 ? "s" : ""} on theories` : "";
    $("notes").hidden = !notes.length;
    replace($("notes-list"), notes);
  }

  /** Energy or momentum by location, and forces. @param {State} state @param {Results} own @param {Results | null} other */
  drawTimes(state, own, other) {
    const motion = own.motion;
    if (!own.ready || !motion || !own.run.header) {
      const message = whyBlank(own);
      for (const chart of [this.budget, this.force, this.modes]) chart.draw([], { xLabel: "time", yLabel: "", message }, message);
      for (const id of ["modes", "force", "budget"]) replace($(`legend-${id}`), []);
      return;
    }
    const axis = this.rangeOf(state, own, other, this.timeAxis(own)), x = times(motion.times, axis.factor);
    this.factor = axis.factor;
    $("whole").hidden = !axis.range;
    for (const each of document.querySelectorAll(".coarse")) each.textContent = own.run.header.coarse;
    this.drawBudget(state, own, x, axis);
    this.drawForces(state, own, other, axis);
    this.drawNumbers(state, own, other);
    this.drawModes(own);
  }

  /** @param {Results} own */
  timeAxis(own) {
    const [factor, unit] = own.si && own.motion ? prefixed(own.motion.times[own.motion.count - 1], "s") : [1, ""];
    return { factor, unit, label: inUnit("time", unit) };
  }

  /** Range of time that is shown: the chosen one, or that of a chain whose run is much shorter than the other's.
   * @param {State} state @param {Results} own @param {Results | null} other @param {any} axis */
  rangeOf({ view, active }, own, other, axis) {
    const ends = [own, ...(other?.si === own.si ? [other] : [])].map(({ motion }) => motion?.times.at(-1) ?? 0), most = Math.max(...ends);
    const [low, high] = view.range, chosen = low >= 0 && low < high && low < most;
    this.cut = ends[0] < most / MUCH;
    if (!chosen && (view.range.length || !this.cut)) return axis;
    const letter = active === "A" ? "B" : "A", label = chosen ? axis.label : `${axis.label} (${letter} until ${short(most * axis.factor)})`;
    return { ...axis, label, range: (chosen ? [low, Math.min(high, most)] : [0, ends[0]]).map((time) => time * axis.factor) };
  }

  /** @param {State} state @param {Results} own @param {ArrayLike<number>} x @param {any} axis */
  drawBudget(state, own, x, { label: xLabel, range }) {
    const of = state.view.budget, arrays = own.run.arrays, prefix = `${of}.`;
    const names = [...arrays.keys()].filter((name) => name.startsWith(prefix)).map((name) => name.slice(prefix.length));
    if (!names.length && own.run.header.draft) return; // Drafts of long chains have none: keep the last one.
    const unit = own.si ? (of === "energy" ? "J" : "N s") : "";
    const total = Math.max(...names.map((name) => largest(arrays.get(prefix + name))));
    const [factor, shown] = prefixed(total, unit);
    const count = x.length, above = new Float64Array(count), below = new Float64Array(count);
    const series = names.map((name) => {
      const values = arrays.get(prefix + name), y = new Float64Array(count), base = new Float64Array(count);
      for (let i = 0; i < count; i++) {
        const side = values[i] < 0 ? below : above;
        base[i] = side[i];
        side[i] += values[i] * factor;
        y[i] = side[i];
      }
      return { name: `part ${name.replaceAll(" ", "-")}`, label: name, x, y, base };
    });
    const note = of === "energy" && own.run.header.over_static, message = names.length ? "" : "Nothing moves.";
    this.budget.draw(series, { xLabel, range, yLabel: inUnit(note ? "excess energy" : of, shown), message }, `${of} by location: ${names.join(", ")}`);
    replace($("legend-budget"), names.map((name) => make("span", { className: "key", title: this.about.parts[name] }, make("i", { className: `swatch part ${name.replaceAll(" ", "-")}` }), name)).concat(note || []));
  }

  /** Forces of both chains at their times. @param {State} state @param {Results} own @param {Results | null} other @param {any} axis */
  drawForces(state, own, other, axis) {
    const scale = state.view.forces, [mine, their] = letters(state);
    const traces = forcesOf(own), all = [...traces, ...(other?.motion && other.si === own.si ? forcesOf(other) : [])], most = Math.max(...all.flatMap(({ shown }) => shown.map(([, force]) => force)), 0), [factor, unit] = own.si ? prefixed(most, "N") : [1, ""];
    const scaled = (/** @type {number[]} */ y, base = y[0]) => scale === "change" ? y.map((each) => (each - base) * factor) : scale === "log" ? y.map((each) => Math.max(each, 1e-4 * most) * factor) : times(y, scale === "each" ? 1 / (largest(y) || 1) : factor);
    const series = all.map((each, i) => {
      const x = [...each.times], y = [...each.values];
      const [faint, label] = i < traces.length ? ["", mine + each.label] : [" faint", their + each.label];
      /** @type {any} */
      let last;
      const notes = each.shown.map(([what, force, time], nth) => {
        if (last === time && time !== null) return `the ${what}`;
        last = time;
        const text = `${what} ${full(force * factor)} ${unit}`;
        if (time === null) return nth === 1 && full(force) === full(each.shown[0][1]) ? `${what}: the same` : text;
        // It may be between saved times.
        const next = Math.ceil(placeAt(x, time) * (x.length - 1));
        x.splice(next, 0, time);
        y.splice(next, 0, force);
        return `${text} at ${full(time * axis.factor)} ${axis.unit}`.trim();
      });
      for (const [what, value, unit] of each.impact ?? []) {
        const [factor, shown] = own.si ? prefixed(value, unit) : [1, ""];
        notes.push(`${what} ${value === null ? "…" : `${full(value * factor)} ${shown}`}`.trim());
      }
      if (each.remark) notes.push(each.remark);
      return { name: each.name + faint, label, x: times(x, axis.factor), y: scaled(y), note: `${label}: ${notes.join("; ")}` };
    });
    if (state.active === "B") series.unshift(...series.splice(traces.length));
    const data = measured(own, axis.factor).map((each) => ({ ...each, y: scaled(Array.from(each.y), each.rest) }));
    const message = series.length ? "" : "Click a bead for a sensor, or add a wall.";
    this.force.draw([...series, ...data], { xLabel: axis.label, range: axis.range, yLabel: scale === "each" ? "force, relative to the largest of each curve" : inUnit(scale === "change" ? "change from the force at t = 0" : "force", unit), log: scale === "log", message }, `Forces: ${summary([...series, ...data])}`);
    replace($("legend-force"), [...series.map(({ name, note }) => key(name, note)), ...data.map(({ name, note }) => key(name, note))]);
  }

  /** Main numbers of both chains, and their ratios. @param {State} state @param {Results} own @param {Results | null} other */
  drawNumbers(state, own, other) {
    if (state.view.errors !== "difference" || !own.run.header || !other?.run.header || own.si !== other.si) return;
    /** @type {Map<string, any[]>} */
    const found = new Map();
    const chains = state.active === "A" ? [own, other] : [other, own], alike = own.beads.header.strikers === other.beads.header.strikers;
    const open = chains.flatMap(forcesOf).some(({ shown: [[words]] }) => /^la/.test(words));
    chains.forEach((chain, i) => {
      const numbers = forcesOf(chain).flatMap(({ label, ball = label, shown, impact = [] }) => [...shown.flatMap(([words, force, time]) => {
        // A complete peak is compared with the largest force of another run.
        const what = words.replace(open ? /^(peak$|largest.*)/ : /^largest.*/, "largest").replace(/^at/, "peak if contacts yield at");
        return [[what, force, "N"], [`time of ${what}`, time, "s"]];
      }), ...impact.map(([what, ...each]) => [what.replace(/ above.*/, ""), ...each])].filter(([, value]) => value !== null).map(([what, value, unit]) => [`${alike ? label : ball}, ${what}`, unit, value]));
      numbers.push(["velocity of the last bead", "m/s", chain.exact("velocity")?.at(-1)], ["arrival there", "s", chain.exact("arrival")?.at(-1)]);
      // The peak without yield is compared with that with yield.
      for (const [label, unit, value] of numbers) found.set(label, Object.assign(found.get(label) ?? [unit, ...chains.map(({ run }) => withoutYield(label, run.header.peaks.right ?? run.header.peaks.body))], { [i + 1]: value ?? NaN }));
    });
    const rows = [...found].map(([label, [unit, a, b]]) => {
      const same = [...found.values()].flatMap(([each, ...values]) => (each === unit ? values.filter(Number.isFinite) : []));
      const [factor, shown] = own.si ? prefixed(unit === "s" ? own.run.arrays.get("times").at(-1) : largest(same), unit) : [1, ""];
      return [inUnit(label, shown), full(a * factor), full(b * factor), full(b / a)];
    });
    replace($("legend-error"), [table(["chain", "A", "B", "B / A"], rows)]);
  }

  /** @param {Results} own */
  drawModes(own) {
    const frequencies = own.run.arrays.get("modes.frequency"), message = own.run.header.spectrum;
    if (own.run.header.draft && !frequencies && !message) return;
    const [factor, unit] = frequencies && own.si ? prefixed(largest(frequencies), "Hz") : [1, ""];
    const series = frequencies ? [{ name: "modes", label: "modes", x: range(frequencies.length), y: times(frequencies, factor), points: true }] : [];
    // Chains that do not repeat have no bands.
    const [gaps, waves] = ["gaps", "waves"].map((each) => own.run.arrays.get(`modes.${each}`) ?? []), shaded = times(gaps, factor), { bands: text, phases } = own.run.header;
    // The frequency of the highest mode may be above all bands.
    const axes = { yLabel: inUnit("frequency", unit), shaded: pairs(shaded), top: text && 1.15 * Math.max(factor * largest(frequencies), shaded[shaded.length - 2]) };
    this.modes.draw(series, { ...axes, xLabel: "mode", counted: true, message: frequencies ? "" : `No spectrum: ${message}.` }, frequencies ? `Spectrum: ${summary(series)}` : "No spectrum");
    $("chart-waves").hidden = !waves.length;
    const x = range(phases ?? 0).map((i) => (i - 1) / (phases - 1)), all = [...range(waves.length / phases || 0)];
    this.waves.draw(all.map((i) => ({ ...line("modes", `band ${i}`, waves.slice((i - 1) * phases, i * phases), factor), x })), { ...axes, xLabel: "phase from cell to cell / π" }, `Plane waves: ${text}`);
    replace($("legend-modes"), text ? [make("span", { className: "key" }, make("i", { className: "swatch shade" }), "no plane waves"), text] : []);
  }

  /** @param {number} bead @param {number} time */
  cursor(bead, time) {
    this.pulse.cursor(bead || null);
    this.error.cursor(bead || null);
    this.budget.cursor(time * this.factor);
    this.force.cursor(time * this.factor);
  }

  /** @param {State} state @param {Results} own */
  drawTable(state, own) {
    if (!own.ready) return;
    const { quantity } = state.view, info = this.about.quantities[quantity];
    const column = (/** @type {string} */ name, /** @type {any} */ values, unit = "1", empty = "", of = "") => {
      const [factor, shown] = own.si && values ? prefixed(largest(values), unit) : [1, ""];
      return { head: inUnit(name.replace("_", " ") + of, shown), values: values && times(values, factor), empty };
    };
    const final = own.run.arrays.get("final") ?? [], { arrays } = own.beads, columns = [column("radius", arrays.get("radii"), "m"), column("mass", times(arrays.get("masses"), own.si ? 1e3 : 1), "g"),
      ...["velocity", "arrival", "residence"].map((name) => column(name, own.exact(name), this.about.quantities[name].unit, "", ", leading pulse")),
      column("velocity at the end", final.map((/** @type {number} */ each) => Math.abs(each) < AT_REST * largest(final) ? 0 : each), "m/s", "–"),
      ...[["largest_force", "N"], ["largest pressure / yield", "1", "yield_ratio"], ["dent", "m"]].map(([name, unit, key = name]) => column(`${name}, contact k`, own.run.arrays.get(key), unit)), ...own.theories.map(([name]) => column(`${quantity}, ${title(name)}`, own.theory(name, quantity), info.unit))].filter(({ values }) => values);
    const rows = Array.from({ length: own.beads.header.beads }, (_, k) => [String(k + 1),
      ...columns.map(({ values, empty }) => (k < values.length && Number.isFinite(values[k]) ? String(+values[k].toPrecision(7)) : empty))]);
    const closed = own.run.header?.closed;
    $("table").replaceChildren(table(["bead", ...columns.map(({ head }) => head)], rows, state.view.bead - 1),
      ...[own.pulse.header?.table_note, closed && `Velocity at the end: ${closed}${fixed ? "" : "; increase “Run until”"}.`].filter(Boolean).map((text) => make("p", {}, text)));
  }
}

/** Why a chain has no results yet. @param {Results} own */
export const whyBlank = (own) => own.problem ? "" : own.pending.length ? `Compiling ${own.pending[0]}: once after an installation, about a minute …` : `Computing${own.beads.header?.beads > 99 ? ", about a minute" : ""} …`;

/** @param {string} text @param {string} unit */
const inUnit = (text, unit) => (unit ? `${text} [${unit}]` : text);

/** @param {string[]} head @param {string[][]} rows @param {number} [chosen] row, from 0 */
function table(head, rows, chosen) {
  const body = rows.map(([first, ...rest], i) => make("tr", { className: i === chosen ? "chosen" : "" }, make("th", { scope: "row" }, first), ...rest.map((text) => make("td", {}, text))));
  return make("table", {}, make("thead", {}, make("tr", {}, ...head.map((text) => make("th", { scope: "col" }, text)))), make("tbody", {}, ...body));
}

/** @param {string} name */
function sample(name) {
  const drawing = svg("svg", { viewBox: "0 0 26 8", class: "sample", "aria-hidden": "true" });
  drawing.append(svg("path", { class: `line ${name}`, d: "M1 4H25" }));
  if (name.startsWith("measured")) drawing.append(svg("path", { class: `circles ${name}`, d: `M7 4${CIRCLE}M19 4${CIRCLE}` }));
  return drawing;
}

/** @param {string} name @param {string} text */
const key = (name, text) => make("span", { className: "key", title: / Y\b/.test(text) ? "Y: yield strength. Contacts begin to flow at a mean pressure from 1.6 Y to 2.8 Y" : "" }, sample(name), text);

/** Replace children if they differ: a button in use must not be replaced.
 * @param {HTMLElement} host @param {HTMLElement[]} children */
function replace(host, children) {
  const fresh = make("div", {}, ...children);
  if (fresh.innerHTML !== host.innerHTML) {
    const focused = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset.curve;
    host.replaceChildren(...children);
    if (focused) /** @type {any} */ (host.querySelector(`[data-curve="${focused}"]`))?.focus();
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

/** Values of the other chain at the balls of this one, if it has the same units.
 * @param {Results} own @param {Results | null} other @param {string} quantity */
function theirs(own, other, quantity) {
  const values = other?.si === own.si && other.exact(quantity), shift = own.beads.header?.strikers - other?.beads.header?.strikers;
  return values && [...Array(Math.max(0, shift)).fill(NaN), ...values.slice(Math.max(0, -shift))];
}

/** Whether the last value is that of a bead at a free end. @param {any} of @param {any} y */
const ends = (of, y) => y?.length === of?.beads.header?.beads && !of.beads.header.walls?.includes("right");
/** Whether it is much larger than the others, too. @param {any} of @param {any} y */
const jumps = (of, y) => ends(of, y) && y.at(-1) * y.at(-3) > 1.2 * y.at(-2) ** 2;
/** Values without one that jumps. @param {any} of @param {any} y @param {string} quantity */
const inner = (of, y, quantity) => y && jumps(of, of.exact(quantity)) ? y.slice(0, -1) : y;

/** The peak of a chain that has none at a yield pressure because no contact yields; otherwise unknown.
 * @param {string} label @param {any} peak */
function withoutYield(label, peak) {
  const yields = peak?.shown.some((/** @type {string[]} */ [words]) => OF_YIELD.test(words));
  return OF_YIELD.test(label) && !(yields && AT_MOST.test(label)) ? peak?.yielding || NaN : NaN;
}

/** Forces on sensors and walls with their peaks. @param {Results} results
 * @returns {{shown: [string, number, any][], impact?: [string, any, string][], times: any, values: any, name: string, label: string, ball?: string, remark?: string}[]} */
function forcesOf({ run: { header, arrays } }) {
  return Object.entries(header.peaks).map(([name, each]) => ({ ...each, times: arrays.get("forces.times"), values: arrays.get(`force.${name}`) }));
}

/** Curves of measured data during the run. @param {Results} own @param {number} factor of times @returns {(Series & {rest: number, note: string})[]} */
function measured({ measured: found, motion, run }, factor) {
  const more = found && record.shift !== null ? found.offset - record.shift : 0, end = motion?.times.at(-1) ?? 0;
  return (found?.curves ?? []).map((/** @type {any} */ { key, label, note, place, static: rest }) => {
    const x = found.arrays.get(`record.times.${key}`), y = found.arrays.get(`record.${key}`), inside = [...x.keys()].filter((i) => x[i] + more >= 0 && x[i] + more <= end);
    return { name: `measured ${run.header.peaks[place]?.name ?? ""}`, label: `measured ${label}`, note: `measured ${label}${record.shift === null ? note : ""}`, marked: true, x: inside.map((i) => (x[i] + more) * factor), y: inside.map((i) => y[i]), rest };
  });
}

/** Largest error from bead 2 on in percent, as `Comparison.worst`; NaN if there is none.
 * @param {ArrayLike<number>} values @param {ArrayLike<number>} exact @param {boolean} free without the last bead */
function worst(values, exact, free) {
  const { y } = difference("", "", values, exact, true);
  let most = NaN;
  for (let i = 1; i < y.length - Number(free); i++) if (!(y[i] <= most) && Number.isFinite(y[i])) most = y[i];
  return most;
}

/** @param {Series[]} series */
function summary(series) {
  return series.map((each) => {
    const last = each.y[each.y.length - 1];
    return `${each.label}, at the end ${short(last)}, largest ${short(largest(each.y))}`;
  }).join("; ") || "no curves";
}

/** Show the time, and its place on the slider. @param {number | undefined} time @param {any} axis
 * @param {number} u @param {boolean} playing */
export function showClock(time, axis, u, playing) {
  const text = time === undefined ? "" : `t = ${(time * axis.factor).toPrecision(4)} ${axis.unit}`.trim();
  if ($("clockface").textContent !== text) $("clockface").textContent = text;
  const slider = $("time");
  if (document.activeElement !== slider || playing) slider.value = String(Math.round(1000 * u));
  slider.setAttribute("aria-valuetext", text);
}
