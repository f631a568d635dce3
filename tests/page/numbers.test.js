import assert from "node:assert/strict";
import { test } from "node:test";

import { FACTORS, STEPS, USUAL, digitsOf, entered, full, parsed, percent, placeAt, plain, positionOf, powers, prefixed, rangeOf, short, spread, ticks, timeAt, valueAt, valued } from "../../src/hertzchain/app/static/js/numbers.js";

Object.assign(FACTORS, { m: 1, cm: 1e-2, mm: 1e-3, in: 25.4e-3, "m/s": 1, "mm/s": 1e-3, "%": 1e-2 });
Object.assign(USUAL, { length: [[0.1, 50], [0.05, 5]], velocity: [[0.01, 20], [0.01, 5]], acceleration: [[-20, 20], [-0.1, 0.1]],
  beads: [[2, 200], [2, 200]], rate: [[0.001, 0.3], [0.001, 0.3]] });

test("short numbers keep their size and sign", () => {
  assert.equal(short(0), "0");
  assert.equal(short(-0.25), "−0.25");
  assert.equal(short(123456), "1.23e5");
  assert.equal(short(0.000012345), "1.23e−5");
  assert.equal(short(NaN), "–");
});

test("texts and tables have the same number of digits", () => {
  assert.deepEqual([17.2, 102.6, 0.05, -3, 9999.9, 123456, 0, NaN].map(full),
    ["17.20", "102.6", "0.05000", "−3.000", "10000", "1.23e5", "0", "–"]);
});

test("an infinite radius is written as in chain files", () => {
  const { number, unit } = parsed("inf", "mm");
  assert.equal(plain(number), "inf");
  assert.equal(valued(number, unit), "inf");
});

test("percentages of theories have decimals instead of powers", () => {
  assert.deepEqual([10, 0.001, 0.0001, -0.0005, 0.0000567, 1e-7].map((each) => percent(each)),
    ["10%", "0.001%", "0.0001%", "−0.0005%", "0.000057%", "1e−7%"]);
  assert.equal(percent(12.345, 2), "12%");
  assert.deepEqual([0, 5e4, 1e5].map((each) => percent(each, 4, 1e5)), ["0%", "5e4%", "1e5%"]);
  assert.deepEqual([0.0005, 0.001].map((each) => short(each, 4, 0.001)), ["0.0005", "0.001"]);
});

test("ticks are round, within the ends and equally spaced", () => {
  for (const [low, high, count] of [[0, 1, 5], [-3.2, 17, 6], [1e-9, 2e-9, 4], [1, 40, 7]]) {
    const found = ticks(low, high, count);
    assert.ok(found.length >= 2 && found.length <= 2 * count + 2);
    assert.ok(found[0] >= low * 0.999999 - 1e-12 && found.at(-1) <= high * 1.000001 + 1e-12);
    const steps = found.slice(1).map((each, i) => each - found[i]);
    for (const step of steps) assert.ok(Math.abs(step / steps[0] - 1) < 1e-6);
  }
});

test("an axis does not show rounding errors, and its labels differ", () => {
  for (const [low, high] of [[99.9999999, 100.0000001], [-90.00000002, -90], [1e-9, 1.00000001e-9], [0.1, 0.100003]]) {
    const [from, to] = spread(low, high), size = Math.max(Math.abs(low), Math.abs(high));
    assert.ok(from <= low && to >= high && (to - from) / size > 0.99e-3);
    const marks = ticks(from, to, 6), labels = marks.map((each) => short(each, digitsOf(marks)));
    assert.ok(labels.length >= 3);
    assert.equal(new Set(labels).size, labels.length, String(labels));
    assert.ok(labels.every((each) => each.length <= 10), String(labels));
  }
  assert.deepEqual(spread(1, 2), [1, 2]);
  assert.deepEqual(spread(0, 2e-9, 1e-4).map((each) => +each.toPrecision(3)), [-5e-5, 5e-5]);
  assert.equal(digitsOf([0, 5, 10]), 4);
});

test("ticks of beads are whole numbers, however few beads there are", () => {
  for (const beads of [2, 3, 5, 20, 300]) {
    const found = ticks(1, beads, 12, 1);
    assert.ok(found.length >= 2 && found.every(Number.isInteger));
  }
  assert.ok(!ticks(1, 5, 12).every(Number.isInteger));
});

test("ticks of logarithmic axes are powers of ten, or round values within one decade", () => {
  assert.deepEqual(powers(0.02, 300, 8), [0.1, 1, 10, 100]);
  assert.ok(powers(2, 5, 4).every((each) => each >= 2 && each <= 5));
});

