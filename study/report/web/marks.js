// What happened, on the train graph: marks of events, and a drill's faults, acts and expectations.
import { valueAt } from "./data.js";
import { COLOURS, dress, font } from "./layer.js";
import { spread } from "./view.js";

const ROW_PX = 16;
const ROWS_MAX = 14;
// Shape and colour of an event's mark by its kind; lesser ones are shown when asked for.
const SHAPES = {
  "broken invariant": ["square", "red", 6], unsafe: ["square", "red", 5.5], intervention: ["cross", "red", 4.5],
  fault: ["triangle", "red", 5.5], "fault over": ["hollow", "green", 5], act: ["diamond", "ink", 5],
  contradiction: ["diamond", "#7a1fa2", 4.5], stop: ["dot", "#d55e00", 3.5], points: ["dot", "#8c6d1f", 3.5],
  reversal: ["dot", "#009e73", 3.5], expectation: ["hollow", "pale", 4],
};
const LESSER = ["dot", "#9a9a9a", 2.5];
export const LESSER_KINDS = ["telegram", "refusal", "train", "reversal", "expectation"];

/** Events that the graph shows. */
export function shownEvents(day, options) {
  return options.lesser ? day.events : day.events.filter((event) => !LESSER_KINDS.includes(event.kind));
}

/** Rows under the graph. */
const rowsOf = (day, options) => (options.strip === false ? [] : day.marks.slice(0, ROWS_MAX));
const isCut = (day, options) => options.strip !== false && day.marks.length > ROWS_MAX;

/** Height of the rows of a drill under the graph, px. */
export function stripHeight(day, options) {
  const rows = rowsOf(day, options).length + (isCut(day, options) ? 1 : 0);
  return rows * ROW_PX + (rows ? 6 : 0);
}

/** Place of an event's mark, px; what has no place on the line stands at the top. */
function placeOf(event, scale, plot) {
  return [scale.x(event.t), Number.isNaN(event.m) ? plot.top + 9 : scale.y(event.m)];
}

/** Draw the marks of the events in view. */
export function drawEvents(context, day, view, scale, plot, options) {
  for (const event of shownEvents(day, options)) {
    if (event.t < view.x0 || event.t > view.x1) continue;
    const [x, y] = placeOf(event, scale, plot);
    drawShape(context, x, y, ...(SHAPES[event.kind] ?? LESSER));
  }
}

/** Events whose marks lie within `reach` px of a place on the canvas. */
export function eventsAt(day, scale, plot, options, x, y, reach = 9) {
  return shownEvents(day, options).filter((event) => {
    const [ex, ey] = placeOf(event, scale, plot);
    return Math.hypot(ex - x, ey - y) <= reach;
  });
}

/** One mark; also drawn in the legend. */
export function drawShape(context, x, y, shape, colour, r) {
  context.fillStyle = context.strokeStyle = COLOURS[colour] ?? colour;
  context.lineWidth = 1.8;
  context.setLineDash([]);
  context.beginPath();
  if (shape === "cross") {
    context.moveTo(x - r, y - r);
    context.lineTo(x + r, y + r);
    context.moveTo(x + r, y - r);
    context.lineTo(x - r, y + r);
    context.stroke();
    return;
  }
  const corners = {
    square: [[-1, -1], [1, -1], [1, 1], [-1, 1]], diamond: [[0, -1], [1, 0], [0, 1], [-1, 0]],
    triangle: [[0, -1], [1, 0.8], [-1, 0.8]],
  }[shape];
  if (corners) corners.forEach(([dx, dy], i) => (i ? context.lineTo(x + dx * r, y + dy * r) : context.moveTo(x + dx * r, y + dy * r)));
  else context.arc(x, y, r, 0, 2 * Math.PI);
  context.closePath();
  if (shape === "hollow") {
    context.fillStyle = "#ffffff";
    context.fill();
    context.stroke();
  } else context.fill();
}

/** The kinds of events of a day with their shapes, for the legend. */
export function kindsShown(day, options) {
  const kinds = new Map(shownEvents(day, options).map((event) => [event.kind, event.called]));
  return [...kinds].map(([kind, called]) => ({ kind, called, shape: SHAPES[kind] ?? LESSER }));
}

