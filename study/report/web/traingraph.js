// The train graph (列車ダイヤ): time across, stations down at true distances, plan thin and run thick.
import { drawCrossings } from "./crossings.js";
import { lastBefore, valueAt } from "./data.js";
import { COLOURS, dress, font, unitColour } from "./layer.js";
import { drawEvents, drawFaultNumbers, drawFaults, drawStrip, stripHeight } from "./marks.js";
import { drawStairway } from "./stairway.js";
import { clock, clockGrid, spread } from "./view.js";

export const TOP = 24;
export const BOTTOM = 22;
const RIGHT = 10;
const MANY = 120; // from so many trains in view on, lines and numbers are drawn in a way that stays quick
const NUMBERS_PER_PX = 0.15; // more trains than that in view leave no room for their numbers
const MINUTE_PX = 9; // least width of a minute at which stations have the minutes of their trains
const TURN_S_MAX = 3 * 3600; // a set that stands longer than this is stabled, not turning round

/** Where the graph lies on a canvas of this size: beside the names of stations, above the strip of a drill. */
export function plotOf(day, options, width, height) {
  const left = options.gutter;
  const below = BOTTOM + stripHeight(day, options);
  return { left, top: TOP, width: Math.max(width - left - RIGHT, 10), height: Math.max(height - TOP - below, 10) };
}

/** From time and kilometrage to px and back, for a view on a plot. */
export function scaleOf(view, plot) {
  const px = plot.width / (view.x1 - view.x0);
  const py = plot.height / (view.y1 - view.y0);
  return {
    px, py,
    x: (t) => plot.left + (t - view.x0) * px,
    y: (m) => plot.top + (m - view.y0) * py,
    t: (x) => view.x0 + (x - plot.left) / px,
    m: (y) => view.y0 + (y - plot.top) / py,
  };
}

/** The window of the whole day. */
export function boundsOf(day) {
  const [low, high] = day.extent;
  const margin = Math.max(0.03 * (high - low), 20);
  const done = day.marks.filter((mark) => mark.kind !== "E" && mark.from !== null).map((mark) => mark.from);
  const [from, to] = [Math.min(day.window[0], ...done), Math.max(day.window[1], ...done)];
  const room = Math.max(0.01 * (to - from), 10);
  return { x0: from - room, x1: to + room, y0: low - margin, y1: high + margin };
}

/** Width of the names of stations beside the graph, px. */
export function gutterOf(context, day, words, width) {
  context.font = font(12);
  const widest = Math.max(0, ...day.line.stations.map((s) => context.measureText(stationText(s, words, width)).width));
  return Math.min(Math.ceil(widest) + 14, Math.round(width * 0.4));
}

function stationText(station, words, width) {
  const km = (station.m / 1000).toFixed(1);
  return width < 600 ? `${words.place(station)} ${km}` : `${words.place(station)}  ${km} km`;
}

/** Draw all of it. `options`: gutter, plan, run, sections, stairway, lesser, chosen (number of a train), words, moment {t, m}. */
export function drawTrainGraph(context, day, view, options, width, height) {
  const plot = plotOf(day, options, width, height);
  const scale = scaleOf(view, plot);
  const grid = clockGrid(scale.px, width < 600 ? 44 : 56);
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, width, height);
  context.save();
  context.beginPath();
  context.rect(plot.left, plot.top, plot.width, plot.height);
  context.clip();
  drawFaults(context, day, scale, plot);
  if (options.sections) drawSections(context, day, view, scale);
  if (options.stairway) drawStairway(context, day, view, scale, options.chosen);
  drawClockLines(context, view, scale, plot, grid);
  drawStationLines(context, day, scale, plot);
  drawCrossings(context, day, scale, plot);
  drawTurns(context, day, view, scale);
  if (options.beside && day.beside) drawBeside(context, day.beside, day.pictures.train_graph.layers, view, scale);
  if (options.run) drawRuns(context, day, view, scale);
  if (options.plan) drawPlans(context, day, view, scale);
  drawChosen(context, day, view, scale, options);
  if (options.minutes || scale.px * 60 >= MINUTE_PX) drawMinutes(context, day, view, scale, plot, options);
  drawNumbers(context, day, view, scale, plot, options);
  drawEvents(context, day, view, scale, plot, options);
  drawFaultNumbers(context, day, scale, plot);
  drawMoment(context, scale, plot, options.moment);
  context.restore();
  drawStationNames(context, day, scale, plot, options, width);
  drawClock(context, view, scale, plot, grid);
  drawStrip(context, day, view, scale, plot, options);
  context.strokeStyle = COLOURS.rule;
  context.lineWidth = 1;
  context.setLineDash([]);
  context.strokeRect(plot.left + 0.5, plot.top + 0.5, plot.width - 1, plot.height - 1);
}

