/** Elements of the page, and labelled fields that show and change values of a document. */

import { FACTORS, SHOWN, STEPS, entered, parsed, plain, positionOf, rangeOf, valueAt, valued } from "./numbers.js";
import { at, changed, listed } from "./state.js";

/** @typedef {import("./state.js").Document} Document */
/** @typedef {(document: Document, moving: boolean) => void} Change */
/** @typedef {(string | number)[]} Path */

/** @param {string} id @returns {any} */
export const $ = (id) => document.getElementById(id);

/** @param {string} tag @param {Record<string, any>} [properties] @param {...(Node | string)} children @returns {any} */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.includes("-") || name === "for" || name === "role" || name === "list") element.setAttribute(name, value);
    else /** @type {any} */ (element)[name] = value;
  }
  element.append(...children);
  return element;
}

/** @param {string} name */
export const words = (name) => name.replaceAll("_", " ");

/** @param {string[]} names @returns {[string, string][]} */
export const choicesOf = (names) => names.map((each) => [each, each]);

/** @param {string} text @param {() => void} onclick @param {Record<string, string>} [more] */
export const button = (text, onclick, more) => make("button", { type: "button", className: "small", onclick, ...more }, text);

/** @param {string} text */
export const hint = (text) => make("p", { className: "hint" }, text);

export class Fields {
  /** @type {Document} */
  document = { chain: {} };
  /** @type {(() => void)[]} */
  updates = [];
  /** The field that was changed last. */
  last = "";
  refused = false;

  /** @param {HTMLElement} host @param {any} about @param {Change} change
   * @param {() => Document | null} accepted the last document without an error */
  constructor(host, about, change, accepted) {
    this.accepted = accepted;
    this.host = host;
    this.about = about;
    this.change = change;
  }

  get chain() {
    return this.document.chain;
  }

  get si() {
    return this.chain.materials !== undefined || this.chain.units === "SI";
  }

  /** @param {Path} path @param {any} value @param {boolean} [moving] */
  put(path, value, moving = false) {
    this.last = path.join(".");
    this.change(changed(this.document, path, value), moving);
  }

  /** @param {string} id @param {string} label @param {[string, string][]} choices @param {() => string} read
   * @param {(chosen: string) => void} write @param {string} [title] */
  select(id, label, choices, read, write, title = "") {
    const select = make("select", { id: `c-${id}`, title }, ...choices.map(([value, text]) => make("option", { value }, text)));
    select.onchange = () => write(select.value);
    this.updates.push(() => { select.value = read(); });
    return make("div", { className: "row choice" }, make("label", { for: select.id }, label), select);
  }

  /** @param {Path} place @param {any} key @param {string} label */
  checkField(place, key, label) {
    const box = make("input", { type: "checkbox", id: `c-${place.join(".")}` });
    box.onchange = () => this.put(place, box.checked);
    this.updates.push(() => { box.checked = at(this.document, place) ?? key.default ?? false; });
    return make("div", { className: "row choice" }, make("label", { for: box.id, title: key.description }, label), box);
  }

  /** Unit in which a key is shown. @param {any} key @param {any} [value] */
  unitOf(key, value) {
    const own = parsed(value, "").unit;
    if (key.fraction && own === "%") return own;
    if (!key.dimension || (!this.si && !["density", "pressure"].includes(key.dimension))) return "";
    return own || (FACTORS[key.unit] === undefined ? "" : SHOWN[key.dimension] ?? key.unit);
  }

  /** Unit of a stiffness without one. @param {Path} place @param {any} key @param {any} value */
  unitOfStiffness(place, key, value) {
    const given = at(this.document, [...place.slice(0, -1), "exponent"]) ?? this.chain.exponent ?? 1.5, exponent = typeof given === "object" ? "exponent" : +given;
    return this.si && key.dimension === "stiffness" && typeof value === "number" && exponent ? `N/m${exponent === 1 ? "" : `^${exponent}`}` : "";
  }

  /** Unit of a field; if the document has an error, that of the last valid value. @param {Path} place @param {any} key */
  unitAt(place, key) {
    const value = at((this.refused && this.accepted()) || this.document, place);
    return this.unitOf(key, value) || (value >= 1e6 && this.unitOfStiffness(place, key, value) === "N/m" ? "kN/mm" : "");
  }

