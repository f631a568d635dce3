/** Numbers as text, ticks, units, and sliders.  Pure functions. */

/** @typedef {{low: number, high: number, log: boolean, integer: boolean, zero: boolean}} Range */

/** Factors to SI by unit, from the server.
 * @type {Record<string, number>} */
export const FACTORS = { "kN/mm": 1e6 };

/** Units in which a quantity is shown and entered first, by dimension.
 * @type {Record<string, string>} */
export const SHOWN = {
  length: "mm", mass: "g", time: "µs", frequency: "kHz", pressure: "GPa",
};

/** Usual ranges of sliders in these units (SI, then scaled), by dimension or name, from the server;
 * number fields accept all values.
 * @type {Record<string, [number, number][]>} */
export const USUAL = {};

/** A number in few characters; powers of ten have one digit less by default.
 * @param {number} value @param {number} [digits] @param {number} [size] of the largest tick */
export function short(value, digits = 4, size = Math.abs(value)) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  if (size >= 1e5 || size < 1e-3) {
    const [mantissa, power] = value.toExponential((digits > 4 ? digits : Math.min(digits, 3)) - 1).split("e");
    return `${String(+mantissa)}e${+power}`.replace("-", "−").replace("e-", "e−");
  }
  return String(+value.toPrecision(digits)).replace("-", "−");
}

/** A number of a text or table with four digits, zeros at the end included. @param {number} value */
export function full(value) {
  const size = Math.abs(value), text = short(value);
  return size >= 1e-3 && size < 9999.5 ? value.toPrecision(4).replace("-", "−") : text;
}

/** A percentage, with decimals down to 0.000001%. @param {number} value @param {number} [digits] @param {number} [size] */
export function percent(value, digits, size = Math.abs(value)) {
  return (size >= 1e-6 && size < 1e-3 ? plain(+value.toPrecision(2)).replace("-", "−") : short(value, digits, size)) + "%";
}

/** @param {number} value @param {number} [digits] */
export const plain = (value, digits = 12) => value === Infinity ? "inf" : String(+value.toPrecision(digits));

/** Round values between two ends, at least a smallest step apart.
 * @param {number} low @param {number} high @param {number} count @param {number} [least] */
export function ticks(low, high, count, least = 0) {
  if (!(high > low)) return [low];
  const rough = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = Math.max(least, power * ([1, 2, 5, 10].find((each) => each * power >= rough * 0.999) ?? 10));
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
    found.push(+(i * step).toPrecision(12));
  }
  return found;
}

/** @param {number[]} marks */
export function digitsOf(marks) {
  const most = Math.max(...marks.map(Math.abs)), step = marks[1] - marks[0];
  return step > 0 ? Math.max(4, 1 + Math.ceil(Math.log10(most / step) + 1e-9)) : 4;
}

/** Ends of an axis at least a part of its largest value apart, so that it does not show rounding errors.
 * @param {number} low @param {number} high @param {number} [least] smallest distance
 * @returns {[number, number]} */
export function spread(low, high, least = 0) {
  const more = (Math.max(least, SMALLEST_SPAN * Math.max(Math.abs(low), Math.abs(high))) - (high - low)) / 2;
  return more > 0 ? [low - more, high + more] : [low, high];
}
const SMALLEST_SPAN = 1e-3;

/** Powers of ten between two ends. @param {number} low @param {number} high @param {number} count */
export function powers(low, high, count) {
  const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
  const step = Math.max(1, Math.ceil((last - first) / count));
  const found = [];
  for (let power = first; power <= last; power += step) found.push(10 ** power);
  return found.length > 1 ? found : ticks(low, high, count).filter((each) => each > 0);
}

/** Prefix that makes the largest value readable: factor and unit.
 * @param {number} largest @param {string} unit @returns {[number, string]} */
export function prefixed(largest, unit) {
  if (unit === "1") return [1, ""];
  /** @type {[number, string][]} */
  const prefixes = [[1e-9, "G"], [1e-6, "M"], [1e-3, "k"], [1, ""], [1e3, "m"], [1e6, "µ"], [1e9, "n"], [1e12, "p"], [1e15, "f"]];
  if (!/^(m|m\/s|s|N|N s|J|Hz|Pa|g)$/.test(unit) || !(largest > 0 && largest < Infinity)) return [1, unit];
  const found = prefixes.find(([factor]) => largest * factor >= 1 - 1e-9) ?? prefixes[8];
  return [found[0], found[1] + unit];
}

/** Number and unit of a value of a document. @param {unknown} value @param {string} unit
 * @returns {{number: number | null, unit: string}} */
export function parsed(value, unit) {
  if (typeof value === "number") return { number: value / (FACTORS[unit] ?? 1), unit };
  const text = typeof value === "string" ? value.trim() : "";
  const inches = /^(?:(\d+)[\s-]+)?(\d+)\s*\/\s*([1-9]\d*)\s*in$/.exec(text);
  if (inches) return { number: +(inches[1] ?? 0) + +inches[2] / +inches[3], unit: "in" };
  const found = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^,]*)$/.exec(text);
  if (found) return { number: Number(found[1]), unit: found[2] || unit };
  return { number: text === "inf" ? Infinity : null, unit };
}

