// What the papers show, worked out from the day: occupation of tracks, departures, punctuality, stops. Pure functions.
import { lastBefore, rowsOf, valueAt } from "./data.js";
import { columnOf } from "./tables.js";

/** Lateness of a call on arrival and departure, s after plan; NaN where there is no plan or it did not come. */
export const lateness = (call) => ({ arrival: call.a - call.pa, departure: call.d - call.pd });

/** Classes of lateness, in order, and which one a number of seconds after plan falls into; null: it never came. */
export const CLASSES = ["class_early", "class_15", "class_60", "class_180", "class_more", "class_never"];
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
      const calls = day.trains.flatMap((train) => train.calls)
        .filter((call) => call.station === station && !Number.isNaN(call[planned]) && call.kind !== "pass");
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
      const at = Number.isNaN(call.pd) ? call.d : call.pd;
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

/** Tables of trains, calls and waits. */
export function trainsTable(day) {
  const trains = day.trains;
  const ends = trains.map((train) => [train.calls[0], train.calls[train.calls.length - 1]]);
  const pick = (i, name) => ends.map((pair) => pair[i]?.[name] ?? NaN);
  return {
    id: "trains",
    columns: [
      columnOf("train", "train", trains.map((t) => t.number)), columnOf("unit", "text", trains.map((t) => t.unit)),
      columnOf("direction", "word", trains.map((t) => (t.direction > 0 ? "down" : "up"))),
      columnOf("revenue", "word", trains.map((t) => (t.revenue ? "yes" : "no"))),
      columnOf("from", "place", ends.map(([first]) => first?.station.id)), columnOf("to", "place", ends.map(([, last]) => last?.station.id)),
      columnOf("planned_departure", "clock", pick(0, "pd")), columnOf("departure", "clock", pick(0, "d")),
      columnOf("planned_arrival", "clock", pick(1, "pa")), columnOf("arrival", "clock", pick(1, "a")),
      columnOf("late_s", "signed", ends.map(([, last]) => (last ? last.a - last.pa : NaN)), 0),
      columnOf("run", "word", trains.map((t) => (t.courses.length ? "run" : "did_not_run"))),
    ],
  };
}

/** Every call, as planned and as it went. */
export function callsTable(day) {
  const calls = day.trains.flatMap((train) => train.calls);
  const pick = (name) => calls.map((call) => call[name]);
  return {
    id: "calls",
    columns: [
      columnOf("train", "train", pick("train")), columnOf("station", "place", calls.map((call) => call.station.id)),
      columnOf("track", "text", pick("track")), columnOf("kind", "word", calls.map((call) => `call_${call.kind}`)),
      columnOf("planned_arrival", "clock", pick("pa")), columnOf("arrival", "clock", pick("a")),
      columnOf("planned_departure", "clock", pick("pd")), columnOf("departure", "clock", pick("d")),
      columnOf("error_m", "signed", pick("error"), 3),
    ],
  };
}

/** Every wait, in the page's language. */
export function waitsTable(day, lang) {
  const rows = [...day.waits.entries()].flatMap(([unit, spans]) => spans.map((span) => ({ unit, ...span })));
  return {
    id: "waits",
    columns: [
      columnOf("unit", "text", rows.map((r) => r.unit)), columnOf("from_s", "clock", rows.map((r) => r.from)),
      columnOf("until", "clock", rows.map((r) => r.to)), columnOf("why", "text", rows.map((r) => r[lang])),
    ],
  };
}

/** Every grant of a section. */
export function blocksTable(day) {
  const known = day.blocks.filter((block) => block.section);
  return {
    id: "blocks",
    columns: [
      columnOf("section", "text", known.map((b) => b.section.id)), columnOf("unit", "text", known.map((b) => b.unit)),
      columnOf("train", "train", known.map((b) => b.train)),
      ...["granted", "entered", "cleared", "released"].map((name) => columnOf(name, "clock", known.map((b) => b[name]))),
    ],
  };
}

/** Stops with their errors. */
export function errorsTable(day) {
  const calls = day.trains.flatMap((train) => train.calls.map((call) => ({ ...call, unit: train.unit }))).filter((c) => !Number.isNaN(c.error));
  return {
    id: "errors",
    columns: [
      columnOf("train", "train", calls.map((c) => c.train)), columnOf("unit", "text", calls.map((c) => c.unit)),
      columnOf("station", "place", calls.map((c) => c.station.id)), columnOf("arrival", "clock", calls.map((c) => c.a)),
      columnOf("error_m", "signed", calls.map((c) => c.error), 3),
    ],
  };
}

/** Legs of one train: planned, least, as run, s. */
export function curveLegs(day, number) {
  const table = day.tables.get("legs");
  const own = table ? table.columns[0].values.map((train, i) => (train === number ? i : -1)).filter((i) => i >= 0) : [];
  return {
    id: "curve_legs",
    columns: (table?.columns.slice(1) ?? []).map((column) => ({ ...column, values: own.map((i) => column.values[i]) })),
  };
}
