// A seat at the desk: who it is stands in the address (?seat=dispatcher&lang=ja), a token behind its #.
import { cab } from "./driver.js";
import { actForm, armForm, changeForm, faultForm, messageForm } from "./forms.js";
import { procedure } from "./procedure.js";
import { crossingTable } from "./roads.js";
import { scorePage } from "./score.js";
import { schematic, trainGraph } from "./schematic.js";
import { element } from "./tables.js";
import { clock, late } from "./view.js";
import { connect } from "./wire.js";
import { wordsIn } from "./words.js";

const asked = new URLSearchParams(location.search);
const lang = (asked.get("lang") ?? navigator.language).startsWith("ja") ? "ja" : "en";
const seat = asked.get("seat"), unit = asked.get("unit") ?? "", run = asked.get("run");
const stations = new Map(); // those of the line, once it is known
const words = wordsIn(lang, stations, await (await fetch("words.json")).json());
const say = (english, values = {}) => words.say(english, values, "desk");
const make = (...parts) => element(document, ...parts);
const paces = [0, 1, 5, 10, 60];
const TOGETHER = ["pace", "one_step", "run_to", "go_back"]; // what both do of two runs side by side
let ask, built = false, last = null, alarmed = 0, wasDefined = null, inCab = null, steps = null, read = 0, held = null, skipped = false;
document.documentElement.lang = lang;
if (lang === "ja") await document.fonts.load('12px "branchline-ja"', "\u65e5").catch(() => {}); // canvases do not wait for it

const address = (changed) => `?${new URLSearchParams({ seat: seat ?? "", ...(unit ? { unit } : {}), ...(run ? { run } : {}), lang, ...changed })}${location.hash}`;

async function openOne(entry) {
  const answer = await fetch("open", { method: "POST", body: JSON.stringify({ kind: entry.kind, name: entry.name, token: location.hash.slice(1) }) });
  if (answer.ok) location.search = new URLSearchParams({ seat: "instructor", lang });
  else document.querySelector("#alarm").textContent = `⚠ ${await answer.text()}`;
}

/** What can be opened, by its kind, and a seat where something is. */
async function chooseSeat() {
  const { running, entries } = await (await fetch("library.json")).json();
  const group = (kind, title) => make("section", {}, make("h2", {}, title), make("ul", {}, ...entries.filter((one) => one.kind === kind).map((one) =>
    make("li", {}, make("button", { type: "button", onclick: () => openOne(one) }, one.name), one.title ? ` ${one.title}` : ""))));
  if (entries.length) document.querySelector("main").after(make("div", { class: "library" }, make("h1", {}, say("library")),
    group("scenario", say("scenarios")), group("drill", say("drills")), group("run", say("finished runs"))));
  if (!running) return document.querySelector("main").remove();
  const main = document.querySelector("main");
  connect("desk", "guest", location.hash.slice(1), (known) => {
    if (!known?.welcome || main.querySelector(".seats")) return;
    main.replaceChildren(make("div", { class: "seats" }, make("h1", {}, say("Take a seat")),
      ...["instructor", "dispatcher", "staff"].map((name) => make("a", { href: address({ seat: name }) }, say(name))),
      ...known.welcome.units.map((name) => make("a", { href: address({ seat: "driver", unit: name }) }, `${say("driver")} ${name}`))));
  });
}

async function tell(word, fields) {
  const answer = await ask(word, fields);
  const line = document.querySelector(".answer");
  line.textContent = answer.good ? say("done") : answer.why || (answer.sent ? say("the line broke: whether it was done is not known") : say("no line to the desk"));
  line.classList.toggle("bad", !answer.good);
  if (answer.good && word === "save") save(answer.text, `${fields.id}.toml`, "application/toml");
  if (answer.good && run && TOGETHER.includes(word)) together({ word, fields });
  if (answer.good && run && word === "next_event") together({ word: "go_back", fields: { time_s: Number(answer.text) } });
  return answer;
}

/** The other one of two runs side by side is asked the same. */
function together(request) {
  if (parent !== window) parent.postMessage(request, location.origin);
}

