// The train graph as a paper: its canvas with tools, what is said of a train pointed at, texts of events, print.
import { lastBefore, placeOf, valueAt, waitAt } from "./data.js";
import { makeLayer, makeMovable } from "./layer.js";
import { drawShape, eventsAt, kindsShown, marksLegend, shownEvents } from "./marks.js";
import { partsOf } from "./stairway.js";
import { element } from "./tables.js";
import { boundsOf, drawTrainGraph, gutterOf, nearestTrain, plotOf, scaleOf } from "./traingraph.js";
import { clock } from "./view.js";

const PICKED_MAX = 40; // events told of one place

// What may be shown or left out.
const LAYERS = {
  plan: "Plan", run: "Run", sections: "Sections", stairway: "Blocking times", lesser: "All events",
  beside: "{label} (dashed: trains that moved; red: not in this run)",
};
const PRINTED_S = 4.7 * 3600; // on a sheet, so that minutes can be read
const PRINTED_PX = [1040, 600]; // a sheet, with its heading
const AROUND_S = 1800; // what a drill's graph shows before and after what is done
const STEP_S = 10;

/** Where a place on the line is, in words: at a station or between two. */
export function whereIs(day, m, words) {
  const { stations } = day.line;
  const at = stations.find((station) => Math.abs(station.m - m) < 120 || station.marks.some((mark) => Math.abs(mark - m) < 30));
  if (at) return words.say("at {place}", { place: words.place(at) });
  const after = stations.findIndex((station) => station.m > m);
  if (after <= 0) return "";
  return words.say("{a} – {b}", { a: words.place(stations[after - 1]), b: words.place(stations[after]) });
}

/** How late a train was at the last of its calls before a time, in words; empty where none was planned. */
export function latenessAt(train, t, words) {
  let last = null;
  for (const call of train.calls) {
    if (call.a <= t && !Number.isNaN(call.pa)) last = { call, late: call.a - call.pa };
    if (call.d <= t && !Number.isNaN(call.pd)) last = { call, late: call.d - call.pd };
  }
  if (!last) return "";
  const s = Math.round(last.late);
  const form = s > 0 ? "{s} s after plan at {place}" : s < 0 ? "{s} s before plan at {place}" : "on time at {place}";
  return words.say(form, { s: Math.abs(s), place: words.place(last.call.station) });
}

/** What a graph opens on: the day; of a drill within a much longer day what was done, with some time around it. */
export function openingOf(day) {
  const bounds = boundsOf(day);
  const done = day.marks.filter((mark) => mark.kind !== "E" && mark.from !== null);
  if (!done.length) return bounds;
  const x0 = Math.max(Math.min(...done.map((mark) => mark.from)) - AROUND_S, bounds.x0);
  const last = Math.max(...done.map((mark) => Math.min(mark.to ?? mark.from, day.window[1])));
  const x1 = Math.min(last + AROUND_S, bounds.x1);
  return x1 - x0 > (bounds.x1 - bounds.x0) / 2 ? bounds : { ...bounds, x0, x1 };
}

/** A window of so many seconds about a time; without one, of a whole day its beginning, else the middle of what is seen. */
export function spanAbout(view, bounds, seconds, about) {
  const size = Math.min(seconds, bounds.x1 - bounds.x0);
  const whole = view.x0 <= bounds.x0 && view.x1 >= bounds.x1;
  const middle = about ?? (whole ? bounds.x0 : (view.x0 + view.x1) / 2);
  const x0 = Math.min(Math.max(middle - size / 2, bounds.x0), bounds.x1 - size);
  return { ...view, x0, x1: x0 + size };
}

/** Lines that say what a train does at a moment: the first is its number. */
export function told(day, hit, words) {
  const { train, course, t, m, planned } = hit;
  const v = course ? valueAt(course.t, course.v, t) : NaN;
  const unit = course?.unit ?? train.unit;
  const speed = Number.isNaN(v) ? words.say("planned")
    : v < 0.05 ? words.say("stands") : words.say("{kmh} km/h", { kmh: v.toFixed(0) });
  const wait = unit && !planned ? waitAt(day, unit, t) : null;
  return [
    [train.number, unit ? words.say("unit {unit}", { unit }) : "", words.say(train.direction > 0 ? "down" : "up")].filter(Boolean).join(" · "),
    [clock(t, true), words.say("km {km}", { km: (m / 1000).toFixed(2) }), whereIs(day, m, words)].filter(Boolean).join(" · "),
    [speed, planned ? "" : latenessAt(train, t, words)].filter(Boolean).join(" · "),
    ...(wait ? [words.said(wait)] : []),
  ];
}

