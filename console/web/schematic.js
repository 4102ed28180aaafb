// The line as a schematic: sections in order and not to scale, as the block manager has them, with the trains on them.
import { crossingSigns } from "./roads.js";
import { along, drawn, reportedIn } from "./svg.js";

const WIDTHS = { track: 150, points: 64, between: 220, portal: 84 };
const TALL = 22, LANE = 42, GAP = 6, MIDDLE = 97;

/** Boxes of the sections by id: those at the same kilometrage stand above each other, in columns from left to right. */
export function laidOut(sections) {
  const columns = [];
  for (const section of [...sections].sort((a, b) => a.from_m - b.from_m || a.to_m - b.to_m)) {
    const column = columns.at(-1);
    const beside = column && section.from_m < column.to_m - 1 && section.kind === column.kind;
    if (beside) { column.all.push(section); column.to_m = Math.max(column.to_m, section.to_m); }
    else columns.push({ all: [section], kind: section.kind, to_m: section.to_m });
  }
  const boxes = new Map();
  let x = 4;
  for (const { all, kind } of columns) {
    const lanes = [...all].sort((a, b) => a.lane - b.lane);
    lanes.forEach((section, i) => {
      const lane = i - (lanes.length - 1) / 2;
      boxes.set(section.id, { x, y: MIDDLE + lane * LANE - TALL / 2, width: WIDTHS[kind], height: TALL, from_m: section.from_m, to_m: section.to_m });
    });
    x += WIDTHS[kind] + GAP;
  }
  return { boxes, width: x };
}

/** The picture; `pick` is called with the kind and id of what is clicked, or chosen by the keyboard. */
export function schematic(known, words, pick) {
  const { welcome, state } = known;
  const { boxes, width } = laidOut(welcome.sections);
  const svg = drawn("svg", { viewBox: `0 0 ${width} 180`, role: "group", "aria-label": words.say("the line", {}, "desk") },
    drawn("defs", {}, drawn("pattern", { id: "hatch", width: 6, height: 6, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
      drawn("rect", { width: 6, height: 6, fill: "#fff" }), drawn("rect", { width: 2, height: 6, fill: "#a8a8a8" }))));
  const chosen = (kind, id) => ({ tabindex: 0, role: "button", onclick: () => pick(kind, id),
    onkeydown: (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); pick(kind, id); } } });
  const marks = drawn("g");
  for (const section of state.sections) {
    const box = boxes.get(section.id);
    const said = words.say(section.state, {}, "desk");
    svg.append(drawn("g", { class: `section ${section.state}`, ...chosen("section", section.id), "aria-label": `${section.id}: ${said} ${section.unit}` },
      drawn("title", {}, `${section.id}: ${said} ${section.unit}`), drawn("rect", box),
      label(box.x + box.width / 2, box.y - 3, section.id, "middle")));
    const here = state.trains.filter((train) => (train.section || reportedIn(train, welcome.stations, boxes)) === section.id);
    here.forEach((train, i) => marks.append(trainMark(box, train, i, chosen)));
    if (!here.length && section.unit) svg.append(label(box.x + box.width / 2, box.y + 15, section.unit, "middle", "unit"));
  }
  const there = new Set(state.sections.map((section) => section.id)); // a driver's page has what the train holds
  for (const points of welcome.points.filter((one) => there.has(one.section))) {
    const box = boxes.get(points.section), lies = state.points.find((one) => one.id === points.id);
    const sign = !lies ? "" : lies.position === "normal" ? " N" : lies.position === "reverse" ? " R" : " ?";
    const group = drawn("g", { ...chosen("points", points.id), class: "points", "aria-label": points.id + sign });
    group.append(label(box.x + box.width / 2, box.y + TALL + 14, points.id + sign, "middle", lies && !lies.position ? "bad" : ""));
    svg.append(group);
  }
  svg.append(...crossingSigns(known, boxes, MIDDLE, words, chosen));
  for (const { x, row, name } of namesInRows(welcome.stations, [...boxes.values()], words.lang === "ja")) {
    svg.append(drawn("line", { class: "lead", x1: x, x2: x, y1: 41 - row * 14, y2: 46, stroke: "#1c1c1c" }), label(x, 39 - row * 14, name, "middle"));
  }
  svg.append(marks); // above the sections, as a mark may stand over two of them
  const silent = (id) => state.silent.includes(id) ? ` ✕ ${words.say("no power", {}, "desk")}` : "";
  const devices = ["block-manager", ...new Set(welcome.points.map((points) => points.terminal))];
  devices.forEach((id, i) => {
    const group = drawn("g", { ...chosen("device", id), "aria-label": id + silent(id) });
    group.append(label(8 + i * Math.min(240, width / devices.length), 174, `▣ ${id}${silent(id)}`, "start", silent(id) ? "bad" : ""));
    svg.append(group);
  });
  return svg;
}