function save(text, name, type) {
  make("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name }).click();
}

/** The protocol in place of the page, to be read, saved as HTML and as JSON, and closed. */
async function protocol() {
  const answer = await tell("protocol");
  if (!answer.good) return;
  const box = document.querySelector("#score"), page = scorePage(JSON.parse(answer.text), words), name = `protocol_${last.welcome.run}`;
  const html = () => `<!DOCTYPE html><html lang="${lang}"><meta charset="utf-8"><title>${name}</title>${page.outerHTML}</html>`;
  const button = (text, click) => make("button", { type: "button", onclick: click }, text);
  box.replaceChildren(make("p", {}, button(say("close"), () => box.close()), " ", button(say("save as HTML"), () => save(html(), `${name}.html`, "text/html")), " ",
    button(say("save as JSON"), () => save(answer.text, `${name}.json`, "application/json"))), page);
  box.showModal();
}

function build(known) {
  const { welcome } = known, lead = welcome.leads, breaks = welcome.faults.length > 0;
  for (const { id, name, name_ja } of welcome.stations) stations.set(id, { name, ja: name_ja });
  document.title = `${say(seat)} – ${welcome.name}`;
  const button = (text, click, more = {}) => make("button", { type: "button", onclick: click, ...more }, text);
  const time = make("input", { id: "to-time", size: 8, placeholder: "HH:MM:SS", "aria-label": say("time") });
  const seconds = () => time.value.split(":").reduce((sum, part) => sum * 60 + Number(part), 0) * (time.value.split(":").length === 2 ? 60 : 1);
  document.querySelector("header").replaceChildren(
    make("h1", {}, `${lang === "ja" ? welcome.line_ja : welcome.line} · ${run ? welcome.run : `${say(seat)} ${unit}`}`), make("span", { class: "clock", id: "clock" }), make("span", { id: "running" }),
    ...(lead ? [
      ...paces.map((factor) => button(factor ? `×${factor}` : say("pause"), () => tell("pace", { factor }), { "data-pace": factor, "aria-pressed": "false" })),
      button(say("one step"), () => tell("one_step")), button(say("next event"), () => tell("next_event")), time,
      button(say("run to"), () => tell("run_to", { time_s: seconds() })), button(say("go back to"), () => tell("go_back", { time_s: seconds() })),
    ] : []),
    ...(welcome.replay ? [slider(welcome), button(say("event before"), () => tell("go_back", { time_s: eventBefore() })), button(say("alarm before"), () => tell("go_back", { time_s: eventBefore((one) => one.alarm) }))]
      : [button(say("save as a drill"), () => tell("save", { id: `desk_${welcome.run}`, title: welcome.name })), button(say("protocol"), protocol)]),
    make("span", { class: "grow" }), make("a", { href: address({ lang: lang === "ja" ? "en" : "ja" }), lang: lang === "ja" ? "en" : "ja" }, lang === "ja" ? "English" : "日本語"));
  inCab = seat === "driver" ? cab(welcome, words, tell) : null;
  steps = welcome.posts.length ? procedure(welcome, words, tell, unit) : null;
  const side = make("section", { class: "side", "aria-label": say("what can be done") }, make("p", { class: "answer", role: "status", "aria-live": "polite" }),
    ...(inCab ? [inCab.host] : []), ...(steps ? [steps.host] : []), ...(breaks ? [make("label", { for: "hit" }, say("Click a section, points, train, crossing or device to break it, or choose:")), anyTarget(welcome)] : []), make("div", { id: "fault" }),
    make("div", { id: "messages", role: "log", "aria-live": "polite" }),
    ...(welcome.acts.length ? [actForm(welcome, words, tell, lead)] : []), ...(breaks ? [messageForm(words, tell), armForm(welcome, words, tell)] : []), make("div", { id: "deeds" }));
  document.querySelector("main").replaceChildren(
    make("section", { class: "schematic", "aria-label": say("the line") }), make("section", { class: "graph", "aria-label": say("train graph, planned and so far") }),
    make("section", { class: "trains", "aria-label": say("trains"), tabindex: 0 }), side, make("section", { class: "log", "aria-label": say("events"), tabindex: 0 }),
    make("section", { class: "rules", id: "lamps", "aria-label": say("checkers"), tabindex: 0 }), make("dialog", { id: "score", "aria-label": say("protocol") }));
}

/** Over the whole of a run that has ended: where the handle is let go, there one looks. */
function slider(welcome) {
  const at = make("input", { id: "slider", type: "range", min: welcome.begin_s, max: welcome.end_s, step: 1, value: welcome.begin_s, "aria-label": say("time"),
    onchange: ({ target }) => tell("go_back", { time_s: Number(target.value) }) });
  return at;
}

/** When the last thing happened before now that a person should hear of. */
function eventBefore(counts = () => true) {
  return Math.max(last.welcome.begin_s, (last.events.filter((one) => counts(one) && one.time_s < last.state.time_s - 0.2).at(-1)?.time_s ?? 0));
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

function trainTable({ state }) {
  const truth = state.rules.length > 0;
  const heads = ["train", "unit", "late", "last at", "heard", "holds", ...(truth ? ["km/h", "waits for"] : []), "order"];
  const bids = new Map(state.bids.map((bid) => [bid.unit, bid])), may = last.welcome.acts.includes("hold_train");
  const order = (train) => {
    const bid = bids.get(train.unit), act = (kind, more) => () => tell("act", { act: { kind, target: train.unit, ...more } });
    const kept = bid ? `${say("kept back until")} ${clock(bid.until_s, true)}${bid.behind ? ` ${bid.behind} ${bid.section}` : ""} ` : "";
    const name = bid ? say("let go") : say("hold back");
    return make("td", {}, kept, may ? make("button", { type: "button", "aria-label": `${train.unit}: ${name}`, onclick: act(bid ? "let_go" : "hold_train", bid ? {} : { hold_s: 300 }) }, name) : null);
  };
  const rows = state.trains.filter((train) => train.train).map((train) => [train.train, train.unit, late(train.late_s), words.place(train.station), clock(train.heard_s, true), [...new Set([train.sections[0], train.sections.at(-1)])].join(" … "),
    ...(truth ? [train.speed_mps === null ? "–" : (train.speed_mps * 3.6).toFixed(0), lang === "ja" ? train.waits_for_ja : train.waits_for] : []), order(train)]);
  return make("table", {}, make("caption", { class: "unseen" }, say("trains")), make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, say(head))))),
    make("tbody", {}, ...rows.map((row) => make("tr", {}, ...row.map((cell) => cell instanceof Node ? cell : make("td", {}, cell))))));
}

