// The blocking-time stairway (閉そく占有時分): for how long each section is a train's, and what that time goes into.

const LEAST_PX = 4; // a set of points is still to be seen

/** The boxes of all trains, or of the chosen one alone, each section over its kilometrage. */
export function drawStairway(context, day, view, scale, chosen) {
  context.globalAlpha = 0.6;
  for (const slice of day.stairway) {
    if (!slice.section || slice.from > view.x1 || slice.to < view.x0 || (chosen && slice.train !== chosen)) continue;
    const y = scale.y(slice.section.from);
    const height = Math.max(scale.y(slice.section.to) - y, LEAST_PX);
    context.fillStyle = slice.colour;
    context.fillRect(scale.x(slice.from), y, Math.max((slice.to - slice.from) * scale.px, 0.5), height);
  }
  context.globalAlpha = 1;
}

/** The parts that a day has, with their colours, in the order in which they first come. */
export function partsOf(day) {
  return [...new Map(day.stairway.map((slice) => [slice.part, slice.colour])).entries()];
}
