// The papers beside the train graph: each fills an element with its charts and the tables behind them.
import { drawBars, drawDots, drawPanels, drawSurface } from "./charts.js";
import { column, valueAt } from "./data.js";
import { makeGantt } from "./gantt.js";
import { COLOURS, makeLayer, makeMovable, unitColour } from "./layer.js";
import * as papers from "./papers.js";
import { boundsOf as curveBounds, drawRunCurve, placesOf, plotOf as curvePlot } from "./runcurve.js";
import { element, headingOf, makeTable } from "./tables.js";
import { clock } from "./view.js";

function heading(doc, host, title, caption) {
  host.append(element(doc, "h3", {}, title), caption ? element(doc, "p", { class: "caption" }, caption) : "");
}

/** A chart that only has to be drawn, at a height. */
function chart(host, context, height, label, draw) {
  const stage = element(host.ownerDocument, "div", { class: "stage" });
  stage.style.height = `${height}px`;
  host.append(stage);
  const layer = makeLayer(stage, draw, label);
  context.layers.push(layer);
  return layer;
}

function tables(host, context, ids, open = false) {
  for (const id of ids) {
    const table = context.day.tables.get(id);
    if (table?.columns[0]?.values.length) host.append(makeTable(host.ownerDocument, table, context, open));
  }
}

const columnOf = (table, label) => table?.columns.find((col) => col.label === label);
const valuesOf = (table, label) => columnOf(table, label)?.values ?? [];

/** Run curve of any train. */
export function curvePaper(host, context) {
  const { day, words, state } = context;
  const doc = host.ownerDocument;
  const ran = day.trains.filter((train) => train.courses.length);
  const fullest = [...ran].sort((a, b) => b.calls.length - a.calls.length)[0];
  const number = ran.some((train) => train.number === state.chosen) ? state.chosen : fullest?.number;
  const train = day.byNumber.get(number);
  const choice = element(doc, "select", { id: "curve-train", onchange: (event) => context.showCurve(event.target.value) },
    ...ran.map((one) => element(doc, "option", { value: one.number, selected: one === train }, one.number)));
  host.append(element(doc, "div", { class: "tools" }, element(doc, "label", {}, `${words.say("Train")} `, choice)));
  if (!train) {
    host.append(element(doc, "p", { class: "caption" }, words.say("Nothing to show: the run has none.")));
    return;
  }
  if (state.chosen && state.chosen !== number) host.append(element(doc, "p", { class: "caption" }, words.say("{train} did not run.", { train: state.chosen })));
  host.append(element(doc, "p", { class: "caption" }, words.say("Speed over distance from left to right in the direction of travel: limit of the line black, permitted by supervision red, target dashed, speed thick; green is the time since the last stand. Below: gradient and curves as the train meets them (climbing and right-hand above the line), notch. At the foot: minutes and seconds from stop to stop as run. Within {kmh} km/h of the run's samples.", { kmh: day.tolerance.kmh })));
  const readout = element(doc, "p", { class: "readout", "aria-live": "polite" }, "\u00a0");
  const course = [...train.courses].sort((a, b) => (b.to - b.from) - (a.to - a.from))[0];
  const bounds = curveBounds(course, train);
  const pane = { bounds: { x0: 0, x1: bounds.high - bounds.low, y0: 0, y1: 1 }, least: { x: 200, y: 1 } };
  pane.view = { ...pane.bounds };
  const options = { words };
  host.append(readout);
  const layer = chart(host, context, 560, words.say("Run curve of {train}", { train: number }), (canvas, width, height) =>
    drawRunCurve(canvas, day, course, train, pane.view, options, width, height));
  pane.plot = () => curvePlot(layer.width, layer.height, options.top ?? 60);
  pane.changed = () => layer.invalidate();
  const show = (t) => {
    options.moment = t;
    readout.textContent = t === undefined ? "\u00a0" : readoutOf(day, course, t, words);
    layer.invalidate();
  };
  pane.pointed = (x) => show(x === null ? undefined : timeAt(course, placesOf(course, bounds, pane.view, pane.plot()).m(x)));
  pane.picked = (x) => pane.pointed(x);
  pane.key = (event) => {
    if (event.key !== "," && event.key !== ".") return false;
    const by = event.key === "." ? 10 : -10;
    show(Math.min(Math.max((options.moment ?? course.from) + by, course.from), course.to));
    return true;
  };
  makeMovable(layer, pane);
  const legs = papers.curveLegs(day, number);
  if (legs.columns[0]?.values.length) host.append(makeTable(doc, legs, context, true));
}

