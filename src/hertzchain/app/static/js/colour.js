/** Colours of canvases: they follow the theme of the page. */

/** Colours of the page by name; filled by `readColours`.
 * @type {Record<string, string>} */
export const COLOURS = {};

const NAMES = ["ink", "soft", "line", "card", "accent", "bead", "edge", "forward", "back", "wall",
  "s0", "s1", "s2", "s3", "m0", "m1", "m2", "m3", "m4"];
/** Number of colours of materials; the rings of further materials are dashed. */
export const KINDS = 5;

/** Colours of velocities and forces from -1 to 1, at 0 .. 511, as pixels of the map. */
export const PIXELS = new Uint32Array(512);
/** The same as CSS colours of beads, which are visible at rest.
 * @type {string[]} */
export const STEPS = [];

/** Read the colours of the theme, and compute the scale of colours. */
export function readColours() {
  const style = getComputedStyle(document.documentElement);
  // Computed colours are rgb(r, g, b).
  const rgb = (/** @type {string} */ colour) => (colour.match(/\d+/g) ?? []).map(Number);
  const resolver = document.createElement("i");
  // Colours carry meaning, also in forced colours.
  resolver.style.setProperty("forced-color-adjust", "none");
  document.body.append(resolver);
  const own = (/** @type {string} */ name) => {
    resolver.style.color = style.getPropertyValue(`--${name}`);
    return getComputedStyle(resolver).color;
  };
  for (const name of NAMES) COLOURS[name] = own(name);
  const ends = ["back-2", "back", "zero", "forward", "forward-2"].map((name) => rgb(own(name)));
  const rest = rgb(own("bead"));
  resolver.remove();
  for (let i = 0; i < 512; i++) {
    const x = Math.abs(i - 256) / 256, side = i < 256 ? [ends[2], ends[1], ends[0]] : [ends[2], ends[3], ends[4]];
    // Half of the colours show the smallest third of the values.
    const u = Math.min(1, x) ** 0.7 * 2, k = u < 1 ? 0 : 1, v = u - k;
    const between = (/** @type {number[]} */ zero) => [0, 1, 2].map((n) => Math.round((k ? side[1] : zero)[n] * (1 - v) + side[k + 1][n] * v));
    const c = between(side[0]);
    PIXELS[i] = (255 << 24) | (c[2] << 16) | (c[1] << 8) | c[0];
    STEPS[i] = `rgb(${between(rest).join(" ")})`;
  }
}

/** Index of a value from -1 to 1. @param {number} value */
export function stepOf(value) {
  const i = 256 + Math.round(255 * value);
  return i < 0 ? 0 : i > 511 ? 511 : i;
}

/** A canvas, cleared and with as many pixels as the screen has. @param {HTMLCanvasElement} canvas */
export function penOf(canvas) {
  const ratio = devicePixelRatio || 1, W = canvas.clientWidth, H = canvas.clientHeight;
  if (canvas.width !== Math.round(W * ratio) || canvas.height !== Math.round(H * ratio)) {
    canvas.width = Math.round(W * ratio);
    canvas.height = Math.round(H * ratio);
  }
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, W, H);
  return { pen, W, H };
}
