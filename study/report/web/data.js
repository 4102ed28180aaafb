// What the page knows of a day: read from its packed form, and made ready to be drawn and asked.
// `study/report/packing.py` writes what `read` and `column` read.

/** The object packed in a text: base64 of deflated JSON. Rejects for other text. */
export async function read(text) {
  const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return JSON.parse(await new Response(stream).text());
}

/** A column of differences as its values; NaN where there is none. */
export function column(packed) {
  const values = new Float64Array(packed.d.length);
  let last = 0;
  packed.d.forEach((step, i) => {
    if (step !== null) last += step;
    values[i] = step === null ? NaN : last / packed.k;
  });
  return values;
}

/** Index of the last of `times` that is not after `time`; -1 before the first. */
export function lastBefore(times, time) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** The value of a curve at a time, straight between its points; NaN outside of it and in its gaps. */
export function valueAt(times, values, time) {
  const i = lastBefore(times, time);
  if (i < 0 || (i === times.length - 1 && time > times[i])) return NaN;
  if (i === times.length - 1 || times[i] === time) return values[i];
  const share = (time - times[i]) / (times[i + 1] - times[i]);
  return values[i] + share * (values[i + 1] - values[i]);
}

/** Indices of the points to keep so that the curve stays within `tolerance` of every point (Douglas and Peucker). */
export function thinned(times, values, tolerance) {
  const count = times.length;
  const keep = new Uint8Array(count);
  if (count) keep[0] = keep[count - 1] = 1;
  const ahead = count > 2 ? [[0, count - 1]] : [];
  while (ahead.length) {
    const [low, high] = ahead.pop();
    const span = times[high] - times[low];
    let worst = tolerance;
    let at = -1;
    for (let i = low + 1; i < high; i++) {
      const share = span > 0 ? (times[i] - times[low]) / span : 1;
      const away = Math.abs(values[i] - values[low] - share * (values[high] - values[low]));
      if (away > worst) [worst, at] = [away, i];
    }
    if (at < 0) continue;
    keep[at] = 1;
    ahead.push([low, at], [at, high]);
  }
  return Array.from(keep.keys()).filter((i) => keep[i]);
}

const COARSE_M = [30, 60, 120];

function courseOf(raw) {
  const course = { ...raw, t: column(raw.t), m: column(raw.m), v: column(raw.v) };
  for (const name of ["permitted", "target", "notch"]) {
    course[name] = { t: column(raw[name].t), v: column(raw[name].v) };
  }
  course.from = course.t.length ? course.t[0] : NaN;
  course.to = course.t.length ? course.t[course.t.length - 1] : NaN;
  course.levels = [{ tolerance: 0, t: course.t, m: course.m }];
  for (const tolerance of COARSE_M) {
    const kept = thinned(course.t, course.m, tolerance);
    course.levels.push({ tolerance, t: kept.map((i) => course.t[i]), m: kept.map((i) => course.m[i]) });
  }
  return course;
}

function trainOf(raw, stations) {
  const times = Object.fromEntries(["pa", "pd", "a", "d", "error"].map((name) => [name, column(raw[name])]));
  const calls = raw.station.map((id, i) => ({
    station: stations.get(id), track: raw.track[i], kind: raw.kind[i], train: raw.number, index: i,
    ...Object.fromEntries(Object.entries(times).map(([name, values]) => [name, values[i]])),
  }));
  const train = { ...raw, calls: calls.filter((call) => call.station) };
  const corners = [];
  for (const call of raw.planned ? train.calls : []) {
    for (const t of [call.pa, call.pd]) if (!Number.isNaN(t)) corners.push([t, call.station.m]);
  }
  train.plan = { t: corners.map((c) => c[0]), m: corners.map((c) => c[1]) };
  train.courses = [];
  return train;
}

function waitsOf(raw) {
  const found = new Map(raw.units.map((unit) => [unit, []]));
  const from = column(raw.from);
  const to = column(raw.to);
  raw.unit.forEach((unit, i) => {
    found.get(raw.units[unit]).push({ from: from[i], to: to[i], said: raw.said[raw.text[i]] });
  });
  for (const spans of found.values()) spans.sort((a, b) => a.from - b.from);
  return found;
}

