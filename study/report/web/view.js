// What part of a picture is seen: pure functions on windows {x0, x1, y0, y1} within bounds of the same form.

/** The window moved by so much, kept within its bounds. */
export function panned(view, bounds, dx, dy) {
  const moved = (low, high, min, max, by) => {
    const shift = Math.min(Math.max(by, min - low), Math.max(max - high, min - low));
    return [low + shift, high + shift];
  };
  const [x0, x1] = moved(view.x0, view.x1, bounds.x0, bounds.x1, dx);
  const [y0, y1] = moved(view.y0, view.y1, bounds.y0, bounds.y1, dy);
  return { x0, x1, y0, y1 };
}

/** The window made `fx` and `fy` times as large about a point, neither larger than its bounds nor less than the least spans. */
export function zoomed(view, bounds, least, fx, fy, ax, ay) {
  const scaled = (low, high, min, max, factor, about, span) => {
    const size = Math.min(Math.max((high - low) * factor, Math.min(span, max - min)), max - min);
    const share = high > low ? (about - low) / (high - low) : 0.5;
    const from = Math.min(Math.max(about - share * size, min), max - size);
    return [from, from + size];
  };
  const [x0, x1] = scaled(view.x0, view.x1, bounds.x0, bounds.x1, fx, ax, least.x);
  const [y0, y1] = scaled(view.y0, view.y1, bounds.y0, bounds.y1, fy, ay, least.y);
  return { x0, x1, y0, y1 };
}

const LINES = [[60, 7], [120, 8], [600, 9], [1800, 8], [3600, 4], [7200, 4], [21600, 4]];
const LABELS = [1, 2, 5, 10, 30, 60, 120, 300, 600, 1800, 3600, 7200, 10800, 21600];
const SHORT = [[1, 6], [10, 6], [30, 6]];

/**
 * Lines of a clock axis with so many pixels a second: steps of the lines drawn, the finest first, and of the labels, s.
 * Hours and ten minutes stay as long as they can be told apart; two minutes and one come when zoomed in.
 */
export function clockGrid(pixelsPerSecond, labelPixels) {
  const fine = pixelsPerSecond >= 1.2 ? SHORT : [];
  const steps = [...fine, ...LINES].filter(([step, gap]) => step * pixelsPerSecond >= gap).map(([step]) => step);
  const label = LABELS.find((step) => step * pixelsPerSecond >= labelPixels) ?? 43200;
  return { steps, label };
}

/** Round steps of a scale so that lines are at least so many pixels apart. */
export function niceStep(pixelsPerUnit, pixels) {
  const least = pixels / pixelsPerUnit;
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((n) => n * power).find((step) => step >= least * 0.999);
}

/** Positions moved apart, in their order, to at least `gap`; they stay about where they are, within `low` and `high`. */
export function spread(positions, gap, low = -Infinity, high = Infinity) {
  const room = positions.length > 1 ? Math.min(gap, (high - low) / (positions.length - 1)) : gap;
  const groups = [];
  for (const at of positions) {
    groups.push({ sum: at, count: 1 });
    for (;;) {
      const [a, b] = groups.slice(-2);
      if (groups.length < 2 || top(b, room, low, high) - bottom(a, room, low, high) >= room - 1e-9) break;
      // Positions of a group are taken less their places in it, so that their mean is where the group begins.
      a.sum += b.sum - room * a.count * b.count;
      a.count += b.count;
      groups.pop();
    }
  }
  return groups.flatMap((g) => Array.from({ length: g.count }, (_, i) => top(g, room, low, high) + i * room));
}

function top(group, gap, low, high) {
  const size = (group.count - 1) * gap;
  return Math.min(Math.max(group.sum / group.count, low), high - size);
}

function bottom(group, gap, low, high) {
  return top(group, gap, low, high) + (group.count - 1) * gap;
}

/** HH:MM or HH:MM:SS; hours go on after 23 as in a Japanese timetable, and what is before midnight has a minus. */
export function clock(time, seconds = false) {
  if (time === null || Number.isNaN(time)) return "–";
  const whole = Math.abs(Math.round(time));
  const two = (n) => String(n).padStart(2, "0");
  const text = `${Math.round(time) < 0 ? "-" : ""}${two(Math.floor(whole / 3600))}:${two(Math.floor(whole / 60) % 60)}`;
  return seconds ? `${text}:${two(whole % 60)}` : text;
}

/** How late, +MM:SS, with hours where there are any; what is early has a minus. */
export function late(time) {
  if (time === null || Number.isNaN(time)) return "–";
  return `${time < 0 && Math.round(-time) > 0 ? "−" : "+"}${clock(Math.abs(time), true).replace(/^00:/, "")}`;
}
