// The modules of the report by themselves: what is read, what is seen, what is worked out. `node --test`.
import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateSync } from "node:zlib";

const from = (name) => import(new URL(`../../../../study/report/web/${name}`, import.meta.url));
const { column, dayOf, lastBefore, read, thinned, valueAt, waitAt } = await from("data.js");
const { clock, clockGrid, late, niceStep, panned, spread, zoomed } = await from("view.js");
const { approaches, classOf, departures, lateness, punctualityClasses, stays } = await from("papers.js");
const { csvOf, written } = await from("tables.js");
const columnOf = (label, kind, values, digits = 0) => ({ label, heading: [label, `${label} (ja)`], kind, values, digits });
const { nearestTrain, boundsOf, plotOf, scaleOf } = await from("traingraph.js");
const { searched } = await from("app.js");
const { wordsIn } = await from("words.js");
const { whereIs, latenessAt } = await from("graphpaper.js");
const { drawStairway, partsOf } = await from("stairway.js");
const { drawCrossings } = await from("crossings.js");
const { standsOf, onAxis } = await from("runcurve.js");

const packed = (values, k = 1) => {
  let last = 0;
  return { k, d: values.map((v) => (v === null ? null : Math.round(v * k) - last + 0 * (last = Math.round(v * k)))) };
};

/** Two stations, a train each way; T1 stands at B for a minute; U1 runs it. */
function example() {
  const stations = ["A", "B", "C"].map((id, i) => ({ id, name: `Name ${id}`, ja: i ? "" : "甲", m: 1000 * i, halt: false, signal: false, tracks: ["1"], marks: [1000 * i] }));
  const none = { t: packed([]), v: packed([]) };
  const train = (number, direction, station, pa, pd, a, d, more = {}) => ({
    number, unit: "U1", direction, revenue: true, planned: true, begins: "stabled", ends: "stabled", station,
    track: station.map(() => "1"), kind: station.map(() => "stop"),
    pa: packed(pa, 10), pd: packed(pd, 10), a: packed(a, 10), d: packed(d, 10), error: packed(station.map((_, i) => (i ? 0.1 : null)), 1000), ...more,
  });
  const course = (train, direction, t, m, v) => ({
    unit: "U1", train, direction, t: packed(t, 10), m: packed(m, 10), v: packed(v, 10), axes: [[0, 0]], braked: [], permitted: none, target: none, notch: none,
  });
  return {
    line: { name: "L", ja: "線", max_kmh: 60, stations, axes: [{ id: "x", from: 0, to: 2000, limits: { 1: [[0, 60]], "-1": [[0, 60]] }, gradients: [], curves: [] }] },
    window: [0, 1000], sections: [{ id: "S", kind: "track", station: "A", track: "1", from: 0, to: 900 }], devices: { P: 500 }, marks: [],
    blocks: { sections: ["S"], units: ["U1"], trains: ["T1"], section: [0], unit: [0], train: [0], granted: packed([5]), released: [40], entered: [null], cleared: [null] },
    stairway: {
      sections: ["S"], trains: ["T1", "T2"], parts: ["approach", "run"], colours: ["#c7e9c0", "#41ab5d"],
      section: [0, 0, 0], train: [0, 0, 1], part: [0, 1, 1], from: packed([5, 20, 600]), to: packed([20, 40, 650]),
    },
    trains: [
      train("T1", 1, ["A", "B", "C"], [null, 110, 300], [0, 170, null], [null, 100, 320], [0, 170, null]),
      train("T2", -1, ["C", "A"], [null, 800], [600, null], [null, null], [600, null]),
    ],
    courses: [course("T1", 1, [0, 100, 170, 320], [0, 1000, 1000, 2000], [0, 0, 0, 0]), course("T2", -1, [600, 700], [2000, 1500], [18, 18])],
    broken: [], beside: null, tuning: null, tolerance: { m: 1, kmh: 1, notch: 1 },
    waits: { said: [["waits", "待つ"]], units: ["U1"], unit: [0], from: packed([100]), to: packed([170]), text: [0] },
    tables: [
      { id: "events", notes: [], columns: [columnOf("t_s", "clock", [50, 60]), columnOf("source", "text", ["U1", "P"]), columnOf("kind", "said", [["fault", "故障"], ["act", "人の操作"]]), columnOf("text", "text", ["one", "two"])] },
      { id: "occupation", notes: [], columns: [
        columnOf("station", "place", ["A", "C"]), columnOf("track", "text", ["1", "1"]), columnOf("train", "train", ["T1", "T1"]), columnOf("next_train", "train", ["T1", "T2"]),
        columnOf("unit", "text", ["U1", "U1"]), columnOf("kind", "call", ["stop", "stop"]), columnOf("planned_from_s", "clock", [null, 300]), columnOf("planned_to_s", "clock", [0, 600]),
        columnOf("from_s", "clock", [null, 320]), columnOf("to_s", "clock", [0, null]),
      ] },
    ],
  };
}

