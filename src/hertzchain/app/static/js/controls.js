/** Controls of a chain file, generated from its schema. */

import { $, Fields, button, choicesOf, hint, make, words } from "./fields.js";
import { inMillimetres, metres, parsed, valued } from "./numbers.js";
import { at, changed, listed } from "./state.js";

/** @typedef {import("./fields.js").Path} Path */

// Of these keys of a table, one has a field.
const ALTERNATIVES = [["ratio", "radius", "diameter"], ["velocity", "height", "energy"]];

const SIZES = ["first", "first_diameter", "radii", "diameters", "cell", "cell_diameters", "last", "last_diameter", "length"];

// Keys of laws of loss that a file may contain, and whose controls are not shown otherwise.
const ONLY_IF_GIVEN = ["between", "restitution", "speed", "contact"];

/** A chain whose first bead has a radius of 5 mm, or has the size 1 in a scaled chain.
 * @param {Record<string, any>} chain @param {boolean} si */
export function resized(chain, si) {
  const result = { ...chain }, names = SIZES.filter((name) => name in chain);
  const first = metres(listed(chain[names[0]])[0], 1), own = /diameter/.test(names[0]) ? 10 : 5;
  for (const name of names) {
    const sizes = listed(chain[name]).map((each) => { const size = +(metres(each, 1) / first).toPrecision(6); return si ? valued(size * own, "mm") : size; });
    result[name] = Array.isArray(chain[name]) ? sizes : sizes[0];
  }
  return result;
}

export class Controls extends Fields {
  /** @type {Set<string>} */
  opened = new Set();
  shape = "";
  /** Chosen keys of alternatives without a value, such as the diameter of a striker, by their place.
   * @type {Record<string, string>} */
  ways = {};

  get schema() {
    return this.about.schema.sections;
  }

  get keysOfForms() {
    return new Set(Object.entries(this.about.schema.forms).flat(2));
  }

  /** Show a document; elements are rebuilt if other controls are needed. @param {any} document */
  show(document) {
    this.document = document;
    const shape = this.shapeOf(document);
    if (shape !== this.shape) this.build(shape);
    for (const update of this.updates) update();
  }

  /** Keys of a document without numbers. @param {any} item @returns {string} */
  shapeOf(item) {
    return JSON.stringify(item, (name, value) => typeof value === "number" || (typeof value === "string" && /^[-+.\d]/.test(value)) ? 0 : value);
  }

  /** @param {string} shape */
  build(shape) {
    this.shape = shape;
    const focused = document.activeElement?.id;
    const top = this.host.scrollTop;
    this.updates = [];
    const chain = this.chain, inForms = this.keysOfForms, keys = this.schema.chain.keys;
    const own = new Set(["materials", "velocity", "exponent"]);
    const rest = keys.filter((/** @type {any} */ key) => !inForms.has(key.name) && !own.has(key.name));
    const tabular = (/** @type {string} */ name) => typeof listed(chain[name])[0] === "object";
    const tables = Object.keys(this.schema).filter((name) => name.startsWith("chain.")
      && (tabular(name.slice(6)) || !keys.some((/** @type {any} */ key) => key.name === name.slice(6))));
    this.host.replaceChildren(
      this.beads(keys),
      ...tables.map((name) => this.table(name)),
      this.group("more", "Static forces, masses and more", rest.some((/** @type {any} */ key) => key.name in chain),
        rest.map((/** @type {any} */ key) => this.field(["chain"], key))),
      this.ownMaterials(),
      make("p", { className: "bad", id: "problem", hidden: true, role: "alert" }),
    );
    this.host.scrollTop = top;
    if (focused && document.activeElement === document.body) $(focused)?.focus();
  }

  /** @param {any[]} keys */
  beads(keys) {
    const chain = this.chain, forms = this.about.schema.forms;
    const form = Object.keys(forms).find((name) => name in chain || name.replace("first", "last") in chain) ?? "taper";
    const choices = Object.keys(forms).filter((name) => name !== "file");
    const names = [form, ...forms[form]];
    const symbols = this.about.tapers[chain.taper] ?? {};
    const parameters = new Set(Object.values(this.about.tapers).flatMap((/** @type {any} */ each) => Object.keys(each)));
    const shown = keys.filter((key) => names.includes(key.name) && (!parameters.has(key.name) || form !== "taper" || key.name in symbols) && (key.name !== "radius" || this.si))
      .filter(({ name }) => !/^(last|ratio|length|strikers)/.test(name) || name in chain
        // A size that was cleared can be entered again.
        || (name === form.replace("first", "last") && !["ratio", "length", "rate"].some((each) => each in chain)));
    const fields = shown.map((key) => this.field(["chain"], key, symbols[key.name] ? `${words(key.name)} ${symbols[key.name]}` : undefined));
    const select = this.select("form", "defined by", choices.map((name) => [name, this.about.forms[name] ?? words(name)]), () => form, (name) => this.changeForm(name));
    const material = this.materialField(keys.find((key) => key.name === "materials"));
    const more = ["velocity", "exponent"].filter((name) => (name !== "velocity" || (this.si && (!chain.struck_by || parseFloat(chain.velocity)))) && typeof listed(chain[name])[0] !== "object")
      .map((name) => this.field(["chain"], keys.find((key) => key.name === name), name === "velocity" ? "impact velocity" : undefined));
    return make("fieldset", {}, make("legend", {}, "Beads"), select, ...fields, material, ...more);
  }

