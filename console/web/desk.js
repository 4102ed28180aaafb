// A seat at the desk: who it is stands in the address (?seat=dispatcher&lang=ja), a token behind its #.
import { actForm, faultForm } from "./forms.js";
import { schematic, trainGraph } from "./schematic.js";
import { element } from "./tables.js";
import { clock } from "./view.js";
import { connect } from "./wire.js";
import { wordsIn } from "./words.js";

const asked = new URLSearchParams(location.search);
const lang = asked.get("lang") ?? (navigator.language.startsWith("ja") ? "ja" : "en");
const seat = asked.get("seat");
const words = wordsIn(lang, new Map(), await (await fetch("words.json")).json());
const say = (english, values = {}) => words.say(english, values, "desk");
const make = (...parts) => element(document, ...parts);
const paces = [0, 1, 5, 10, 60];
let ask, built = false, last = null, alarmed = 0, wasDefined = null;
document.documentElement.lang = lang;

const address = (changed) => `?${new URLSearchParams({ seat: seat ?? "", lang, ...changed })}${location.hash}`;

function chooseSeat() {
  document.querySelector("main").replaceChildren(make("div", { class: "seats" }, make("h1", {}, say("Take a seat")),
    ...["instructor", "dispatcher", "staff"].map((name) => make("a", { href: address({ seat: name }) }, say(name)))));
}

async function tell(word, fields) {
  const answer = await ask(word, fields);
  const line = document.querySelector(".answer");
  line.textContent = answer.good ? say("done") : answer.why;
  line.classList.toggle("bad", !answer.good);
  if (answer.text) save(answer.text, fields.id);
  return answer;
}

function save(text, id) {
  const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "application/toml" })), download: `${id}.toml` });
  link.click();
  document.querySelector("main").dataset.saved = text;
}

function build(known) {
  const { welcome } = known, lead = welcome.faults.length > 0;
  document.title = `${say(seat)} – ${welcome.name}`;
  const button = (text, click, more = {}) => make("button", { type: "button", onclick: click, ...more }, text);
  const time = make("input", { id: "to-time", size: 8, placeholder: "HH:MM:SS", "aria-label": say("time") });
  const seconds = () => time.value.split(":").reduce((sum, part) => sum * 60 + Number(part), 0) * (time.value.split(":").length === 2 ? 60 : 1);
  document.querySelector("header").replaceChildren(
    make("h1", {}, `${lang === "ja" ? welcome.line_ja : welcome.line} · ${say(seat)}`), make("span", { class: "clock", id: "clock" }), make("span", { id: "running" }),
    ...(lead ? [
      ...paces.map((factor) => button(factor ? `×${factor}` : say("pause"), () => tell("pace", { factor }), { "data-pace": factor, "aria-pressed": "false" })),
      button(say("one step"), () => tell("one_step")), button(say("next event"), () => tell("next_event")), time,
      button(say("run to"), () => tell("run_to", { time_s: seconds() })), button(say("go back to"), () => tell("go_back", { time_s: seconds() })),
    ] : []),
    button(say("save as a drill"), () => tell("save", { id: `desk_${welcome.run}`, title: welcome.name })),
    make("span", { class: "grow" }), make("a", { href: address({ lang: lang === "ja" ? "en" : "ja" }), lang: lang === "ja" ? "en" : "ja" }, lang === "ja" ? "English" : "日本語"));
  const side = make("section", { class: "side", "aria-label": say("what can be done") }, make("p", { class: "answer", role: "status", "aria-live": "polite" }),
    ...(lead ? [make("label", { for: "hit" }, say("Click a section, points, train or device to break it, or choose:")), anyTarget(welcome)] : []), make("div", { id: "fault" }),
    ...(welcome.acts.length ? [actForm(welcome, words, tell, lead)] : []), make("div", { id: "deeds" }));
  document.querySelector("main").replaceChildren(
    make("section", { class: "schematic", "aria-label": say("the line") }), make("section", { class: "graph", "aria-label": say("train graph, planned and so far") }),
    make("section", { class: "trains", "aria-label": say("trains"), tabindex: 0 }), side, make("section", { class: "log", "aria-label": say("events"), tabindex: 0 }),
    make("section", { class: "rules", id: "lamps", "aria-label": say("checkers"), tabindex: 0 }));
}

/** Everything that a fault may hit, whether it stands on the schematic or not. */
function anyTarget(welcome) {
  const all = [...new Set(welcome.faults.flatMap((kind) => kind.targets))];
  return make("select", { id: "hit", onchange: ({ target }) => target.value && pick("", target.value) }, ...["", ...all].map((value) => make("option", { value }, value)));
}

function pick(kind, id) {
  const { welcome } = last;
  if (welcome.faults.length) document.querySelector("#fault").replaceChildren(faultForm(welcome, { kind, id }, words, tell));
  const target = document.querySelector("#act-target"), sections = document.querySelector("#act-sections");
  if (target && [...target.options].some((option) => option.value === id)) target.value = id;
  for (const option of sections?.options ?? []) if (option.value === id) option.selected = !option.selected;
}