test("what Python packs is read", async () => {
  const data = { 駅: "宝積寺", n: [1, null] };
  assert.deepEqual(await read(deflateSync(Buffer.from(JSON.stringify(data))).toString("base64")), data);
  await assert.rejects(read("AAAA"));
  assert.deepEqual([...column({ k: 10, d: [5, null, -3] })], [0.5, NaN, 0.2]);
});

test("a curve is straight between its points, and nothing outside of it", () => {
  const [t, v] = [[0, 10, 20], [0, 100, 0]];
  assert.deepEqual([-1, 0, 5, 10, 15, 20, 20.1].map((at) => valueAt(t, v, at)), [NaN, 0, 50, 100, 50, 0, NaN]);
  assert.deepEqual([-1, 0, 9, 20, 99].map((at) => lastBefore(t, at)), [-1, 0, 0, 2, 2]);
  assert.ok(Number.isNaN(valueAt([0, 1, 1], [5, NaN, 7], 0.5)));
});

test("what is thinned is within its tolerance of every point", () => {
  const t = Array.from({ length: 200 }, (_, i) => i);
  const v = t.map((x) => 40 * Math.sin(x / 15) + (x % 7));
  const kept = thinned(t, v, 9);
  assert.ok(kept.length < 60 && kept[0] === 0 && kept.at(-1) === 199);
  const [kt, kv] = [kept.map((i) => t[i]), kept.map((i) => v[i])];
  assert.ok(t.every((x, i) => Math.abs(valueAt(kt, kv, x) - v[i]) <= 9));
});

test("moving never leaves the bounds, and zooming keeps what is under the pointer", () => {
  const bounds = { x0: 0, x1: 1000, y0: 0, y1: 100 };
  const least = { x: 10, y: 10 };
  let view = bounds;
  for (let i = 0; i < 400; i++) {
    const [fx, fy] = [[0.5, 1.7, 3, 0.9][i % 4], [2, 0.6, 1][i % 3]];
    const [ax, ay] = [view.x0 + 0.3 * (view.x1 - view.x0), view.y0 + 0.8 * (view.y1 - view.y0)];
    const next = zoomed(view, bounds, least, fx, fy, ax, ay);
    const inside = next.x0 > 0 && next.x1 < 1000;
    if (inside) assert.ok(Math.abs((ax - next.x0) / (next.x1 - next.x0) - 0.3) < 1e-9);
    view = panned(next, bounds, ((i * 37) % 900) - 450, ((i * 11) % 90) - 45);
    assert.ok(view.x0 >= 0 && view.x1 <= 1000 && view.y0 >= 0 && view.y1 <= 100);
    assert.ok(view.x1 - view.x0 >= 10 - 1e-9 && view.y1 - view.y0 >= 10 - 1e-9);
    assert.ok(Math.abs(view.x1 - view.x0 - (next.x1 - next.x0)) < 1e-6);
  }
});

test("a day has hours and ten minutes; zoomed in come two minutes and one", () => {
  assert.deepEqual(clockGrid(1100 / (18 * 3600), 56), { steps: [600, 1800, 3600, 7200, 21600], label: 3600 });
  assert.ok(clockGrid(1100 / (2 * 3600), 56).steps.includes(120) || clockGrid(1100 / (2 * 3600), 56).steps.includes(60));
  assert.ok(clockGrid(1100 / 1200, 56).steps.includes(60));
  assert.ok(!clockGrid(1100 / (6 * 3600), 56).steps.includes(60));
  for (const px of [0.005, 0.02, 0.1, 1, 8]) {
    const { steps, label } = clockGrid(px, 56);
    assert.ok(label * px >= 56 || label === 43200);
    assert.ok(steps.every((step) => step * px >= 4));
  }
  assert.equal(clock(5 * 3600 + 37 * 60), "05:37");
  assert.equal(clock(24 * 3600 + 600), "24:10");
  assert.equal(clock(36061, true), "10:01:01");
  assert.equal(clock(NaN), "–");
  assert.equal(niceStep(2, 30), 20);
});

