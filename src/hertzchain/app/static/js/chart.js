/** Line charts and stacked areas as SVG. */

import { digitsOf, percent, powers, short, spread, ticks } from "./numbers.js";

/** @typedef {{name: string, label: string, x: ArrayLike<number>, y: ArrayLike<number>, base?: ArrayLike<number>,
 *   points?: boolean, marked?: boolean, apart?: boolean}} Series; circles mark a `marked` line; no line joins a last value that is `apart` */
/** The x values of `counted` axes are numbers of beads, contacts or modes.
 * @typedef {{xLabel: string, yLabel: string, counted?: boolean, log?: boolean,
 *   percent?: boolean, message?: string, most?: number, shaded?: number[][], top?: number, range?: number[]}} Axes;
 * ranges of y are `shaded`, and the `range` of x is shown */

const SVG = "http://www.w3.org/2000/svg";
/** Values below this part of the largest are cut off on logarithmic axes. */
const SMALLEST = 1e-10;
/** Smallest range of an axis of differences [%]. */
const SMALLEST_PERCENTAGE = 2e-3;
const LEFT = 62, RIGHT = 20, TOP = 20, BOTTOM = 32;
/** Pixels between circles on a line, and a circle around the current point. */
const BETWEEN = 15;
export const CIRCLE = "m-2.4 0a2.4 2.4 0 1 0 4.8 0a2.4 2.4 0 1 0-4.8 0";
/** Heights of the chart beyond which curves are cut. */
const FAR = 1000;
/** Pixels from which a movement is a drag, and largest zoom. */
const DRAG = 5, MOST_ZOOM = 500;

/** @param {string} name @param {Record<string, string | number>} [attributes] @param {string} [text] */
export function svg(name, attributes = {}, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  if (text !== undefined) element.textContent = text;
  return element;
}

export class Chart {
  x = [0, 1];
  y = [0, 1];
  log = false;
  /** Range of all data. */
  whole = [0, 1];
  /** @type {number | null} */
  at = null;

  /** @param {HTMLElement} host @param {(x: number) => void} pick */
  constructor(host, pick) {
    this.host = host;
    this.plot = svg("g", { "clip-path": `url(#${host.id}-inside)` });
    this.inside = svg("rect");
    const clip = svg("clipPath", { id: `${host.id}-inside` });
    clip.append(this.inside);
    this.axes = svg("g", { "aria-hidden": "true" });
    this.mark = svg("line", { class: "cursor" });
    this.svg = svg("svg", { role: "img" });
    this.svg.append(clip, this.axes, this.plot, this.mark);
    this.message = document.createElement("p");
    this.message.className = "nothing";
    host.append(this.svg, this.message);
    this.W = this.H = 1;
    const picked = (/** @type {PointerEvent} */ event) => {
      if (event.buttons & 1) pick(this.valueAt(event.offsetX));
    };
    host.onpointerdown = host.onpointermove = picked;
    this.pick = pick;
  }

  /** Drags, keys, and the wheel with Ctrl select a range of x; a double click, all.
   * @param {(range: number[] | null) => void} chosen */
  zoomable(chosen) {
    const { host } = this, band = svg("rect", { class: "band", height: 0 });
    let from = NaN;
    this.svg.append(band);
    host.tabIndex = 0;
    host.setAttribute("role", "group");
    host.setAttribute("aria-label", "Chart over time; plus and minus zoom, arrow keys move, 0 shows all");
    const place = (/** @type {MouseEvent} */ event) => Math.max(LEFT, Math.min(this.W - RIGHT, event.clientX - host.getBoundingClientRect().left));
    const show = (/** @type {number} */ low, /** @type {number} */ high) => {
      const [first, last] = this.whole, span = Math.min(last - first, Math.max(high - low, (last - first) / MOST_ZOOM));
      const begin = Math.max(first, Math.min(last - span, (low + high - span) / 2));
      chosen(span > 0.999 * (last - first) ? null : [begin, begin + span]);
    };
    const scale = (/** @type {number} */ factor, /** @type {number} */ x) => show(x + factor * (this.x[0] - x), x + factor * (this.x[1] - x));
    const over = (/** @type {number} */ to) => Math.abs(to - from) > DRAG;
    host.onpointerdown = (event) => {
      if (event.button || !this.plot.childElementCount) return;
      from = place(event);
      host.setPointerCapture(event.pointerId);
    };
    host.onpointermove = (event) => {
      const to = place(event);
      if (over(to)) for (const [name, value] of Object.entries({ x: Math.min(from, to), y: TOP, width: Math.abs(to - from), height: this.H - TOP - BOTTOM })) band.setAttribute(name, String(value));
    };
    host.onpointerup = (event) => {
      const [low, high] = [from, place(event)].sort((a, b) => a - b).map((px) => this.valueAt(px));
      if (over(place(event))) show(low, high);
      else if (from >= 0) this.pick(low);
      host.onpointercancel?.(event);
    };
    host.onpointercancel = () => {
      from = NaN;
      band.setAttribute("height", "0");
    };
    host.ondblclick = () => chosen(null);
    host.onwheel = (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      scale(event.deltaY > 0 ? 1.25 : 0.8, this.valueAt(place(event)));
    };
    host.onkeydown = (event) => {
      const [low, high] = this.x, middle = this.at !== null && this.at >= low && this.at <= high ? this.at : (low + high) / 2, step = (high - low) / 5;
      /** @type {Record<string, () => void>} */
      const actions = {
        "+": () => scale(0.5, middle), "=": () => scale(0.5, middle), "-": () => scale(2, middle), 0: () => chosen(null),
        ArrowLeft: () => show(low - step, high - step), ArrowRight: () => show(low + step, high + step),
      };
      if (event.ctrlKey || event.metaKey || event.altKey || !actions[event.key]) return;
      event.preventDefault();
      actions[event.key]();
    };
  }

