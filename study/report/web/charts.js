// The smaller charts: stacked bars, dots by group, curves, a map of colours. Each is drawn from plain values.
import { COLOURS, font } from "./layer.js";
import { fitted } from "./marks.js";
import { niceStep } from "./view.js";

function frame(context, width, height, margins) {
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, width, height);
  return {
    left: margins.left, top: margins.top,
    width: Math.max(width - margins.left - margins.right, 10), height: Math.max(height - margins.top - margins.bottom, 10),
  };
}

function scaleY(context, plot, low, high, unit) {
  const y = (value) => plot.top + plot.height * (1 - (value - low) / (high - low));
  const step = niceStep(plot.height / (high - low), 26);
  context.font = font(11);
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9; i++) {
    context.strokeStyle = i === 0 ? COLOURS.pale : COLOURS.rule;
    context.lineWidth = 0.8;
    context.beginPath();
    context.moveTo(plot.left, y(i * step));
    context.lineTo(plot.left + plot.width, y(i * step));
    context.stroke();
    context.fillStyle = COLOURS.ink;
    context.fillText(String(+(i * step).toPrecision(6)).replace("-", "−"), plot.left - 5, y(i * step));
  }
  context.save();
  context.translate(11, plot.top + plot.height / 2);
  context.rotate(-Math.PI / 2);
  context.textAlign = "center";
  context.fillText(unit, 0, 0);
  context.restore();
  return y;
}

/** Where the names of series stand above a plot, px: as many rows as they need. */
function legendPlaces(context, series, left, width) {
  context.font = font(11);
  let [x, y] = [left, 6];
  return series.map(({ label }) => {
    const wide = context.measureText(label).width + 26;
    if (x > left && x + wide > left + width + 8) [x, y] = [left, y + 15];
    const place = [x, y];
    x += wide;
    return place;
  });
}

function drawLegend(context, series, places) {
  context.font = font(11);
  context.textBaseline = "middle";
  context.textAlign = "left";
  series.forEach(({ label, colour }, i) => {
    const [x, y] = places[i];
    context.fillStyle = colour;
    context.fillRect(x, y, 10, 10);
    context.fillStyle = COLOURS.ink;
    context.fillText(label, x + 14, y + 5.5);
  });
}

/** Room for labels under a chart, and whether they stand upright because they have none side by side. */
function roomForLabels(context, labels, width) {
  context.font = font(11);
  const widest = Math.max(0, ...labels.map((label) => context.measureText(label).width));
  const upright = widest > (width - 64) / Math.max(labels.length, 1) - 6;
  return { upright, bottom: upright ? Math.min(Math.ceil(widest) + 12, 230) : 26 };
}

/**
 * Stacked bars: `labels` along, `series` [{label, colour, values}] up where positive and down where negative; `tops` are texts
 * above. Labels stand upright where they have no room side by side; of very many, some have none.
 */
export function drawBars(context, width, height, { labels, series, unit, tops = [] }) {
  const { upright, bottom } = roomForLabels(context, labels, width);
  const legend = legendPlaces(context, series, 52, width - 60);
  const plot = frame(context, width, height, { left: 52, right: 8, top: 20 + (legend[legend.length - 1]?.[1] ?? 0), bottom });
  const known = (value) => (Number.isFinite(value) ? value : 0);
  const sums = labels.map((_, i) => series.reduce(([up, down], { values }) => {
    const value = known(values[i]);
    return value >= 0 ? [up + value, down] : [up, down + value];
  }, [0, 0]));
  const [most, least] = [Math.max(0, ...sums.map(([up]) => up)), Math.min(0, ...sums.map(([, down]) => down))];
  const high = (most > 0 || least < 0 ? most : 1) * (tops.length ? 1.18 : 1.06);
  const low = least * 1.1;
  const y = scaleY(context, plot, low, high, unit);
  const each = plot.width / Math.max(labels.length, 1);
  const wide = Math.min(each * 0.74, 46);
  const every = Math.ceil(11 / each);
  labels.forEach((label, i) => {
    const x = plot.left + (i + 0.5) * each;
    let [up, down] = [0, 0];
    for (const { values, colour } of series) {
      const value = known(values[i]);
      const from = value >= 0 ? up : down;
      context.fillStyle = colour;
      context.fillRect(x - wide / 2, y(Math.max(from, from + value)), wide, Math.abs(y(from + value) - y(from)));
      if (value >= 0) up += value;
      else down += value;
    }
    if (i % every === 0) drawLabel(context, label, x, plot.top + plot.height + 6, each, upright);
    if (tops[i] && each >= 14) drawTop(context, tops[i], x, y(up) - 4, each);
  });
  drawLegend(context, series, legend);
}