test("labels keep their order, come apart, and stay where they have room", () => {
  for (const places of [[], [5], [1, 1, 1], [0, 1, 2, 10, 30], [98, 99, 100], [3, 50, 51, 52, 97]]) {
    const found = spread(places, 6, 0, 100);
    assert.equal(found.length, places.length);
    found.slice(1).forEach((at, i) => assert.ok(at - found[i] >= 6 - 1e-9));
    assert.ok(found.every((at) => at >= 0 && at <= 100));
  }
  assert.deepEqual(spread([10, 20, 30], 6), [10, 20, 30]);
  const tight = spread([1, 2, 3, 4], 50, 0, 60);
  assert.ok(tight.every((at) => at >= 0 && at <= 60));
});

test("a train is found where its line is, and not beside it", () => {
  const day = dayOf(example());
  const options = { plan: false, run: true, gutter: 100, strip: false };
  const view = boundsOf(day);
  const plot = plotOf(day, options, 1000, 500);
  const scale = scaleOf(view, plot);
  const hit = nearestTrain(day, view, options, plot, scale.x(50), scale.y(500));
  assert.equal(hit.train.number, "T1");
  assert.ok(Math.abs(hit.m - 500) < 1e-6);
  assert.equal(nearestTrain(day, view, options, plot, scale.x(50), scale.y(1500)), null);
  assert.equal(nearestTrain(day, view, { ...options, plan: true, run: false }, plot, scale.x(650), scale.y(1500)).train.number, "T2");
});

test("a search finds the very train, else one that begins so, else one that has it", () => {
  const day = { trains: ["321M", "21M", "E21M"].map((number) => ({ number })) };
  assert.deepEqual(["21M", "21m", "32", "e2", "1M", "9", ""].map((text) => searched(day, text)?.number), ["21M", "21M", "321M", "E21M", "321M", undefined, undefined]);
});

test("a day is made of its parts", () => {
  const day = dayOf(example());
  assert.deepEqual(day.events.map((event) => event.m), [500, 500]);
  assert.equal(waitAt(day, "U1", 120)[1], "待つ");
  assert.equal(waitAt(day, "U1", 99), null);
  assert.equal(waitAt(day, "U9", 120), null);
  assert.ok(Number.isNaN(day.blocks[0].entered) && day.blocks[0].released === 45);
  const words = wordsIn("en", day.stations);
  assert.equal(whereIs(day, 1500, words), "Name B – Name C");
  assert.equal(whereIs(day, 1010, words), "at Name B");
  assert.equal(latenessAt(day.trains[0], 130, words), "10 s before plan at Name B");
  assert.equal(latenessAt(day.trains[0], 400, words), "20 s after plan at Name C");
});

test("tracks, departures, punctuality and stops are those of the calls", () => {
  const day = dayOf(example());
  assert.deepEqual(stays(day, false).map((s) => [s.station.id, s.train, s.next, s.from, s.to]), [["A", "T1", null, 0, 0], ["C", "T1", "T2", 320, 1000]]);
  assert.deepEqual(stays(day, true).map((s) => [s.from, s.to]), [[0, 0], [300, 600]]);
  assert.deepEqual(departures(day, day.stations.get("B"), 1).map(({ hour, trains }) => [hour, trains.length]), [[0, 1]]);
  assert.deepEqual(departures(day, day.stations.get("C"), 1), []);
  const rows = punctualityClasses(day);
  assert.deepEqual(rows.find((r) => r.station.id === "A" && r.what === "arrival").classes, [0, 0, 0, 0, 0, 1]);
  assert.deepEqual(rows.find((r) => r.station.id === "C" && r.what === "arrival").classes, [0, 0, 1, 0, 0, 0]);
  const part = punctualityClasses(dayOf({ ...example(), due: 700 })); // T2 is not due at A yet
  assert.equal(part.find((r) => r.station.id === "A" && r.what === "arrival"), undefined);
  assert.equal(part.length, rows.length - 1);
  assert.deepEqual([-16, -15, 15, 16, 60, 61, 181, NaN].map(classOf), [0, 1, 1, 2, 2, 3, 4, 5]);
  const stops = approaches(day);
  assert.deepEqual(stops.map((s) => [s.train, s.station.id]), [["T1", "B"], ["T1", "C"]]);
  assert.ok(Math.abs(stops[0].x.at(-1) + 0.1) < 1e-9);
});