// Where a fault is while it lasts: a stretch of line as a box, a train as a broad band along its run.
const TRAIN_PX = 9;

function drawPlace(context, day, scale, mark, end) {
  const x0 = scale.x(mark.from);
  const to = mark.to ?? end;
  context.fillStyle = context.strokeStyle = day.pictures.drill.layers.stretch.colour;
  for (const [low, high] of mark.stretches) {
    const [y0, y1] = [scale.y(low), scale.y(high)];
    context.fillRect(x0, Math.min(y0, y1), Math.max(scale.x(to) - x0, 2), Math.max(Math.abs(y1 - y0), 3));
  }
  context.lineWidth = TRAIN_PX;
  context.lineCap = "round";
  context.setLineDash([]);
  for (const unit of mark.units) {
    for (const course of day.courses) {
      if (course.unit !== unit || course.to < mark.from || course.from > to) continue;
      const from = Math.max(mark.from, course.from);
      const until = Math.min(to, course.to);
      context.beginPath();
      context.moveTo(scale.x(from), scale.y(valueAt(course.t, course.m, from)));
      course.t.forEach((t, i) => { if (t > from && t < until) context.lineTo(scale.x(t), scale.y(course.m[i])); });
      context.lineTo(scale.x(until), scale.y(valueAt(course.t, course.m, until)));
      context.stroke();
    }
  }
  context.lineCap = "butt";
}

/** What the bands, boxes and lines of a drill mean, each as [words, how its sign is drawn in 16 px]. */
export function marksLegend(day) {
  const faults = day.marks.filter((mark) => mark.kind === "F");
  const box = (context) => context.fillRect(1, 3, 14, 10);
  const line = (x0, y0, x1, y1) => (context) => {
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.stroke();
  };
  const signs = {
    lasts: faults.length && box, stretch: faults.some((mark) => mark.stretches.length) && box,
    train: faults.some((mark) => mark.units.length) && line(3, 13, 13, 3), act: day.marks.some((mark) => mark.kind === "A") && line(8, 0, 8, 16),
  };
  const { layers } = day.pictures.drill;
  return Object.entries(signs).filter(([, sign]) => sign).map(([name, sign]) => [layers[name].label, (context) => {
    dress(context, layers[name]);
    sign(context);
  }]);
}

/** A drill's faults as pale bands with their places, and its acts as dashed lines. */
export function drawFaults(context, day, scale, plot) {
  const shown = day.marks.filter((mark) => mark.kind !== "E" && mark.from !== null).sort((a, b) => a.from - b.from);
  for (const mark of shown) {
    const x = scale.x(mark.from);
    const end = scale.x(mark.to ?? day.window[1]);
    context.fillStyle = day.pictures.drill.layers.lasts.colour;
    if (mark.kind === "F") {
      context.fillRect(x, plot.top, Math.max(end - x, 0), plot.height);
      drawPlace(context, day, scale, mark, day.window[1]);
    }
    context.strokeStyle = mark.kind === "F" ? COLOURS.red : COLOURS.ink;
    context.lineWidth = 0.9;
    context.setLineDash(mark.kind === "F" ? [] : [3, 3]);
    context.beginPath();
    context.moveTo(x, plot.top);
    context.lineTo(x, plot.top + plot.height);
    context.stroke();
  }
  context.setLineDash([]);
}

/** Their numbers at the foot of the graph, apart from each other and over what lies there. */
export function drawFaultNumbers(context, day, scale, plot) {
  const shown = day.marks.filter((mark) => mark.kind !== "E" && mark.from !== null).sort((a, b) => a.from - b.from);
  const seen = shown.filter((mark) => scale.x(mark.from) > plot.left && scale.x(mark.from) < plot.left + plot.width);
  const places = spread(seen.map((mark) => scale.x(mark.from)), 20, plot.left + 10, plot.left + plot.width - 10);
  context.font = font(11, "600");
  context.textAlign = "center";
  context.textBaseline = "middle";
  seen.forEach((mark, i) => {
    context.fillStyle = "#ffffff";
    context.fillRect(places[i] - 9, plot.top + plot.height - 15, 18, 14);
    context.fillStyle = mark.kind === "F" ? COLOURS.red : COLOURS.ink;
    context.fillText(mark.label, places[i], plot.top + plot.height - 8);
  });
}