/** Vertical lines of the clock within a plot: hours bold, half hours dashed, ten minutes, two and one as far as they fit. */
export function drawClockLines(context, view, scale, plot, grid) {
  const drawn = new Set();
  for (const step of [...grid.steps].reverse()) {
    context.beginPath();
    for (let i = Math.ceil(view.x0 / step); i * step <= view.x1; i++) {
      const t = i * step;
      if (drawn.has(t)) continue;
      drawn.add(t);
      const x = Math.round(scale.x(t)) + 0.5;
      context.moveTo(x, plot.top);
      context.lineTo(x, plot.top + plot.height);
    }
    const coarse = step >= 3600;
    context.strokeStyle = coarse ? "#9a9a9a" : step >= 600 ? "#c9c9c9" : step >= 120 ? "#dfdfdf" : COLOURS.fine;
    context.lineWidth = coarse ? 1.1 : step >= 600 ? 0.9 : 0.7;
    context.setLineDash(step === 1800 ? [4, 3] : []);
    context.stroke();
  }
  context.setLineDash([]);
}

/** Times above and below a plot. */
export function drawClock(context, view, scale, plot, grid, below = true) {
  context.fillStyle = COLOURS.ink;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const seconds = grid.label % 60 !== 0;
  for (let i = Math.ceil(view.x0 / grid.label); i * grid.label <= view.x1; i++) {
    const t = i * grid.label;
    const x = scale.x(t);
    if (x < plot.left + 8 || x > plot.left + plot.width - 12) continue;
    context.font = font(11, t % 3600 === 0 ? "600" : "");
    context.fillText(clock(t, seconds), x, plot.top - 11);
    if (below) context.fillText(clock(t, seconds), x, plot.top + plot.height + 11);
  }
}

function drawStationLines(context, day, scale, plot) {
  for (const station of day.line.stations) {
    const y = Math.round(scale.y(station.m)) + 0.5;
    if (y < plot.top - 1 || y > plot.top + plot.height + 1) continue;
    context.strokeStyle = "#8a8a8a";
    context.lineWidth = station.halt ? 0.5 : 1;
    context.beginPath();
    context.moveTo(plot.left, y);
    context.lineTo(plot.left + plot.width, y);
    context.stroke();
  }
}

function drawStationNames(context, day, scale, plot, options, width) {
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, plot.left, plot.top + plot.height + BOTTOM);
  const shown = day.line.stations.filter((s) => scale.y(s.m) >= plot.top - 1 && scale.y(s.m) <= plot.top + plot.height + 1);
  const size = width < 600 ? 11 : 12;
  const places = spread(shown.map((s) => scale.y(s.m)), size + 2, plot.top + 2, plot.top + plot.height - 2);
  context.textAlign = "right";
  context.textBaseline = "middle";
  shown.forEach((station, i) => {
    context.font = font(size);
    context.fillStyle = station.halt ? "#555555" : COLOURS.ink;
    context.fillText(stationText(station, options.words, width), plot.left - 8, places[i], plot.left - 10);
    context.strokeStyle = "#8a8a8a";
    context.lineWidth = 0.7;
    context.beginPath();
    context.moveTo(plot.left - 6, places[i]);
    context.lineTo(plot.left, scale.y(station.m));
    context.stroke();
  });
}

/** Adds to the path what of a curve falls into the view. */
function trace(context, times, places, view, scale) {
  const first = Math.max(lastBefore(times, view.x0), 0);
  let open = false;
  for (let i = first; i < times.length; i++) {
    const [x, y] = [scale.x(times[i]), scale.y(places[i])];
    if (open) context.lineTo(x, y);
    else context.moveTo(x, y);
    open = true;
    if (times[i] > view.x1) break;
  }
}

const wayOf = (direction) => (direction > 0 ? "down" : "up");

