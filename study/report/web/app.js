// The page: papers as tabs, a bar with search and language, print. Knows neither where its data came from nor how it was bundled.
import { dayOf } from "./data.js";
import { makeGraphPaper } from "./graphpaper.js";
import { COLOURS } from "./layer.js";
import * as panels from "./panels.js";
import { element } from "./tables.js";
import { wordsIn } from "./words.js";

// Papers that stand in the page already have the id of an element and are moved to their place.
const STANDING = { summary: "summary", compared: "compared" };
const PAPERS = [
  ["graph", "Train graph", null], ["summary", "Summary", null], ["compared", "What changed", null], ["curve", "Run curve", panels.curvePaper], ["stations", "Stations", panels.stationsPaper],
  ["punctuality", "Punctuality", panels.punctualityPaper], ["energy", "Energy", panels.energyPaper], ["margins", "Margins", panels.marginsPaper],
  ["crossings", "Level crossings", panels.crossingsPaper],
  ["stopping", "Stopping", panels.stoppingPaper], ["sections", "Sections", panels.sectionsPaper], ["trains", "Trains", panels.trainsPaper], ["events", "Events and telegrams", panels.eventsPaper],
];

/** Make the page of a day in a document that has #papers, and #summary where there is one. Returns a handle on what it shows. */
export function start(doc, data) {
  Object.assign(COLOURS, data.palette);
  const day = dayOf(data);
  const page = {
    doc, day, layers: [], made: new Map(),
    state: { lang: firstLanguage(doc), paper: "graph", graph: { plan: true, run: true, sections: false, stairway: false, lesser: false, beside: true, chosen: null, moment: null }, chosen: null, station: null },
  };
  page.standing = new Map(Object.entries(STANDING).map(([id, name]) => [id, doc.getElementById(name)]).filter(([, found]) => found));
  page.papers = PAPERS.filter(([id]) => (id in STANDING ? page.standing.has(id) : id !== "crossings" || day.tables.has(id)));
  const asked = doc.defaultView.location.hash.slice(1);
  if (page.papers.some(([id]) => id === asked)) page.state.paper = asked;
  build(page);
  doc.defaultView.addEventListener("beforeprint", () => forPrint(page));
  doc.defaultView.addEventListener("afterprint", () => doc.body.classList.remove("printing"));
  doc.defaultView.addEventListener("hashchange", () => {
    const id = doc.defaultView.location.hash.slice(1);
    if (page.papers.some(([known]) => known === id) && id !== page.state.paper) show(page, id);
  });
  doc.defaultView.branchline = page;
  for (const id of ["drawing", "undrawn"]) doc.getElementById(id)?.remove();
  return page;
}

function firstLanguage(doc) {
  return (doc.defaultView.navigator.language ?? "").startsWith("ja") ? "ja" : "en";
}

function build(page) {
  const { doc, state, day } = page;
  doc.documentElement.lang = state.lang;
  doc.body.classList.add("live");
  page.layers.length = 0;
  page.made.clear();
  for (const standing of page.standing.values()) {
    standing.hidden = true;
    doc.body.append(standing);
  }
  const words = wordsIn(state.lang, day.stations, day.words);
  const live = element(doc, "div", { class: "unseen", "aria-live": "polite" });
  page.context = {
    day, words, state, layers: page.layers,
    showTrain: (number) => {
      state.chosen = number;
      show(page, "graph");
      page.graph.choose(number, true);
      page.graph.layer.canvas.focus();
    },
    showCurve: (number) => {
      state.chosen = number;
      page.made.delete("curve");
      show(page, "curve");
    },
    say: (text) => {
      live.textContent = text;
    },
  };
  page.tabs = new Map(page.papers.map(([id, title]) => [id, element(doc, "button", {
    type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `paper-${id}`, onclick: () => show(page, id),
  }, words.say(title))]));
  page.places = new Map(page.papers.map(([id]) => [id, element(doc, "section", { class: "paper", role: "tabpanel", id: `paper-${id}`, "aria-labelledby": `tab-${id}` })]));
  const tabs = element(doc, "div", { class: "tabs", role: "tablist", "aria-label": words.say("Papers"), onkeydown: (event) => turnTab(page, event) }, ...page.tabs.values());
  doc.getElementById("papers").replaceChildren(bar(page), tabs, live, ...page.places.values());
  show(page, state.paper);
}

