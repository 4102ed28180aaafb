// Bars over time in named rows: tracks of stations (番線), sections of the line.
import { COLOURS, font, makeLayer, makeMovable } from "./layer.js";
import { fitted } from "./marks.js";
import { drawClock, drawClockLines, scaleOf } from "./traingraph.js";
import { clockGrid } from "./view.js";

const TOP = 24;
const RIGHT = 10;

/**
 * A picture of rows of bars in `host`. `picture()` gives {rows: [{label, group, bars}], rowPx}; a bar has from and to (s), colour,
 * share of the row's height, text, and title (what is said of it when pointed at). `pointed(bar, event place)` hears of it.
 */
export function makeGantt(host, bounds, picture, label, pointed) {
  const pane = { bounds: { ...bounds, y0: 0, y1: 1 }, least: { x: 120, y: 1 } };
  pane.view = { ...pane.bounds };
  let rows = picture();
  const layer = makeLayer(host, (context, width, height) => draw(context, rows, pane, layer, width, height), label);
  pane.plot = () => ({ left: layer.gutter ?? 80, top: TOP, width: Math.max(layer.width - (layer.gutter ?? 80) - RIGHT, 10), height: layer.height - TOP });
  pane.changed = () => layer.invalidate();
  const barAt = (x, y) => {
    if (x === null) return null;
    const scale = scaleOf(pane.view, pane.plot());
    const row = rows.rows[Math.floor((y - TOP) / rows.rowPx)];
    const t = scale.t(x);
    return row?.bars.findLast((bar) => bar.title && bar.from - 2 / scale.px <= t && t <= bar.to + 2 / scale.px) ?? null;
  };
  pane.pointed = (x, y) => pointed(barAt(x, y), x, y, layer);
  pane.picked = (x, y) => pointed(barAt(x, y), x, y, layer, true);
  makeMovable(layer, pane);
  const resize = () => {
    host.style.height = `${TOP + rows.rows.length * rows.rowPx + 4}px`;
  };
  resize();
  return {
    pane, layer,
    refresh() {
      rows = picture();
      resize();
      layer.invalidate();
    },
  };
}

function draw(context, { rows, rowPx }, pane, layer, width, height) {
  context.font = font(11);
  const widest = Math.max(30, ...rows.map((row) => context.measureText(row.label).width));
  layer.gutter = Math.min(Math.ceil(widest) + 12, Math.round(width * 0.38));
  const plot = pane.plot();
  const scale = scaleOf(pane.view, plot);
  const grid = clockGrid(scale.px, width < 600 ? 44 : 56);
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, width, height);
  context.save();
  context.beginPath();
  context.rect(plot.left, plot.top, plot.width, plot.height);
  context.clip();
  drawClockLines(context, pane.view, scale, plot, grid);
  rows.forEach((row, i) => row.bars.forEach((bar) => drawBar(context, bar, TOP + i * rowPx, rowPx, scale, pane.view)));
  context.restore();
  rows.forEach((row, i) => drawRow(context, row, rows[i - 1], TOP + i * rowPx, rowPx, plot));
  drawClock(context, pane.view, scale, plot, grid, false);
}

function drawRow(context, row, before, y, rowPx, plot) {
  const first = row.group !== before?.group;
  context.strokeStyle = first ? "#8a8a8a" : COLOURS.fine;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(first ? 0 : plot.left, Math.round(y) + 0.5);
  context.lineTo(plot.left + plot.width, Math.round(y) + 0.5);
  context.stroke();
  context.font = font(11);
  context.fillStyle = COLOURS.ink;
  context.textAlign = "right";
  context.textBaseline = "middle";
  context.fillText(fitted(context, row.label, plot.left - 8), plot.left - 6, y + rowPx / 2);
}

function drawBar(context, bar, y, rowPx, scale, view) {
  if (bar.to < view.x0 || bar.from > view.x1) return;
  const high = rowPx * bar.share;
  const [x, w] = [scale.x(bar.from), Math.max((bar.to - bar.from) * scale.px, 1)];
  const at = y + (rowPx - high) / 2;
  context.globalAlpha = bar.alpha ?? 1;
  context.fillStyle = context.strokeStyle = bar.colour;
  context.lineWidth = 1;
  if (bar.outline) context.strokeRect(x, at + 0.5, w, high - 1);
  else context.fillRect(x, at, w, high);
  context.globalAlpha = 1;
  if (!bar.text) return;
  context.font = font(10);
  if (context.measureText(bar.text).width > w - 4) return;
  context.fillStyle = bar.outline ? bar.colour : "#ffffff";
  context.textAlign = "center";
  context.textBaseline = "middle";
  const [left, right] = [Math.max(x, scale.x(view.x0)), Math.min(x + w, scale.x(view.x1))];
  if (right - left > context.measureText(bar.text).width) context.fillText(bar.text, (left + right) / 2, y + rowPx / 2);
}