/** When a course was first at or beyond a kilometrage, s. */
function timeAt(course, m) {
  for (let i = 1; i < course.m.length; i++) {
    const [a, b] = [(course.m[i - 1] - m) * course.direction, (course.m[i] - m) * course.direction];
    if (a <= 0 && b >= 0 && b > a) return course.t[i - 1] + (-a / (b - a)) * (course.t[i] - course.t[i - 1]);
  }
  return (m - course.m[0]) * course.direction < 0 ? course.from : course.to;
}

function readoutOf(day, course, t, words) {
  const m = valueAt(course.t, course.m, t);
  const index = [...course.axes].reverse().find(([from]) => course.t[from] <= t) ?? course.axes[0];
  const limits = day.line.axes[index[1]].limits[String(course.direction)];
  const limit = [...limits].reverse().find(([from]) => from <= m)?.[1] ?? limits[0][1];
  return words.say("km {km} · {kmh} km/h · limit {limit} · {time}", {
    km: (m / 1000).toFixed(3), kmh: valueAt(course.t, course.v, t).toFixed(1), limit: `${+limit.toFixed(1)} km/h`, time: clock(t, true),
  });
}

/** Says in a line under a picture of bars what the bar pointed at is. */
function says(readout) {
  return (bar) => {
    readout.textContent = bar ? bar.title : "\u00a0";
  };
}

/** Tracks of the stations over time, and the timetable of one. */
export function stationsPaper(host, context) {
  const { day, words } = context;
  const doc = host.ownerDocument;
  heading(doc, host, words.say("Track occupation"), words.say("A row a track of each station: outlined as planned, filled as run, in the colour of the unit. A train stands from arrival to departure; where it turns round, until the next train of its unit leaves. Passing trains are a thin line."));
  const readout = element(doc, "p", { class: "readout", "aria-live": "polite" }, "\u00a0");
  const stage = element(doc, "div", { class: "stage" });
  host.append(readout, stage);
  const bounds = { x0: day.window[0] - 300, x1: day.window[1] + 300 };
  const gantt = makeGantt(stage, bounds, () => trackRows(day, words), words.say("Track occupation over time"), says(readout));
  context.layers.push(gantt.layer);
  heading(doc, host, words.say("Station timetable"), words.say("Departures as planned, hour by hour; in brackets as run, seconds after plan, from 15 s on; –: it did not leave. Small: where the train goes."));
  const place = element(doc, "div", { class: "timetables" });
  const choice = element(doc, "select", { id: "timetable-station", onchange: (event) => fill(event.target.value) },
    ...day.line.stations.map((station) => element(doc, "option", { value: station.id, selected: station.id === context.state.station }, words.place(station))));
  const fill = (id) => {
    context.state.station = id;
    place.replaceChildren(...[1, -1].map((direction) => stationTimetable(doc, day, day.stations.get(id), direction, context)));
  };
  host.append(element(doc, "div", { class: "tools" }, element(doc, "label", {}, `${words.say("Station")} `, choice)), place);
  if (choice.value) fill(choice.value);
  tables(host, context, ["occupation"]);
  host.append(makeTable(doc, papers.callsTable(day), context));
}

function trackRows(day, words) {
  const rows = new Map();
  const rowOf = (station, track) => {
    const key = `${station.id}\n${track}`;
    if (!rows.has(key)) rows.set(key, { label: `${words.place(station)} ${track}`, group: station.id, m: station.m, track, bars: [] });
    return rows.get(key);
  };
  for (const station of day.line.stations) for (const track of station.tracks) rowOf(station, track);
  for (const planned of [false, true]) {
    for (const stay of papers.stays(day, planned)) {
      const track = stay.track || (stay.station.tracks.length === 1 ? stay.station.tracks[0] : "");
      rowOf(stay.station, track).bars.push(stayBar(day, stay, planned, words));
    }
  }
  const found = [...rows.values()].sort((a, b) => a.m - b.m || a.track.localeCompare(b.track, "en", { numeric: true }));
  return { rows: found, rowPx: 22 };
}

