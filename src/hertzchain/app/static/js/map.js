// @ts-check
/** Space-time map: beads across, time upwards, colour for velocity or force. */

import { COLOURS, PIXELS } from "./colour.js";
import { short, ticks } from "./numbers.js";

const LEFT = 52, RIGHT = 16, TOP = 6, BOTTOM = 34;

export class SpaceTime {
  /** @param {HTMLCanvasElement} canvas @param {(bead: number, u: number) => void} pick */
  constructor(canvas, pick) {
    this.canvas = canvas;
    this.image = document.createElement("canvas");
    /** @type {import("./stage.js").Motion | null} */
    this.motion = null;
    const picked = (/** @type {PointerEvent} */ event) => {
      if (!(event.buttons & 1) || !this.motion) return;
      const x = (event.offsetX - LEFT) / this.wide, u = 1 - (event.offsetY - TOP) / this.high;
      pick(Math.max(1, Math.min(this.motion.beads, 1 + Math.floor(x * this.motion.beads))), Math.max(0, Math.min(1, u)));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      picked(event);
    });
    canvas.addEventListener("pointermove", picked);
  }

  get wide() {
    return Math.max(1, this.canvas.clientWidth - LEFT - RIGHT);
  }

  get high() {
    return Math.max(1, this.canvas.clientHeight - TOP - BOTTOM);
  }

  /** Colours of all beads at all times, drawn once. @param {import("./stage.js").Motion} motion
   * @param {"velocities" | "forces"} what @param {string} scale "bead" or "all" */
  paint(motion, what, scale) {
    this.motion = motion;
    const T = motion.count, columns = motion.beads + (what === "forces" ? 1 : 0);
    const values = motion[what], largest = what === "forces" ? motion.strengths : motion.speeds;
    const most = largest.reduce((a, b) => Math.max(a, b), 1e-300);
    const factor = new Float32Array(columns);
    for (let k = 0; k < columns; k++) factor[k] = (255 / 32767) * (scale === "bead" ? 1 : largest[k] / most);
    this.image.width = columns;
    this.image.height = T;
    const pen = /** @type {CanvasRenderingContext2D} */ (this.image.getContext("2d"));
    const picture = pen.createImageData(columns, T), pixels = new Uint32Array(picture.data.buffer);
    for (let i = 0; i < T; i++) {
      const row = (T - 1 - i) * columns, from = i * columns;
      for (let k = 0; k < columns; k++) pixels[row + k] = PIXELS[(256.5 + factor[k] * values[from + k]) | 0];
    }
    pen.putImageData(picture, 0, 0);
  }

  /** @param {number} frame @param {number} bead @param {{factor: number, label: string}} time */
  draw(frame, bead, time) {
    const canvas = this.canvas, ratio = devicePixelRatio || 1, W = canvas.clientWidth, H = canvas.clientHeight;
    if (canvas.width !== Math.round(W * ratio) || canvas.height !== Math.round(H * ratio)) {
      canvas.width = Math.round(W * ratio);
      canvas.height = Math.round(H * ratio);
    }
    const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d")), motion = this.motion;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, W, H);
    if (!motion) return;
    const { wide, high } = this;
    pen.imageSmoothingEnabled = this.image.width > wide || this.image.height > high;
    pen.drawImage(this.image, LEFT, TOP, wide, high);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = COLOURS.soft;
    pen.textAlign = "right";
    for (let n = 0; n <= 5; n++) {
      const i = Math.round((n / 5) * (motion.count - 1)), y = TOP + high * (1 - i / (motion.count - 1));
      pen.fillText(short(motion.times[i] * time.factor, 3), LEFT - 5, Math.min(Math.max(y + 4, TOP + 9), TOP + high));
    }
    pen.textAlign = "center";
    for (const k of ticks(1, motion.beads, wide / 55)) {
      if (Number.isInteger(k)) pen.fillText(String(k), LEFT + ((k - 0.5) / motion.beads) * wide, TOP + high + 14);
    }
    pen.fillText("bead", LEFT + wide / 2, H - 5);
    pen.textAlign = "left";
    pen.fillText(time.label, 2, H - 5);
    const y = TOP + high * (1 - frame / Math.max(1, motion.count - 1)), x = LEFT + ((bead - 0.5) / motion.beads) * wide;
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