function bar(page) {
  const { doc, day, context } = page;
  const { words } = context;
  const answer = element(doc, "span", { class: "answer", "aria-live": "polite" });
  const names = element(doc, "datalist", { id: "train-numbers" }, ...day.trains.map((train) => element(doc, "option", { value: train.number })));
  const field = element(doc, "input", { type: "search", id: "search", list: "train-numbers", placeholder: words.say("Train number"), "aria-label": words.say("Search for a train"), size: 16 });
  const find = (event) => {
    event.preventDefault();
    const text = field.value.trim();
    const train = searched(day, text);
    answer.textContent = text && !train ? words.say("no train {text}", { text }) : "";
    if (train) context.showTrain(train.number);
  };
  const turn = element(doc, "button", {
    type: "button", id: "language", "aria-label": words.say("Switch to Japanese"),
    onclick: () => {
      page.state.lang = page.state.lang === "ja" ? "en" : "ja";
      build(page);
      doc.getElementById("language").focus();
    },
  }, words.say("日本語"));
  const print = element(doc, "button", { type: "button", onclick: () => doc.defaultView.print() }, words.say("Print"));
  return element(doc, "div", { class: "bar" }, element(doc, "form", { role: "search", onsubmit: find }, field, names), answer, print, turn);
}

/** The train of a number: the very one, else the first that begins with the text, else that has it. Case does not count. */
export function searched(day, text) {
  const wanted = text.toLowerCase();
  if (!wanted) return null;
  const has = (test) => day.trains.find((train) => test(train.number.toLowerCase()));
  return has((n) => n === wanted) ?? has((n) => n.startsWith(wanted)) ?? has((n) => n.includes(wanted)) ?? null;
}

/** Show one paper; it is made when it is first shown. */
function show(page, id) {
  const { state, doc } = page;
  state.paper = id;
  for (const [name, tab] of page.tabs) {
    tab.setAttribute("aria-selected", String(name === id));
    tab.tabIndex = name === id ? 0 : -1;
    page.places.get(name).hidden = name !== id;
  }
  make(page, id);
  page.tabs.get(id).scrollIntoView({ block: "nearest", inline: "nearest" });
  if (doc.defaultView.location.hash.slice(1) !== id) doc.defaultView.history.replaceState(null, "", `#${id}`);
}

function make(page, id) {
  if (page.made.has(id)) return;
  page.made.set(id, true);
  const { doc, context } = page;
  const place = page.places.get(id);
  const [, title, paper] = PAPERS.find(([name]) => name === id);
  place.replaceChildren(element(doc, "h2", {}, context.words.say(title)));
  if (id === "graph") {
    page.graph = makeGraphPaper(place, context);
    page.layers.push(page.graph.layer);
  } else if (page.standing.has(id)) {
    const standing = page.standing.get(id);
    standing.hidden = false;
    place.append(standing);
    const more = standing.querySelector("#summary-more");
    more?.replaceChildren();
    if (more) panels.summaryTables(more, context);
  } else paper(place, context);
}

function turnTab(page, event) {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return;
  const ids = page.papers.map(([id]) => id);
  const next = ids[(ids.indexOf(page.state.paper) + step + ids.length) % ids.length];
  show(page, next);
  page.tabs.get(next).focus();
  event.preventDefault();
}

/** Every paper, one after the other, at the width of a sheet. */
function forPrint(page) {
  page.doc.body.classList.add("printing");
  for (const [id] of page.papers) {
    page.places.get(id).hidden = false;
    make(page, id);
  }
  page.graph.printed();
  for (const layer of page.layers) {
    layer.fit();
    layer.drawNow();
  }
  page.doc.defaultView.addEventListener("afterprint", () => show(page, page.state.paper), { once: true });
}
