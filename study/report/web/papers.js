// What the papers show, worked out from the day: occupation of tracks, departures, punctuality, stops. Pure functions.
import { lastBefore, rowsOf, valueAt } from "./data.js";

/** Lateness of a call on arrival and departure, s after plan: infinite where it was due and never came, NaN without a plan. */
export function lateness(call, due = Infinity) {
  const late = (planned, came) => (Number.isNaN(came) && planned <= due ? Infinity : came - planned);
  return { arrival: late(call.pa, call.a), departure: late(call.pd, call.d) };
}

/** Classes of lateness, in order, and which one a number of seconds after plan falls into; null: it never came. */
export const CLASSES = ["early by over 15 s", "within 15 s", "to 1 min late", "to 3 min late", "later", "did not come"];
export function classOf(late) {
  if (late === null || Number.isNaN(late)) return 5;
  if (late < -15) return 0;
  return [15, 60, 180].filter((limit) => late > limit).length + 1;
}

/** For every station and for arrivals and departures: how many calls were planned, and how they fell into classes. */
export function punctualityClasses(day) {
  const found = [];
  for (const station of day.line.stations) {
    for (const [what, planned, came] of [["arrival", "pa", "a"], ["departure", "pd", "d"]]) {
      const calls = day.trains.flatMap((train) => train.calls).filter((call) => call.station === station && call.kind !== "pass"
        && !Number.isNaN(call[planned]) && !(Number.isNaN(call[came]) && call[planned] > (day.due ?? Infinity)));
      if (!calls.length) continue;
      const classes = CLASSES.map(() => 0);
      for (const call of calls) classes[classOf(call[came] - call[planned])] += 1;
      found.push({ station, what, calls: calls.length, classes });
    }
  }
  return found;
}

/**
 * Stays at tracks, planned or as run, from the table of occupation: a stay where a set turns is one. Where one end is not known,
 * a stabled set stands from the beginning or to the end of the day, and of others a minute is shown.
 */
export function stays(day, planned) {
  const [begins, ends] = planned ? ["planned_from_s", "planned_to_s"] : ["from_s", "to_s"];
  const found = [];
  for (const row of rowsOf(day.tables.get("occupation"))) {
    let [from, to] = [row[begins], row[ends]];
    const station = day.stations.get(row.station);
    if ((from === null && to === null) || !station) continue;
    const [first, last] = [day.byNumber.get(row.train), day.byNumber.get(row.next_train)];
    if (from === null) from = first?.begins === "stabled" ? Math.min(day.window[0], to) : to - 60;
    if (to === null) to = last?.ends === "stabled" ? Math.max(day.window[1], from) : from + 60;
    const next = row.next_train === row.train ? null : row.next_train;
    found.push({ station, track: row.track ?? "", train: row.train, next, unit: row.unit, from, to, passes: row.kind === "pass" });
  }
  return found;
}

/** Departures of a station in a direction by hour: [{hour, trains: [{call, train, late}]}], with stops and passes. */
export function departures(day, station, direction) {
  const hours = new Map();
  for (const train of day.trains.filter((t) => t.direction === direction)) {
    train.calls.forEach((call, i) => {
      if (call.station !== station || i === train.calls.length - 1) return;
      const at = Number.isNaN(call.pd) ? Math.floor(call.d) : call.pd;
      if (Number.isNaN(at)) return;
      const hour = Math.floor(at / 3600);
      if (!hours.has(hour)) hours.set(hour, []);
      hours.get(hour).push({ at, call, train, late: call.d - call.pd });
    });
  }
  return [...hours.entries()].sort((a, b) => a[0] - b[0]).map(([hour, trains]) => ({ hour, trains: trains.sort((a, b) => a.at - b.at) }));
}

