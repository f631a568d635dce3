import assert from "node:assert/strict";
import { test } from "node:test";

import { Splitter, unpack } from "../../src/hertzchain/app/static/js/results.js";

/** A message as `messages.py` packs it. */
function packed(header, values) {
  let text = JSON.stringify({ ...header, arrays: [["x", "f8", [values.length], 0]] });
  text += " ".repeat((8 - ((text.length + 8) % 8)) % 8);
  const body = new Uint8Array(8 + text.length + 8 * values.length), view = new DataView(body.buffer);
  view.setUint32(0, text.length, true);
  view.setUint32(4, 1, true);
  body.set(new TextEncoder().encode(text), 8);
  body.set(new Uint8Array(Float64Array.from(values).buffer), 8 + text.length);
  return body;
}

function framed(...bodies) {
  return Uint8Array.from(bodies.flatMap((body) => [...new Uint8Array(new Uint32Array([body.length]).buffer), ...body]));
}

test("messages arrive whole, however the stream is cut", () => {
  const stream = framed(packed({ part: "a" }, [1, 2.5]), packed({ part: "bb" }, [-0]));
  for (const size of [1, 3, 7, 64, stream.length]) {
    const splitter = new Splitter(), found = [];
    for (let at = 0; at < stream.length; at += size) found.push(...splitter.add(stream.slice(at, at + size)));
    assert.deepEqual(found.map((each) => each.header.part), ["a", "bb"]);
    assert.deepEqual([...found[0].arrays.get("x")], [1, 2.5]);
    assert.ok(Object.is(found[1].arrays.get("x")[0], -0));
  }
});

test("another version is refused", () => {
  const body = packed({}, []);
  new DataView(body.buffer).setUint32(4, 2, true);
  assert.throws(() => unpack(body.buffer), /reload/);
});