/** The paper in `host`; `context`: day, words, state, showCurve(number), say(text) for those who listen. */
export function makeGraphPaper(host, context) {
  const { day, words, state } = context;
  const doc = host.ownerDocument;
  const options = Object.assign(state.graph, { words, gutter: 120 });
  const tip = element(doc, "div", { class: "tip", hidden: true });
  const popup = element(doc, "div", { class: "popup", role: "dialog", hidden: true, "aria-label": words.say("Events here") });
  const stage = element(doc, "div", { class: "stage graph" });
  const pane = { bounds: boundsOf(day), least: { x: 120, y: (day.extent[1] - day.extent[0]) / 40 || 50 } };
  pane.view = state.graphView ?? openingOf(day);
  const layer = makeLayer(stage, (canvas, width, height) => {
    options.gutter = gutterOf(canvas, day, words, width);
    drawTrainGraph(canvas, day, pane.view, options, width, height);
  }, words.say("Train graph: time across, stations down. Arrow keys move, plus and minus zoom, 0 shows the whole day, n and p choose the next and the previous train, comma and full stop move along it."));
  pane.plot = () => plotOf(day, options, layer.width, layer.height);
  pane.changed = () => {
    state.graphView = pane.view;
    options.moment = options.following ? options.moment : null;
    layer.invalidate();
  };
  const paper = { pane, layer, options, tip };
  pane.pointed = (x, y) => point(paper, context, x, y);
  pane.picked = (x, y) => pick(paper, context, popup, x, y);
  pane.key = (event) => key(paper, context, event);
  makeMovable(layer, pane);
  paper.choose = (number, show = true) => choose(paper, context, number, show);
  stage.append(tip, popup);
  host.append(
    element(doc, "p", { class: "caption" }, words.say("Plan thin, run thick; blue runs down, orange up, dashed carries no passengers; dotted links are turn-rounds. Zoomed in: minutes of arrival and departure at the stations (seconds after the point). Point at a line for its train; click a mark for its text. Curves are within {m} m of the run's samples at every second.", { m: day.tolerance.m })),
    tools(doc, paper, context), stage, legend(doc, day, options, words),
    element(doc, "p", { class: "caption screen-only" }, words.say("Drag or arrow keys move; Ctrl+wheel or + and − zoom in time (Shift: in distance, keys * and /), 0 shows all; once the graph is clicked the wheel alone moves it. n, p: next and previous train; comma, full stop: along it; Enter: its run curve.")),
    element(doc, "div", { class: "print-only" }),
  );
  paper.printed = () => host.querySelector(".print-only").replaceChildren(...bandsOf(doc, day, options));
  return paper;
}

function tools(doc, paper, context) {
  const { words } = context;
  const { pane, options, layer } = paper;
  const button = (text, label, onclick) => element(doc, "button", { type: "button", title: label, "aria-label": label, onclick }, text);
  const toWidth = (seconds) => () => {
    const chosen = context.day.byNumber.get(options.chosen);
    const [from, to] = chosen ? spanOf(chosen) : [NaN, NaN];
    const about = options.moment?.t ?? (Number.isNaN(from) ? undefined : (from + to) / 2);
    pane.view = spanAbout(pane.view, pane.bounds, seconds, about);
    pane.changed();
  };
  const box = (name) => element(doc, "label", {}, element(doc, "input", {
    type: "checkbox", checked: options[name], "data-option": name,
    onchange: (event) => {
      options[name] = event.target.checked;
      if (name === "lesser" || name === "stairway") doc.querySelector(".legend")?.replaceWith(legend(doc, context.day, options, words));
      layer.invalidate();
    },
  }), words.say(LAYERS[name], { label: context.day.beside?.label }));
  return element(doc, "div", { class: "tools" },
    button("−", words.say("Zoom out"), () => pane.zoom(1.6, 1)), button("+", words.say("Zoom in"), () => pane.zoom(1 / 1.6, 1)),
    button(words.say("Whole day"), words.say("Whole day"), () => pane.fit()),
    button(words.say("2 h"), words.say("2 h"), toWidth(7200)), button(words.say("20 min"), words.say("20 min"), toWidth(1200)),
    button("↕+", words.say("Stretch distance"), () => pane.zoom(1, 1 / 1.4)), button("↕−", words.say("Shrink distance"), () => pane.zoom(1, 1.4)),
    ...["plan", "run", "sections", ...(context.day.stairway.length ? ["stairway"] : []), "lesser", ...(context.day.beside ? ["beside"] : [])].map(box));
}

