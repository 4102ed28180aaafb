// The line from a page to the desk, by itself. `node --test`.
import assert from "node:assert/strict";
import { test } from "node:test";

const { connect } = await import(new URL("../../../console/web/wire.js", import.meta.url));

/** A socket that nobody is at the other end of; `all` are those that were made. */
class Wire {
  static OPEN = 1;
  static all = [];
  constructor(url) { Object.assign(this, { url, sent: [], readyState: 0 }); Wire.all.push(this); }
  send(text) { this.sent.push(JSON.parse(text)); }
  opens() { this.readyState = 1; this.onopen(); }
  closes() { this.readyState = 3; this.onclose({ reason: "" }); }
  says(message) { this.onmessage({ data: JSON.stringify(message) }); }
}

test("what is asked is answered by its number, and refused where there is no line or it breaks", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  Object.assign(globalThis, { WebSocket: Wire, location: { origin: "https://desk.example:444" } });
  const ask = connect("desk", "driver", "t", () => {}, "K1");
  const [wire] = Wire.all;
  assert.equal(wire.url, "wss://desk.example:444/desk"); // behind something that encrypts
  assert.equal((await ask("act")).good, false); // not yet
  wire.opens();
  const asked = [ask("act"), ask("save")];
  const [hello, , save] = wire.sent;
  assert.deepEqual([hello.say, hello.seat, hello.unit, hello.token], ["hello", "driver", "K1", "t"]);
  wire.says({ say: "answer", number: save.number, good: true });
  assert.equal((await asked[1]).good, true);
  wire.closes();
  assert.equal((await asked[0]).good, false); // nobody knows whether it was done
  assert.equal((await ask("act")).good, false);
  t.mock.timers.tick(1000);
  assert.equal(Wire.all.length, 2);
});
