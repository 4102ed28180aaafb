// The run curve (運転曲線) of a train: speed and time over distance, limits, gradients and curves, stations, leg minutes.
import { valueAt } from "./data.js";
import { COLOURS, dress, font } from "./layer.js";
import { fitted } from "./marks.js";
import { niceStep, spread } from "./view.js";

const LEFT = 52;
const RIGHT = 46;
const NAME_ANGLE = Math.PI / 5;
const STRIPS = [["gradient", "‰", 46], ["curve", "R, m", 40], ["notch", "", 40]];
const BELOW = STRIPS.reduce((sum, [, , px]) => sum + px, 0) + 24;

/** The axis of kilometrage on which most of a course lies, and from and to where on it; with the points there. */
export function onAxis(course, axes) {
  const spans = course.axes.map(([from, axis], i) => ({ from, to: course.axes[i + 1]?.[0] ?? course.t.length, axis }));
  const sum = new Map();
  for (const { from, to, axis } of spans) sum.set(axis, (sum.get(axis) ?? 0) + course.t[to - 1] - course.t[from]);
  const [axis] = [...sum.entries()].sort((a, b) => b[1] - a[1])[0];
  const kept = spans.filter((span) => span.axis === axis);
  const ranges = kept.map(({ from, to }) => [course.t[from], course.t[to - 1]]);
  return { axis: axes[axis], inside: (t) => ranges.some(([a, b]) => a <= t && t <= b) };
}

/** Kilometrages that the picture of a course covers, m, with room at the ends. */
export function boundsOf(course, train) {
  const called = (train?.calls ?? []).map((call) => call.station.m);
  const low = Math.min(...course.m, ...called);
  const high = Math.max(...course.m, ...called);
  const room = Math.max(0.015 * (high - low), 2);
  return { low: low - room, high: high + room };
}

/** Where the curve lies on a canvas of this size, with so much room for names above. */
export const plotOf = (width, height, top) => ({
  left: LEFT, top, width: Math.max(width - LEFT - RIGHT, 10), height: Math.max(height - top - BELOW, 10),
});

/** How the names of stations stand above the curve, and their room, px: aslant, or upright where the last would be cut. */
export function roomForNames(context, stations, words, width) {
  context.font = font(11);
  const widths = stations.map((station) => context.measureText(words.place(station)).width);
  const widest = Math.max(0, ...widths);
  const cut = width < 600 || Math.max(0, widths[0], widths[widths.length - 1]) * Math.cos(NAME_ANGLE) > RIGHT - 6;
  const angle = cut ? Math.PI / 2 : NAME_ANGLE;
  return { angle, top: Math.min(Math.ceil(widest * Math.sin(angle)) + 30, 220) };
}

/** Px of a kilometrage: a train runs from left to right, so the axis of an UP train is turned. */
export function placesOf(course, bounds, view, plot) {
  const along = (m) => (course.direction > 0 ? m - bounds.low : bounds.high - m);
  const px = plot.width / (view.x1 - view.x0);
  const x = (m) => plot.left + (along(m) - view.x0) * px;
  const m = (at) => {
    const way = view.x0 + (at - plot.left) / px;
    return course.direction > 0 ? bounds.low + way : bounds.high - way;
  };
  return { x, m, px };
}

/** Draw all of it. `view` is in m from the end at which the train begins. */
export function drawRunCurve(context, day, course, train, view, options, width, height) {
  const bounds = boundsOf(course, train);
  const stations = day.line.stations.filter((s) => s.m >= bounds.low && s.m <= bounds.high);
  const names = roomForNames(context, stations, options.words, width);
  options.top = names.top;
  const plot = plotOf(width, height, names.top);
  const places = placesOf(course, bounds, view, plot);
  const { axis, inside } = onAxis(course, day.line.axes);
  const limits = axis.limits[String(course.direction)];
  const top = Math.max(...limits.map(([, v]) => v), ...course.v) * 1.08;
  const y = (kmh) => plot.top + plot.height * (1 - kmh / top);
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, width, height);
  const { layers, up } = day.pictures.run_curve;
  drawGrid(context, plot, y, top, options.words, up);
  clipped(context, { ...plot, height: plot.height + BELOW - 24 }, () => drawStationLines(context, stations, places, plot));
  drawTimeScale(context, course, plot);
  clipped(context, plot, () => {
    drawLimits(context, limits, axis, places, y, layers.limit);
    drawCurve(context, course, course.permitted, inside, places, y, layers.permitted);
    drawCurve(context, course, course.target, inside, places, y, layers.target);
    drawTime(context, course, inside, places, plot);
    drawCurve(context, course, { t: course.t, v: course.v }, inside, places, y, layers[course.direction > 0 ? "down" : "up"]);
    for (const t of course.braked) cross(context, places.x(valueAt(course.t, course.m, t)), y(valueAt(course.t, course.v, t)));
    if (options.moment !== undefined) drawCursor(context, course, options.moment, places, plot, y);
  });
  drawStrips(context, course, axis, inside, places, plot, options.words);
  drawNames(context, stations, train, places, plot, options.words, names.angle);
  drawLegMinutes(context, train, places, plot);
  drawKilometres(context, course, bounds, view, places, plot, height, options.words);
}

