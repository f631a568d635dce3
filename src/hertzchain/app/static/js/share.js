/** Dialogs: examples, and what can be shared or saved. */

import { svg } from "./chart.js";
import { $, make } from "./fields.js";
import { host, stored } from "./host.js";
import { about, own, record, say, state } from "./page.js";
import { openAs } from "./show.js";
import { copy, toLink } from "./state.js";

/** @param {string} name @param {Blob} blob */
function offer(name, blob) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** A chain as a picture, whose first beads move. @param {number[]} radii @param {number} moving */
function picture(radii, moving) {
  const long = radii.reduce((sum, r) => sum + 2 * r, 0), most = Math.max(...radii), tall = Math.max(2 * most, long / 12);
  const drawing = svg("svg", { viewBox: `0 0 ${long} ${tall}`, "aria-hidden": "true", class: "picture" });
  let x = 0;
  radii.forEach((r, k) => {
    drawing.append(svg("circle", { cx: x + r, cy: tall / 2, r: 0.96 * r, class: k < moving ? "first" : "" }));
    x += 2 * r;
  });
  return drawing;
}

function request() {
  const { view } = state, { sensors, quantity, clock, until } = view, slot = state.active, other = state.B && state[slot === "A" ? "B" : "A"];
  return {
    document: state[slot], slot, sensors, quantity, clock, frames: 320, run_until: until, record: record.record,
    until: own().run.header?.peaks.right?.first && !until ? undefined : own().motion?.times.at(-1), other, view: { view, B: other, record: { shift: record.shift } },
  };
}

/** Show a message in the dialog, which remains open, and below the page. @param {string} text @param {boolean} [bad] */
function tell(text, bad = false) {
  $("share-status").textContent = text;
  $("share-status").classList.toggle("bad", bad);
  if (text) say(text, bad);
}

export function fillDialogs() {
  const examples = $("examples"), share = $("share-dialog");
  $("gallery").replaceChildren(...about.gallery.map((/** @type {any} */ example) => {
    const choose = (/** @type {"A" | "B"} */ slot) => {
      examples.close();
      const { document, other = null } = copy(example), sensors = example.view.sensors ?? (slot === "B" ? state.view.sensors : []);
      openAs(slot, document, other, sensors, example.view.until);
      say(example.look_for);
    };
    return make("li", { className: "example" }, picture(example.radii, example.moving), make("h3", {}, example.title), make("p", {}, example.look_for),
      make("div", { className: "actions" },
        make("button", { className: "primary", "aria-label": `Open ${example.title}`, onclick: () => choose("A") }, "Open"),
        make("button", { "aria-label": `Open as chain B: ${example.title}`, onclick: () => choose("B") }, "Open as chain B")));
  }));
  for (const [button, dialog] of [["open-examples", examples], ["open-share", share], ["open-help", $("help")]]) {
    $(button).onclick = () => /** @type {any} */ (dialog).showModal();
  }
  $("open-share").addEventListener("click", () => {
    const description = own().beads.header?.description ?? "", { problem } = own();
    $("share-of").textContent = state.B ? `Chain ${state.active} of A and B${problem ? " has an error" : description && `: ${description}`}. The link, the page and the figure of the leading pulse contain both chains; the other files contain only this one.` : description;
    for (const each of document.querySelectorAll("[data-export]")) /** @type {any} */ (each).disabled = problem;
    tell(problem, true);
  });
  for (const close of document.querySelectorAll("dialog .close")) close.addEventListener("click", () => close.closest("dialog")?.close());

  $("copy-link").onclick = async () => {
    try {
      await navigator.clipboard.writeText((stored ? "http://127.0.0.1:8765/" : location.origin + location.pathname) + toLink(state));
      tell("Link copied.");
    } catch {
      tell("Copy the address of the page instead.", true);
    }
  };
  for (const button of document.querySelectorAll("[data-export]")) {
    button.addEventListener("click", () => {
      const kind = /** @type {HTMLElement} */ (button).dataset.export;
      tell("Preparing the file …");
      host.save({ ...request(), kind, figure: $("figure").value, format: $("format").value }).then(({ name, blob }) => {
        offer(name, blob);
        tell(`Saved ${name}.`);
      }, (error) => tell(error.message, true));
    });
  }
}
