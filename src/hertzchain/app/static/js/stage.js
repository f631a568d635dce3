/** The beads, to scale, with the pulse in them. */

import { COLOURS, KINDS, STEPS, penOf, stepOf } from "./colour.js";
import { fixed } from "./host.js";
import { prefixed, short, ticks } from "./numbers.js";

/** @typedef {{count: number, beads: number, times: Float64Array, velocities: Int16Array, speeds: Float64Array,
 *   forces: Int16Array, strengths: Float64Array}} Motion */
/** @typedef {CanvasRenderingContext2D} Pen */
/** Margins in pixels, and the length and largest radius of the chain.
 * @typedef {{left: number, right: number, long: number, tall: number}} Room */
/** @typedef {{select: (bead: number) => void, sensor: () => void,
 *   resize: (bead: number, radius: number, moving: boolean) => void,
 *   wall: (gap: number, moving: boolean) => void}} Handlers */

const FULL = 32767;
/** Pixels around the rim of a bead in which it can be dragged. */
const RIM = 6;
const MOST = 6, LEAST = 0.15;

/** @param {Pen} pen @param {number} x @param {number} y @param {number} r */
function circle(pen, x, y, r, h = r) {
  pen.beginPath();
  if (h > r) pen.rect(x - r, y - h, 2 * r, 2 * h);
  else pen.arc(x, y, Math.max(r, 0.5), 0, 6.2832);
}

/** Room for both of two chains. @param {Room} one @param {Room} other @returns {Room} */
export function around(one, other) {
  const { left, right, long, tall } = one;
  return { left: Math.max(left, other.left), right: Math.max(right, other.right), long: Math.max(long, other.long), tall: Math.max(tall, other.tall) };
}

export class Stage {
  /** @type {string[]} */
  walls = [];
  /** Contacts with pads. @type {number[]} */
  pads = [];
  strikers = 0;
  kinds = new Int16Array(0);
  /** Colours of the materials, if there are several. @type {number[]} */
  colours = [];
  long = 1;
  largest = 1;
  /** @type {Motion | null} */
  motion = null;
  bead = 0;
  /** @type {number[]} */
  sensors = [];
  camera = "whole";
  scale = "bead";
  wallGap = 0;
  si = false;
  /** Room of the drawings of two chains, one below the other. @type {Room | null} */
  shared = null;
  least = 0;
  look = { x: 0, scale: 1 };
  /** @type {any} */
  drag = null;

  /** @param {HTMLCanvasElement} canvas @param {Handlers} on */
  constructor(canvas, on) {
    this.canvas = canvas;
    this.on = on;
    /** Half widths and heights; faces of plates are infinite. @type {Float64Array} */
    this.radii = this.heights = this.faces = this.centres = new Float64Array(0);
    canvas.onpointerdown = (event) => this.down(event);
    canvas.onpointermove = (event) => this.move(event);
    canvas.onpointerup = () => this.up();
    canvas.onpointercancel = () => this.up();
  }

  /** @param {import("./results.js").Part} beads @param {number} wallGap */
  chain({ header, arrays }, wallGap) {
    this.faces = arrays.get("radii");
    this.radii = arrays.get("widths");
    this.heights = arrays.get("heights");
    this.centres = arrays.get("centres");
    this.kinds = arrays.get("kinds");
    this.walls = header.walls;
    this.pads = header.pads;
    this.strikers = header.strikers;
    this.si = header.units === "SI";
    this.wallGap = this.si ? wallGap : 0;
    const last = this.radii.length - 1;
    this.long = this.centres[last] + this.radii[last] + this.wallGap;
    this.largest = Math.max(...this.heights);
  }

  get middle() {
    return this.canvas.clientHeight * 0.63;
  }

  /** @param {number} x */
  px(x) {
    return (x - this.look.x) * this.look.scale;
  }

  /** Centre and radius of a bead in the window. @param {number} bead from 1 @returns {number[]} */
  placeOf(bead) {
    const { left, top } = this.canvas.getBoundingClientRect();
    return [left + this.px(this.centres[bead - 1]), top + this.middle, this.radii[bead - 1] * this.look.scale];
  }