  /** @param {string} form */
  changeForm(form) {
    const { chain } = this.document, si = this.si;
    const begin = this.about.begin.forms[form];
    const dropped = this.keysOfForms;
    const kept = Object.fromEntries(Object.entries(chain).filter(([name]) => !dropped.has(name) && !(form === "mass_ratio" && ["materials", "velocity", "units"].includes(name))));
    this.change({ ...this.document, chain: { ...(si ? resized(begin, si) : begin), ...(si && form === "taper" ? { radius: "5 mm" } : {}), ...kept } }, false);
  }

  /** A table of the schema: on or off, or several. @param {string} name */
  table(name) {
    const key = name.replace("chain.", ""), section = this.schema[name], title = this.about.titles[key] ?? words(key);
    const present = this.chain[key] !== undefined;
    const entries = listed(this.chain[key]), several = section.repeated && key !== "loss";
    const path = (/** @type {number} */ i) => /** @type {Path} */ (Array.isArray(this.chain[key]) ? ["chain", key, i] : ["chain", key]);
    const items = entries.map((entry, i) => {
      const fields = this.tableFields(section, path(i), entry);
      const label = `Remove ${title}${entries.length > 1 ? ` ${i + 1}` : ""}`;
      return make("div", { className: "entry" }, ...fields, button("Remove", () => this.remove(key, i), { "aria-label": label }));
    });
    const what = present ? "Add another" : "Add", add = button(what, () => this.add(key, section), { id: `add-${key}`, "aria-label": `${what}: ${title}` });
    return this.group(key, title, present, [hint(section.description), ...items, ...(present && !several ? [] : [add])]);
  }

  ownMaterials() {
    const own = Object.keys(this.document.materials ?? {}), section = this.schema["materials.NAME"];
    const entries = own.map((name) => {
      const remove = button("Remove", () => this.put(["materials", name], undefined), { "aria-label": `Remove material ${name}` });
      return make("div", { className: "entry" }, hint(name), ...this.tableFields(section, ["materials", name], this.document.materials[name]), remove);
    });
    const what = own.length ? "Add another" : "Add", add = button(what, () => {
      let number = 1;
      while (own.includes(`material ${number}`)) number++;
      this.opened.add("materials");
      this.put(["materials", `material ${number}`], this.about.begin.material);
    }, { id: "add-material", "aria-label": `${what}: own material` });
    return this.group("materials", "Own materials", own.length > 0, [hint(section.description), ...entries, add]);
  }

  /** @param {string} name @param {string} title @param {boolean} used @param {Node[]} children */
  group(name, title, used, children) {
    const details = make("details", { className: "group", id: `group-${name}` }, make("summary", {}, title, ...(used ? [make("span", { className: "used", title: "used" }, "●")] : [])), ...children);
    details.open = this.opened.has(name) || (used && !this.opened.has(`-${name}`));
    details.firstElementChild?.addEventListener("click", () => {
      this.opened.delete(details.open ? name : `-${name}`);
      this.opened.add(details.open ? `-${name}` : name);
    });
    return details;
  }

