// @ts-check
/** Requests for results: the latest wins, here and on the server. */

import { Splitter } from "./parts.js";

/** Milliseconds after which a request that has not been answered is replaced. */
const PATIENCE = 250;
/** Milliseconds between maps during a drag: in between, the leading pulse has precedence. */
const BETWEEN_MAPS = 120;

/** @typedef {{number: number, draft: boolean, sent: number, input: number}} Sent */
/** @typedef {{part: (part: import("./parts.js").Part, sent: Sent) => void, offline: (message: string) => void}} Handlers */

let numbers = 0;
const session = Array.from(crypto.getRandomValues(new Uint8Array(12)), (each) => each.toString(36)).join("").slice(0, 24);

/** Requests for one of the chains. */
export class Link {
  /** @param {string} slot @param {Handlers} on */
  constructor(slot, on) {
    this.slot = slot;
    this.on = on;
    /** @type {Sent | null} */
    this.current = null;
    /** @type {any} */
    this.waiting = null;
    this.timer = 0;
    this.retry = 0;
    this.lastMap = 0;
  }

  get busy() {
    return this.current !== null || this.waiting !== null;
  }

  /** @param {any} request */
  ask(request) {
    this.waiting = request;
    clearTimeout(this.retry);
    // A draft is short: the next request waits for it, so that each drag shows results.
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
    const sent = { number: ++numbers, draft: Boolean(rest.draft), sent: performance.now(), input };
    this.current = sent;
    void this.stream({ ...rest, session, slot: this.slot, number: sent.number }, sent, request);
  }

  /** @param {import("./parts.js").Part} part @param {Sent} sent */
  received(part, sent) {
    this.on.part(part, sent);
    const now = performance.now(), kind = part.header.part;
    if (kind === "run") this.lastMap = now;
    if (kind === "pulse" && sent.draft && this.waiting?.draft && now - this.lastMap < BETWEEN_MAPS) this.send();
  }

  /** @param {any} body @param {Sent} sent @param {any} request */
  async stream(body, sent, request) {
    let failure = "";
    try {
      const answer = await fetch("/api/results", {
        method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body),
      });
      if (!answer.ok || !answer.body) throw new Error(await answer.text());
      const reader = answer.body.getReader(), splitter = new Splitter();
      for (;;) {
        const { done, value } = await reader.read();
        if (done) break;
        for (const part of splitter.add(value)) if (this.current === sent) this.received(part, sent);
      }
    } catch (error) {
      failure = error instanceof TypeError ? "The server does not answer. Is `hertzchain app` still running? Trying again …" : String(error);
    }
    if (this.current !== sent) return;
    this.current = null;
    if (failure) {
      this.on.offline(failure);
      this.waiting ??= request;
      this.retry = setTimeout(() => this.send(), 1500);
    } else if (this.waiting) this.send();
  }
}

/** Results that are stored in the page. */
export class SavedLink {
  /** @param {string} slot @param {Handlers} on @param {import("./parts.js").Part[]} parts */
  constructor(slot, on, parts) {
    this.busy = false;
    this.on = on;
    this.parts = parts.filter((part) => part.header.slot === slot);
  }

  /** @param {any} request */
  ask(request) {
    const sent = { number: 0, draft: false, sent: performance.now(), input: request.input };
    queueMicrotask(() => this.parts.forEach((part) => this.on.part(part, sent)));
  }
}