const late = (train) => train.late_s === null ? "–" : `${train.late_s < -0.5 ? "−" : "+"}${clock(Math.abs(train.late_s), true).slice(3)}`;

function trainTable({ state }) {
  const truth = state.rules.length > 0;
  const heads = ["train", "unit", "late", "last at", "heard", "holds", ...(truth ? ["km/h", "waits for"] : [])];
  const rows = state.trains.filter((train) => train.train).map((train) => [train.train, train.unit, late(train), train.station, clock(train.heard_s, true), [...new Set([train.sections[0], train.sections.at(-1)])].join(" … "),
    ...(truth ? [train.speed_mps === null ? "–" : (train.speed_mps * 3.6).toFixed(0), train.waits_for] : [])]);
  return make("table", {}, make("caption", { class: "unseen" }, say("trains")), make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, say(head))))),
    make("tbody", {}, ...rows.map((row) => make("tr", {}, ...row.map((cell) => make("td", {}, cell))))));
}

function eventList({ events }) {
  return make("ul", {}, ...events.slice(-40).reverse().map((event) => make("li", { class: event.alarm ? "bad" : null },
    `${event.alarm ? "⚠ " : ""}${clock(event.time_s, true)} ${event.who}: ${lang === "ja" ? event.text_ja : event.text}`)));
}

function keptFocus(host, node) {
  const at = host.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label")?.split(":")[0] : null;
  host.replaceChildren(node);
  if (at) [...host.querySelectorAll("[tabindex]")].find((one) => one.getAttribute("aria-label")?.split(":")[0] === at)?.focus();
}

function alarm({ state, events }) {
  const line = document.querySelector("#alarm");
  const fresh = events.slice(alarmed).filter((event) => event.alarm).at(-1);
  alarmed = events.length;
  const picture = `${state.manager_on} ${state.defined}`;
  if (!state.manager_on && picture !== wasDefined) line.textContent = `⚠ ${clock(state.time_s, true)} ${say("the block manager does not answer: every section is undefined")}`;
  else if (state.manager_on && !state.defined && picture !== wasDefined) line.textContent = `⚠ ${clock(state.time_s, true)} ${say("the block manager has restarted and knows nothing: restore the picture")}`;
  else if (fresh) line.textContent = `⚠ ${clock(fresh.time_s, true)} ${lang === "ja" ? fresh.text_ja : fresh.text}`;
  else if (state.defined && wasDefined !== null && picture !== wasDefined) line.textContent = `${clock(state.time_s, true)} ${say("the picture is restored")}`;
  line.classList.toggle("on", line.textContent.startsWith("⚠"));
  wasDefined = picture;
}

function show(known, reason) {
  if (!known) {
    const line = document.querySelector("#alarm");
    line.textContent = `⚠ ${say("no line to the desk")} ${reason ?? ""}`;
    line.classList.add("on");
    wasDefined = null;
    return;
  }
  if (!known.welcome) return;
  if (!built) { last = known; build(known); built = true; }
  if (last.state && last.state.branch !== known.state.branch) alarmed = 0;
  last = known;
  const { state } = known, at = (name) => document.querySelector(name);
  at("main").dataset.digest = state.digest;
  at("#clock").textContent = clock(Math.floor(state.time_s), true);
  at("#running").textContent = state.ended ? `${say("ended")}: ${state.ended}` : say(state.running ? "runs" : "stands");
  for (const one of document.querySelectorAll("[data-pace]")) one.setAttribute("aria-pressed", String(Number(one.dataset.pace) === state.factor));
  keptFocus(at(".schematic"), schematic(known, words, pick));
  at(".graph").replaceChildren(trainGraph(known, words));
  at(".trains").replaceChildren(trainTable(known));
  at(".log").replaceChildren(eventList(known));
  keptFocus(at("#deeds"), make("ul", {}, ...state.deeds.map((deed) => make("li", {}, `${clock(deed.time_s, true)} ${lang === "ja" ? deed.text_ja : deed.text} `,
    deed.ends ? make("button", { type: "button", tabindex: 0, "aria-label": `${say("end")} ${deed.deed}`, onclick: () => tell("end_fault", { deed: deed.deed }) }, say("end")) : null))));
  at("#lamps").replaceChildren(...(state.rules.length ? [make("h2", {}, say("checkers")), make("div", { class: "lamps" }, ...state.rules.map((rule) =>
    make("span", { class: rule.broken ? "bad" : null, title: rule.first }, `${rule.broken ? "✕" : "○"} ${rule.rule}`)))] : []));
  alarm(known);
}

if (seat) ask = connect(`ws://${location.host}/desk`, seat, location.hash.slice(1), show);
else chooseSeat();
