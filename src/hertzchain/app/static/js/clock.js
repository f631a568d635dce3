/** The time that the page shows, and the frames of its animation. */

import { $ } from "./fields.js";
import { placeAt, timeAt } from "./numbers.js";
import { own, results, state } from "./page.js";

/** Seconds that the times shown take at speed 1. */
const DURATION = 8;

/** Place in the run, from 0 to 1, and whether it advances. */
export const clock = { u: 0, playing: !matchMedia("(prefers-reduced-motion: reduce)").matches };
let last = 0, awake = false, draw = () => {};

/** Places at which the times shown begin and end. */
export function span() {
  const { motion } = own(), [low, high] = state.view.range;
  return motion && low >= 0 && low < high && low < timeAt(motion.times, 1) ? [placeAt(motion.times, low), placeAt(motion.times, high)] : [0, 1];
}

export function part() {
  const [from, to] = span();
  return (Math.min(to, clock.u) - from) / (to - from);
}

/** @param {() => void} drawn */
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
  const [from, to] = span();
  if (clock.playing && last) clock.u += (Math.min(100, now - last) / 1000 / DURATION) * state.view.speed * (to - from);
  // The cursor is always in the part that is shown.
  if (clock.u < from || clock.u >= to + 0.06 * (to - from)) clock.u = from;
  last = clock.playing ? now : 0;
  draw();
  if (clock.playing && results.A.motion) wake();
}

/** The chains have one time. @param {import("./state.js").Slot} slot */
export function placeOf(slot) {
  const place = Math.min(span()[1], clock.u), mine = own().motion, { motion, si } = results[slot];
  return mine && motion && slot !== state.active && si === own().si ? placeAt(motion.times, timeAt(mine.times, place)) : place;
}

/** @param {boolean} on */
export function play(on) {
  clock.playing = on;
  if (on && clock.u >= span()[1]) clock.u = 0;
  last = 0;
  $("play").setAttribute("aria-label", on ? "Pause" : "Play");
  $("play").textContent = on ? "❚❚" : "▶";
  wake();
}

/** @param {number} place */
function put(place) {
  const [from, to] = span();
  clock.u = Math.max(from, Math.min(to, place));
  play(false);
}

/** @param {number} part of the times shown */
export function goTo(part) {
  const [from, to] = span();
  put(from + part * (to - from));
}

/** @param {number} time */
export function goToTime(time) {
  const { motion } = own();
  if (motion) put(placeAt(motion.times, time));
}
