// The protocol of a session as a page of its own: what the desk answered as JSON, read as tables.
import { element } from "./tables.js";
import { clock } from "./view.js";

/** The protocol as an element; `score` as the desk has it. */
export function scorePage(score, words) {
  const say = (english, values = {}) => words.say(english, values, "desk");
  const make = (...parts) => element(document, ...parts);
  const told = (one) => words.lang === "ja" ? one.text_ja : one.text;
  const after = (s) => s === null ? "–" : `${s.toFixed(1)} s`;
  const table = (title, heads, rows) => [make("h2", {}, title), rows.length ? make("table", {}, make("caption", { class: "unseen" }, title),
    make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, head)))),
    make("tbody", {}, ...rows.map((row) => make("tr", {}, ...row.map((cell) => make("td", {}, String(cell))))))) : make("p", {}, say("none"))];
  const broken = score.rules.filter((rule) => rule.broken);
  return make("article", { class: "score", lang: words.lang },
    make("h1", {}, `${say("protocol")}: ${score.run}`),
    make("p", {}, `${clock(score.time_s, true)} · ${score.ended ? words.say(score.ended, {}, "ending") : say("runs")} · ${say("trains arrived")}: ${score.trains_arrived}/${score.trains_planned} · ${say("train-minutes lost")}: ${score.lost_train_minutes}`),
    ...table(say("faults"), [say("fault"), say("shown after"), say("acted after"), say("recovered after")], score.faults.map((one) => [told(one), after(one.shown_s), after(one.acted_s), after(one.recovered_s)])),
    ...table(say("what was done"), [say("time"), say("act")], score.deeds.map((one) => [clock(one.time_s, true), told(one)])),
    ...table(say("wrong entries"), [say("time"), say("seat"), say("why")], [...score.refused_acts, ...score.refused_words].map((one) => [clock(one.time_s, true), one.seat, one.why])),
    ...table(say("irregular acts"), [say("act"), say("times")], Object.entries(score.irregular).map(([kind, n]) => [words.say(kind, {}, "act"), n])),
    ...table(say("steps left out, out of order or refused"), [say("time"), say("who"), say("step")], score.steps.map((one) => [clock(one.time_s, true), one.who, told(one)])),
    ...table(say("rules broken"), [say("checkers"), say("times")], broken.map((rule) => [words.say(rule.rule, {}, "rule"), rule.broken])),
    make("p", {}, `${say("digest")}: ${score.digest || "–"}`));
}