const inView = (from, to, view) => from <= view.x1 && to >= view.x0;

/** The points of a course that are fine enough for the scale. */
function levelOf(course, scale) {
  for (let i = course.levels.length - 1; i > 0; i--) {
    if (course.levels[i].tolerance * scale.py < 0.9) return course.levels[i];
  }
  return course.levels[0];
}

/**
 * Strokes what looks alike together. Hairlines are one path: a day of 500 trains is four strokes. Thick lines are one path each,
 * because a canvas without a graphics card takes seconds for the outline of all of them at once. `of`: "run" or "plan".
 */
function strokeGroups(context, items, layers, of, widthMax = Infinity) {
  for (const direction of [1, -1]) {
    for (const revenue of [true, false]) {
      const group = items.filter((item) => item.direction === direction && item.revenue === revenue);
      if (!group.length) continue;
      dress(context, layers[`${of}_${wayOf(direction)}`]);
      context.lineWidth = Math.min(context.lineWidth, widthMax);
      if (!revenue) context.setLineDash(layers.empty.dashes);
      const hair = context.lineWidth <= 1;
      if (hair) context.beginPath();
      for (const item of group) {
        if (!hair) context.beginPath();
        item.trace();
        if (!hair) context.stroke();
      }
      if (hair) context.stroke();
    }
  }
  context.setLineDash([]);
}

function drawRuns(context, day, view, scale) {
  const items = day.courses.filter((course) => inView(course.from, course.to, view)).map((course) => {
    const level = levelOf(course, scale);
    return {
      direction: course.direction, revenue: day.byNumber.get(course.train)?.revenue ?? true,
      trace: () => trace(context, level.t, level.m, view, scale),
    };
  });
  context.lineJoin = "bevel";
  const many = items.length > MANY;
  // Of many trains each is two hairlines side by side, as good as thick and twenty times as fast; of very many it is one.
  const one = !many || items.length > NUMBERS_PER_PX * scale.px * (view.x1 - view.x0);
  for (const aside of one ? [0] : [-0.45, 0.45]) {
    context.save();
    context.translate(aside, 0);
    strokeGroups(context, items, day.pictures.train_graph.layers, "run", many ? 1 : Infinity);
    context.restore();
  }
}

function drawPlans(context, day, view, scale) {
  const items = day.trains.filter(({ plan }) => plan.t.length && inView(plan.t[0], plan.t[plan.t.length - 1], view))
    .map((train) => ({ ...train, trace: () => trace(context, train.plan.t, train.plan.m, view, scale) }));
  strokeGroups(context, items, day.pictures.train_graph.layers, "plan");
}

function drawChosen(context, day, view, scale, options) {
  const train = day.byNumber.get(options.chosen);
  if (!train) return;
  context.strokeStyle = COLOURS.chosen;
  for (const course of options.run ? train.courses : []) {
    context.lineWidth = 4;
    context.beginPath();
    trace(context, course.t, course.m, view, scale);
    context.stroke();
  }
  context.lineWidth = 1.6;
  context.beginPath();
  trace(context, train.plan.t, train.plan.m, view, scale);
  context.stroke();
}

/** Trains that moved, or are gone, as they ran in the other run: dashed, dark or red. */
function drawBeside(context, beside, layers, view, scale) {
  for (const gone of [false, true]) {
    dress(context, gone ? layers.gone : layers.beside);
    context.beginPath();
    for (const course of beside.courses) {
      if (beside.gone.has(course.train) !== gone || !course.t.length) continue;
      if (inView(course.t[0], course.t[course.t.length - 1], view)) trace(context, course.t, course.m, view, scale);
    }
    context.stroke();
  }
  context.setLineDash([]);
}

/** Thin dotted links from a unit's train to its next one at the same place (折返し). */
function drawTurns(context, day, view, scale) {
  const last = new Map();
  dress(context, day.pictures.train_graph.layers.turn);
  context.beginPath();
  for (const course of day.courses) {
    const before = last.get(course.unit);
    const here = { t: course.from, m: course.m[0] };
    if (before && here.t - before.t < TURN_S_MAX && Math.abs(here.m - before.m) < 500 && inView(before.t, here.t, view)) {
      context.moveTo(scale.x(before.t), scale.y(before.m));
      context.lineTo(scale.x(here.t), scale.y(here.m));
    }
    last.set(course.unit, { t: course.to, m: course.m[course.m.length - 1] });
  }
  context.stroke();
  context.setLineDash([]);
}

