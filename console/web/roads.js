// Level crossings: on the schematic where they lie, and as a table of those at which something goes on.
import { along, drawn } from "./svg.js";
import { element } from "./tables.js";
import { clock } from "./view.js";

const WIDE = 12; // that a sign takes, with the space beside it

// What stands under a road: a shape for each state, so that no colour is needed to tell them apart.
const ring = (more = {}) => drawn("circle", { r: 4, ...more });
const SIGNS = {
  open: () => [ring()],
  warning: () => [ring(), drawn("path", { d: "M0 -4 A4 4 0 0 1 0 4 Z", class: "filled" })],
  closed: () => [ring({ class: "filled" })],
  opening: () => [drawn("path", { d: "M-4 3 L0 -3 L4 3" })],
  "not proven": () => [drawn("path", { d: "M0 -5 L5 4 L-5 4 Z", class: "alert" }), drawn("path", { d: "M0 -2 V1.4 M0 2.4 V3.2" })],
  "nothing known on it": () => [ring(), drawn("path", { d: "M-2 0 L-0.5 2 L2.5 -2" })],
  asked: () => [ring(), drawn("circle", { r: 1, class: "filled" })],
  "no word": () => [ring({ "stroke-dasharray": "2 1.6" })],
};

/** What is known of a crossing, in words: its state with the reason, who comes, and who is there. */
function said(known, state, words) {
  const say = (english) => words.say(english, {}, "desk");
  const trains = (units) => units.map((unit) => state.trains.find((train) => train.unit === unit)?.train || unit).join(" ");
  const why = words.lang === "ja" ? known.why_ja : known.why;
  const marks = [known.occupied && say("something is on it"), known.guarded && say("guarded"), state.silent.includes(known.id) && say("no power"),
    known.creeps.length && `${say("leave to creep")} ${trains(known.creeps)}`].filter(Boolean);
  return { is: why ? `${say(known.state)} (${why})` : say(known.state), comes: trains(known.announced), marks: marks.join(", "), heard: known.heard_s === null ? "" : clock(known.heard_s, true) };
}

/** Each crossing of the sections that are shown: its road over the track, what is known of it, and its name for who asks. */
export function crossingSigns({ welcome, state }, boxes, middle, words, chosen) {
  const say = (english) => words.say(english, {}, "desk"), taken = [];
  const there = new Set(state.sections.map((section) => section.id));
  return welcome.crossings.filter((one) => there.has(one.section)).sort((a, b) => a.at_m - b.at_m).map((one) => {
    const box = boxes.get(one.section), x = along(box, one.at_m), low = box.y + box.height, known = state.crossings.find((seen) => seen.id === one.id);
    const above = box.y + box.height / 2 < middle; // the upper one of two tracks has its signs above it
    const first = above ? box.y - 18 : low + 8;
    const row = [0, 1, 2].find((k) => !taken.some((at) => Math.abs(at.x - x) < WIDE && at.y === first + k * WIDE)) ?? 2;
    const y = above ? first : first + row * WIDE;
    taken.push({ x, y });
    const what = known ? said(known, state, words) : { is: say("no device"), comes: "", marks: "", heard: "" };
    const text = `${say("level crossing")} ${one.name}: ${[what.is, what.comes && `${say("announced")} ${what.comes}`, what.marks, what.heard && `${say("heard")} ${what.heard}`].filter(Boolean).join(", ")}`;
    const sign = drawn("g", { transform: `translate(${x} ${y})`, class: "sign" }, ...(known ? SIGNS[known.state]() : [drawn("path", { d: "M-4 -4 L4 4 M-4 4 L4 -4" })]));
    if (known?.occupied) sign.append(drawn("rect", { class: "vehicle", x: -5, y: box.y + box.height / 2 - 3 - y, width: 10, height: 6 }));
    if (known?.guarded) sign.append(drawn("path", { class: "flag", d: "M6 5 V-5 L11 -3 L6 -0.5" }));
    if (state.silent.includes(one.id)) sign.append(drawn("path", { class: "dead", d: "M-3 7 L3 13 M-3 13 L3 7" }));
    const top = Math.min(box.y, y - 6);
    return drawn("g", { ...(one.has_device ? chosen("crossing", one.id) : { role: "img" }), class: `crossing${known?.announced.length ? " announced" : ""}`, "aria-label": text, "data-state": known?.state },
      drawn("title", {}, text), drawn("rect", { class: "reach", x: x - WIDE / 2, y: top, width: WIDE, height: Math.max(low, y + 6) - top }),
      drawn("path", { class: "road", d: [x - 2, x + 2].map((at) => `M${at} ${box.y} v4 M${at} ${low - 5} v9`).join(" ") }), sign);
  });
}

/** The crossings at which something goes on; null where the line has none with a device. */
export function crossingTable({ welcome, state }, words) {
  const say = (english) => words.say(english, {}, "desk");
  if (!state.crossings.length) return null;
  const quiet = (one) => ["open", "no word"].includes(one.state) && !one.announced.length && !one.creeps.length && !one.guarded && !one.occupied && !state.silent.includes(one.id);
  const rows = state.crossings.filter((one) => !quiet(one)).map((one) => {
    const { is, comes, marks, heard } = said(one, state, words);
    return [welcome.crossings.find((it) => it.id === one.id).name, is, comes, marks, heard];
  });
  const cells = (tag, texts) => element(document, "tr", {}, ...texts.map((text) => element(document, tag, tag === "th" ? { scope: "col" } : {}, text)));
  const title = rows.length ? say("level crossing") : say("level crossings: nothing goes on");
  return element(document, "table", { class: "roads" }, element(document, "caption", { class: rows.length ? "unseen" : null }, title),
    element(document, "thead", {}, rows.length ? cells("th", [title, say("state"), say("announced"), say("remarks"), say("heard")]) : null), element(document, "tbody", {}, ...rows.map((row) => cells("td", row))));
}
