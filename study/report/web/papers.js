// What the papers show, worked out from the day: occupation of tracks, departures, punctuality, stops. Pure functions.
import { lastBefore, valueAt } from "./data.js";
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

function share(sorted, part) {
  if (!sorted.length) return NaN;
  const at = part * (sorted.length - 1);
  const low = Math.floor(at);
  return sorted[low] + (at - low) * ((sorted[low + 1] ?? sorted[low]) - sorted[low]);
}

/** For every station and for arrivals and departures: how many were planned, how they fell into classes, and their figures. */
export function punctuality(day) {
  const found = [];
  for (const station of day.line.stations) {
    for (const [what, planned, came] of [["arrivals", "pa", "a"], ["departures", "pd", "d"]]) {
      const calls = day.trains.flatMap((train) => train.calls)
        .filter((call) => call.station === station && !Number.isNaN(call[planned]) && call.kind !== "pass");
      if (!calls.length) continue;
      const classes = CLASSES.map(() => 0);
      for (const call of calls) classes[classOf(call[came] - call[planned])] += 1;
      const late = calls.map((call) => call[came] - call[planned]).filter((s) => !Number.isNaN(s)).sort((a, b) => a - b);
      const within = (limit) => (late.length ? (100 * late.filter((s) => Math.abs(s) <= limit).length) / calls.length : NaN);
      found.push({
        station, what, calls: calls.length, classes, came: late.length,
        mean: late.reduce((a, b) => a + b, 0) / late.length, median: share(late, 0.5), p95: share(late, 0.95),
        worst: late[late.length - 1] ?? NaN, earliest: late[0] ?? NaN, within15: within(15), within60: within(60),
      });
    }
  }
  return found;
}

/** The table of punctuality. */
export function punctualityTable(rows) {
  const pick = (name) => rows.map((row) => row[name]);
  return {
    id: "punctuality",
    columns: [
      columnOf("station", "place", rows.map((row) => row.station.id)), columnOf("what", "word", pick("what")),
      columnOf("calls", "number", pick("calls")), columnOf("mean_s", "signed", pick("mean"), 1),
      columnOf("median_s", "signed", pick("median"), 1), columnOf("p95_s", "signed", pick("p95"), 1),
      columnOf("worst_s", "signed", pick("worst"), 1), columnOf("earliest_s", "signed", pick("earliest"), 1),
      columnOf("within_15", "number", pick("within15"), 1), columnOf("within_60", "number", pick("within60"), 1),
      columnOf("class_never", "number", rows.map((row) => row.classes[5])),
    ],
  };
}

/** Stays at tracks, planned or as run: station, track, train, unit, from and to (s); a stay where a set turns is one. */
export function stays(day, planned) {
  const [arrives, leaves] = planned ? ["pa", "pd"] : ["a", "d"];
  const found = [];
  const open = new Map();
  const seen = new Set();
  const known = (time, other) => (Number.isNaN(time) ? other : time);
  const trains = day.trains.filter((train) => train.calls.length);
  const startOf = (train) => {
    for (const call of train.calls) for (const t of [call[arrives], call[leaves]]) if (!Number.isNaN(t)) return t;
    return NaN;
  };
  for (const train of trains.filter((t) => !Number.isNaN(startOf(t))).sort((a, b) => startOf(a) - startOf(b))) {
    train.calls.forEach((call, i) => {
      const passes = call.kind === "pass";
      let [from, to] = [call[arrives], call[leaves]];
      const last = i === train.calls.length - 1;
      if (Number.isNaN(from) && Number.isNaN(to)) return;
      const before = open.get(train.unit)?.stay;
      if (i === 0 && before && before.station === call.station && before.track === call.track) {
        // The set stood here since the train before.
        open.delete(train.unit);
        before.to = known(to, known(from, before.to));
        before.next = train.number;
        return;
      }
      open.delete(train.unit);
      [from, to] = [known(from, to - (i === 0 ? 60 : 0)), known(to, from + (last ? 60 : 0))];
      if (i === 0 && train.begins === "stabled" && !seen.has(train.unit)) from = Math.min(from, day.window[0]);
      seen.add(train.unit);
      const stay = { station: call.station, track: call.track ?? "", train: train.number, next: null, unit: train.unit, from, to, passes };
      found.push(stay);
      // What goes out over a portal does not stand here; what nobody knows of is taken to.
      if (last && train.unit && train.ends !== "portal") open.set(train.unit, { stay, train });
    });
  }
  for (const { stay, train } of open.values()) if (train.ends === "stabled") stay.to = Math.max(stay.to, day.window[1]);
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