  /** @param {Path} place @param {any} key @param {string} label */
  numberField(place, key, label) {
    if (key.dimension_if_displacement && at(this.document, [...place.slice(0, -1), "of"]) === "displacement") key = { ...key, dimension: "length" };
    const id = `c-${place.join(".")}`, read = () => at(this.document, place), usual = key.default ?? null;
    const box = make("input", { type: "text", id, inputMode: key.kind === "integer" ? "numeric" : "", spellcheck: false, placeholder: usual === null ? "auto" : plain(usual) });
    const slider = make("input", { type: "range", min: "0", max: String(STEPS), step: "1", "aria-label": `${label}, slider` });
    const unit = make("span", { className: "unit" }), reset = `Use the default for ${label}`;
    const clear = make("button", { type: "button", className: "clear", title: reset, "aria-label": reset, onclick: () => this.put(place, undefined) }, "×");
    const rangeNow = () => {
      const value = read(), unit = this.unitAt(place, key), chain = this.chain;
      return rangeOf(key, this.si, parsed(value, unit).number, { beads: chain.beads, taper: chain.taper, unit });
    };
    let range = rangeNow(), typing = false;
    const write = (/** @type {number} */ value, /** @type {boolean} */ moving) => this.put(place, valued(value, this.unitAt(place, key)), moving);
    slider.onpointerdown = () => { range = rangeNow(); };
    slider.oninput = () => write(valueAt(Number(slider.value), range), true);
    slider.onchange = () => write(valueAt(Number(slider.value), range), false);
    box.oninput = box.onchange = (/** @type {Event} */ { type }) => {
      const given = entered(box.value);
      typing = type === "input";
      if (typeof given === "number") this.put(place, valued(given, this.unitAt(place, key).replace("%", "")), typing);
      else if (!typing) this.put(place, given);
    };
    box.onblur = () => { typing = false; };
    this.updates.push(() => {
      const value = read(), own = this.unitAt(place, key), given = parsed(value, own), shown = given.unit === own ? given : { number: null, unit: own };
      const text = shown.number === null ? "" : plain(shown.number, key.kind === "integer" ? 12 : 6);
      if (document.activeElement !== slider) range = rangeNow();
      if (!typing) box.value = shown.number === null ? value ?? "" : text + (shown.unit === "%" ? "%" : "");
      const position = positionOf(shown.number ?? usual, range);
      if (document.activeElement !== slider || Math.abs(valueAt(Number(slider.value), range) - (shown.number ?? NaN)) > 1e-9 * Math.abs(shown.number ?? 1)) slider.value = String(position);
      slider.setAttribute("aria-valuetext", shown.number === null ? "default" : `${text} ${shown.unit}`);
      slider.classList.toggle("idle", value === undefined);
      unit.textContent = shown.unit.replace("%", "") || this.unitOfStiffness(place, key, value);
      // A required key may be cleared if its alternative is there, such as a diameter for a radius.
      const required = key.required && (!key.unless || at(this.document, [...place.slice(0, -1), key.unless]) === undefined);
      clear.hidden = value === undefined || required || ["rate", "beads", "cells", "mass_ratio"].includes(key.name);
    });
    return make("div", { className: "row", title: key.description }, make("label", { for: id }, label), make("span", { className: "value" }, clear, box, unit), slider);
  }

  /** @param {Path} place @param {any} key @param {string} label */
  listField(place, key, label) {
    const unit = make("span", { className: "unit" }), box = make("input", { type: "text", id: `c-${place.join(".")}`, placeholder: key.default ?? (key.per ? `one per ${key.per}` : ""), spellcheck: false });
    const own = (/** @type {any} */ each) => typeof each === "number" ? valued(each, this.unitOf(key)) : each;
    const shown = (/** @type {any} */ each) => { const { number, unit } = parsed(each, this.unitOf(key, each)); return number === null ? each : `${plain(number)} ${unit}`.trim(); };
    box.onchange = () => { const given = listOf(box.value, key); this.put(place, Array.isArray(given) ? given.map(own) : own(given)); };
    this.updates.push(() => {
      const value = at(this.document, place);
      if (document.activeElement !== box || !box.value) box.title = box.value = listed(value).map(key.kind === "number" ? shown : String).join(", ");
      unit.textContent = this.unitOfStiffness(place, key, listed(value)[0] ?? 1);
    });
    return make("div", { className: "row wide", title: key.description }, make("label", { for: box.id }, label), unit, box);
  }

  /** Mark the fields of errors, and show the message next to one of them. An error that appears is that of the
   * field in its text, or of the last change. @param {string} message @param {Record<string, string>} causes fields of errors */
  problem(message, causes) {
    const text = $("problem");
    text.textContent = message;
    if (this.refused !== !!message) {
      this.refused = !!message;
      for (const update of this.updates) update();
    }
    text.hidden = !message;
    for (const each of this.host.querySelectorAll("[aria-invalid]")) each.removeAttribute("aria-invalid");
    this.host.append(text);
    if (!message) return;
    for (const each of message.replace(/^\d+ errors:\n/, "").split("\n")) {
      const key = "." + each.match(/^ *(?:value \d+ of )?([\w ]+?)(?: of (?!bead)[\w ]+)? must/)?.[1].replaceAll(" ", "_");
      const field = causes[each] ??= (!this.last.includes(key) && this.host.querySelector(`[id$="${key}"]`)?.id.slice(2)) || this.last;
      const control = $(`c-${field}`), row = control?.closest(".row");
      if (!row) continue;
      control.setAttribute("aria-invalid", "true");
      control.setAttribute("aria-errormessage", "problem");
      if (field === this.last || text.parentNode === this.host) row.after(text);
    }
  }
}

/** @param {string} text @param {any} key */
export function listOf(text, key) {
  // The server explains a comma that may be a decimal comma.
  const listing = !/,\s|;/.test(text) && /\.\d|\d,[-+\de]+,[-+\de]+(,|$)/i.test(text.trim());
  if (!listing && key.kind === "number" && /(?<![\d.])\d+,\d+(?![\d.])/.test(text)) return text;
  const items = text.split(/[,;\n]+/).map((each) => each.trim()).filter(Boolean)
    .map((each) => (key.kind === "number" ? entered(each) : each));
  if (!items.length) return undefined;
  return items.length === 1 && key.one_for_all ? items[0] : key.kind === "text" ? text : items;
}
