/** Dialogs: examples, and what can be shared or saved. */

import { svg } from "./chart.js";
import { $, make } from "./fields.js";
import { host } from "./host.js";

/** @typedef {{open: (example: any, slot: "A" | "B") => void, document: () => any, request: () => any,
 *   say: (text: string, bad?: boolean) => void, link: () => string}} Handlers */

/** Offer a file to save. @param {string} name @param {Blob} blob */
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

/** @param {any} about @param {Handlers} on */
export function fillDialogs(about, on) {
  const examples = $("examples"), share = $("share-dialog");
  const failed = (/** @type {Error} */ error) => on.say(error.message, true);
  $("gallery").replaceChildren(...about.gallery.map((/** @type {any} */ example) => {
    const choose = (/** @type {"A" | "B"} */ slot) => {
      examples.close();
      on.open(example, slot);
    };
    return make("li", { className: "example" }, picture(example.radii, example.moving), make("h3", {}, example.title), make("p", {}, example.look_for),
      make("div", { className: "actions" },
        make("button", { className: "primary", "aria-label": `Open ${example.title}`, onclick: () => choose("A") }, "Open"),
        make("button", { "aria-label": `Open as chain B: ${example.title}`, onclick: () => choose("B") }, "Open as chain B")));
  }));
  for (const [button, dialog] of [["open-examples", examples], ["open-share", share], ["open-help", $("help")]]) {
    $(button).onclick = () => /** @type {any} */ (dialog).showModal();
  }
  for (const close of document.querySelectorAll("dialog .close")) close.addEventListener("click", () => close.closest("dialog")?.close());

  $("copy-link").onclick = async () => {
    share.close();
    try {
      await navigator.clipboard.writeText(on.link());
      on.say("Link copied.");
    } catch {
      on.say("Copy the address of the page instead.", true);
    }
  };
  for (const button of document.querySelectorAll("[data-export]")) {
    button.addEventListener("click", () => {
      const kind = /** @type {HTMLElement} */ (button).dataset.export;
      on.say("Preparing the file …");
      share.close();
      host.save({ ...on.request(), kind, document: on.document(), figure: $("figure").value, format: $("format").value }).then(({ name, blob }) => {
        offer(name, blob);
        on.say(`Saved ${name}.`);
      }, failed);
    });
  }
}