function drawLabel(context, text, x, y, room, upright) {
  context.fillStyle = COLOURS.ink;
  context.font = font(11);
  context.save();
  context.translate(x, y);
  if (upright) {
    context.rotate(-Math.PI / 2);
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.fillText(fitted(context, text, 224), 0, 0);
  } else {
    context.textAlign = "center";
    context.textBaseline = "top";
    context.fillText(fitted(context, text, room - 2), 0, 0);
  }
  context.restore();
}

function drawTop(context, text, x, y, room) {
  context.font = font(10);
  context.fillStyle = COLOURS.pale;
  context.save();
  context.translate(x, y);
  if (context.measureText(text).width > room - 2) {
    context.rotate(-Math.PI / 2);
    context.textAlign = "left";
    context.textBaseline = "middle";
  } else {
    context.textAlign = "center";
    context.textBaseline = "bottom";
  }
  context.fillText(text, 0, 0);
  context.restore();
}

/** Dots by group, moved aside by rank so that equal ones stay apart, a bar at the mean. `groups`: [{label, values}]. */
export function drawDots(context, width, height, { groups, unit }) {
  const { upright, bottom } = roomForLabels(context, groups.map((group) => group.label), width);
  const plot = frame(context, width, height, { left: 56, right: 8, top: 12, bottom });
  const all = groups.flatMap((group) => group.values).filter(Number.isFinite);
  const reach = Math.max(0.05, ...all.map(Math.abs)) * 1.1;
  const y = scaleY(context, plot, -reach, reach, unit);
  const each = plot.width / Math.max(groups.length, 1);
  groups.forEach((group, i) => {
    const x = plot.left + (i + 0.5) * each;
    context.fillStyle = "rgba(61,103,145,0.75)";
    group.values.forEach((value, k) => {
      const aside = group.values.length > 1 ? (k / (group.values.length - 1) - 0.5) * each * 0.5 : 0;
      context.beginPath();
      context.arc(x + aside, y(value), 2, 0, 2 * Math.PI);
      context.fill();
    });
    if (group.values.length) {
      const mean = group.values.reduce((a, b) => a + b, 0) / group.values.length;
      context.fillStyle = COLOURS.ink;
      context.fillRect(x - each * 0.32, y(mean) - 0.7, each * 0.64, 1.5);
    }
    drawLabel(context, group.label, x, plot.top + plot.height + 6, each, upright);
  });
}