test("prefixes make the largest value readable", () => {
  assert.deepEqual(prefixed(0.0007, "s"), [1e6, "µs"]);
  assert.deepEqual(prefixed(870, "N"), [1, "N"]);
  assert.deepEqual(prefixed(1e-3, "s"), [1e3, "ms"]);
  assert.deepEqual(prefixed(4e-3, "g"), [1e3, "mg"]);
  assert.deepEqual(prefixed(2.5, "1"), [1, ""]);
  assert.deepEqual(prefixed(1.9, "m/s"), [1, "m/s"]);
  assert.deepEqual(prefixed(12000, "N"), [1e-3, "kN"]);
  assert.deepEqual(prefixed(0.012, "N s"), [1e3, "mN s"]);
  assert.deepEqual(prefixed(5e-13, "J"), [1e15, "fJ"]);
  assert.deepEqual(prefixed(2e-18, "J"), [1e15, "fJ"]);
  assert.deepEqual(prefixed(0, "N"), [1, "N"]);
});

test("values with units keep their decimal digits", () => {
  assert.deepEqual(parsed("9.3 mm", "mm"), { number: 9.3, unit: "mm" });
  assert.deepEqual(parsed(0.25, ""), { number: 0.25, unit: "" });
  assert.deepEqual(parsed(undefined, "mm"), { number: null, unit: "mm" });
  assert.equal(parsed("inf", "mm").number, Infinity);
  for (const text of ["0,05", "10,5 mm"]) assert.deepEqual(parsed(text, "mm"), { number: null, unit: "mm" });
  assert.equal(valued(9.3, "mm"), "9.3 mm");
  assert.equal(valued(0.1, "m/s"), "0.1 m/s");
  assert.equal(valued(0.1, ""), 0.1);
  assert.equal(valued(Infinity, "mm"), "inf");
  assert.equal(plain(0.1 + 0.2), "0.3");
});

test("percentages and fractions of inches are shown as numbers", () => {
  assert.deepEqual(parsed("5%", ""), { number: 5, unit: "%" });
  assert.equal(valued(6.5, "%"), "6.5%");
  assert.deepEqual(parsed("3/16 in", "mm"), { number: 0.1875, unit: "in" });
  assert.deepEqual(parsed("1 1/2 in", "mm"), { number: 1.5, unit: "in" });
  assert.deepEqual(parsed("1-1/4 in", "mm"), { number: 1.25, unit: "in" });
  assert.equal(parsed("1/0 in", "mm").unit, "/0 in"); // rejected by the server
  const rate = { name: "rate", kind: "number", fraction: true }, plainRange = rangeOf(rate, false, 0.05);
  const range = rangeOf(rate, false, 5, { unit: "%" });
  assert.deepEqual([range.low, range.high], [100 * plainRange.low, 100 * plainRange.high]);
});

test("other text than numbers is left to the server", () => {
  assert.deepEqual([" 0.25 ", "1e-3", "-2"].map(entered), [0.25, 1e-3, -2]);
  assert.deepEqual(["5%", "3/16 in", " 9 mm ", "nan", "inf"].map(entered), ["5%", "3/16 in", "9 mm", "nan", "inf"]);
  assert.deepEqual(["", "  "].map(entered), [undefined, undefined]);
});

test("sliders reach both ends, and positions return to their values", () => {
  const keys = [
    { name: "beads", kind: "integer", least: 2 }, { name: "rate", kind: "number" }, { name: "gap", kind: "number", dimension: "length", least: 0 },
    { name: "coefficient", kind: "number", above: 0, most: 1 }, { name: "gravity", kind: "number", dimension: "acceleration" },
  ];
  for (const key of keys) {
    for (const si of [true, false]) {
      const range = rangeOf(key, si, null);
      assert.equal(valueAt(STEPS, range), range.high);
      assert.equal(valueAt(0, range), range.zero ? 0 : range.low);
      let last = -Infinity;
      for (let at = 0; at <= STEPS; at += 50) {
        const value = valueAt(at, range);
        assert.ok(value >= last, `${key.name}: ${value} after ${last}`);
        assert.ok(Math.abs(positionOf(value, range) - at) <= (range.integer ? STEPS : 12), `${key.name} at ${at}: ${value}`);
        last = value;
      }
    }
  }
});

test("a slider includes the present value, and depends on the taper", () => {
  assert.equal(rangeOf({ name: "beads", kind: "integer", least: 2 }, false, 1500).high, 1500);
  const rate = { name: "rate", kind: "number" };
  assert.ok(rangeOf(rate, false, 0.01, { beads: 50, taper: "forward-linear" }).high < 1 / 49);
  const speed = { name: "velocity", kind: "number", dimension: "velocity", unit: "m/s" };
  assert.equal(rangeOf(speed, true, 50, { unit: "mm/s" }).high, 1000 * rangeOf(speed, true, 0.05, { unit: "m/s" }).high);
  assert.equal(rangeOf({ name: "bead", kind: "integer", least: 1 }, false, 3, { beads: 30 }).high, 30);
});

test("places of the animation are converted to times and back", () => {
  const times = [0, 1, 3, 7, 15]; // Each bead takes twice as long as the one before.
  assert.deepEqual([0, 0.25, 0.375, 1].map((u) => timeAt(times, u)), [0, 1, 2, 15]);
  assert.deepEqual([-1, 0, 2, 15, 99].map((time) => placeAt(times, time)), [0, 0, 0.375, 1, 1]);
  for (let u = 0; u <= 1; u += 0.0625) assert.equal(placeAt(times, timeAt(times, u)), u);
});
