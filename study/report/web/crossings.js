// Level crossings on the train graph: a thin line at the kilometrage of each, with its name.
import { font } from "./layer.js";

const CROSSING_PX = 9;

/** Level crossings in view, with their height on the canvas. */
function crossingsSeen(day, scale, plot) {
  return (day.line.crossings ?? []).map((crossing) => ({ ...crossing, y: Math.round(scale.y(crossing.m)) + 0.5 }))
    .filter(({ y }) => y >= plot.top && y <= plot.top + plot.height);
}

/** A thin line at each level crossing. */
export function drawCrossingLines(context, day, scale, plot) {
  const { colour, width, dashes } = day.pictures.train_graph.layers.crossing;
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dashes);
  for (const { y } of crossingsSeen(day, scale, plot)) {
    context.beginPath();
    context.moveTo(plot.left, y);
    context.lineTo(plot.left + plot.width, y);
    context.stroke();
  }
  context.setLineDash([]);
}

/** The names of level crossings at the right end of their lines, as far as there is room for them. */
export function drawCrossingNames(context, day, scale, plot) {
  context.font = font(CROSSING_PX);
  context.textAlign = "right";
  context.textBaseline = "middle";
  context.strokeStyle = "rgba(255,255,255,0.85)";
  context.lineWidth = 2.5;
  context.setLineDash([]);
  context.fillStyle = day.pictures.train_graph.layers.crossing.colour;
  let last = -Infinity;
  for (const { name, y } of crossingsSeen(day, scale, plot).sort((a, b) => a.y - b.y)) {
    if (y - last < CROSSING_PX) continue;
    last = y;
    context.strokeText(name, plot.left + plot.width - 3, y);
    context.fillText(name, plot.left + plot.width - 3, y);
  }
}