/** What was held, pale, and what was occupied, darker: each section over its kilometrage, in the colour of its unit. */
function drawSections(context, day, view, scale) {
  const end = day.window[1];
  for (const block of day.blocks) {
    if (!block.section) continue;
    const y = scale.y(block.section.from);
    const height = Math.max(scale.y(block.section.to) - y, 2);
    const bars = [[block.granted, block.released, 0.1], [block.entered, block.cleared, 0.16]];
    context.fillStyle = unitColour(day.units, block.unit);
    for (const [from, to, alpha] of bars) {
      const until = Number.isNaN(to) ? end : to;
      if (Number.isNaN(from) || !inView(from, until, view)) continue;
      context.globalAlpha = alpha;
      context.fillRect(scale.x(from), y, (until - from) * scale.px, height);
    }
  }
  context.globalAlpha = 1;
}

/**
 * Minutes of arrival and departure at the stations, each on the side of the station's line where the train is not:
 * a train that comes from above has its arrival below, and its departure above.
 */
function drawMinutes(context, day, view, scale, plot, options) {
  const size = Math.min(Math.max(scale.px * 60 * 0.85, 8.5), 11.5);
  context.font = font(size);
  context.textBaseline = "middle";
  const [arrives, leaves] = options.plan ? ["pa", "pd"] : ["a", "d"];
  const taken = new Set();
  context.strokeStyle = "rgba(255,255,255,0.8)";
  context.lineWidth = 2.5;
  context.setLineDash([]);
  for (const train of day.trains) {
    context.fillStyle = train.number === options.chosen ? COLOURS.chosen
      : day.pictures.train_graph.layers[`plan_${wayOf(train.direction)}`].colour;
    for (const call of train.calls) {
      const y = scale.y(call.station.m);
      if (y < plot.top - 2 || y > plot.top + plot.height + 2) continue;
      const away = train.direction * size * 0.62;
      minute(context, call[arrives], view, scale, y + away, "right", taken, size);
      minute(context, call[leaves], view, scale, y - away, "left", taken, size);
    }
  }
}

function minute(context, time, view, scale, y, side, taken, size) {
  if (!(time >= view.x0 && time <= view.x1)) return;
  const whole = Math.round(time);
  const seconds = whole % 60;
  const text = String(Math.floor(whole / 60) % 60) + (seconds && size > 9 ? `.${String(seconds).padStart(2, "0")}` : "");
  const x = scale.x(time) + (side === "right" ? -2 : 2);
  const place = `${Math.round(x / size)},${Math.round(y / (size * 0.8))}`;
  if (taken.has(place)) return;
  taken.add(place);
  context.textAlign = side;
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
}

const CELL = 5;

/** Each train's number along its line where there is room for it; none where it would lie on another. */
function drawNumbers(context, day, view, scale, plot, options) {
  const taken = new Set();
  const size = 11;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const chosen = day.byNumber.get(options.chosen);
  const seen = day.trains.filter((train) => train !== chosen && trainInView(train, view));
  const ordered = [...(chosen ? [chosen] : []), ...(seen.length > NUMBERS_PER_PX * plot.width ? [] : seen)];
  for (const train of ordered) {
    const course = options.plan && train.plan.t.length ? train.plan : train.courses[0]?.levels.at(-1);
    if (!course?.t.length || !inView(course.t[0], course.t[course.t.length - 1], view)) continue;
    const bold = train === chosen;
    context.font = font(size, bold ? "700" : "");
    const text = train.revenue ? train.number : `(${train.number})`;
    const place = roomFor(context.measureText(text).width, course, view, scale, plot, taken, bold);
    if (!place) continue;
    context.save();
    context.translate(place.x, place.y);
    context.rotate(place.angle);
    context.strokeStyle = "rgba(255,255,255,0.85)";
    context.lineWidth = 3;
    context.strokeText(text, 0, -size * 0.62);
    context.fillStyle = bold ? COLOURS.chosen : train.direction > 0 ? COLOURS.down : COLOURS.up;
    context.fillText(text, 0, -size * 0.62);
    context.restore();
  }
}