  /** @param {number} px */
  valueAt(px) {
    return this.x[0] + ((px - LEFT) / (this.W - LEFT - RIGHT)) * (this.x[1] - this.x[0]);
  }

  /** @param {number} x */
  px(x) {
    return LEFT + ((x - this.x[0]) / (this.x[1] - this.x[0] || 1)) * (this.W - LEFT - RIGHT);
  }

  /** @param {number} y */
  py(y) {
    const [low, high] = this.y;
    const u = this.log ? Math.log(y / low) / Math.log(high / low) : (y - low) / (high - low);
    // Browsers reject longer numbers, of curves far outside the part that is shown.
    return this.H - BOTTOM - Math.max(-FAR, Math.min(FAR, u)) * (this.H - TOP - BOTTOM);
  }

  /** @param {Series[]} series @param {Axes} axes @param {string} summary */
  draw(series, axes, summary) {
    this.W = Math.max(120, this.host.clientWidth);
    this.H = Math.max(90, this.host.clientHeight);
    this.log = Boolean(axes.log);
    this.svg.setAttribute("viewBox", `0 0 ${this.W} ${this.H}`);
    this.svg.setAttribute("aria-label", summary);
    this.message.textContent = axes.message ?? "";
    this.message.hidden = !axes.message;
    this.fit(series, axes);
    if (!series.length) this.axes.replaceChildren();
    else this.drawAxes(axes);
    this.plot.replaceChildren(...series.flatMap((each) => each.apart ? [this.path(each), this.path({ ...each, points: true })] : each.marked ? [this.path(each), this.circles(each)] : this.path(each)));
    for (const [name, value] of Object.entries({ x: LEFT - 3, y: TOP - 3, width: this.W - LEFT - RIGHT + 6, height: this.H - TOP - BOTTOM + 6 })) this.inside.setAttribute(name, String(value));
    this.cursor(this.at);
  }

  /** @param {Series[]} series @param {Axes} axes */
  fit(series, axes) {
    let x0 = Infinity, x1 = -Infinity, y0 = Infinity, y1 = -Infinity;
    const [from, to] = axes.range ?? [-Infinity, Infinity];
    for (const { x, y, base } of series) {
      for (let i = 0; i < y.length; i++) {
        const value = y[i];
        if (x[i] < x0) x0 = x[i];
        if (x[i] > x1) x1 = x[i];
        // The first points outside belong to lines that are seen.
        if (!Number.isFinite(value) || (this.log && !(value > 0)) || x[i + 1] < from || x[i - 1] > to) continue;
        if (value < y0) y0 = value;
        if (value > y1) y1 = value;
        if (base && base[i] < y0) y0 = base[i];
      }
    }
    this.whole = x0 <= x1 ? [x0, x1 > x0 ? x1 : x0 + 1] : [0, 1];
    this.x = axes.range ?? this.whole;
    if (!(y0 <= y1)) [y0, y1] = this.log ? [0.1, 1] : [0, 1];
    if (axes.most !== undefined && y0 < axes.most) y1 = Math.min(y1, axes.most);
    if (this.log) {
      this.y = [Math.max(y0, y1 * SMALLEST) / 1.3, y1 * 1.3];
      return;
    }
    if (y0 > 0 && y0 < 0.6 * y1) y0 = 0;
    if (y1 < 0 && y1 > 0.6 * y0) y1 = 0;
    if (y0 === y1) [y0, y1] = y0 === 0 ? [-1, 1] : [y0 - 0.1 * Math.abs(y0), y1 + 0.1 * Math.abs(y1)];
    [y0, y1] = spread(y0, y1, axes.percent ? SMALLEST_PERCENTAGE : 0);
    if (axes.top) [y0, y1] = [0, axes.top];
    const room = 0.05 * (y1 - y0);
    this.y = [y0 === 0 ? 0 : y0 - room, y1 === 0 ? 0 : y1 + room];
  }