test("legs of a course lie between its stands, on the axis where it runs most", () => {
  const day = dayOf(example());
  assert.deepEqual(standsOf(day.courses[0]), [{ from: 0, to: 100 }, { from: 170, to: 320 }]);
  assert.equal(onAxis(day.courses[0], day.line.axes).axis.id, "x");
});

test("words are said in either language, in their context, with what fills them", () => {
  const words = wordsIn("ja", new Map([["A", { name: "Ogane", ja: "大金" }], ["B", { name: "Only", ja: "" }]]), { "{count} rows": "{count} 行", "call\u0004stop": "停車" });
  assert.deepEqual([words.say("{count} rows", { count: 3 }), words.say("stop", {}, "call"), words.say("other")], ["3 行", "停車", "other"]);
  assert.deepEqual([words.said(["plan", "計画"]), wordsIn("en").said(["plan", "計画"]), wordsIn("en").say("{count} rows", { count: 3 })], ["計画", "plan", "3 rows"]);
  assert.deepEqual([words.place("A"), words.place("B"), words.place("P1")], ["大金", "Only", "P1"]);
});

test("values are written in their kind, and CSV quotes what needs it", () => {
  const words = wordsIn("en");
  assert.equal(written(-3.14159, { kind: "signed", digits: 2 }, words), "−3.14");
  assert.equal(written(null, { kind: "number", digits: 0 }, words), "–");
  const table = { columns: [columnOf("train", "train", ['a"b', "c,d"]), columnOf("kwh", "number", [1.5, null])] };
  assert.equal(csvOf(table, words), 'train,kwh\r\n"a""b",1.5\r\n"c,d",\r\n');
});

test("blocking times are boxes of their section; those of others than the train chosen are pale", () => {
  const day = dayOf(example());
  assert.deepEqual(partsOf(day), [["approach", "#c7e9c0"], ["run", "#41ab5d"]]);
  const view = { x0: 0, x1: 500, y0: 0, y1: 2000 };
  const scale = scaleOf(view, { left: 0, top: 0, width: 500, height: 200 });
  const drawn = (chosen, seen = view) => {
    const boxes = [];
    const context = { fillRect: (...box) => boxes.push([context.fillStyle, ...box, context.globalAlpha]) };
    drawStairway(context, day, seen, scale, chosen);
    return boxes;
  };
  assert.deepEqual(drawn(null), [["#c7e9c0", 5, 0, 15, 90, 0.6], ["#41ab5d", 20, 0, 20, 90, 0.6]]);
  assert.deepEqual(drawn("T2"), [["#c7e9c0", 5, 0, 15, 90, 0.2], ["#41ab5d", 20, 0, 20, 90, 0.2]]);
  assert.deepEqual(drawn("T2", { ...view, x1: 1000 }).map((box) => box.at(-1)), [0.2, 0.2, 0.6]);
});

test("level crossings in view have a line, and a name where there is room", () => {
  const day = {
    line: { crossings: [100, 104, 150, 900].map((m, i) => ({ id: `C${i}`, name: `c${i}`, m })) },
    pictures: { train_graph: { layers: { crossing: { colour: "#111111", width: 1, dashes: [2, 3] } } } },
  };
  const [lines, names] = [[], []];
  const context = {
    beginPath: () => {}, setLineDash: () => {}, stroke: () => {}, strokeText: () => {},
    moveTo: (x, y) => lines.push([x, y]), lineTo: (x) => lines.at(-1).push(x), fillText: (text) => names.push(text),
  };
  const plot = { left: 10, top: 20, width: 300, height: 400 };
  drawCrossings(context, day, { y: (m) => m }, plot);
  assert.deepEqual(lines, [[10, 100.5, 310], [10, 104.5, 310], [10, 150.5, 310]]);
  assert.deepEqual(names, ["c0", "c2"]);
  drawCrossings(context, { ...day, line: {} }, { y: (m) => m }, plot);
  assert.equal(lines.length, 3);
});