  /** Bead at a place, or -1; and whether it is at the rim. @param {number} x @param {number} y */
  hit(x, y) {
    // The rim of the last bead ends at the wall.
    if (this.atWall(x) && x >= this.px(this.long)) return { bead: -1, rim: false };
    const place = x / this.look.scale + this.look.x, right = this.centres.findIndex((each, k) => each + this.radii[k] >= place);
    const low = right < 0 ? this.radii.length - 1 : right;
    const r = this.radii[low] * this.look.scale, distance = Math.hypot(x - this.px(this.centres[low]), (y - this.middle) * this.radii[low] / this.heights[low]);
    if (distance > Math.max(r, 8) + RIM) return { bead: -1, rim: false };
    return { bead: low, rim: !fixed && this.faces[low] < Infinity && distance > r - Math.min(RIM, 0.35 * r) };
  }

  /** @param {number} x */
  atWall(x) {
    return !fixed && this.walls.includes("right") && Math.abs(x - this.px(this.long) - 5) < 9;
  }

  /** @param {PointerEvent} event */
  down(event) {
    const { offsetX: x, offsetY: y } = event;
    const { bead, rim } = this.hit(x, y);
    if (bead < 0 && !this.atWall(x)) return;
    this.canvas.setPointerCapture(event.pointerId);
    if (bead < 0) {
      this.drag = { wall: true, x, gap: this.wallGap };
      return;
    }
    const reach = Math.max(4, Math.hypot(x - this.px(this.centres[bead]), y - this.middle));
    this.drag = { bead, rim, reach, radius: this.faces[bead], look: { ...this.look }, moved: false, x, y };
    this.on.select(bead + 1);
  }

  /** @param {PointerEvent} event */
  move(event) {
    const { offsetX: x, offsetY: y } = event, drag = this.drag;
    if (!drag) {
      const { bead, rim } = this.hit(x, y);
      this.canvas.style.cursor = bead >= 0 ? (rim ? "nwse-resize" : "pointer") : this.atWall(x) ? "ew-resize" : "default";
      return;
    }
    if (drag.wall) {
      drag.to = Math.max(0, drag.gap + (x - drag.x) / this.look.scale);
      this.on.wall(drag.to, true);
      return;
    }
    if (!drag.moved && Math.hypot(x - drag.x, y - drag.y) < 3) return;
    drag.moved = true;
    // Distances from the centre at the start of the drag.
    const centre = (this.centres[drag.bead] - drag.look.x) * drag.look.scale;
    const factor = Math.min(MOST, Math.max(LEAST, Math.hypot(x - centre, y - this.middle) / drag.reach));
    this.on.resize(drag.bead + 1, drag.radius * factor, true);
  }

  up() {
    const drag = this.drag;
    this.drag = null;
    if (!drag) return;
    if (drag.wall) { if (drag.to >= 0) this.on.wall(drag.to, false); }
    else if (drag.moved) this.on.resize(drag.bead + 1, NaN, false);
    else this.on.sensor();
  }

  /** @returns {Room} */
  get room() {
    return { left: this.walls.includes("left") ? 16 : 8, right: this.walls.includes("right") ? 22 : 8, long: this.long, tall: this.largest };
  }

  /** Radius and place of the pulse. @param {number} front bead, counted from 0, with a fraction */
  near(front) {
    const place = Math.max(0, Math.min(this.radii.length - 1, front)), k = Math.floor(place);
    return [this.heights, this.centres].map((each) => each[k] + (place - k) * ((each[k + 1] ?? 0) - each[k]));
  }

  /** @param {number} front */
  aim(front) {
    if (this.drag && !this.drag.wall) {
      this.look = this.drag.look;
      return;
    }
    const W = this.canvas.clientWidth, H = this.canvas.clientHeight;
    const { left, right, long, tall } = this.shared ?? this.room, whole = Math.min((W - left - right) / long, (0.26 * H) / tall);
    if (this.camera !== "follow") {
      const spare = W - left - right - long * whole;
      this.look = { scale: whole, x: -(left + spare / 2) / whole };
      return;
    }
    const [near, x] = this.near(front), r = Math.max(near, this.least), scale = Math.max(whole, Math.min((0.2 * H) / r, W / (28 * r)));
    this.look = { scale, x: x - W / 2 / scale };
  }