  /** @param {Axes} axes */
  drawAxes(axes) {
    const items = [], right = this.W - RIGHT, bottom = this.H - BOTTOM, rows = Math.max(2, (bottom - TOP) / 28);
    const marks = this.log ? powers(this.y[0], this.y[1], rows) : ticks(this.y[0], this.y[1], rows);
    const digits = this.log ? 4 : digitsOf(marks), size = this.log ? undefined : Math.max(...marks.map(Math.abs));
    for (const [low, high] of axes.shaded ?? []) {
      const top = this.py(Math.min(high, this.y[1]));
      items.push(svg("rect", { class: "shade", x: LEFT, y: top, width: right - LEFT, height: Math.max(0, this.py(low) - top) }));
    }
    for (const y of marks) {
      const at = Math.round(this.py(y)) + 0.5;
      items.push(svg("line", { class: y === 0 ? "axis" : "grid", x1: LEFT, x2: right, y1: at, y2: at }));
      items.push(svg("text", { x: LEFT - 6, y: at + 3.5, "text-anchor": "end" }, axes.percent && !this.log ? percent(y, digits, size) : short(y, digits, size) + (axes.percent ? "%" : "")));
    }
    const places = ticks(this.x[0], this.x[1], (right - LEFT) / 50, axes.counted ? 1 : 0);
    for (const at of places) {
      const x = this.px(at);
      items.push(svg("line", { class: "tick", x1: x, x2: x, y1: bottom, y2: bottom + 4 }));
      items.push(svg("text", { x, y: bottom + 15, "text-anchor": "middle" }, short(at, digitsOf(places))));
    }
    items.push(svg("line", { class: "axis", x1: LEFT, x2: right, y1: bottom + 0.5, y2: bottom + 0.5 }));
    items.push(svg("text", { x: (LEFT + right) / 2, y: this.H - 3, "text-anchor": "middle", class: "label" }, axes.xLabel));
    items.push(svg("text", { x: 2, y: 11, class: "label" }, axes.yLabel));
    this.axes.replaceChildren(...items);
  }

  /** Circles at some points of a line. @param {Series} each */
  circles({ name, x, y }) {
    const parts = [];
    let last = [-Infinity, 0];
    for (let i = 0; i < y.length; i++) {
      const here = [this.px(x[i]), this.py(y[i])];
      if (!Number.isFinite(here[1]) || here[0] < LEFT || here[0] > this.W - RIGHT || Math.hypot(here[0] - last[0], here[1] - last[1]) < BETWEEN) continue;
      parts.push(`M${here[0].toFixed(1)} ${here[1].toFixed(1)}${CIRCLE}`);
      last = here;
    }
    return svg("path", { class: `circles ${name}`, d: parts.join("") });
  }

  /** @param {Series} each */
  path(each) {
    const { x, y, base } = each, parts = [];
    const end = y.length - Number(!!each.apart);
    let on = false;
    if (each.points) {
      for (let i = each.apart ? end : 0; i < y.length; i++) if (Number.isFinite(y[i])) parts.push(`M${this.px(x[i]).toFixed(1)} ${this.py(y[i]).toFixed(1)}h0`);
      return svg("path", { class: `line points ${each.name}`, d: parts.join("") });
    }
    for (let i = 0; i < end; i++) {
      const good = Number.isFinite(y[i]) && (!this.log || y[i] > 0);
      if (good) parts.push(`${on ? "L" : "M"}${this.px(x[i]).toFixed(1)} ${this.py(y[i]).toFixed(1)}`);
      on = good || (on && each.name === "effective-chain");
    }
    if (!base) return svg("path", { class: `line ${each.name}`, d: parts.join("") });
    for (let i = y.length - 1; i >= 0; i--) parts.push(`L${this.px(x[i]).toFixed(1)} ${this.py(base[i]).toFixed(1)}`);
    return svg("path", { class: `area ${each.name}`, d: parts.join("") + "Z" });
  }

  /** @param {number | null} x */
  cursor(x) {
    this.at = x;
    const px = x === null || !this.plot.childElementCount || (x - this.x[0]) * (x - this.x[1]) > 0 ? -9 : this.px(x);
    for (const [name, value] of Object.entries({ x1: px, x2: px, y1: TOP, y2: this.H - BOTTOM })) this.mark.setAttribute(name, value.toFixed(1));
  }
}
