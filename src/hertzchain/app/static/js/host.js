/** Where results come from: the local server, the page itself, or a notebook. */

import { Splitter } from "./results.js";

/** @typedef {import("./results.js").Part} Part */
/** @typedef {{name: string, blob: Blob}} File */
/** @typedef {{about: () => Promise<any>, results: (body: any, received: (part: Part) => void) => Promise<void>,
 *   read: (text: string) => Promise<any>, record: (body: any) => Promise<any>, save: (body: any) => Promise<File>, state: (state: any) => void}} Host */

/** The server did not answer. */
export class OfflineError extends Error {}

const embedded = document.getElementById("embedded");
/** What is stored in the page: nothing, if a server has sent it.
 * @type {{kind: "saved" | "notebook", about: any, parts?: string} | null} */
export const stored = embedded ? JSON.parse(embedded.textContent ?? "null") : null;
/** Whether the chain cannot be changed. */
export const fixed = stored?.kind === "saved";

/** Results that a server sends with the page: those of its first requests, unless a link replaces the chains.
 * @type {{about: any, slots: string[], parts: string} | null} */
const first = JSON.parse(document.getElementById("first")?.textContent ?? "null");
const unused = new Set(location.hash ? [] : first?.slots);

/** Take stored messages of a chain. @param {string} text @param {string} slot @param {(part: Part) => void} received */
function unpackStored(text, slot, received) {
  const bytes = Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
  for (const part of new Splitter().add(bytes)) if (part.header.slot === slot) received(part);
}

/** @returns {never} */
function offline() {
  throw new OfflineError("The server does not answer. Is `hertzchain app` still running? Trying again …");
}

/** @param {string} path @param {string} type @param {string} body */
async function post(path, type, body) {
  const answer = await fetch(path, { method: "POST", headers: { "content-type": type }, body }).catch(offline);
  if (!answer.ok) throw new Error(await answer.text());
  return answer;
}

/** An answer, which may be the reason why a file is rejected. @param {string} path @param {string} type @param {string} body */
async function read(path, type, body) {
  const { error, ...found } = await (await post(path, type, body)).json();
  if (error) throw new Error(error);
  return found;
}

/** @type {Host} */
const server = {
  about: async () => first?.about ?? (await fetch("/api/about")).json(),
  async results(body, received) {
    if (first && unused.delete(body.slot)) return unpackStored(first.parts, body.slot, received);
    const answer = await post("/api/results", "application/json", JSON.stringify(body));
    const reader = /** @type {any} */ (answer.body).getReader(), splitter = new Splitter();
    for (;;) {
      const { done, value } = await reader.read().catch(offline);
      if (done) return;
      splitter.add(value).forEach(received);
    }
  },
  read: async (text) => (await read("/api/chain", "application/toml", text)).document,
  record: (body) => read("/api/record", "application/json", JSON.stringify(body)),
  async save(body) {
    const answer = await post("/api/export", "application/json", JSON.stringify(body));
    return { name: /filename="([^"]+)"/.exec(answer.headers.get("content-disposition") ?? "")?.[1] ?? "chain", blob: await answer.blob() };
  },
  state() {},
};

/** Results that are stored in the page, which has no buttons to open or save files.
 * @type {Host} */
const saved = {
  ...server,
  about: async () => stored?.about,
  async results(body, received) {
    unpackStored(stored?.parts ?? "", body.slot, received);
  },
};

/** A notebook, whose cell relays messages between this frame and Python.
 * @returns {Host} */
function notebook() {
  let last = 0;
  /** @type {Map<number, (content: any, buffers: ArrayBuffer[]) => void>} */
  const pending = new Map();
  addEventListener("message", (event) => {
    if (event.source === parent && event.data?.content) pending.get(event.data.content.id)?.(event.data.content, event.data.buffers);
  });
  const ask = (/** @type {string} */ type, /** @type {any} */ body, /** @type {(buffer: ArrayBuffer) => void} */ received = () => {}) => new Promise((done, failed) => {
    const id = ++last;
    pending.set(id, (content, buffers) => {
      buffers.forEach(received);
      if (!content.done) return;
      pending.delete(id);
      if (content.error) failed(new Error(content.error));
      else done({ ...content, buffers });
    });
    parent.postMessage({ id, type, body }, "*");
  });
  return {
    about: async () => stored?.about,
    async results(body, received) {
      await ask("results", body, (buffer) => new Splitter().add(new Uint8Array(buffer)).forEach(received));
    },
    read: async (text) => (await ask("read", text)).document,
    record: (body) => ask("record", body),
    async save(body) {
      const { name, media_type: type, buffers } = await ask("export", body);
      return { name, blob: new Blob(buffers, { type }) };
    },
    state: (state) => { void ask("state", state); },
  };
}

export const host = fixed ? saved : stored ? notebook() : server;