function legend(doc, day, options, words) {
  const signOf = (draw) => {
    const sign = element(doc, "canvas", { width: 32, height: 32, "aria-hidden": "true" });
    const drawn = sign.getContext("2d");
    drawn.scale(2, 2);
    draw(drawn);
    return sign;
  };
  const drill = marksLegend(day).map(([label, draw]) => element(doc, "span", {}, signOf(draw), words.said(label)));
  const items = kindsShown(day, options).map(({ kind, called, shape }) => {
    const sign = signOf((drawn) => drawShape(drawn, 8, 8, ...shape));
    const count = shownEvents(day, options).filter((event) => event.kind === kind).length;
    return element(doc, "span", {}, sign, `${words.said(called)} ${count}`);
  });
  const parts = (options.stairway ? partsOf(day) : []).map(([part, colour]) => element(doc, "span", {},
    element(doc, "span", { class: "part", style: `background:${colour}` }), words.said(part)));
  return element(doc, "p", { class: "legend" }, ...drill, ...items, ...parts);
}

function point(paper, context, x, y) {
  const { pane, options, layer, tip } = paper;
  const hit = x === null ? null : nearestTrain(context.day, pane.view, options, pane.plot(), x, y);
  const had = options.moment;
  options.moment = hit ? { t: hit.t, m: hit.m } : null;
  options.following = false;
  if (had || hit) layer.invalidate();
  showTip(paper, context, hit, x, y);
}

function showTip({ tip, layer }, context, hit, x, y) {
  tip.hidden = !hit;
  if (!hit) return;
  const doc = tip.ownerDocument;
  const lines = told(context.day, hit, context.words);
  tip.replaceChildren(...lines.map((line, i) => element(doc, i ? "span" : "strong", {}, line)));
  const left = Math.min(Math.max(x + 14, 4), layer.width - tip.offsetWidth - 6);
  const above = y - tip.offsetHeight - 12;
  tip.style.left = `${Math.max(left, 4)}px`;
  tip.style.top = `${above > 0 ? above : Math.min(y + 16, layer.height - tip.offsetHeight)}px`;
}

function pick(paper, context, popup, x, y) {
  const { pane, options } = paper;
  const { day, words } = context;
  const plot = pane.plot();
  const events = eventsAt(day, scaleOf(pane.view, plot), plot, options, x, y);
  popup.hidden = !events.length;
  if (!events.length) {
    const hit = nearestTrain(day, pane.view, options, plot, x, y);
    choose(paper, context, hit ? hit.train.number : null, false);
    point(paper, context, x, y);
    return;
  }
  const doc = popup.ownerDocument;
  popup.replaceChildren(
    element(doc, "button", { type: "button", class: "quiet", onclick: () => { popup.hidden = true; } }, words.say("Close")),
    element(doc, "strong", {}, words.say("Events here")),
    ...(events.length > PICKED_MAX ? [element(doc, "p", {}, words.say("{count} of {all}", { count: PICKED_MAX, all: events.length }))] : []),
    ...events.slice(0, PICKED_MAX).map((event) => element(doc, "p", {}, `${clock(event.t, true)} ${words.said(event.source)} · ${words.said(event.called)} · ${words.said(event.text)}`)),
  );
  popup.style.left = `${Math.max(Math.min(x + 10, paper.layer.width - 340), 4)}px`;
  popup.style.top = `${Math.max(Math.min(y + 10, paper.layer.height - 140), 4)}px`;
}

