// Level crossings on the train graph: a thin line at the kilometrage of each, with its name where there is room.
import { font } from "./layer.js";

const NAME_PX = 9;

/** Draw all in view; trains are drawn over them. */
export function drawCrossings(context, day, scale, plot) {
  const { colour, width, dashes } = day.pictures.train_graph.layers.crossing;
  const right = plot.left + plot.width;
  context.font = font(NAME_PX);
  context.textAlign = "right";
  context.textBaseline = "middle";
  context.fillStyle = colour;
  let named = Infinity;
  for (const { name, m } of day.line.crossings ?? []) {
    const y = Math.round(scale.y(m)) + 0.5;
    if (y < plot.top || y > plot.top + plot.height) continue;
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash(dashes);
    context.beginPath();
    context.moveTo(plot.left, y);
    context.lineTo(right, y);
    context.stroke();
    context.setLineDash([]);
    if (Math.abs(y - named) < NAME_PX) continue;
    named = y;
    context.strokeStyle = "#ffffff";
    context.lineWidth = 3;
    context.strokeText(name, right - 3, y);
    context.fillText(name, right - 3, y);
  }
}