function eventList({ events }) {
  return make("ul", {}, ...events.slice(-40).reverse().map((event) => make("li", { class: event.alarm ? "bad" : null },
    `${event.alarm ? "⚠ " : ""}${clock(event.time_s, true)} ${lang === "ja" ? event.who_ja : event.who}: ${lang === "ja" ? event.text_ja : event.text}`)));
}

// What is pressed, by finger or key, is not put anew until it is let go: it would not be clicked then.
const isHeld = (host) => host.contains(held) && (skipped = true);
for (const kind of ["pointerdown", "keydown"]) addEventListener(kind, ({ target }) => { held = target; });
for (const kind of ["pointerup", "pointercancel", "keyup", "blur"]) addEventListener(kind, () => {
  held = null;
  if (skipped) setTimeout(() => document.body.classList.contains("lost") || show(last));
  skipped = false;
});

function keptFocus(host, node) {
  if (isHeld(host)) return;
  const at = host.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label")?.split(":")[0] : null;
  host.replaceChildren(node);
  if (at) [...host.querySelectorAll("[aria-label]")].find((one) => one.getAttribute("aria-label").split(":")[0] === at)?.focus();
}

function alarm({ state, events }) {
  const line = document.querySelector("#alarm");
  if (wasDefined === null) line.textContent = ""; // that there was no line to the desk
  if (events.length < alarmed) alarmed = 0;
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
  document.body.classList.toggle("lost", !known);
  if (!known) {
    const line = document.querySelector("#alarm");
    line.textContent = `⚠ ${reason === undefined ? say("nothing is heard from the desk: what is shown is old") : `${say("no line to the desk")} ${reason}`}`;
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
  const slide = at("#slider");
  if (slide && slide !== held) slide.value = state.time_s;
  at("#running").textContent = state.ended ? `${say("ended")}: ${words.say(state.ended, {}, "ending")}` : say(state.running ? "runs" : "stands");
  for (const one of document.querySelectorAll("[data-pace]")) one.setAttribute("aria-pressed", String(Number(one.dataset.pace) === state.factor));
  keptFocus(at(".schematic"), schematic(known, words, pick));
  at(".graph").replaceChildren(trainGraph(known, words, run ? { width: 560, height: 160 } : {}));
  keptFocus(at(".trains"), make("div", {}, trainTable(known), crossingTable(known, words)));
  if (inCab && state.cab) inCab.show(state.cab);
  if (steps && !isHeld(steps.host)) steps.show(state);
  if (state.messages.length !== read) at("#messages").replaceChildren(...state.messages.slice(-3).map((one) => make("p", { class: "said" }, `✉ ${clock(one.time_s, true)} ${one.text}`)));
  read = state.messages.length;
  at(".log").replaceChildren(eventList(known));
  keptFocus(at("#deeds"), make("ul", {}, ...state.deeds.map((deed) => make("li", {}, `${clock(deed.time_s, true)} ${lang === "ja" ? deed.text_ja : deed.text} `,
    deed.ends ? make("button", { type: "button", tabindex: 0, "aria-label": `${say("end")} ${deed.deed}`, onclick: () => tell("end_fault", { deed: deed.deed }) }, say("end")) : null, " ",
    deed.ends ? make("button", { type: "button", tabindex: 0, "aria-label": `${say("change")} ${deed.deed}`, onclick: () => at("#fault").replaceChildren(changeForm(deed, words, tell)) }, say("change")) : null))));
  at("#lamps").replaceChildren(...(state.rules.length ? [make("h2", {}, say("checkers")), make("div", { class: "lamps" }, ...state.rules.map((rule) =>
    make("span", { class: rule.broken ? "bad" : null, title: rule.first }, `${rule.broken ? "✕" : "○"} ${words.say(rule.rule, {}, "rule")}`)))] : []));
  alarm(known);
}

if (seat) ask = connect(run ?? "desk", seat, location.hash.slice(1), show, unit);
else chooseSeat();
if (run) { // beside another one, which tells what it was asked, so that both go the same way
  document.body.classList.add("beside");
  addEventListener("message", ({ origin, data }) => origin === location.origin && ask(data.word, data.fields));
}
