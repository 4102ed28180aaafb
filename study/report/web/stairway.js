// The blocking-time stairway (閉そく占有時分): for how long each section is a train's, and what that time goes into.

const LEAST_PX = 4; // a set of points is still to be seen
const TRACK_PX = 7; // and each track of a station, beside the others

/** The boxes of all trains, those that are not the chosen one pale: each section over its kilometrage, tracks apart. */
export function drawStairway(context, day, view, scale, chosen) {
  const rows = rowsOf(day.sections, scale);
  for (const own of chosen ? [false, true] : [true]) {
    context.globalAlpha = own ? 0.6 : 0.2;
    for (const slice of day.stairway) {
      if (!slice.section || slice.from > view.x1 || slice.to < view.x0 || (chosen && (slice.train === chosen) !== own)) continue;
      const { y, height } = rows.get(slice.section.id);
      context.fillStyle = slice.colour;
      context.fillRect(scale.x(slice.from), y, Math.max((slice.to - slice.from) * scale.px, 0.5), height);
    }
  }
  context.globalAlpha = 1;
}

/** Where each section stands: over its kilometrage; tracks of a station side by side, none thinner than can be told apart. */
export function rowsOf(sections, scale) {
  const rows = new Map();
  for (const section of sections) {
    const tracks = section.kind === "track" && section.station ? sections.filter((s) => s.kind === "track" && s.station === section.station) : [section];
    const [from, to] = [Math.min(...tracks.map((s) => s.from)), Math.max(...tracks.map((s) => s.to))].map(scale.y);
    if (tracks.length === 1) {
      rows.set(section.id, { y: from, height: Math.max(to - from, LEAST_PX) });
      continue;
    }
    const height = Math.max((to - from) / tracks.length, TRACK_PX);
    rows.set(section.id, { y: (from + to) / 2 + (tracks.indexOf(section) - tracks.length / 2) * height, height });
  }
  return rows;
}

/** The parts that a day has, with their colours, in the order in which they first come. */
export function partsOf(day) {
  return [...new Map(day.stairway.map((slice) => [slice.part, slice.colour])).entries()];
}