/** Choose a train and, where asked, move to it. */
function choose(paper, context, number, show) {
  const { pane, options, layer } = paper;
  const train = context.day.byNumber.get(number);
  options.chosen = train ? number : null;
  context.state.chosen = options.chosen ?? context.state.chosen;
  layer.invalidate();
  if (!train || !show) return;
  const [from, to] = spanOf(train);
  if (Number.isNaN(from)) return;
  const { bounds } = pane;
  const size = Math.min(Math.max(2.2 * (to - from), 3600), bounds.x1 - bounds.x0);
  const middle = (from + to) / 2;
  const x0 = Math.min(Math.max(middle - size / 2, bounds.x0), bounds.x1 - size);
  pane.view = { x0, x1: x0 + size, y0: bounds.y0, y1: bounds.y1 };
  options.moment = null;
  pane.changed();
  context.say(context.words.say("{train} chosen", { train: number }));
}

/** First and last time of a train, planned or run, s. */
export function spanOf(train) {
  const times = [...train.plan.t, ...train.courses.flatMap((course) => [course.from, course.to])].filter((t) => !Number.isNaN(t));
  return times.length ? [Math.min(...times), Math.max(...times)] : [NaN, NaN];
}

function key(paper, context, event) {
  const { day } = context;
  const { options } = paper;
  if (event.key === "n" || event.key === "p") {
    const at = day.trains.findIndex((train) => train.number === options.chosen);
    const next = at < 0 ? 0 : (at + (event.key === "n" ? 1 : -1) + day.trains.length) % day.trains.length;
    choose(paper, context, day.trains[next]?.number, true);
    return true;
  }
  if ((event.key === "," || event.key === ".") && options.chosen) {
    step(paper, context, event.key === "." ? STEP_S : -STEP_S);
    return true;
  }
  if (event.key === "Enter" && options.chosen) {
    context.showCurve(options.chosen);
    return true;
  }
  if (event.key === "Escape") {
    point(paper, context, null);
    return true;
  }
  return false;
}

/** Along the chosen train by so many seconds; what it does is said aloud. */
function step(paper, context, seconds) {
  const { pane, options, layer } = paper;
  const train = context.day.byNumber.get(options.chosen);
  const [from, to] = spanOf(train);
  const t = Math.min(Math.max((options.moment?.t ?? from) + (options.moment ? seconds : 0), from), to);
  const course = train.courses.find((c) => c.from <= t && t <= c.to) ?? null;
  const m = course ? valueAt(course.t, course.m, t) : train.courses.length ? placeOf(train.courses, train.unit, t) : valueAt(train.plan.t, train.plan.m, t);
  if (Number.isNaN(m)) return;
  options.moment = { t, m };
  options.following = true;
  if (t < pane.view.x0 || t > pane.view.x1) pane.pan(((t - (pane.view.x0 + pane.view.x1) / 2) / (pane.view.x1 - pane.view.x0)) * pane.plot().width, 0);
  layer.invalidate();
  const scale = scaleOf(pane.view, pane.plot());
  const hit = { train, course, t, m, planned: !course };
  showTip(paper, context, hit, scale.x(t), scale.y(m));
  context.say(told(context.day, hit, context.words).join(", "));
}

/** The whole day in pictures of a sheet each, with minutes, for paper. */
function bandsOf(doc, day, options) {
  const bounds = boundsOf(day);
  const count = Math.ceil((bounds.x1 - bounds.x0) / PRINTED_S);
  return Array.from({ length: count }, (_, i) => {
    const each = (bounds.x1 - bounds.x0) / count;
    const [width, height] = PRINTED_PX;
    const canvas = element(doc, "canvas", { width: 2 * width, height: 2 * height });
    const context = canvas.getContext("2d");
    context.scale(2, 2);
    const gutter = gutterOf(context, day, options.words, width);
    drawTrainGraph(context, day, { ...bounds, x0: bounds.x0 + i * each, x1: bounds.x0 + (i + 1) * each }, { ...options, gutter, minutes: true, moment: null, chosen: null }, width, height);
    return canvas;
  });
}

/** The train that runs at a time and place of the graph; for those who ask from outside. */
export const hitAt = (paper, day, x, y) => nearestTrain(day, paper.pane.view, paper.options, paper.pane.plot(), x, y);
export { lastBefore };