function blocksOf(raw, sections) {
  const granted = column(raw.granted);
  const after = (values, i) => (values[i] === null ? NaN : granted[i] + values[i]);
  return raw.section.map((section, i) => ({
    section: sections.get(raw.sections[section]), unit: raw.units[raw.unit[i]], train: raw.trains[raw.train[i]],
    granted: granted[i], released: after(raw.released, i), entered: after(raw.entered, i), cleared: after(raw.cleared, i),
  }));
}

/** Slices of blocking times: section, train, part with its colour, from and to. */
function stairwayOf(raw, sections) {
  const [from, to] = [column(raw.from), column(raw.to)];
  return raw.section.map((section, i) => ({
    section: sections.get(raw.sections[section]), train: raw.trains[raw.train[i]],
    part: raw.parts[raw.part[i]], colour: raw.colours[raw.part[i]], from: from[i], to: to[i],
  }));
}

/** The day, ready: stations, trains with calls and plan, courses, blocks, events, waits, tables by id. */
export function dayOf(data) {
  const stations = new Map(data.line.stations.map((station) => [station.id, station]));
  const sections = new Map(data.sections.map((section, row) => [section.id, { ...section, row }]));
  const trains = data.trains.map((raw) => trainOf(raw, stations));
  const byNumber = new Map(trains.map((train) => [train.number, train]));
  const courses = data.courses.map(courseOf);
  for (const course of courses) byNumber.get(course.train)?.courses.push(course);
  const tables = new Map(data.tables.map((table) => [table.id, table]));
  const marks = data.line.stations.flatMap((s) => [s.m, ...s.marks]);
  return {
    ...data, stations, trains, byNumber, courses, tables,
    sections: [...sections.values()],
    beside: data.beside && {
      ...data.beside, gone: new Set(data.beside.gone),
      courses: data.beside.courses.map((raw) => ({ ...raw, t: column(raw.t), m: column(raw.m) })),
    },
    blocks: blocksOf(data.blocks, sections),
    stairway: stairwayOf(data.stairway, sections),
    waits: waitsOf(data.waits),
    events: eventsOf(data, tables.get("events"), courses),
    units: [...new Set([...courses.map((c) => c.unit), ...trains.map((t) => t.unit)])].filter(Boolean).sort(),
    extent: [Math.min(...marks), Math.max(...marks)],
  };
}

/** Rows of a table as objects. */
export function rowsOf(table) {
  if (!table || !table.columns.length) return [];
  return table.columns[0].values.map((_, i) =>
    Object.fromEntries(table.columns.map((col) => [col.label, col.values[i]])));
}

/** Where a stock was at a time: kilometrage, m; between two of its trains, where the one before ended. */
export function placeOf(courses, unit, time) {
  let place = NaN;
  for (const course of courses) {
    if (course.unit !== unit || !(course.from <= time)) continue;
    place = time <= course.to ? valueAt(course.t, course.m, time) : course.m[course.m.length - 1];
  }
  return place;
}

/** The id of who tells an event: its name in English. */
const idOf = (event) => (Array.isArray(event.source) ? event.source[0] : event.source);

/** Events with their kind bare and their place on the graph; broken invariants among them. Source and text in both languages. */
function eventsOf(data, table, courses) {
  const told = rowsOf(table).map((row) => ({
    t: row.t_s, source: row.source, kind: row.kind[0], called: row.kind, text: row.text,
  }));
  const broken = data.broken.map((row) => ({ t: row.t, source: row.checker, kind: row.kind[0], called: row.kind, text: row.text }));
  return [...told, ...broken].filter((event) => event.t !== null).map((event) => ({
    ...event, m: data.devices[idOf(event)] ?? placeOf(courses, idOf(event), event.t),
  })).sort((a, b) => a.t - b.t);
}

/** Why a stock waited at a time, in both languages; null where nothing is said. */
export function waitAt(day, unit, time) {
  const spans = day.waits.get(unit) ?? [];
  const found = spans.filter((span) => span.from <= time && time <= span.to);
  return found.length ? found[found.length - 1].said : null;
}
