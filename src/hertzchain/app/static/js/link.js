/** Requests for results: the latest wins, here and on the server. */

import { OfflineError, host } from "./host.js";

/** Milliseconds after which a request that has not been answered is replaced. */
const PATIENCE = 250;
/** Milliseconds between maps during a drag. */
const BETWEEN_MAPS = 120;

/** @typedef {{number: number, draft: boolean, sent: number, input: number, document: any}} Sent */
/** @typedef {{part: (part: import("./results.js").Part, sent: Sent) => void, offline: (message: string) => void}} Handlers */

let numbers = 0;
const session = String(Math.random());

export class Link {
  /** @type {Sent | null} */
  current = null;
  /** @type {any} */
  waiting = null;
  timer = 0;
  retry = 0;
  lastMap = 0;

  /** @param {string} slot @param {Handlers} on */
  constructor(slot, on) {
    this.slot = slot;
    this.on = on;
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

  /** @param {import("./results.js").Part} part @param {Sent} sent */
  received(part, sent) {
    this.on.part(part, sent);
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
      this.on.offline(failure);
      if (!offline) return;
      this.waiting ??= request;
      this.retry = setTimeout(() => this.send(), 1500);
    } else if (this.waiting) this.send();
  }
}