function stayBar(day, stay, planned, words) {
  const numbers = stay.next ? `${stay.train} → ${stay.next}` : stay.train;
  const title = [
    numbers, stay.unit ? words.say("unit {unit}", { unit: stay.unit }) : "", words.say(planned ? "Plan" : "Run"),
    stay.passes ? `${words.say("passes")} ${clock(stay.to, true)}` : `${clock(stay.from, true)} – ${clock(stay.to, true)}`,
    words.place(stay.station), stay.track ? `${words.say("track")} ${stay.track}` : "",
  ].filter(Boolean).join(" · ");
  const share = planned ? 0.9 : stay.passes ? 0.25 : 0.62;
  return {
    from: stay.from, to: stay.to, title, share, outline: planned,
    colour: planned ? "#222222" : unitColour(day.units, stay.unit), text: planned ? "" : numbers,
  };
}

function stationTimetable(doc, day, station, direction, context) {
  const { words } = context;
  const hours = papers.departures(day, station, direction);
  const title = words.say(direction > 0 ? "Down" : "Up");
  const cell = ({ at, call, train, late }) => {
    const passes = call.kind === "pass";
    const last = train.calls[train.calls.length - 1].station;
    const two = String(Math.floor(at / 60) % 60).padStart(2, "0");
    const seconds = at % 60 ? `.${String(at % 60).padStart(2, "0")}` : "";
    const behind = Number.isNaN(call.d) ? " (–)" : Math.abs(late) >= 15 ? ` (${late > 0 ? "+" : "−"}${Math.abs(Math.round(late))})` : "";
    return element(doc, "button", {
      type: "button", class: `departure${passes ? " passes" : ""}${train.revenue ? "" : " empty"}`, title: train.number,
      onclick: () => context.showTrain(train.number),
    }, element(doc, "b", {}, two + seconds), behind, element(doc, "small", {}, passes ? `${words.say("passes")}` : words.place(last)));
  };
  const rows = hours.map(({ hour, trains }) => element(doc, "tr", {}, element(doc, "th", { scope: "row" }, String(hour)), element(doc, "td", {}, ...trains.map(cell))));
  return element(doc, "div", {}, element(doc, "h4", {}, `${words.place(station)} · ${title}`),
    rows.length ? element(doc, "table", { class: "departures" }, ...rows) : element(doc, "p", { class: "caption" }, words.say("No departures.")));
}

const CLASS_COLOURS = ["#7fb2d9", "#5b8c5a", "#b7c96b", "#e6b04d", "#c4492f", "#555555"];

/** Punctuality by station, and the delay of every call. */
export function punctualityPaper(host, context) {
  const { day, words } = context;
  const doc = host.ownerDocument;
  const rows = papers.punctualityClasses(day);
  host.append(element(doc, "p", { class: "caption" }, words.say("Share of calls by station, arrivals (A) and departures (D), by how far they were from plan. The plan is in whole minutes where nothing else is given: to arrive early is no fault, a departure before its time is.")));
  if (!rows.length) {
    host.append(element(doc, "p", { class: "caption" }, words.say("Nothing to show: the run has none.")));
    return;
  }
  chart(host, context, 380, words.say("Punctuality by station"), (canvas, width, height) => drawBars(canvas, width, height, {
    labels: rows.map((row) => `${words.place(row.station)} ${words.say(row.what === "arrival" ? "A" : "D", {}, "short")}`),
    series: papers.CLASSES.map((name, i) => ({ label: words.say(name), colour: CLASS_COLOURS[i], values: rows.map((row) => (100 * row.classes[i]) / row.calls) })),
    unit: words.say("share of calls, %"),
  }));
  tables(host, context, ["punctuality"], true);
  heading(doc, host, words.say("Delays"), words.say("Seconds after plan, arrival/departure (minus: before it; –: it did not come), in the colour of the worse of both; a departure before its time is red."));
  for (const direction of [1, -1]) host.append(delays(doc, day, direction, context));
}