/** A number, or text for the server. @param {string} text @returns {number | string | undefined} */
export function entered(text) {
  const given = text.trim();
  return given !== "" && Number.isFinite(Number(given)) ? Number(given) : given || undefined;
}

/** Value of a document for a number in a unit; text with the unit keeps all decimal digits.
 * @param {number} number @param {string} unit @returns {number | string} */
export function valued(number, unit) {
  if (number === Infinity) return "inf";
  return unit ? `${plain(number)}${unit === "%" ? "" : " "}${unit}` : number;
}

/** Time at a place of the animation, 0 .. 1. @param {ArrayLike<number>} times @param {number} u */
export function timeAt(times, u) {
  const at = Math.min(1, Math.max(0, u)) * (times.length - 1), i = Math.floor(at);
  return times[i] + (at > i ? (at - i) * (times[i + 1] - times[i]) : 0);
}

/** Place of a time in the animation, 0 .. 1. @param {ArrayLike<number>} times @param {number} time */
export function placeAt(times, time) {
  const next = Array.prototype.findIndex.call(times, (each) => each >= time), before = next - 1;
  if (next < 1) return next < 0 ? 1 : 0;
  return (before + (time - times[before]) / (times[next] - times[before])) / (times.length - 1);
}

/** A length in metres as text with three digits, as after a drag. @param {number} length */
export const inMillimetres = (length) => `${plain(+(length * 1e3).toPrecision(3))} mm`;

/** Gap in front of the right wall [m, or scaled]. @param {any} document */
export const gapOf = (document) => metres(document?.chain?.right_wall?.gap, 0);

/** A length [m, or scaled]. @param {unknown} value @param {number} otherwise */
export function metres(value, otherwise) {
  const { number, unit } = parsed(value, "m");
  return number === null ? otherwise : number * (FACTORS[unit] ?? 1);
}

/** Range of the slider of a key.
 * @param {any} key @param {boolean} si @param {number | null} value in the unit that is shown
 * @param {{beads?: number, taper?: string, unit?: string}} [chain] with the unit that is shown
 * @returns {Range} */
export function rangeOf(key, si, value, chain = {}) {
  const least = key.least ?? key.above, most = key.most ?? key.below;
  const usual = USUAL[key.dimension || key.name]?.[si ? 0 : 1];
  let [low, high] = usual ?? [0.01, 10];
  if (si && key.dimension && chain.unit && FACTORS[chain.unit]) {
    const factor = (FACTORS[SHOWN[key.dimension] ?? key.unit] ?? 1) / FACTORS[chain.unit];
    [low, high] = [low * factor, high * factor];
  }
  if (!usual && !key.dimension && least !== undefined && most !== undefined) [low, high] = [least, most];
  if (key.name === "rate" && chain.taper?.endsWith("linear") && chain.beads) {
    high = chain.taper.startsWith("forward") ? 0.999 / (chain.beads - 1) : 1;
    low = high / 1000;
  }
  if (chain.unit === "%") [low, high] = [100 * low, 100 * high];
  if (key.name === "bead" && chain.beads) [low, high] = [1, chain.beads];
  if (key.kind === "integer" && least !== undefined) low = Math.max(low, least);
  const finite = value !== null && Number.isFinite(value);
  if (finite && value > 0) [low, high] = [Math.min(low, value), Math.max(high, value)];
  if (finite && value < 0) low = Math.min(low, value);
  const integer = key.kind === "integer", log = low > 0 && high / low > 50;
  return { low, high, log, integer, zero: log && key.least === 0 };
}

export const STEPS = 1000;

/** Value at a position of a slider. @param {number} position 0 .. STEPS @param {Range} range */
export function valueAt(position, range) {
  if (range.zero && position <= 0) return 0;
  const u = Math.min(1, Math.max(0, position / STEPS));
  const value = range.log ? range.low * (range.high / range.low) ** u : range.low + u * (range.high - range.low);
  if (range.integer) return Math.round(value);
  if (u === 0) return range.low;
  if (u === 1) return range.high;
  return range.log ? +value.toPrecision(3) : +value.toFixed(Math.max(0, 3 - Math.floor(Math.log10(range.high - range.low))));
}

/** Position of a slider at a value. @param {number | null} value @param {Range} range */
export function positionOf(value, range) {
  if (value === null || !Number.isFinite(value)) return STEPS / 2;
  if (range.log && value <= 0) return 0;
  const u = range.log ? Math.log(value / range.low) / Math.log(range.high / range.low) : (value - range.low) / (range.high - range.low);
  return Math.round(STEPS * Math.min(1, Math.max(0, u)));
}