/** The last `reach` m of every stop at a mark: unit, distance before the mark (m), speed and target speed (km/h). */
export function approaches(day, reach = 400) {
  const found = [];
  for (const train of day.trains) {
    for (const call of train.calls.filter((c) => !Number.isNaN(c.error) && !Number.isNaN(c.a))) {
      const course = train.courses.find((c) => c.from <= call.a && call.a <= c.to + 1);
      if (!course) continue;
      const end = lastBefore(course.t, call.a + 0.05);
      const rest = course.m[end];
      let first = end;
      const before = (i) => (rest - course.m[i]) * course.direction;
      // As far back as the reach, and to the first point beyond it; a stop shortly before is not part of this one.
      while (first > 0 && before(first) <= reach && course.v[first - 1] > 0) first -= 1;
      const times = Array.from(course.t.slice(first, end + 1));
      for (const t of course.target.t) if (t > times[0] && t < times[times.length - 1]) times.push(t);
      times.sort((a, b) => a - b);
      found.push({
        unit: course.unit, train: train.number, station: call.station,
        x: times.map((t) => (rest - valueAt(course.t, course.m, t)) * course.direction - call.error),
        v: times.map((t) => valueAt(course.t, course.v, t)), target: times.map((t) => valueAt(course.target.t, course.target.v, t)),
      });
    }
  }
  return found;
}

/** A table of rows that the page has, with the columns that the run says of it. */
const tableOf = (day, id, rows) => ({
  id, title: day.columns[id].title, columns: day.columns[id].columns.map((column) => ({ ...column, values: rows.map((row) => row[column.label]) })),
});

/** The columns of a call, as planned and as it went. */
const callRow = (call) => ({
  train: call.train, station: call.station.id, track: call.track, kind: call.kind,
  planned_arrival_s: call.pa, arrival_s: call.a, planned_departure_s: call.pd, departure_s: call.d, stop_error_m: call.error,
});

/** Every train, with its first and last call. */
export function trainsTable(day) {
  const none = { pa: NaN, pd: NaN, a: NaN, d: NaN };
  return tableOf(day, "trains", day.trains.map((train) => {
    const [first, last] = [train.calls[0] ?? none, train.calls[train.calls.length - 1] ?? none];
    return {
      train: train.number, unit: train.unit, direction: train.direction > 0 ? "down" : "up", revenue: train.revenue ? "yes" : "no",
      from: first.station?.id, to: last.station?.id, planned_departure_s: first.pd, departure_s: first.d,
      planned_arrival_s: last.pa, arrival_s: last.a, late_s: last.a - last.pa, run: train.courses.length ? "Run" : "did not run",
    };
  }));
}

/** Every call, as planned and as it went. */
export const callsTable = (day) => tableOf(day, "calls", day.trains.flatMap((train) => train.calls.map(callRow)));

/** Every wait. */
export const waitsTable = (day) => tableOf(day, "waits", [...day.waits.entries()].flatMap(([unit, spans]) =>
  spans.map((span) => ({ unit, from_s: span.from, until: span.to, why: span.said }))));

/** Every grant of a section. */
export const blocksTable = (day) => tableOf(day, "blocks", day.blocks.filter((block) => block.section).map((block) => ({
  section: block.section.id, unit: block.unit, train: block.train,
  granted_s: block.granted, released_s: block.released, entered_s: block.entered, cleared_s: block.cleared,
})));

/** Stops with their errors. */
export const errorsTable = (day) => tableOf(day, "errors", day.trains.flatMap((train) =>
  train.calls.filter((call) => !Number.isNaN(call.error)).map((call) => ({ ...callRow(call), unit: train.unit }))));

/** Legs of one train: planned, least, as run, s. */
export function curveLegs(day, number) {
  const table = day.tables.get("legs");
  const own = table ? table.columns[0].values.map((train, i) => (train === number ? i : -1)).filter((i) => i >= 0) : [];
  return {
    id: "curve_legs",
    title: "Leg minutes of this train",
    columns: (table?.columns.slice(1) ?? []).map((column) => ({ ...column, values: own.map((i) => column.values[i]) })),
  };
}