/** +42 in s; from ten minutes on in whole minutes; nothing where there is nothing, – where it never came. */
export function lateText(late, words) {
  if (Number.isNaN(late)) return "";
  if (late === Infinity) return "–";
  const s = Math.round(late);
  const text = Math.abs(s) >= 600 ? `${s > 0 ? "+" : ""}${Math.round(s / 60)}${words.say("min")}` : s > 0 ? `+${s}` : String(s);
  return text.replace("-", "−");
}

function delays(doc, day, direction, context) {
  const { words } = context;
  const trains = day.trains.filter((train) => train.direction === direction);
  const stations = [...day.line.stations].sort((a, b) => direction * (a.m - b.m));
  const details = element(doc, "details", { class: "table delays-of" }, element(doc, "summary", {}, `${words.say(direction > 0 ? "Down" : "Up")} · ${words.say("{count} rows", { count: trains.length })}`));
  const fill = () => {
    if (details.childElementCount > 1) return;
    const head = element(doc, "tr", {}, element(doc, "th", {}, words.say("train")), ...stations.map((s) => element(doc, "th", {}, words.place(s))));
    const cell = (train, station) => {
      const call = train.calls.find((one) => one.station === station);
      const { arrival, departure } = call ? papers.lateness(call, day.due) : { arrival: NaN, departure: NaN };
      const known = [arrival, departure].filter((s) => !Number.isNaN(s));
      if (!known.length) return element(doc, "td", {});
      const worse = Math.max(...known);
      const style = `background:${delayColour(worse)}${worse > 240 ? ";color:#fff" : Math.round(departure) < 0 ? ";color:#b3261e" : ""}`;
      return element(doc, "td", { style, class: "delay" }, `${lateText(arrival, words)}/${lateText(departure, words)}`);
    };
    const rows = trains.map((train) => element(doc, "tr", {},
      element(doc, "td", {}, element(doc, "button", { type: "button", class: "train", onclick: () => context.showTrain(train.number) }, train.number)),
      ...stations.map((station) => cell(train, station))));
    details.append(element(doc, "div", { class: "grid" }, element(doc, "table", { class: "delays" }, head, ...rows)));
  };
  details.addEventListener("toggle", () => details.open && fill());
  if (trains.length <= 60) {
    details.open = true;
    fill();
  }
  return details;
}

/** Fixed, so that the delays of two runs compare by eye: blue a minute early, white on time, red five minutes late. */
export function delayColour(late) {
  const mix = (from, to, share) => `rgb(${from.map((a, i) => Math.round(a + (to[i] - a) * Math.min(share, 1))).join(",")})`;
  if (late < 0) return mix([255, 255, 255], [156, 195, 224], -late / 60);
  return late <= 150 ? mix([255, 255, 255], [240, 180, 158], late / 150) : mix([240, 180, 158], [179, 38, 30], (late - 150) / 150);
}

/** Values as the layers of a picture show them. */
const seriesOf = (picture, words, values) =>
  Object.entries(picture.layers).map(([name, { label, colour }]) => ({ label: words.said(label), colour, values: values[name] }));

/** Energy by train, by hour and by leg. */
export function energyPaper(host, context) {
  const { day, words } = context;
  const doc = host.ownerDocument;
  const table = day.tables.get("energy_trains");
  if (!table) {
    host.append(element(doc, "p", { class: "caption" }, words.say("Nothing to show: the run has none.")));
    return;
  }
  heading(doc, host, words.say("Energy by train"), words.say("kWh from where a train begins to move to where it ends; layovers apart. Figures above: net kWh per train-km. Numbers in brackets carry no passengers."));
  const [trains, traction, auxiliary, standing, regenerated, perKm, revenue] =
    ["train", "traction_kwh", "auxiliary_kwh", "standing_kwh", "regenerated_kwh", "net_per_km", "revenue"].map((label) => valuesOf(table, label));
  chart(host, context, 320, words.say("Energy by train"), (canvas, width, height) => drawBars(canvas, width, height, {
    labels: trains.map((number, i) => (revenue[i] === "yes" ? number : `(${number})`)), unit: words.said(day.pictures.energy.up),
    tops: perKm.map((value) => (value === null ? "–" : value.toFixed(2))),
    series: seriesOf(day.pictures.energy, words, {
      traction, auxiliary: auxiliary.map((kwh, i) => kwh - standing[i]), standing, regenerated: regenerated.map((kwh) => -kwh),
    }),
  }));
  tables(host, context, ["energy_sums", "energy_parts", "energy_per_km", "energy_taken"], true);
  energyByHour(host, context);
  tables(host, context, ["driving"], true);
  batteries(host, context);
  tables(host, context, ["energy_trains", "energy_by_leg", "energy_parts_by_leg", "energy_legs", "layovers"]);
  tables(host, context, ["opinion"], true);
}