/** In which of three rows, from the lowest, a station's name stands: over no other, nor over what leads down from one above. */
function namesInRows(stations, boxes, japanese) {
  const placed = [];
  const named = stations.flatMap((station) => {
    const box = boxes.find((one) => one.from_m <= station.at_m && station.at_m <= one.to_m), name = japanese ? station.name_ja : station.name;
    return box ? [{ x: along(box, station.at_m), half: name.length * (japanese ? 6.5 : 3.8), name }] : [];
  });
  for (const one of named.sort((a, b) => a.half - b.half || a.x - b.x)) { // a long name finds room above short ones
    const room = (row, other) => other.row === row ? one.half + other.half + 6 : (other.row > row ? one.half : other.half) + 2;
    const clashes = [0, 1, 2].map((row) => placed.filter((other) => Math.abs(one.x - other.x) < room(row, other)).length);
    placed.push({ ...one, row: clashes.indexOf(Math.min(...clashes)) });
  }
  return placed;
}

function trainMark(box, train, i, chosen) {
  const half = 26, there = train.at_m === null ? box.x + box.width / 2 : along(box, train.at_m);
  const x = Math.max(box.x + half, Math.min(box.x + box.width - half, there)), y = box.y + 15 + i * 12;
  const group = drawn("g", { class: "train", ...chosen("unit", train.unit), "aria-label": `${train.train} ${train.unit}` });
  group.append(drawn("title", {}, `${train.train} ${train.unit} ${train.waits_for}`), label(x, y, `◆ ${train.train || train.unit}`, "middle", "number"));
  return group;
}

function label(x, y, text, anchor, kind = "") {
  return drawn("text", { x, y, "text-anchor": anchor, class: kind || undefined }, text);
}

/** The train graph: what was planned, what has been, and how the day will go on, for three hours about now. */
export function trainGraph(known, words, { width = 450, height = 400 } = {}) {
  const { welcome, state, graph, forecast } = known;
  const left = 140, low = 10;
  const from = state.time_s - 3600, to = state.time_s + (forecast.length ? 7200 : 3600);
  const places = welcome.stations.map((station) => station.at_m), first = Math.min(...places), last = Math.max(...places);
  const x = (t) => left + ((t - from) / (to - from)) * (width - left - 6);
  const y = (m) => low + ((m - first) / (last - first || 1)) * (height - low - 24);
  const svg = drawn("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": words.say("train graph, planned and so far", {}, "desk") },
    drawn("clipPath", { id: "paper" }, drawn("rect", { x: left, y: low - 8, width: width - left - 6, height: height - low - 16 })));
  for (let t = Math.max(0, Math.ceil(from / 1800) * 1800); t <= to; t += 1800) {
    svg.append(drawn("line", { class: "grid", x1: x(t), x2: x(t), y1: low, y2: height - 24 }),
      label(x(t), height - 8, `${Math.floor(t / 3600)}:${String(Math.floor(t / 60) % 60).padStart(2, "0")}`, "middle"));
  }
  for (const station of welcome.stations) {
    svg.append(drawn("line", { class: "grid", x1: left, x2: width - 6, y1: y(station.at_m), y2: y(station.at_m) }),
      label(left - 4, y(station.at_m) + 4, words.lang === "ja" ? station.name_ja : station.name, "end"));
  }
  const paper = drawn("g", { "clip-path": "url(#paper)" });
  const line = (points, kind) => paper.append(drawn("polyline", { class: kind, points: points.map(([t, m]) => `${x(t).toFixed(1)},${y(m).toFixed(1)}`).join(" ") }));
  for (const train of welcome.plan) {
    if (train.times_s.at(-1) < from || train.times_s[0] > to) continue;
    line(train.times_s.map((t, i) => [t, train.at_m[i]]), "plan");
    const shown = Math.max(train.times_s[0], from);
    if (shown === train.times_s[0]) paper.append(label(x(shown) + 3, y(train.at_m[0]) + (train.at_m[0] < train.at_m.at(-1) ? 12 : -4), train.train, "start"));
  }
  const went = Map.groupBy ? Map.groupBy(graph, (point) => point.train) : grouped(graph);
  for (const points of went.values()) line(points.map((point) => [point.time_s, point.at_m]), "went");
  for (const { train, times_s, at_m } of forecast) {
    const been = went.get(train)?.at(-1), here = been ? [[been.time_s, been.at_m]] : [];
    if (times_s[0] <= to) line([...here, ...times_s.map((t, i) => [t, at_m[i]])], "forecast");
  }
  if (forecast.length) paper.append(drawn("rect", { class: "soon", x: x(state.time_s), y: low, width: x(state.time_s + 1800) - x(state.time_s), height: height - low - 24 }));
  paper.append(drawn("line", { class: "now", x1: x(state.time_s), x2: x(state.time_s), y1: low, y2: height - 24 }));
  svg.append(paper);
  return svg;
}

function grouped(points) {
  const found = new Map();
  for (const point of points) found.set(point.train, [...(found.get(point.train) ?? []), point]);
  return found;
}