function clipped(context, plot, draw) {
  context.save();
  context.beginPath();
  context.rect(plot.left, plot.top, plot.width, plot.height);
  context.clip();
  draw();
  context.restore();
}

function drawGrid(context, plot, y, top, words, up) {
  context.font = font(11);
  context.textBaseline = "middle";
  context.textAlign = "right";
  const step = niceStep(plot.height / top, 28);
  for (let v = 0; v <= top; v += step) {
    context.strokeStyle = COLOURS.rule;
    context.lineWidth = 0.8;
    context.beginPath();
    context.moveTo(plot.left, y(v));
    context.lineTo(plot.left + plot.width, y(v));
    context.stroke();
    context.fillStyle = COLOURS.ink;
    context.fillText(String(Math.round(v)), plot.left - 5, y(v));
  }
  turned(context, words.said(up), 12, plot.top + plot.height / 2);
  context.fillStyle = COLOURS.green;
  turned(context, words.say("time since the stand, min"), plot.left + plot.width + RIGHT - 7, plot.top + plot.height / 2);
}

function turned(context, text, x, y) {
  context.save();
  context.translate(x, y);
  context.rotate(-Math.PI / 2);
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, 0, 0);
  context.restore();
}

function drawStationLines(context, stations, places, plot) {
  context.strokeStyle = "#b9b9b9";
  context.lineWidth = 0.9;
  for (const station of stations) {
    context.beginPath();
    context.moveTo(places.x(station.m), plot.top);
    context.lineTo(places.x(station.m), plot.top + plot.height + BELOW - 24);
    context.stroke();
  }
}

function drawLimits(context, limits, axis, places, y, layer) {
  dress(context, layer);
  context.beginPath();
  limits.forEach(([from, kmh], i) => {
    const to = limits[i + 1]?.[0] ?? axis.to;
    if (i === 0) context.moveTo(places.x(from), y(kmh));
    context.lineTo(places.x(from), y(kmh));
    context.lineTo(places.x(to), y(kmh));
  });
  context.stroke();
}

function drawCurve(context, course, curve, inside, places, y, layer) {
  dress(context, layer);
  context.lineJoin = "round";
  context.beginPath();
  let open = false;
  // Where the curve has few points the train still moves: its own points are taken too.
  const times = curve.t === course.t ? course.t : merged(curve.t, course.t);
  for (const t of times) {
    const v = curve.t === course.t ? valueAt(course.t, course.v, t) : valueAt(curve.t, curve.v, t);
    const m = valueAt(course.t, course.m, t);
    if (Number.isNaN(v) || !inside(t)) {
      open = false;
      continue;
    }
    if (open) context.lineTo(places.x(m), y(v));
    else context.moveTo(places.x(m), y(v));
    open = true;
  }
  context.stroke();
  context.setLineDash([]);
}

const merged = (a, b) => Float64Array.from(new Set([...a, ...b])).sort();

/** The time curve (時分曲線): minutes since the last stand rise from left to right, as on the Japanese run curve. */
function drawTime(context, course, inside, places, plot) {
  const legs = standsOf(course);
  const longest = longestOf(course);
  const y = (s) => plot.top + plot.height * (1 - s / (longest * 1.05));
  context.strokeStyle = COLOURS.green;
  context.lineWidth = 1;
  for (const { from, to } of legs) {
    context.beginPath();
    let open = false;
    for (let i = 0; i < course.t.length; i++) {
      const t = course.t[i];
      if (t < from || t > to || !inside(t)) continue;
      if (open) context.lineTo(places.x(course.m[i]), y(t - from));
      else context.moveTo(places.x(course.m[i]), y(t - from));
      open = true;
    }
    context.stroke();
  }
}

