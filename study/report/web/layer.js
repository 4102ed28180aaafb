// The canvas layer: a sharp canvas that fits its place, is drawn at most once a frame, and is moved by mouse, finger and key.
import { panned, zoomed } from "./view.js";

// Colours of the page alone; those that plots share come with the data.
export const COLOURS = { pale: "#6b6b6b", fine: "#ececec", green: "#2e7d4f", chosen: "#7a1fa2", target: "#d55e00", units: ["#0072b2"] };
const FONT = '"Helvetica Neue", Helvetica, Arial, "Hiragino Sans", "Noto Sans CJK JP", "Yu Gothic", "branchline-ja", sans-serif';

/** Lines and faces as a layer of a picture has them. */
export function dress(context, layer) {
  context.strokeStyle = context.fillStyle = layer.colour;
  context.lineWidth = layer.width;
  context.setLineDash(layer.dashes);
}

/** The font of pictures at a size in px. */
export const font = (px, weight = "") => `${weight} ${px}px ${FONT}`.trim();

/** A colour for each unit. */
export const unitColour = (units, unit) => COLOURS.units[Math.max(units.indexOf(unit), 0) % COLOURS.units.length];

/**
 * A canvas within `host`. `draw(context, width, height)` is asked for whenever it was invalidated, once a frame; sizes are CSS px.
 * `label` is what it is called for those who do not see it.
 */
export function makeLayer(host, draw, label) {
  const canvas = host.ownerDocument.createElement("canvas");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", label);
  host.append(canvas);
  const layer = { canvas, width: 0, height: 0, frames: 0, drawingMs: 0, waiting: false };
  layer.drawNow = () => {
    layer.waiting = false;
    if (!layer.width || !layer.height) return;
    const began = performance.now();
    const scale = layer.scale ?? (globalThis.devicePixelRatio || 1);
    const [w, h] = [Math.round(layer.width * scale), Math.round(layer.height * scale)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const context = canvas.getContext("2d");
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, layer.width, layer.height);
    draw(context, layer.width, layer.height);
    layer.frames += 1;
    layer.drawingMs += performance.now() - began;
  };
  layer.invalidate = () => {
    if (layer.waiting) return;
    layer.waiting = true;
    requestAnimationFrame(() => layer.waiting && layer.drawNow());
  };
  layer.fit = (width = host.clientWidth, height = host.clientHeight) => {
    if (width === layer.width && height === layer.height) return;
    [layer.width, layer.height] = [width, height];
    layer.invalidate();
  };
  new ResizeObserver(() => layer.fit()).observe(host);
  layer.fit();
  return layer;
}

/**
 * Lets mouse, finger and keys move `pane`: {view, bounds, least, plot()} with plot() the px rectangle of the view on the canvas.
 * Calls pane.changed() after a move, pane.pointed(x, y) where the mouse is (null: left), pane.picked(x, y) on a click,
 * pane.key(event) for keys that are not its own; it returns whether it took the key.
 */
export function makeMovable(layer, pane) {
  const { canvas } = layer;
  const move = (view) => {
    pane.view = view;
    pane.changed();
  };
  const perPx = () => {
    const plot = pane.plot();
    return { x: (pane.view.x1 - pane.view.x0) / plot.width, y: (pane.view.y1 - pane.view.y0) / plot.height };
  };
  pane.pan = (dx, dy) => move(panned(pane.view, pane.bounds, dx * perPx().x, dy * perPx().y));
  pane.zoom = (fx, fy, x, y) => {
    const plot = pane.plot();
    const about = (from, to, share) => from + Math.min(Math.max(share, 0), 1) * (to - from);
    const ax = about(pane.view.x0, pane.view.x1, x === undefined ? 0.5 : (x - plot.left) / plot.width);
    const ay = about(pane.view.y0, pane.view.y1, y === undefined ? 0.5 : (y - plot.top) / plot.height);
    move(zoomed(pane.view, pane.bounds, pane.least, fx, fy, ax, ay));
  };
  pane.fit = () => move({ ...pane.bounds });
  listenToPointers(canvas, pane);
  canvas.addEventListener("wheel", (event) => {
    const zooms = event.ctrlKey || event.metaKey;
    // Without the canvas in use the wheel goes on scrolling the page.
    if (!zooms && !event.deltaX && !event.shiftKey && canvas.ownerDocument.activeElement !== canvas) return;
    event.preventDefault();
    const unit = event.deltaMode === 1 ? 16 : 1;
    if (!zooms) {
      const along = event.deltaX || event.deltaY;
      pane.pan(along * unit, 0);
      return;
    }
    const factor = Math.exp(Math.min(Math.max(event.deltaY * unit, -240), 240) * 0.0025);
    const only = event.shiftKey ? [1, factor] : [factor, 1];
    pane.zoom(...only, event.offsetX, event.offsetY);
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (keyMoves(pane, event) || pane.key?.(event)) event.preventDefault();
  });
}

const STEP_PX = 60;
const KEYS = {
  ArrowLeft: (pane) => pane.pan(-STEP_PX, 0),
  ArrowRight: (pane) => pane.pan(STEP_PX, 0),
  ArrowUp: (pane) => pane.pan(0, -STEP_PX),
  ArrowDown: (pane) => pane.pan(0, STEP_PX),
  "+": (pane) => pane.zoom(1 / 1.25, 1),
  "=": (pane) => pane.zoom(1 / 1.25, 1),
  "-": (pane) => pane.zoom(1.25, 1),
  "*": (pane) => pane.zoom(1, 1 / 1.25),
  "/": (pane) => pane.zoom(1, 1.25),
  0: (pane) => pane.fit(),
};

function keyMoves(pane, event) {
  const move = KEYS[event.key];
  if (move) move(pane);
  return Boolean(move);
}

function listenToPointers(canvas, pane) {
  const down = new Map();
  let moved = 0;
  const spot = (event) => [event.offsetX, event.offsetY];
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, spot(event));
    moved = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    const [x, y] = spot(event);
    if (!before) {
      pane.pointed?.(x, y);
      return;
    }
    moved += Math.abs(x - before[0]) + Math.abs(y - before[1]);
    const other = [...down.entries()].find(([id]) => id !== event.pointerId)?.[1];
    down.set(event.pointerId, [x, y]);
    if (other) pinch(pane, before, [x, y], other);
    else if (moved > 4) {
      pane.pointed?.(null);
      pane.pan(before[0] - x, before[1] - y);
    }
  });
  const up = (event) => {
    if (down.delete(event.pointerId) && event.type === "pointerup" && moved <= 4 && !down.size) {
      pane.picked?.(...spot(event));
    }
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => pane.pointed?.(null));
}

/** Two fingers: time by how far they are apart across, distance by how far up and down, each where they are apart at all. */
function pinch(pane, before, now, other) {
  const ratio = (a, b) => (Math.abs(a) > 24 && Math.abs(b) > 24 ? Math.abs(a) / Math.abs(b) : 1);
  const fx = ratio(before[0] - other[0], now[0] - other[0]);
  const fy = ratio(before[1] - other[1], now[1] - other[1]);
  pane.zoom(fx, fy, (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
}