/** Sets that run on batteries: the lowest charge of the day, and every charge. */
function batteries(host, context) {
  const { day, words } = context;
  const table = day.tables.get("battery_sets");
  if (!table?.columns[0].values.length) return;
  heading(host.ownerDocument, host, words.say("Batteries"), words.say("Lowest state of charge of each set in the day; above, how far its energy then lay over what is to be kept back. Minutes that suffice: the least charging after which the set comes to its next charge with just that; – where no time would do. A place – lies off the line. Given, taken and lost are counted at the battery; missing is what a train asked of it and did not get."));
  const [units, lowest, margins] = ["unit", "soc_lowest", "margin_kwh"].map((label) => valuesOf(table, label));
  chart(host, context, 220, words.say("Lowest state of charge by set"), (canvas, width, height) => drawBars(canvas, width, height, {
    labels: units, unit: "%", tops: margins.map((kwh) => (kwh === null ? "–" : `${kwh > 0 ? "+" : ""}${kwh.toFixed(0)} kWh`.replace("-", "−"))),
    series: [{ label: headingOf(columnOf(table, "soc_lowest"), words), colour: COLOURS.traction, values: lowest }],
  }));
  tables(host, context, ["battery_sets", "charges"], true);
}

function energyByHour(host, context) {
  const { day, words } = context;
  const table = day.tables.get("energy_hours");
  if (!table?.columns[0].values.length) return;
  heading(host.ownerDocument, host, words.say("Energy by hour"), words.say("Of all trains and layovers, by the hour in which it was taken."));
  const hours = valuesOf(table, "hour");
  chart(host, context, 260, words.say("Energy by hour"), (canvas, width, height) => drawBars(canvas, width, height, {
    labels: hours.map(String), unit: words.said(day.pictures.energy.up),
    series: [["traction", 1], ["auxiliary", 1], ["regenerated", -1]].map(([name, sign]) => ({
      label: words.say(name), colour: COLOURS[name], values: valuesOf(table, `${name}_kwh`).map((kwh) => sign * kwh),
    })),
  }));
  tables(host, context, ["energy_hours"]);
}

/** Margins of the timetable by hop. */
export function marginsPaper(host, context) {
  const { day, words } = context;
  const table = day.tables.get("margins");
  host.append(element(host.ownerDocument, "p", { class: "caption" }, words.say(table ? "Planned: from the departure to the latest arrival that keeps the planned arrival, and the least dwell before the next departure. Least: full power and the planned braking, at the limits of the line, with the mean load and no reaction times; attainable: as far below the limits as trains are driven. Margin: planned less least, in percent of the least. Left: what was left on arrival as run; automatic driving spends a margin on a lower speed, so little is left by intent." : "Nothing to show: the run has none.")));
  if (!table) return;
  const [from, to, least, margin] = ["from_station", "to_station", "least_s", "margin_s"].map((label) => valuesOf(table, label));
  chart(host, context, 400, words.say("Planned and least running time by hop"), (canvas, width, height) => drawBars(canvas, width, height, {
    labels: from.map((id, i) => `${words.place(id)}–${words.place(to[i])}`), unit: words.say("s"),
    tops: margin.map((s) => (s === null ? "–" : s > 0 ? `+${s}` : String(s).replace("-", "−"))),
    series: [
      { label: words.say("least"), colour: "#c9d6e4", values: least },
      { label: words.say("smallest margin"), colour: COLOURS.traction, values: margin.map((s) => Math.max(s, 0)) },
      { label: words.say("planned too short"), colour: COLOURS.red, values: margin.map((s) => Math.min(s, 0)) },
    ].filter(({ values }) => values.some((value) => value !== 0)),
  }));
  tables(host, context, ["margins"], true);
  tables(host, context, ["legs"]);
}