test("what was planned and never came is later than anything, and what nobody planned has no lateness", () => {
  const call = { pa: 100, a: NaN, pd: 130, d: NaN };
  assert.deepEqual(lateness(call, 1000), { arrival: Infinity, departure: Infinity });
  assert.deepEqual(lateness({ ...call, a: 90 }, 120), { arrival: -10, departure: NaN }); // the run was too short for it to leave
  assert.deepEqual(lateness({ pa: NaN, a: 90, pd: NaN, d: NaN }, 1000), { arrival: NaN, departure: NaN });
});

test("before midnight the clock has a minus, as everywhere else", () => {
  assert.deepEqual([-300, -3900, -1].map((t) => clock(t, true)), ["-00:05:00", "-01:05:00", "-00:00:01"]);
  assert.equal(clock(-300), "-00:05");
});

test("a train without a plan leaves at a whole second", () => {
  const day = dayOf(example());
  day.trains[0].calls[1].pd = NaN;
  day.trains[0].calls[1].d = 97.3;
  assert.deepEqual(departures(day, day.stations.get("B"), 1)[0].trains.map(({ at }) => at), [97]);
});

test("an hour late is not on time", () => {
  assert.deepEqual([0, 65.4, 3605, -30, null].map(late), ["+00:00", "+01:05", "+01:00:05", "−00:30", "–"]);
});

test("a drill with more marks than rows says how many of them are shown", async () => {
  const { drawStrip, stripHeight } = await from("marks.js");
  const mark = (i) => ({ kind: "A", label: `A${i}`, text: ["act", "操作"], from: 10 * i, to: null, at: null, units: [], stretches: [], passed: true });
  const marked = (count) => ({ ...dayOf(example()), marks: Array.from({ length: count }, (_, i) => mark(i)) });
  const texts = [];
  const context = new Proxy({ measureText: () => ({ width: 10 }), fillText: (text) => texts.push(text) },
    { get: (target, name) => target[name] ?? (() => {}), set: () => true });
  const shown = (count, words) => {
    texts.length = 0;
    drawStrip(context, marked(count), null, { x: (t) => t }, { left: 100, top: 0, width: 500, height: 300 }, { words });
    return texts.filter((text) => /20/.test(text));
  };
  const english = wordsIn("en");
  const japanese = wordsIn("ja", new Map(), { "{count} of {all}": "{all} 件中 {count} 件" });
  assert.deepEqual(shown(14, english), []);
  assert.deepEqual(shown(20, english), ["14 of 20"]);
  assert.deepEqual(shown(20, japanese), ["20 件中 14 件"]);
  assert.equal(stripHeight(marked(20), {}) - stripHeight(marked(14), {}), 16);
  assert.equal(stripHeight(marked(0), {}), 0);
});

test("what a row is about is read also where its bar is as wide as the graph", async () => {
  const { drawStrip } = await from("marks.js");
  const { context, texts } = writtenOn();
  const mark = { kind: "E", label: "E4", text: ["nothing collides", "衝突しない"], from: 0, to: null, at: null, units: [], stretches: [], passed: true };
  const day = { ...dayOf(example()), window: [0, 900], marks: [mark] };
  drawStrip(context, day, null, { x: (t) => t }, { left: 100, top: 0, width: 500, height: 300 }, { words: wordsIn("en") });
  const { x } = texts.find(({ text }) => text === "nothing collides");
  assert.ok(x >= 100 && x + 6 * "nothing collides".length <= 600);
});

