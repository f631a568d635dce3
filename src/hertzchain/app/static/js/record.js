/** Measured data over the simulated forces: the server reads, aligns and scales them. */

import { $ } from "./fields.js";
import { fixed, host } from "./host.js";
import { other, own, record, say, state } from "./page.js";

/** Text of the file, with which places of sensors can be changed. */
let text = "", problem = "";

/** Balls in which the file that was read last has added sensors. */
let added = /** @type {number[]} */ ([]);

/** Read a file, or read it again with other places of sensors.
 * @param {(sensors: number[]) => void} changed */
async function read(changed) {
  try {
    const { balls, ...found } = await host.record({ name: record.name, text, sensors: $("record-sensors").value });
    problem = "";
    Object.assign(record, found, { shift: null });
    const kept = state.view.sensors.filter((each) => !added.includes(each));
    added = balls.filter((/** @type {number} */ each) => !kept.includes(each));
    const { sensors } = state.view, all = [...kept, ...added].slice(-4), fresh = all.filter((each) => !sensors.includes(each));
    // Sensors keep their colours.
    changed([...sensors.map((each) => all.includes(each) ? each : fresh.shift() ?? NaN), ...fresh].filter(Number.isFinite));
  } catch (error) {
    problem = error instanceof Error ? error.message : String(error);
    record.record = "";
    changed(state.view.sensors);
  }
}

/** @param {{changed: (sensors: number[]) => void, shifted: () => void, opened: (document: any) => void}} on */
export function handleRecords(on) {
  const open = async (/** @type {File | undefined} */ file) => {
    if (!file) return;
    try {
      const content = await file.text();
      if (/\.toml$/i.test(file.name)) return on.opened(await host.read(content));
      text = content;
      record.name = file.name;
      await read(on.changed);
    } catch (error) {
      say(String(/** @type {Error} */ (error).message), true);
    }
  };
  for (const id of ["open-file", "open-record"]) $(id).onclick = () => $("file").click();
  $("file").onchange = () => {
    $("share-dialog").close();
    void open($("file").files[0]);
    $("file").value = "";
  };
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (!fixed) void open(event.dataTransfer?.files[0]);
  });
  $("record-sensors").onchange = () => read(on.changed);
  $("shift").onchange = () => {
    record.shift = $("shift").value === "" ? null : Number($("shift").value) / 1e6;
    on.shifted();
  };
  $("record-close").onclick = () => {
    Object.assign(record, { record: "", name: "" });
    on.changed(state.view.sensors.filter((each) => !added.includes(each)));
    added = [];
  };
}

export function showRecord() {
  const { measured } = own(), shown = measured ?? {}, name = shown.name ?? record.name, that = other()?.measured;
  const begins = (/** @type {any} */ { offset }) => String(+(1e6 * offset).toPrecision(5));
  // The chains have alignments of their own.
  const aligned = state.B && shown.aligned && record.shift === null ? [`aligned with chain ${state.active}${that?.aligned ? ` (with ${state.active === "A" ? "B" : "A"}: ${begins(that)} µs)` : ""}`] : [];
  $("record").hidden = !name && !shown.notes;
  $("record-places").hidden = !text || fixed;
  $("record-name").textContent = name;
  $("shift").placeholder = shown.aligned ? begins(shown) : "0";
  if (document.activeElement !== $("shift")) $("shift").value = record.shift === null ? "" : String(+(1e6 * record.shift).toPrecision(9));
  $("record-note").textContent = problem || [...aligned, ...((record.shift !== null && shown.given) || shown.notes || [])].join("; ");
  $("record-note").classList.toggle("bad", problem !== "" || shown.aligned === false || shown.exchanged);
}