/** Level crossings: closed minutes and warnings of each, then by hour and by passage. */
export function crossingsPaper(host, context) {
  const { day, words } = context;
  const table = day.tables.get("crossings");
  host.append(element(host.ownerDocument, "p", { class: "caption" }, words.say("Closed: lamps lit or barriers not raised, as the road sees it. Warning: from the lamps to the front on the road; a front without any counts as 0 s, and the second train in one closure from when the first was warned of.")));
  const closed = columnOf(table, "closed_min");
  chart(host, context, 260, words.said(closed.heading), (canvas, width, height) => drawBars(canvas, width, height, {
    labels: valuesOf(table, "crossing"), unit: words.said(closed.heading), tops: closed.values.map((min) => min.toFixed(1)),
    series: [{ label: words.said(closed.heading), colour: day.pictures.train_graph.layers.crossing.colour, values: closed.values }],
  }));
  tables(host, context, ["crossings"], true);
  tables(host, context, ["crossing_hours", "warnings"]);
}

/** Stops at the mark: errors, the last 400 m, what trains have learned. */
export function stoppingPaper(host, context) {
  const { day, words } = context;
  const doc = host.ownerDocument;
  const errors = papers.errorsTable(day);
  heading(doc, host, words.say("Stop errors"), words.say("How far the front stood beyond the mark, by station; bars are means."));
  if (!errors.columns[0].values.length) host.append(element(doc, "p", { class: "caption" }, words.say("Nothing to show: the run has none.")));
  else {
    const [, , stations, , values] = errors.columns.map((col) => col.values);
    chart(host, context, 280, words.say("Stop errors by station"), (canvas, width, height) => drawDots(canvas, width, height, {
      groups: day.line.stations.map((s) => ({ label: words.place(s), values: values.filter((_, i) => stations[i] === s.id) })), unit: words.said(day.pictures.stop_errors.up),
    }));
    host.append(makeTable(doc, errors, context));
    approachesIn(host, context);
  }
  tuningIn(host, context);
  tables(host, context, ["learned"], true);
}

function approachesIn(host, context) {
  const { day, words } = context;
  const all = papers.approaches(day);
  const units = [...new Set(all.map((one) => one.unit))].sort();
  heading(host.ownerDocument, host, words.say("Approaches"), words.say("The last 400 m of every stop at a mark, by unit: what the train ran (blue) and what its target-speed pattern asked for (orange, dashed)."));
  const width = host.clientWidth || 1000;
  const columns = Math.max(1, Math.min(units.length, Math.floor(width / 320)));
  chart(host, context, 260 * Math.ceil(units.length / columns), words.say("The last 400 m of every stop"), (canvas, w, h) => drawPanels(canvas, w, h, {
    columns, from: 400, to: -10, unitX: words.say("before the mark, m"), unitY: words.said(day.pictures.run_curve.up),
    panels: units.map((unit) => {
      const own = all.filter((one) => one.unit === unit);
      return {
        title: words.say("{unit}, {count} stops", { unit, count: own.length }),
        curves: own.flatMap((one) => [
          { x: one.x, y: one.v, colour: COLOURS.traction, alpha: 0.5 },
          { x: one.x, y: one.target, colour: COLOURS.target, dash: [5, 3], alpha: 0.5 },
        ]),
      };
    }),
  }));
}