/** Curves in panels of one scale: `panels` [{title, curves: [{x, y, colour, dash}]}], x running from `from` to `to`. */
export function drawPanels(context, width, height, { panels, columns, from, to, unitX, unitY }) {
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, width, height);
  const rows = Math.ceil(panels.length / columns);
  const cell = { width: width / columns, height: height / Math.max(rows, 1) };
  const top = Math.max(1e-6, ...panels.flatMap((p) => p.curves.flatMap((c) => c.y.filter((v) => !Number.isNaN(v))))) * 1.06;
  panels.forEach((panel, i) => {
    context.save();
    context.translate((i % columns) * cell.width, Math.floor(i / columns) * cell.height);
    const plot = { left: 48, top: 22, width: cell.width - 58, height: cell.height - 60 };
    const y = scaleY(context, plot, 0, top, unitY);
    const x = (value) => plot.left + ((value - from) / (to - from)) * plot.width;
    context.fillStyle = COLOURS.ink;
    context.textAlign = "left";
    context.font = font(12, "600");
    context.fillText(fitted(context, panel.title, plot.width), plot.left, 10);
    context.font = font(11);
    context.textAlign = "center";
    const step = niceStep(plot.width / Math.abs(to - from), 44);
    for (let k = Math.ceil(Math.min(from, to) / step); k * step <= Math.max(from, to); k++) {
      context.fillText(String(+(k * step).toPrecision(6)).replace("-", "−"), x(k * step), plot.top + plot.height + 11);
    }
    context.fillText(unitX, plot.left + plot.width / 2, plot.top + plot.height + 27);
    context.beginPath();
    context.rect(plot.left, plot.top, plot.width, plot.height);
    context.clip();
    for (const curve of panel.curves) drawLine(context, curve, x, y);
    context.restore();
  });
}

function drawLine(context, curve, x, y) {
  context.strokeStyle = curve.colour;
  context.globalAlpha = curve.alpha ?? 1;
  context.lineWidth = curve.width ?? 1;
  context.setLineDash(curve.dash ?? []);
  context.beginPath();
  let open = false;
  curve.x.forEach((value, i) => {
    if (Number.isNaN(curve.y[i]) || Number.isNaN(value)) {
      open = false;
      return;
    }
    if (open) context.lineTo(x(value), y(curve.y[i]));
    else context.moveTo(x(value), y(curve.y[i]));
    open = true;
  });
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/** A map of colours over two axes, on a logarithmic scale: `rows` of values, the first at the foot; the least is marked. */
export function drawSurface(context, width, height, { rows, x0, stepX, y0, stepY, unitX, unitY, marks }) {
  const plot = frame(context, width, height, { left: 56, right: 10, top: 14, bottom: 40 });
  const logs = rows.map((row) => row.map((value) => Math.log10(Math.max(value, 1e-7))));
  const [low, high] = [Math.min(...logs.flat()), Math.max(...logs.flat())];
  const [cellX, cellY] = [plot.width / rows[0].length, plot.height / rows.length];
  logs.forEach((row, j) => row.forEach((value, i) => {
    const share = high > low ? (value - low) / (high - low) : 0;
    context.fillStyle = `rgb(${Math.round(12 + 240 * share)},${Math.round(44 + 205 * share)},${Math.round(132 + 75 * share)})`;
    context.fillRect(plot.left + i * cellX, plot.top + (rows.length - 1 - j) * cellY, cellX + 0.6, cellY + 0.6);
  }));
  const x = (value) => plot.left + ((value - x0) / stepX + 0.5) * cellX;
  const y = (value) => plot.top + plot.height - ((value - y0) / stepY + 0.5) * cellY;
  context.font = font(11);
  context.fillStyle = COLOURS.ink;
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (let i = 0; i < rows[0].length; i += 5) context.fillText((x0 + i * stepX).toFixed(1), x(x0 + i * stepX), plot.top + plot.height + 11);
  context.fillText(unitX, plot.left + plot.width / 2, plot.top + plot.height + 28);
  context.textAlign = "right";
  for (let j = 0; j < rows.length; j += 5) context.fillText((y0 + j * stepY).toFixed(1).replace("-", "−"), plot.left - 5, y(y0 + j * stepY));
  context.save();
  context.translate(11, plot.top + plot.height / 2);
  context.rotate(-Math.PI / 2);
  context.textAlign = "center";
  context.fillText(unitY, 0, 0);
  context.restore();
  for (const mark of marks) {
    context.strokeStyle = "#ffffff";
    context.lineWidth = 2.5;
    context.beginPath();
    context.arc(x(mark.x), y(mark.y), 6, 0, 2 * Math.PI);
    context.stroke();
  }
}