/** Seconds that the scale of the time curve reaches to. */
const longestOf = (course) => Math.max(60, ...standsOf(course).map(({ from, to }) => to - from));

function drawTimeScale(context, course, plot) {
  const longest = longestOf(course);
  context.fillStyle = COLOURS.green;
  context.font = font(10);
  context.textAlign = "left";
  context.textBaseline = "middle";
  const step = [15, 30, 60, 120, 300, 600, 1200, 3600].find((s) => (s / longest) * plot.height >= 24) ?? 7200;
  for (let s = 0; s <= longest; s += step) {
    const text = step < 60 ? `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}` : String(s / 60);
    context.fillText(text, plot.left + plot.width + 4, plot.top + plot.height * (1 - s / (longest * 1.05)));
  }
}

/** Stretches of a course between two stands of at least 5 s, s. */
export function standsOf(course) {
  const legs = [];
  let from = course.from;
  for (let i = 1; i < course.t.length; i++) {
    const stood = course.m[i] === course.m[i - 1] && course.t[i] - course.t[i - 1] >= 5;
    if (!stood) continue;
    if (course.t[i - 1] > from) legs.push({ from, to: course.t[i - 1] });
    from = course.t[i];
  }
  if (course.to > from) legs.push({ from, to: course.to });
  return legs;
}

function cross(context, x, y) {
  context.strokeStyle = COLOURS.red;
  context.lineWidth = 1.8;
  context.beginPath();
  context.moveTo(x - 4, y - 4);
  context.lineTo(x + 4, y + 4);
  context.moveTo(x + 4, y - 4);
  context.lineTo(x - 4, y + 4);
  context.stroke();
}

function drawCursor(context, course, t, places, plot, y) {
  const x = places.x(valueAt(course.t, course.m, t));
  context.strokeStyle = "rgba(122,31,162,0.6)";
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x, plot.top);
  context.lineTo(x, plot.top + plot.height);
  context.stroke();
  context.fillStyle = COLOURS.chosen;
  context.beginPath();
  context.arc(x, y(valueAt(course.t, course.v, t)), 4, 0, 2 * Math.PI);
  context.fill();
}

function drawStrips(context, course, axis, inside, places, plot, words) {
  let top = plot.top + plot.height;
  for (const [name, unit, px] of STRIPS) {
    const strip = { left: plot.left, top, width: plot.width, height: px };
    context.strokeStyle = COLOURS.rule;
    context.lineWidth = 1;
    context.strokeRect(strip.left + 0.5, strip.top + 0.5, strip.width, strip.height);
    context.font = font(10);
    context.fillStyle = COLOURS.ink;
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(words.say(name), plot.left - 4, top + px / 2 - 6);
    context.fillText(words.say(unit), plot.left - 4, top + px / 2 + 7);
    clipped(context, strip, () => STRIP_DRAWN[name](context, course, axis, inside, places, strip));
    top += px;
  }
}

function bar(context, from, to, height, strip, colour, text) {
  const middle = strip.top + strip.height / 2;
  const reach = strip.height / 2 - 13;
  // What of it is in view, so that its text is.
  const a = Math.max(Math.min(from, to), strip.left);
  const b = Math.min(Math.max(from, to), strip.left + strip.width);
  if (b <= a) return;
  context.fillStyle = colour;
  context.fillRect(a, middle, b - a, -height * reach);
  if (!text || b - a < context.measureText(text).width + 4) return;
  context.fillStyle = COLOURS.ink;
  context.textAlign = "center";
  context.fillText(text, (a + b) / 2, middle - height * reach + (height >= 0 ? -6 : 7));
}

