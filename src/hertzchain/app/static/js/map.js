/** Space-time map: beads across, time upwards. */

import { COLOURS, PIXELS, penOf } from "./colour.js";
import { digitsOf, placeAt, short, ticks, timeAt } from "./numbers.js";

const LEFT = 52, RIGHT = 16, TOP = 6, BOTTOM = 34;

export class SpaceTime {
  /** @param {HTMLCanvasElement} canvas @param {(bead: number, time: number) => void} pick */
  constructor(canvas, pick) {
    this.canvas = canvas;
    this.image = document.createElement("canvas");
    /** @type {import("./stage.js").Motion | null} */
    this.motion = null;
    this.times = [0, 1];
    /** Columns are contacts 0 .. N instead of beads. */
    this.contacts = false;
    const picked = (/** @type {PointerEvent} */ event) => {
      if (!(event.buttons & 1) || !this.motion) return;
      const x = (event.offsetX - LEFT) / this.wide, u = 1 - (event.offsetY - TOP) / this.high;
      pick(Math.max(1, Math.min(this.motion.beads, this.contacts ? Math.round(x * this.columns) : 1 + Math.floor(x * this.columns))), this.times[0] + u * (this.times[1] - this.times[0]));
    };
    canvas.onpointerdown = (event) => {
      canvas.setPointerCapture(event.pointerId);
      picked(event);
    };
    canvas.onpointermove = picked;
  }

  get wide() {
    return Math.max(1, this.canvas.clientWidth - LEFT - RIGHT);
  }

  get high() {
    return Math.max(1, this.canvas.clientHeight - TOP - BOTTOM);
  }

  get columns() {
    return (this.motion?.beads ?? 1) + Number(this.contacts);
  }

  /** Paint all beads or contacts. @param {import("./stage.js").Motion} motion
   * @param {"velocities" | "forces"} what @param {string} scale "bead" or "all"
   * @param {number[]} span first and last place in the run */
  paint(motion, what, scale, span) {
    this.motion = motion;
    const [low, high] = this.times = span.map((u) => timeAt(motion.times, u));
    this.contacts = what === "forces";
    const T = motion.count, { columns } = this;
    const values = motion[what], largest = this.contacts ? motion.strengths : motion.speeds;
    const most = Math.max(...largest, 1e-300);
    const factor = new Float32Array(columns);
    for (let k = 0; k < columns; k++) factor[k] = (255 / 32767) * (scale === "bead" ? 1 : largest[k] / most);
    this.image.width = columns;
    this.image.height = T;
    const pen = /** @type {CanvasRenderingContext2D} */ (this.image.getContext("2d"));
    const picture = pen.createImageData(columns, T), pixels = new Uint32Array(picture.data.buffer);
    for (let i = 0; i < T; i++) {
      const place = placeAt(motion.times, low + (i / (T - 1)) * (high - low)) * (T - 1), before = Math.min(T - 2, Math.floor(place));
      const row = (T - 1 - i) * columns, from = before * columns, next = from + columns, v = place - before;
      for (let k = 0; k < columns; k++) pixels[row + k] = PIXELS[(256.5 + factor[k] * ((1 - v) * values[from + k] + v * values[next + k])) | 0];
    }
    pen.putImageData(picture, 0, 0);
  }

  /** @param {number} now @param {number} bead @param {{factor: number, label: string}} axis */
  draw(now, bead, axis) {
    const { pen, H } = penOf(this.canvas), { motion, wide, high } = this;
    if (!motion) return;
    pen.imageSmoothingEnabled = this.image.width > wide / 8;
    pen.drawImage(this.image, LEFT, TOP, wide, high);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = COLOURS.soft;
    pen.textAlign = "right";
    const [begin, end] = this.times, yOf = (/** @type {number} */ time) => TOP + high * (end - time) / (end - begin), marks = ticks(begin * axis.factor, end * axis.factor, high / 40);
    for (const tick of marks) {
      pen.fillText(short(tick, digitsOf(marks)), LEFT - 5, Math.max(yOf(tick / axis.factor) + 4, TOP + 9));
    }
    pen.textAlign = "center";
    const { columns } = this, first = this.contacts ? 0 : 1;
    for (const k of ticks(first, motion.beads, wide / 55, 1)) {
      pen.fillText(String(k), LEFT + ((k - first + 0.5) / columns) * wide, TOP + high + 14);
    }
    pen.fillText(this.contacts ? "contact k" : "bead", LEFT + wide / 2, H - 5);
    pen.textAlign = "left";
    pen.fillText(axis.label, 2, H - 5);
    const y = yOf(now), x = LEFT + ((this.contacts ? bead : bead - 0.5) / columns) * wide;
    pen.strokeStyle = COLOURS.accent;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(LEFT, y);
    pen.lineTo(LEFT + wide, y);
    if (bead) {
      pen.moveTo(x, TOP);
      pen.lineTo(x, TOP + high);
    }
    pen.stroke();
  }
}
