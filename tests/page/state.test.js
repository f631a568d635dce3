import assert from "node:assert/strict";
import { test } from "node:test";

import { resized } from "../../src/hertzchain/app/static/js/controls.js";
import { listOf } from "../../src/hertzchain/app/static/js/fields.js";
import { FACTORS } from "../../src/hertzchain/app/static/js/numbers.js";
import { History, VIEW, changed, copy, fromLink, toLink, withRadius } from "../../src/hertzchain/app/static/js/state.js";

Object.assign(FACTORS, { m: 1, cm: 1e-2, mm: 1e-3, in: 25.4e-3, "m/s": 1, "mm/s": 1e-3, "%": 1e-2 });

const TAPER = { chain: { taper: "backward-exponential", rate: 0.05, beads: 40 } };
const RICH = {
  chain: {
    radii: ["5 mm", "4.5 mm"], beads: 12, materials: ["steel-52100", "soft & odd=ly #1.5%"], velocity: "0.5 m/s",
    struck_by: [{ velocity: 1e-7, radius: "inf" }, { count: 2 }], right_wall: {}, left_wall: { loss: { law: "dashpot", gamma: 0.1 } },
    loss: { law: "restitution", coefficient: 0.9 }, with_scatter: { seed: 7, relative: 0.1 }, held_by: "true", units: "SI",
  },
  materials: { "soft & odd=ly #1.5%": { density: 1e3, young: 2.5e6, poisson: 0.3, source: "a book, 2.5 % off" } },
};

test("links are readable, and return the same state", () => {
  const state = { A: TAPER, B: null, active: "A", view: copy(VIEW) };
  assert.equal(toLink(state), "#taper=backward-exponential&rate=0.05&beads=40");
  const rich = { A: RICH, B: TAPER, active: "A", view: { ...copy(VIEW), sensors: [3, 9], quantity: "arrival", log: true } };
  assert.deepEqual(fromLink(toLink(rich)), rich);
  assert.equal(fromLink(""), null);
});

test("hostile links change nothing but the state", () => {
  const state = fromLink("#__proto__.polluted=1&constructor.prototype.polluted=1&taper=uniform&~view=1&~sensors=text&beads=9&struck_by.99999999999.count=1&x=%E0%A4%A&=&a..b=1");
  assert.equal({}.polluted, undefined);
  assert.equal(state.A.chain.taper, "uniform");
  assert.deepEqual(state.view, VIEW);
});

test("changes leave the old document as it is", () => {
  const next = changed(TAPER, ["chain", "right_wall", "gap"], 2);
  assert.deepEqual(next.chain.right_wall, { gap: 2 });
  assert.equal("right_wall" in TAPER.chain, false);
  assert.deepEqual(changed(next, ["chain", "right_wall"], undefined), TAPER);
  const list = changed(TAPER, ["chain", "struck_by", 0, "count"], 2);
  assert.deepEqual(list.chain.struck_by, [{ count: 2 }]);
});

test("a dragged bead becomes one defect, counted without strikers", () => {
  const once = withRadius(TAPER, 5, 2), twice = withRadius(once, 5, 3);
  assert.deepEqual(twice.chain.with_defects, [{ bead: 5, radius: 3 }]);
  // A radius replaces a diameter.
  const defects = [{ bead: 5, diameter: "8 mm", material: "brass" }];
  const wide = withRadius({ chain: { beads: 9, with_defects: defects } }, 5, 3);
  assert.deepEqual(wide.chain.with_defects, [{ bead: 5, material: "brass", radius: 3 }]);
  const struck = { chain: { ...TAPER.chain, struck_by: { count: 2 } } };
  assert.deepEqual(withRadius(struck, 5, 2).chain.with_defects, [{ bead: 3, radius: 2 }]);
});

test("a drag is one step of undo", () => {
  const history = new History();
  history.note("a", true);
  history.note("b", true);
  history.note("c", false);
  history.note("d", false);
  assert.equal(history.undo("e"), "d");
  assert.equal(history.undo("d"), "a");
  assert.equal(history.undo("a"), undefined);
  assert.equal(history.redo("a"), "d");
  assert.equal(history.redo("d"), "e");
});

test("lists are read with numbers and units", () => {
  const key = { kind: "number", one_for_all: true };
  assert.deepEqual(listOf("1, 0.5; 2", key), [1, 0.5, 2]);
  assert.equal(listOf(" 5 mm ", key), "5 mm");
  assert.equal(listOf("", key), undefined);
  assert.equal(listOf("a, b", { kind: "text" }), "a, b");
  // A comma between whole numbers may be a decimal comma: the text is left to the server.
  for (const text of ["10,5", "10,5 mm", "10 mm, 9,5 mm", "1,5, 2,5", "1,5; 2,5; 3,5", "1,2,3 mm", "0,1 um,0,0", "10,5 mm,9,5 mm"]) assert.equal(listOf(text, key), text);
  assert.deepEqual(listOf("10 mm,5 mm", key), ["10 mm", "5 mm"]);
  assert.deepEqual(listOf("0,0,0,1.2 um,0", key), [0, 0, 0, "1.2 um", 0]);
  assert.deepEqual(listOf("0,0,0,1 um,0", key), [0, 0, 0, "1 um", 0]);
  assert.deepEqual(listOf("1,0.8,0.64", key), [1, 0.8, 0.64]);
  assert.deepEqual(listOf("0.1,0,0,-1e-2,0", key), [0.1, 0, 0, -0.01, 0]);
  assert.deepEqual(listOf("1,2,3", key), [1, 2, 3]);
});

test("sizes are the same, whether a material or the sizes are chosen first", () => {
  assert.deepEqual(resized({ first_diameter: 1, last_diameter: 0.3, beads: 40 }, true), { first_diameter: "10 mm", last_diameter: "3 mm", beads: 40 });
  assert.deepEqual(resized({ first: 20, last: 8 }, true), { first: "5 mm", last: "2 mm" });
  assert.deepEqual(resized({ diameters: [1, 0.7] }, true), { diameters: ["10 mm", "7 mm"] });
  assert.deepEqual(resized({ first: "20 mm", last: "0.8 cm" }, false), { first: 1, last: 0.4 });
  assert.deepEqual(resized({ cell: ["5 mm", 0.003], cells: 20 }, false), { cell: [1, 0.6], cells: 20 });
  assert.deepEqual(resized({ cell_diameters: [1, 0.6], cells: 20 }, true), { cell_diameters: ["10 mm", "6 mm"], cells: 20 });
  assert.deepEqual(resized({ taper: "uniform", beads: 9 }, true), { taper: "uniform", beads: 9 });
});