  /** @param {number} frame @param {number} front */
  draw(frame, front) {
    const { pen, W, H } = penOf(this.canvas);
    if (!this.radii.length) return;
    this.aim(front);
    const m = this.motion, i = m ? Math.min(m.count - 1, Math.max(0, Math.floor(frame))) : 0, u = frame - i;
    const count = this.radii.length, fastest = m && this.scale !== "bead" ? Math.max(...m.speeds, 1e-300) : 0;
    const speeds = new Float64Array(count);
    if (m && m.beads === count) {
      const here = i * count, there = Math.min(m.count - 1, i + 1) * count;
      for (let k = 0; k < count; k++) {
        const v = ((1 - u) * m.velocities[here + k] + u * m.velocities[there + k]) / FULL;
        speeds[k] = fastest ? (v * m.speeds[k]) / fastest : v;
      }
    }
    this.drawProfile(pen, W, H, speeds);
    this.drawWalls(pen, H);
    this.drawBeads(pen, W, H, speeds);
    this.drawPads(pen);
    if (m && m.beads === count) this.drawForces(pen, W, i, u);
    this.drawLabels(pen, W, H);
  }

  /** @param {Pen} pen @param {number} W @param {number} H @param {Float64Array} speeds */
  drawProfile(pen, W, H, speeds) {
    const base = H * 0.185 + 7.5, tall = base - 15, count = this.radii.length;
    pen.fillStyle = COLOURS.line;
    pen.fillRect(0, base, W, 1);
    pen.fillStyle = COLOURS.soft;
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "left";
    let free = W;
    if (this.si) {
      const size = ticks(0, 60 / this.look.scale, 3)[1], wide = size * this.look.scale, [factor, unit] = prefixed(size, "m");
      const text = `${short(size * factor)} ${unit}`;
      free = W - wide - 5 - pen.measureText(text).width - 10;
      pen.fillRect(W - wide, 5, wide, 2);
      pen.textAlign = "right";
      pen.fillText(text, W - wide - 5, 10);
      pen.textAlign = "left";
    }
    const each = this.scale === "bead", caption = `velocity, relative to the largest of ${each ? "each bead" : "all"}`;
    pen.fillText(pen.measureText(caption).width <= free ? caption : `velocity / largest ${each ? "of bead" : "of all"}`, 0, 10);
    if (!this.motion) return;
    for (const sign of [1, -1]) {
      pen.beginPath();
      let first = -1, last = 0;
      for (let k = 0; k < count; k++) {
        const x = this.px(this.centres[k]);
        if (x < -60 || x > W + 60) continue;
        if (first < 0) pen.moveTo((first = x), base);
        const v = speeds[k] * sign;
        pen.lineTo(x, base - sign * tall * (v > 0 ? v : 0));
        last = x;
      }
      pen.lineTo(last, base);
      pen.closePath();
      pen.fillStyle = sign > 0 ? COLOURS.forward : COLOURS.back;
      pen.globalAlpha = 0.3;
      pen.fill();
      pen.globalAlpha = 1;
      pen.strokeStyle = pen.fillStyle;
      pen.lineWidth = 1.25;
      pen.stroke();
    }
  }

  /** @param {Pen} pen @param {number} H */
  drawWalls(pen, H) {
    const y = this.middle, half = Math.min(0.32 * H, H - y - 4);
    for (const side of this.walls) {
      const x = side === "left" ? this.px(0) - 10 : this.px(this.long);
      pen.fillStyle = COLOURS.wall;
      pen.fillRect(x, y - half, 10, 2 * half);
      pen.strokeStyle = COLOURS.card;
      pen.lineWidth = 1;
      pen.beginPath();
      for (let at = y - half; at + 7 < y + half; at += 7) {
        pen.moveTo(x, at + 7);
        pen.lineTo(x + 10, at);
      }
      pen.stroke();
    }
  }

  /** Pads and load cells, whose sizes are not known. @param {Pen} pen */
  drawPads(pen) {
    const tall = 0.8 * this.largest * this.look.scale, thick = Math.max(2, 0.3 * tall);
    pen.fillStyle = COLOURS.edge;
    for (const k of this.pads) {
      const { centres: c, radii: r } = this, last = k === r.length;
      const x = last ? this.px(this.long) - thick : k ? this.px((c[k - 1] + r[k - 1] + c[k] - r[k]) / 2) - thick / 2 : this.px(0);
      pen.fillRect(x, this.middle - tall, thick, 2 * tall);
    }
  }