/** A canvas on which a character is 6 px wide; what is written on it, with the turn and the place. */
function writtenOn() {
  const texts = [];
  const stack = [];
  let [x0, y0, turn] = [0, 0, 0];
  const context = {
    measureText: (text) => ({ width: 6 * text.length }),
    fillText: (text, x, y) => texts.push({ text, x: x0 + x, y: y0 + y, turn }),
    save: () => stack.push([x0, y0, turn]), restore: () => { [x0, y0, turn] = stack.pop(); },
    translate: (x, y) => { x0 += x; y0 += y; }, rotate: (angle) => { turn += angle; },
  };
  return { texts, context: new Proxy(context, { get: (target, name) => target[name] ?? (() => {}), set: () => true }) };
}

const bars = async (values, more = {}) => {
  const { drawBars } = await from("charts.js");
  const { texts, context } = writtenOn();
  drawBars(context, 600, 300, { labels: values.map((_, i) => `T${i}`), unit: "kWh", series: [{ label: "s", colour: "#000", values }], ...more });
  return texts;
};

test("bars of nothing but nought have a scale that can be read, and one without a value does not blank the others", async () => {
  assert.ok((await bars([0, 0])).every(({ text }) => !text.includes("e-") && !/0\.0000/.test(text)));
  for (const missing of [null, NaN, Infinity]) {
    const texts = await bars([40, missing]);
    assert.ok(texts.some(({ text }) => text === "40"), String(missing));
    assert.ok(texts.every(({ x, y }) => Number.isFinite(x) && Number.isFinite(y)));
  }
  assert.ok((await bars([-3, -1])).some(({ text }) => text.startsWith("−")));
});

test("what stands above a bar is upright where it has no room", async () => {
  const turnOf = (texts, wanted) => texts.find(({ text }) => text === wanted).turn;
  const values = Array.from({ length: 12 }, () => 5);
  assert.equal(turnOf(await bars(values, { tops: values.map(() => "+1") }), "+1"), 0);
  assert.notEqual(turnOf(await bars(values, { tops: values.map(() => "+12345 kWh") }), "+12345 kWh"), 0);
});

test("lateness has its sign, and a dash where there is none", () => {
  assert.deepEqual([0, 0.4, -0.4, -0.5, -61, 3700].map(late), ["+00:00", "+00:00", "+00:00", "−00:01", "−01:01", "+01:01:40"]);
  assert.deepEqual([null, NaN].map(late), ["–", "–"]);
});

test("names above a run curve, gradients and minutes stand within what is seen of it", async () => {
  const { boundsOf: boundsOfCurve, drawRunCurve } = await from("runcurve.js");
  const day = dayOf(example());
  const layer = { colour: "#000", width: 1, dashes: [], alpha: 1 };
  const layers = Object.fromEntries(["limit", "permitted", "target", "down", "up"].map((name) => [name, layer]));
  const axis = { ...day.line.axes[0], gradients: [[-3000, 2000, 12]], curves: [[-3000, 2000, -300]] };
  const pictured = { ...day, line: { ...day.line, axes: [axis] }, pictures: { ...day.pictures, run_curve: { layers, up: ["km/h", "km/h"] } } };
  const train = day.byNumber.get("T1");
  const empty = { t: new Float64Array(), v: new Float64Array() };
  const course = { ...train.courses[0], braked: [], permitted: empty, target: empty, notch: empty };
  const bounds = boundsOfCurve(course, train);
  const long = "B".repeat(60);
  const words = { ...wordsIn("en"), place: () => long };
  const { texts, context } = writtenOn();
  // Between the first two stations, where neither the middle of the gradient nor that of the leg is.
  const view = { x0: 100 - bounds.low, x1: 400 - bounds.low };
  drawRunCurve(context, pictured, course, train, view, { words }, 700, 500);
  const left = Math.max(...texts.filter(({ text }) => text === "‰" || text === "permille").map(({ x }) => x));
  assert.ok(Number.isFinite(left));
  for (const wanted of ["12", "300"]) assert.ok(texts.some(({ text, x }) => text === wanted && x > left && x < 700), wanted);
  const whole = writtenOn();
  drawRunCurve(whole.context, pictured, course, train, { x0: 0, x1: bounds.high - bounds.low }, { words }, 700, 500);
  const names = whole.texts.filter(({ text }) => text.startsWith("BB"));
  assert.ok(names.length > 0);
  assert.ok(names.every(({ text, y, turn }) => y - 6 * text.length * Math.sin(-turn) >= 0));
});