/** What a train climbs stands above the line, what bends to its right too. */
const STRIP_DRAWN = {
  gradient(context, course, axis, _inside, places, strip) {
    const steepest = Math.max(1, ...axis.gradients.map(([, , p]) => Math.abs(p)));
    for (const [from, to, permille] of axis.gradients) {
      const p = permille * course.direction;
      bar(context, places.x(from), places.x(to), p / steepest, strip, "#c3cfda", p ? String(+Math.abs(p).toPrecision(3)) : "");
    }
  },
  curve(context, course, axis, _inside, places, strip) {
    const sharpest = Math.max(...axis.curves.map(([, , r]) => 1 / Math.abs(r)), 1e-9);
    for (const [from, to, radius] of axis.curves) {
      bar(context, places.x(from), places.x(to), course.direction / radius / sharpest, strip, "#d8cdb8", String(Math.round(Math.abs(radius))));
    }
  },
  notch(context, course, _axis, inside, places, strip) {
    const { t, v } = course.notch;
    const most = Math.max(1, ...v.filter((value) => !Number.isNaN(value)).map(Math.abs));
    const middle = strip.top + strip.height / 2;
    for (let i = 0; i + 1 < t.length; i++) {
      if (Number.isNaN(v[i]) || !inside(t[i]) || !v[i]) continue;
      const [a, b] = [valueAt(course.t, course.m, t[i]), valueAt(course.t, course.m, t[i + 1])];
      context.fillStyle = v[i] > 0 ? COLOURS.traction : "#c9554d";
      const [x0, x1] = [places.x(a), places.x(b)];
      context.fillRect(Math.min(x0, x1), middle, Math.max(Math.abs(x1 - x0), 0.6), (-v[i] / most) * (strip.height / 2 - 3));
    }
    context.fillStyle = COLOURS.pale;
    context.fillRect(strip.left, middle, strip.width, 0.8);
  },
};

function drawNames(context, stations, train, places, plot, words, angle) {
  const called = new Set((train?.calls ?? []).map((call) => call.station.id));
  const seen = stations.filter((s) => places.x(s.m) >= plot.left - 1 && places.x(s.m) <= plot.left + plot.width + 1)
    .sort((a, b) => places.x(a.m) - places.x(b.m));
  context.font = font(11);
  const tops = spread(seen.map((s) => places.x(s.m)), angle < 1 ? 24 : 13, plot.left, plot.left + plot.width);
  context.textAlign = "left";
  context.textBaseline = "middle";
  seen.forEach((station, i) => {
    context.save();
    context.translate(tops[i], plot.top - 18);
    context.rotate(-angle);
    context.fillStyle = called.has(station.id) ? COLOURS.ink : COLOURS.pale;
    context.fillText(fitted(context, words.place(station), (plot.top - 22) / Math.sin(angle)), 0, 0);
    context.restore();
    context.strokeStyle = "#b9b9b9";
    context.beginPath();
    context.moveTo(tops[i], plot.top - 14);
    context.lineTo(places.x(station.m), plot.top);
    context.stroke();
  });
}

/** Minutes and seconds from stop to stop as run, between the stations at the foot of the curve. */
function drawLegMinutes(context, train, places, plot) {
  const stops = (train?.calls ?? []).filter((call) => call.kind !== "pass");
  context.font = font(11, "600");
  context.textAlign = "center";
  context.textBaseline = "middle";
  stops.slice(1).forEach((there, i) => {
    const here = stops[i];
    const took = there.a - here.d;
    const [a, b] = [here, there].map((call) => Math.min(Math.max(places.x(call.station.m), plot.left), plot.left + plot.width));
    const [x, room] = [(a + b) / 2, Math.abs(b - a)];
    if (Number.isNaN(took)) return;
    const whole = Math.round(took);
    const text = `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
    const width = context.measureText(text).width;
    if (width + 6 > room) return;
    context.fillStyle = "rgba(255,255,255,0.85)";
    context.fillRect(x - width / 2 - 2, plot.top + plot.height - 18, width + 4, 14);
    context.fillStyle = COLOURS.ink;
    context.fillText(text, x, plot.top + plot.height - 11);
  });
}

function drawKilometres(context, course, bounds, view, places, plot, height, words) {
  context.font = font(11);
  context.fillStyle = COLOURS.ink;
  context.textBaseline = "middle";
  context.textAlign = "center";
  const step = niceStep(places.px, 56);
  const [a, b] = [places.m(plot.left), places.m(plot.left + plot.width)].sort((p, q) => p - q);
  for (let i = Math.ceil(a / step); i * step <= b; i++) {
    const x = places.x(i * step);
    if (x < plot.left + 8 || x > plot.left + plot.width - 8) continue;
    context.fillText(String(+((i * step) / 1000).toFixed(3)), x, height - 11);
  }
  context.textAlign = "right";
  context.fillText("km", plot.left - 6, height - 11);
}
