/** Requests for the results of both chains, and their answers: the latest wins, here and on the server. */

import { OfflineError, host } from "./host.js";
import { SLOTS, keepAddress, record, results, say, state } from "./page.js";

/** @typedef {import("./results.js").Part} Part */
/** @typedef {import("./state.js").Slot} Slot */

/** Milliseconds after which a request that has not been answered is replaced. */
const PATIENCE = 250;
/** Milliseconds between maps during a drag. */
const BETWEEN_MAPS = 120;

/** @typedef {{number: number, draft: boolean, sent: number, input: number, document: any}} Sent */

let numbers = 0;
const session = String(Math.random());

class Link {
  /** @type {Sent | null} */
  current = null;
  /** @type {any} */
  waiting = null;
  timer = 0;
  retry = 0;
  lastMap = 0;

  /** @param {Slot} slot */
  constructor(slot) {
    this.slot = slot;
  }

  get busy() {
    return this.current !== null || this.waiting !== null;
  }

  /** @param {any} request */
  ask(request) {
    this.waiting = request;
    clearTimeout(this.retry);
    const patient = this.current?.draft && performance.now() - this.current.sent < PATIENCE;
    if (!patient) this.send();
    else {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.send(), PATIENCE);
    }
  }

  send() {
    clearTimeout(this.timer);
    const request = this.waiting;
    if (!request) return;
    this.waiting = null;
    const { input, ...rest } = request;
    const sent = { number: ++numbers, draft: Boolean(rest.draft), sent: performance.now(), input, document: rest.document };
    this.current = sent;
    void this.stream({ ...rest, session, slot: this.slot, number: sent.number }, sent, request);
  }

  /** @param {Part} part @param {Sent} sent */
  received(part, sent) {
    take(this.slot, part, sent);
    const now = performance.now(), kind = part.header.part;
    if (kind === "run") this.lastMap = now;
    if (kind === "pulse" && sent.draft && this.waiting?.draft && now - this.lastMap < BETWEEN_MAPS) this.send();
  }

  /** @param {any} body @param {Sent} sent @param {any} request */
  async stream(body, sent, request) {
    let failure = "", offline = false;
    try {
      await host.results(body, (part) => { if (this.current === sent) this.received(part, sent); });
    } catch (error) {
      offline = error instanceof OfflineError;
      failure = error instanceof Error ? error.message : String(error);
    }
    if (this.current !== sent) return;
    this.current = null;
    if (failure) {
      say(failure, true);
      if (!offline) return;
      this.waiting ??= request;
      this.retry = setTimeout(() => this.send(), 1500);
    } else if (this.waiting) this.send();
  }
}

/** Milliseconds without a change after which the exact results are requested. */
const SETTLE = 180;
/** For the tests and `benchmarks/app.py`. */
export const answers = /** @type {any[]} */ ([]);
/** Answers that no frame has shown yet. @type {any[]} */
const waiting = [];
/** @type {Record<Slot, boolean>} */
const moved = { A: false, B: false };
let settle = 0, asked = 0, draft = false, later = 0;
/** @type {(slot: Slot, kind: string) => void} */
let received = () => {};

const links = { A: new Link("A"), B: new Link("B") };

/** @param {(slot: Slot, kind: string) => void} shown */
export function eachAnswer(shown) {
  received = shown;
}

/** @param {Slot} slot */
export function forget(slot) {
  links[slot].current = links[slot].waiting = null;
}

/** Ask for results: a draft during a drag, the exact ones when it has settled.
 * @param {Slot[]} slots @param {boolean} moving */
export function request(slots, moving) {
  const input = performance.now();
  for (const slot of slots) if (state[slot]) moved[slot] = true;
  document.body.dataset.settled = "no";
  draft = moving;
  asked ||= requestAnimationFrame(() => {
    asked = 0;
    for (const slot of SLOTS) if (moved[slot] && state[slot]) links[slot].ask(requestOf(slot, draft, input));
  });
  clearTimeout(settle);
  const finish = () => {
    if (asked || SLOTS.some((slot) => links[slot].busy)) {
      settle = setTimeout(finish, 30);
      return;
    }
    keepAddress();
    if (draft) for (const slot of SLOTS) if (moved[slot] && state[slot]) links[slot].ask(requestOf(slot, false, performance.now()));
    draft = false;
    for (const slot of SLOTS) moved[slot] = false;
    if (document.body.dataset.settled === "no") wakeLater();
  };
  settle = setTimeout(finish, moving ? SETTLE : 20);
}

/** @param {Slot} slot @param {boolean} rough @param {number} input */
function requestOf(slot, rough, input) {
  return {
    document: state[slot], draft: rough, frames: rough ? 160 : 320, rtol: rough ? 1e-6 : 1e-9, clock: state.view.clock,
    sensors: state.view.sensors, run_until: state.view.until, record: record.record, input,
  };
}

/** @param {Slot} slot @param {any} part @param {any} sent */
function take(slot, part, sent) {
  const kind = results[slot].take(part);
  if (kind === "beads") results[slot].accepted = sent.document;
  const record = { part: kind, draft: sent.draft, input: sent.input, shown: 0 };
  answers.push(record);
  if (answers.length > 2000) answers.splice(0, 1000);
  waiting.push(record);
  received(slot, kind);
}

/** Note when the answers of this frame are on the screen. */
export function noteShown() {
  if (!waiting.length) return;
  const shown = waiting.splice(0);
  setTimeout(() => {
    for (const record of shown) record.shown = performance.now();
    wakeLater();
  });
}

function settled() {
  return !moved.A && !moved.B && !asked && SLOTS.every((slot) => !state[slot] || ((results[slot].settled || results[slot].problem) && !links[slot].busy));
}

function wakeLater() {
  clearTimeout(later);
  later = setTimeout(() => {
    if (settled()) document.body.dataset.settled = "yes";
    else wakeLater();
  }, 30);
}
