// The line from a page to the desk, by itself. `node --test`.
import assert from "node:assert/strict";
import { test } from "node:test";

const { connect } = await import(new URL("../../../console/web/wire.js", import.meta.url));
const { reportedIn } = await import(new URL("../../../console/web/svg.js", import.meta.url));
const frames = []; // what is to be done before the page is painted next
const nextFrame = () => { for (const one of frames.splice(0)) one(); };
const state = (time_s, more = {}) => ({ say: "state", time_s, branch: 0, events: [time_s], graph: [], ...more });
globalThis.requestAnimationFrame = (one) => frames.push(one);

/** A socket that nobody is at the other end of; `all` are those that were made. */
class Wire {
  static OPEN = 1;
  static all = [];
  constructor(url) { Object.assign(this, { url, sent: [], readyState: 0 }); Wire.all.push(this); }
  send(text) { this.sent.push(JSON.parse(text)); }
  opens() { this.readyState = 1; this.onopen(); }
  closes() { this.readyState = 3; this.onclose({ reason: "" }); }
  says(message) { this.onmessage({ data: JSON.stringify(message) }); }
  /** A page at a desk that has let it in, and its end of the line; `show` as for `connect`. */
  static seated(t, show) {
    t.mock.timers.enable({ apis: ["setTimeout"] });
    Object.assign(globalThis, { WebSocket: Wire, location: { origin: "http://127.0.0.1:8580", reload: t.mock.fn() } });
    connect("desk", "guest", "", show);
    const wire = Wire.all.at(-1);
    wire.opens();
    wire.says({ say: "welcome", run: "one" });
    return wire;
  }
}

test("what is asked is answered by its number, and refused where there is no line or it breaks", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  Object.assign(globalThis, { WebSocket: Wire, location: { origin: "https://desk.example:444" } });
  const ask = connect("desk", "driver", "t", () => {}, "K1");
  const [wire] = Wire.all;
  assert.equal(wire.url, "wss://desk.example:444/desk"); // behind something that encrypts
  assert.deepEqual(await ask("act"), { good: false, why: "" }); // not yet
  wire.opens();
  const asked = [ask("act"), ask("save")];
  const [hello, , save] = wire.sent;
  assert.deepEqual([hello.say, hello.seat, hello.unit, hello.token], ["hello", "driver", "K1", "t"]);
  wire.says({ say: "answer", number: save.number, good: true });
  assert.equal((await asked[1]).good, true);
  wire.closes();
  assert.deepEqual(await asked[0], { good: false, why: "", sent: true }); // nobody knows whether it was done
  assert.deepEqual(await ask("act"), { good: false, why: "" });
  t.mock.timers.tick(1000);
  assert.equal(Wire.all.length, 2);
});

test("who draws slowly takes all that comes meanwhile, and draws the present alone", (t) => {
  let now_ms = 0;
  const drawn = [];
  t.mock.method(performance, "now", () => now_ms);
  const wire = Wire.seated(t, (known) => { drawn.push([known.state.time_s, known.events.length]); now_ms += 300; });
  for (let time_s = 1; time_s <= 40; time_s += 1) {
    wire.says(state(time_s));
    nextFrame();
    t.mock.timers.tick(50);
  }
  // 300 ms to draw, a frame until it is painted, 300 ms for what comes, and a frame: every eighth of them, 50 ms apart
  assert.deepEqual(drawn, [1, 9, 17, 25, 33].map((time_s) => [time_s, time_s])); // with every event until then
});

test("a run that goes on and is not heard of for five seconds is old, one that stands is not", (t) => {
  const shown = [];
  const wire = Wire.seated(t, (known) => shown.push(known));
  wire.says(state(1, { running: true }));
  t.mock.timers.tick(4999);
  assert.deepEqual(shown, []);
  wire.says(state(2, { running: true }));
  t.mock.timers.tick(5000);
  assert.deepEqual(shown, [null]);
  wire.says(state(3, { running: false }));
  t.mock.timers.tick(60_000);
  assert.deepEqual(shown, [null]);
});

test("a page comes anew where the desk has another run, and stays where it has the same", (t) => {
  const wire = Wire.seated(t, () => {});
  for (const [run, times] of [["one", 0], ["other", 1]]) {
    Wire.all.at(-1).closes();
    t.mock.timers.tick(1000);
    Wire.all.at(-1).says({ say: "welcome", run });
    assert.equal(location.reload.mock.callCount(), times);
  }
  assert.notEqual(Wire.all.at(-1), wire);
});

test("a train stands where it last reported, among the sections that it holds", () => {
  const boxes = new Map([["A.1", { from_m: 0, to_m: 300 }], ["A-B", { from_m: 300, to_m: 9000 }], ["B.1", { from_m: 9000, to_m: 9300 }]]);
  const stations = [{ id: "A", at_m: 100 }, { id: "halt", at_m: 5000 }, { id: "B", at_m: 9100 }];
  const at = (station, sections = ["A.1", "A-B", "B.1"]) => reportedIn({ station, sections }, stations, boxes);
  assert.deepEqual(["A", "halt", "B", "portal"].map((id) => at(id)), ["A.1", "A-B", "B.1", "A.1"]);
  assert.equal(at("A", ["A-B"]), "A-B"); // it has given back what it left
  assert.equal(at("A", []), undefined);
});
