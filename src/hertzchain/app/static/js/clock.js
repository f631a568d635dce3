/** The time that the page shows, and the frames of its animation. */

import { $ } from "./fields.js";
import { placeAt, timeAt } from "./numbers.js";
import { own, results, state } from "./page.js";

/** Seconds that a run takes at speed 1. */
const DURATION = 8;

/** Place in the run, from 0 to 1, and whether it advances. */
export const clock = { u: 0, playing: !matchMedia("(prefers-reduced-motion: reduce)").matches };
let last = 0, awake = false, draw = () => {};

/** Call a function in each frame in which something may have changed. @param {() => void} drawn */
export function eachFrame(drawn) {
  draw = drawn;
}

export function wake() {
  if (awake) return;
  awake = true;
  requestAnimationFrame(tick);
}

/** @param {number} now */
function tick(now) {
  awake = false;
  if (clock.playing && last) clock.u += (Math.min(100, now - last) / 1000 / DURATION) * state.view.speed;
  if (clock.u >= 1.06) clock.u = 0;
  last = clock.playing ? now : 0;
  draw();
  if (clock.playing && results.A.motion) wake();
}

/** The chains have one time. @param {import("./state.js").Slot} slot */
export function placeOf(slot) {
  const place = Math.min(1, clock.u), mine = own().motion, { motion, si } = results[slot];
  return mine && motion && slot !== state.active && si === own().si ? placeAt(motion.times, timeAt(mine.times, place)) : place;
}

/** @param {boolean} on */
export function play(on) {
  clock.playing = on;
  if (on && clock.u >= 1) clock.u = 0;
  last = 0;
  $("play").setAttribute("aria-label", on ? "Pause" : "Play");
  $("play").textContent = on ? "❚❚" : "▶";
  wake();
}

/** @param {number} place */
export function goTo(place) {
  clock.u = Math.max(0, Math.min(1, place));
  play(false);
}

/** @param {number} time */
export function goToTime(time) {
  const { motion } = own();
  if (motion) goTo(placeAt(motion.times, time));
}