function tuningIn(host, context) {
  const { day, words } = context;
  const { tuning } = day;
  if (!tuning) return;
  heading(host.ownerDocument, host, words.say("Self-tuning"), words.say("What each train has learned of its brake from its own stops, and the evaluation function J of the last stop of {unit}, which differs most from its design: dark is least, the ring is the least of all. Beside it the deceleration designed (orange), measured (grey) and smoothed (blue).", { unit: tuning.unit }));
  const cells = tuning.surface.flatMap((row, j) => row.map((value, i) => ({ value, x: i * tuning.step_s, y: (j - tuning.zero) * tuning.step_kmhps })));
  const least = cells.reduce((a, b) => (b.value < a.value ? b : a));
  chart(host, context, 300, words.say("Evaluation function of one stop"), (canvas, width, height) => drawSurface(canvas, Math.min(width, 560), height, {
    rows: tuning.surface, x0: 0, stepX: tuning.step_s, y0: -tuning.zero * tuning.step_kmhps, stepY: tuning.step_kmhps,
    unitX: words.say("dead time, s"), unitY: words.say("offset, km/h/s"), marks: [least],
  }));
  const waves = [["actual", COLOURS.auxiliary], ["designed", COLOURS.target], ["smooth", COLOURS.traction]]
    .map(([name, colour]) => ({ y: Array.from(column(tuning[name])), colour, width: 1.3 }));
  const x = waves[0].y.map((_, i) => (i - waves[0].y.length) * tuning.step_s);
  chart(host, context, 240, words.say("Deceleration designed and measured"), (canvas, width, height) => drawPanels(canvas, Math.min(width, 720), height, {
    columns: 1, from: x[0], to: 0, unitX: words.say("before rest, s"), unitY: words.say("deceleration, m/s²"),
    panels: [{ title: tuning.unit, curves: waves.map((wave) => ({ ...wave, x })) }],
  }));
}

/** Sections over time. */
export function sectionsPaper(host, context) {
  const { day, words } = context;
  const doc = host.ownerDocument;
  host.append(element(doc, "p", { class: "caption" }, words.say(day.blocks.length ? "By the manager's register (pale) and in truth (solid), by unit." : "No section was granted in this run: none was asked for, or people or signals let trains go.")));
  if (!day.blocks.length) return;
  const readout = element(doc, "p", { class: "readout", "aria-live": "polite" }, "\u00a0");
  const stage = element(doc, "div", { class: "stage" });
  host.append(readout, stage);
  const end = day.window[1];
  const until = (time) => (Number.isNaN(time) ? end : time);
  const { layers } = day.pictures.occupancy;
  const said = (what) => headingOf(day.columns.blocks.columns.find((column) => column.label === `${what}_s`), words);
  const rows = () => ({
    rowPx: 18,
    rows: day.sections.map((section) => ({
      label: section.id, group: section.station ?? section.id,
      bars: day.blocks.filter((block) => block.section?.id === section.id).flatMap((block) => {
        const colour = unitColour(day.units, block.unit);
        const title = [
          section.id, block.train, words.say("unit {unit}", { unit: block.unit }),
          ...["granted", "entered", "cleared", "released"].map((what) => `${said(what)} ${clock(block[what], true)}`),
        ].join(" · ");
        const held = { from: block.granted, to: until(block.released), colour, alpha: layers.held.opacity, share: 0.8, title };
        const occupied = { from: block.entered, to: until(block.cleared), colour, alpha: layers.occupied.opacity, share: 0.5, title };
        return Number.isNaN(block.entered) ? [held] : [held, occupied];
      }),
    })),
  });
  const bounds = { x0: day.window[0] - 300, x1: day.window[1] + 300 };
  context.layers.push(makeGantt(stage, bounds, rows, words.say("Section occupancy over time"), says(readout)).layer);
  host.append(makeTable(doc, papers.blocksTable(day), context));
}

/** Every train, every wait. */
export function trainsPaper(host, context) {
  const { day, words } = context;
  host.append(makeTable(host.ownerDocument, papers.trainsTable(day), context, true));
  const waits = papers.waitsTable(day);
  if (!waits.columns[0].values.length) return;
  heading(host.ownerDocument, host, words.say("Why did it wait?"), words.say("What each unit waited for, moment by moment."));
  host.append(makeTable(host.ownerDocument, waits, context));
}

/** Events and telegrams. */
export function eventsPaper(host, context) {
  const { day, words } = context;
  const doc = host.ownerDocument;
  host.append(element(doc, "p", { class: "caption" }, words.say(day.events.length ? "What a person should hear of; the journal has all. Refusals that repeat are one line with their count." : "None: no intervention, refusal or fault.")));
  tables(host, context, ["events"], true);
  host.append(element(doc, "p", { class: "caption" }, words.say("Lost by the air, dropped by the receiver's checks.")));
  tables(host, context, ["telegrams_kind", "telegrams_source", "telegrams_destination"], true);
}

/** What the summary says besides its figures: what was changed, the drill. */
export function summaryTables(host, context) {
  tables(host, context, ["drill_items", "expectations", "changes"], true);
}