  /** @param {Pen} pen @param {number} W @param {number} H @param {Float64Array} speeds */
  drawBeads(pen, W, H, speeds) {
    const y = this.middle, scale = this.look.scale;
    for (let k = 0; k < this.radii.length; k++) {
      const r = Math.max(this.radii[k] * scale, 0.5), x = this.px(this.centres[k]), h = r + (this.heights[k] - this.radii[k]) * scale;
      if (x + r < -2 || x - r > W + 2) continue;
      const body = (/** @type {number} */ inset) => circle(pen, x, y, r - inset, h - inset);
      body(0.5);
      pen.fillStyle = STEPS[stepOf(speeds[k])];
      pen.fill();
      if (this.colours.length) {
        const kind = this.colours[this.kinds[k]], wide = Math.max(1.75, 0.24 * r);
        body(wide / 2);
        pen.strokeStyle = COLOURS[`m${kind % KINDS}`];
        pen.lineWidth = wide;
        pen.setLineDash(kind < KINDS ? [] : [r / 3, r / 5]);
        pen.stroke();
        pen.setLineDash([]);
      }
      if (r > 3) {
        body(0.5);
        pen.strokeStyle = COLOURS.edge;
        pen.lineWidth = r > 12 ? 1.25 : 0.75;
        pen.stroke();
      }
    }
  }

  /** Forces of the contacts, as bars across them. @param {Pen} pen
   * @param {number} W @param {number} i @param {number} u */
  drawForces(pen, W, i, u) {
    const m = /** @type {Motion} */ (this.motion), y = this.middle, columns = m.beads + 1;
    const here = i * columns, there = Math.min(m.count - 1, i + 1) * columns;
    pen.strokeStyle = COLOURS.ink;
    pen.lineCap = "round";
    for (let c = 0; c < columns; c++) {
      const force = ((1 - u) * m.forces[here + c] + u * m.forces[there + c]) / FULL;
      if (force < 0.03) continue;
      const k = Math.max(0, c - 1), next = Math.min(m.beads - 1, c);
      const x = c === 0 ? this.px(0) : c === m.beads ? this.px(this.long) : this.px(this.centres[k] + this.radii[k]);
      if (x < -5 || x > W + 5) continue;
      const r = Math.min(this.heights[k], this.heights[next]) * this.look.scale, half = Math.max(1.5, 0.6 * r * Math.cbrt(force));
      pen.globalAlpha = 0.25 + 0.75 * force;
      pen.lineWidth = Math.max(1.25, Math.min(4.5, 0.14 * r));
      pen.beginPath();
      pen.moveTo(x, y - half);
      pen.lineTo(x, y + half);
      pen.stroke();
    }
    pen.globalAlpha = 1;
  }

  /** @param {Pen} pen @param {number} W @param {number} H */
  drawLabels(pen, W, H) {
    const y = this.middle;
    pen.textAlign = "center";
    this.sensors.forEach((ball, n) => {
      const bead = ball + this.strikers;
      if (bead < 1 || bead > this.radii.length) return;
      const x = this.px(this.centres[bead - 1]), r = Math.max(3, this.heights[bead - 1] * this.look.scale);
      pen.fillStyle = COLOURS[`s${n}`];
      pen.beginPath();
      pen.moveTo(x, y + r + 2);
      pen.lineTo(x - 5, y + r + 10);
      pen.lineTo(x + 5, y + r + 10);
      pen.fill();
    });
    if (!this.bead || this.bead > this.radii.length) return;
    const x = this.px(this.centres[this.bead - 1]), r = this.radii[this.bead - 1] * this.look.scale, h = this.heights[this.bead - 1] * this.look.scale;
    pen.strokeStyle = COLOURS.accent;
    pen.lineWidth = 2;
    circle(pen, x, y, Math.max(r + 1.5, 4.5), h + 1.5);
    pen.stroke();
    pen.fillStyle = COLOURS.accent;
    pen.font = "600 12px system-ui, sans-serif";
    const face = this.faces[this.bead - 1], [factor, unit] = prefixed(2 * face, "m");
    const size = this.si ? `${short(2 * face * factor)} ${unit}` : `radius ${short(face)}`, name = `bead ${this.bead}${this.drag?.moved ? `, ${size}` : ""}`;
    // An arrow points to a bead outside of the view.
    const before = x + r < 0, text = before ? `← ${name}` : x - r > W ? `${name} →` : name;
    const half = pen.measureText(text).width / 2 + 7, at = Math.max(half, Math.min(W - half, x));
    const below = text !== name || this.sensors.includes(this.bead - this.strikers) ? 24 : 15, base = Math.min(H - 3, y + Math.max(h, 4) + below);
    pen.strokeStyle = COLOURS.card;
    pen.lineWidth = 4;
    pen.strokeText(text, at, base);
    pen.fillText(text, at, base);
  }
}