/** Whether a train is planned or runs at any time of the view. */
function trainInView(train, view) {
  const { t } = train.plan;
  return (t.length > 0 && inView(t[0], t[t.length - 1], view)) || train.courses.some((course) => inView(course.from, course.to, view));
}

/** The middle of the first stretch of the line that has room for a text of a width, and is not taken. */
function roomFor(width, course, view, scale, plot, taken, always) {
  const first = Math.max(lastBefore(course.t, view.x0), 0);
  for (let i = first; i + 1 < course.t.length && course.t[i] <= view.x1; i++) {
    if (course.m[i] === course.m[i + 1]) continue;
    const seen = within(course, i, scale, plot);
    if (!seen) continue;
    const [x0, y0, x1, y1] = seen;
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (length < width + 10) continue;
    for (const share of [0.5, 0.3, 0.7]) {
      if (length * Math.min(share, 1 - share) < width / 2 + 3) continue;
      const place = { x: x0 + share * (x1 - x0), y: y0 + share * (y1 - y0), angle: Math.atan2(y1 - y0, x1 - x0) };
      const cells = cellsOf(place, width);
      if (!always && cells.some((cell) => taken.has(cell))) continue;
      cells.forEach((cell) => taken.add(cell));
      return place;
    }
  }
  return null;
}

/** What of the stretch from point i on is seen, px; null: nothing. */
function within(course, i, scale, plot) {
  const [x0, y0] = [scale.x(course.t[i]), scale.y(course.m[i])];
  const [x1, y1] = [scale.x(course.t[i + 1]), scale.y(course.m[i + 1])];
  let [from, to] = [0, 1];
  for (const [a, b, low, high] of [
    [x0, x1, plot.left, plot.left + plot.width], [y0, y1, plot.top + 12, plot.top + plot.height - 4],
  ]) {
    if (a === b) {
      if (a < low || a > high) return null;
      continue;
    }
    const [enter, leave] = [(low - a) / (b - a), (high - a) / (b - a)].sort((p, q) => p - q);
    from = Math.max(from, enter);
    to = Math.min(to, leave);
  }
  if (from >= to) return null;
  return [x0 + from * (x1 - x0), y0 + from * (y1 - y0), x0 + to * (x1 - x0), y0 + to * (y1 - y0)];
}

function cellsOf(place, width) {
  const cells = new Set();
  const [cos, sin] = [Math.cos(place.angle), Math.sin(place.angle)];
  for (let along = -width / 2; along <= width / 2; along += CELL - 1) {
    for (const up of [2, 7, 12]) {
      const x = place.x + along * cos + up * sin;
      const y = place.y + along * sin - up * cos;
      cells.add(`${Math.round(x / CELL)},${Math.round(y / CELL)}`);
    }
  }
  return [...cells];
}

function drawMoment(context, scale, plot, moment) {
  if (!moment) return;
  const [x, y] = [scale.x(moment.t), scale.y(moment.m)];
  context.strokeStyle = "rgba(122,31,162,0.55)";
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x, plot.top);
  context.lineTo(x, plot.top + plot.height);
  context.stroke();
  context.fillStyle = COLOURS.chosen;
  context.beginPath();
  context.arc(x, y, 4, 0, 2 * Math.PI);
  context.fill();
}

/** The train whose line is nearest to a place on the canvas, within `reach` px, at the time of that place; null: none. */
export function nearestTrain(day, view, options, plot, x, y, reach = 9) {
  const scale = scaleOf(view, plot);
  const t = scale.t(x);
  let best = null;
  const consider = (train, course, times, places, planned) => {
    const i = lastBefore(times, t);
    if (i < 0 || i + 1 >= times.length) return;
    const m = valueAt(times, places, t);
    const slope = ((places[i + 1] - places[i]) * scale.py) / Math.max((times[i + 1] - times[i]) * scale.px, 1e-6);
    const away = Math.abs(scale.y(m) - y) / Math.hypot(1, slope) + (planned ? 1 : 0);
    if (away <= reach && (!best || away < best.away)) best = { train, course, t, m, planned, away };
  };
  for (const course of options.run ? day.courses : []) {
    const train = day.byNumber.get(course.train);
    if (t >= course.from && t <= course.to && train) consider(train, course, course.t, course.m, false);
  }
  for (const train of options.plan ? day.trains : []) consider(train, null, train.plan.t, train.plan.m, true);
  return best;
}