/** A row a fault, act or expectation under the graph, on its clock. */
export function drawStrip(context, day, view, scale, plot, options) {
  const rows = rowsOf(day, options);
  const top = plot.top + plot.height + 24;
  rows.forEach((mark, row) => {
    const y = top + row * ROW_PX + ROW_PX / 2;
    const bad = mark.kind === "E" ? !mark.passed : mark.kind === "F";
    context.save();
    context.beginPath();
    context.rect(plot.left, y - ROW_PX / 2, plot.width, ROW_PX);
    context.clip();
    stretch(context, mark, scale, y, day.window[1]);
    context.restore();
    context.fillStyle = bad ? COLOURS.red : COLOURS.ink;
    context.font = font(11, mark.kind === "E" && !mark.passed ? "700" : "");
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(mark.label, plot.left - 6, y);
    drawText(context, mark, scale, y, plot, day.window[1], options.words);
    context.strokeStyle = COLOURS.fine;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(plot.left, y + ROW_PX / 2);
    context.lineTo(plot.left + plot.width, y + ROW_PX / 2);
    context.stroke();
  });
  if (!isCut(day, options)) return;
  context.fillStyle = COLOURS.ink;
  context.font = font(11);
  context.textAlign = "left";
  context.textBaseline = "middle";
  const cut = options.words.say("{count} of {all}", { count: rows.length, all: day.marks.length });
  context.fillText(cut, plot.left + 2, top + (rows.length + 0.5) * ROW_PX);
}

const LEAST_TEXT_PX = 60;

/** What a row is about: right of its mark, or left where there is more room, or on a bar that is as wide as the graph. */
function drawText(context, mark, scale, y, plot, end, words) {
  const inside = (x) => Math.min(Math.max(x, plot.left), plot.left + plot.width);
  const places = [mark.from ?? end, mark.at ?? mark.to ?? end].map((t) => inside(scale.x(t)));
  const [first, last] = [Math.min(...places) - 8, Math.max(...places) + 8];
  const [left, right] = [first - plot.left - 4, plot.left + plot.width - last - 4];
  const room = Math.max(left, right);
  if (room < LEAST_TEXT_PX) {
    const text = fitted(context, words.said(mark.text), plot.width - 32);
    context.textAlign = "left";
    context.clearRect(plot.left + 12, y - 7, context.measureText(text).width + 8, 14);
    context.fillText(text, plot.left + 16, y);
    return;
  }
  context.textAlign = right >= left ? "left" : "right";
  context.fillText(fitted(context, words.said(mark.text), room), right >= left ? last : first, y);
}

function stretch(context, mark, scale, y, end) {
  const from = scale.x(mark.from ?? end);
  const to = scale.x(mark.to ?? end);
  if (mark.kind === "E") {
    context.fillStyle = "rgba(107,107,107,0.4)";
    context.fillRect(from, y - 2, Math.max(to - from, 0), 4);
    const at = mark.at === null ? to : scale.x(mark.at);
    drawShape(context, at, y, ...(mark.passed ? ["dot", COLOURS.green, 4.5] : ["cross", COLOURS.red, 4.5]));
  } else if (mark.kind === "F" && to > from) {
    context.fillStyle = "rgba(179,38,30,0.55)";
    context.fillRect(from, y - 4, to - from, 8);
  } else drawShape(context, from, y, "diamond", mark.kind === "F" ? COLOURS.red : COLOURS.ink, 4.5);
}

/** A text cut with … so that it is no wider than so many px. */
export function fitted(context, text, width) {
  if (context.measureText(text).width <= width) return text;
  let cut = text;
  while (cut && context.measureText(`${cut}…`).width > width) cut = cut.slice(0, -1);
  return `${cut.trimEnd()}…`;
}