  /** @param {any} section @param {Path} path @param {any} entry @returns {Node[]} */
  tableFields(section, path, entry) {
    const fields = [], variant = section.variant_key;
    if (variant) {
      fields.push(this.select(path.join("."), variant, choicesOf(Object.keys(section.variants)), () => at(this.document, path)?.[variant],
        (chosen) => this.put(path, this.begin({ keys: section.variants[chosen] }, { [variant]: chosen }))));
    }
    const keys = variant ? section.variants[entry[variant]] ?? [] : section.keys;
    const common = variant ? section.keys.filter((/** @type {any} */ key) => !ONLY_IF_GIVEN.includes(key.name) || key.name in entry) : [];
    const given = (/** @type {string} */ name) => at(this.document, [...path, name]) !== undefined;
    const all = [...common, ...keys].filter(({ kind, name }) => kind !== "file" && kind !== "signal" && (this.si || given(name) || !/^(height|energy)$/.test(name)));
    for (const key of all) {
      const ways = ALTERNATIVES.find((names) => names.includes(key.name))?.filter((name) => all.some((each) => each.name === name)) ?? [];
      const id = [...path, ways[0]].join("."), way = ways.find(given) ?? this.ways[id] ?? ways[0];
      if (ways.length > 1 && key.name === way) {
        fields.push(this.select(`${id}-by`, ways[0] === "velocity" ? "impact by" : "size by", choicesOf(ways), () => way, (name) => this.changeWay(path, way, name, id)));
      }
      if (ways.length < 2 || key.name === way || given(key.name)) fields.push(this.field(path, key));
    }
    return fields;
  }

  /** Another alternative, with twice the radius for the diameter. @param {Path} path @param {string} before @param {string} name @param {string} id */
  changeWay(path, before, name, id) {
    const { number, unit } = parsed(at(this.document, [...path, before]), ""), { SI, other } = this.about.begin;
    const factor = before === "radius" && name === "diameter" ? 2 : before === "diameter" && name === "radius" && 0.5;
    if (factor && number === null) {
      this.ways[id] = name;
      this.build(this.shape);
      for (const update of this.updates) update();
    } else {
      this.document = changed(this.document, [...path, before], undefined);
      this.put([...path, name], factor && number ? valued(number * factor, unit) : (this.si && SI[name]) || (other[name] ?? other.radius));
    }
  }

  /** @param {any} section @param {any} table */
  begin(section, table) {
    for (const key of section.keys) {
      const low = key.least ?? key.above ?? 0, high = key.most ?? key.below ?? low + 1;
      if (!key.required && key.per !== "row" && !["relative", "ratio"].includes(key.name)) continue;
      const { SI, other } = this.about.begin, si = this.si ? SI[key.name] ?? SI[key.dimension] : undefined;
      table[key.name] = si ?? other[key.name] ?? (key.kind === "boolean" ? false : key.choices?.[0] ?? valued((low + high) / 2, this.unitOf(key)));
    }
    return table;
  }

  /** @param {string} key @param {any} section */
  add(key, section) {
    const variant = section.variant_key ? Object.keys(section.variants)[key === "loss" ? 1 : 0] : "";
    const keys = variant ? section.variants[variant] : section.keys;
    const entry = this.begin({ keys }, variant ? { [section.variant_key]: variant } : {});
    const before = listed(this.chain[key]);
    // A defect has 1.5 times the size of the chosen bead.
    const { size } = this.about.begin;
    if (entry.bead && size) {
      const wide = /diameter/.test(Object.keys(this.chain).join()), own = +(size * (wide ? 3 : 1.5)).toPrecision(2);
      delete entry.radius;
      entry[wide ? "diameter" : "radius"] = this.si ? inMillimetres(own) : own;
    }
    this.opened.add(key);
    // The first striker has the velocity of the impact, and bead 1 is then at rest.
    const moving = key === "struck_by" && !before.length && parseFloat(this.chain.velocity) > 0;
    if (moving) entry.velocity = this.chain.velocity;
    this.putAll(["chain", key], section.repeated && key !== "loss" ? [...before, entry] : entry, moving ? { velocity: undefined } : {});
  }

  /** @param {string} key @param {number} i */
  remove(key, i) {
    const before = listed(this.chain[key]), left = before.filter((_, place) => place !== i);
    const back = key === "struck_by" && this.si && !left.length && before[i].velocity && !parseFloat(this.chain.velocity);
    this.putAll(["chain", key], left.length ? left : undefined, back ? { velocity: before[i].velocity } : {});
  }

  /** With other values of the chain. @param {Path} path @param {any} value @param {Record<string, any>} more */
  putAll(path, value, more) {
    this.document = Object.entries(more).reduce((document, [name, each]) => changed(document, ["chain", name], each), this.document);
    this.put(path, value);
  }

  /** @param {Path} path @param {any} key @param {string} [label] @returns {HTMLElement} */
  field(path, key, label = words(key.name)) {
    const place = [...path, key.name];
    if (key.kind === "law") return this.lawField(place, key);
    if (key.kind === "boolean") return this.checkField(place, key, label);
    if (key.kind === "choice") {
      // Tapers of given sizes have other names, and a default.
      const taper = key.name === "taper", sized = !this.chain.rate && /"first/.test(JSON.stringify(this.chain));
      const choices = choicesOf(taper ? key.choices.filter((/** @type {string} */ each) => sized === /^(exponential|linear)$/.test(each)) : key.choices);
      return this.select(place.join("."), label, key.required || taper ? choices : [["", key.default ?? "automatic"], ...choices],
        () => at(this.document, place) ?? (taper ? "exponential" : ""), (chosen) => this.chooseKey(place, key, chosen), key.description);
    }
    if (key.kind === "material") return this.materialOf(place, key);
    const list = Array.isArray(at(this.document, place)), single = key.one_for_all && key.default !== null && !list;
    if (key.kind === "text" || (key.per && !single)) return this.listField(place, key, label);
    return this.numberField(place, key, label);
  }

  /** @param {Path} place @param {any} key @param {string} chosen */
  chooseKey(place, key, chosen) {
    if (key.name !== "taper") return this.put(place, chosen || undefined);
    const chain = { ...this.chain, taper: chosen }, beads = chain.beads ?? 40;
    for (const each of Object.values(this.about.tapers)) for (const name of Object.keys(/** @type {any} */ (each))) delete chain[name];
    for (const name of Object.keys(this.about.tapers[chosen] ?? {})) {
      chain[name] = chosen === "forward-linear" ? +(0.65 / (beads - 1)).toPrecision(2) : chosen.endsWith("linear") ? 0.2 : 0.05;
    }
    this.last = place.join(".");
    this.change({ ...this.document, chain }, false);
  }

  /** @param {any} key */
  materialField(key) {
    const own = Object.keys(this.document.materials ?? {}), names = [...this.about.materials, ...own];
    const value = this.chain.materials, several = Array.isArray(value);
    const choices = /** @type {[string, string][]} */ ([["", "scaled, no material"], ...choicesOf(names), ...(several ? [["several", "several"]] : [])]);
    const select = this.select("chain.materials", "material", choices, () => (several ? "several" : at(this.document, ["chain", "materials"]) ?? ""), (chosen) => this.changeMaterial(chosen), key.description);
    return several ? make("div", {}, select, this.listField(["chain", "materials"], key, "of each bead")) : select;
  }

  /** Change to a material, or to scaled variables, in which lengths in metres have no meaning.
   * @param {string} chosen */
  changeMaterial(chosen) {
    if (chosen === "several") return;
    let chain = { ...this.chain };
    this.last = "chain.materials";
    if (chosen) {
      if (!this.si) {
        for (const name of Object.keys(chain)) if (this.isTable(name)) delete chain[name];
        chain = resized(chain, true);
        if ("mass_ratio" in chain) Object.assign(chain, { taper: "uniform" }), delete chain.mass_ratio;
        if ("taper" in chain) chain.radius = "5 mm";
        chain.velocity = "0.1 m/s";
      }
      chain.materials = chosen;
    } else {
      for (const name of ["materials", "radius", "velocity", "units"]) delete chain[name];
      chain = resized(chain, false);
      for (const name of Object.keys(chain)) if (this.isTable(name) || (typeof chain[name] === "string" && /^[\d.].*[^%]$/.test(chain[name]))) delete chain[name];
    }
    this.change({ ...this.document, chain }, false);
  }

  /** Whether a key is a table with quantities that have units. @param {string} name */
  isTable(name) {
    const section = this.schema[`chain.${name}`], entries = listed(this.chain[name]);
    return section && [section.keys, ...Object.values(section.variants ?? {})].flat().some((/** @type {any} */ key) => (key.dimension || key.kind === "law") && entries.some((each) => each?.[key.name] !== undefined));
  }

  /** @param {Path} place @param {any} key */
  materialOf(place, key) {
    const names = [...this.about.materials, ...Object.keys(this.document.materials ?? {})];
    if (!this.si) return make("span", { hidden: true });
    if (key.per) return this.listField(place, key, words(key.name));
    const like = place.includes("struck_by") ? "as the first ball" : place.includes("right_wall") ? "as the last bead" : place.includes("left_wall") ? "as the first bead" : "as the beads";
    return this.select(place.join("."), words(key.name), [["", like], ...choicesOf(names)],
      () => at(this.document, place) ?? "", (chosen) => this.put(place, chosen || undefined), key.description);
  }

  /** @param {Path} place @param {any} key */
  lawField(place, key) {
    const section = this.schema["chain.loss"], entry = at(this.document, place);
    if (entry) return make("div", { className: "entry" }, ...this.tableFields(section, place, entry), button("Use the chain’s loss", () => this.put(place, undefined)));
    return this.select(place.join("."), words(key.name), [["", "the chain’s"], ...choicesOf(Object.keys(section.variants))], () => "",
      (chosen) => chosen && this.put(place, this.begin({ keys: section.variants[chosen] }, { law: chosen })), key.description);
  }
}
