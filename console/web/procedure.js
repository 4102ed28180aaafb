// Substitute working: the roles that can be taken, and each step of one's own by a click, in its turn or not.
import { element } from "./tables.js";

const SIGNS = { done: "○", "left out": "✕", "under way": "…", next: "▶", waits: "⧖", later: "·" };

/** The procedure as a part of the page; what is shown comes by the function returned. */
export function procedure(welcome, words, tell, unit) {
  const say = (english, values = {}) => words.say(english, values, "desk");
  const make = (...parts) => element(document, ...parts);
  const ja = words.lang === "ja", inWords = (one, name) => ja ? one[`${name}_ja`] : one[name];
  const posts = welcome.posts.filter((one) => !unit || one.post.endsWith(` ${unit}`));
  const host = make("section", { class: "procedure", "aria-label": say("substitute working") });
  const opened = new Set(), chosen = new Map();
  let before = "";
  const name = (post) => inWords({ name: post, name_ja: welcome.posts.find((one) => one.post === post)?.name_ja ?? post }, "name");
  const button = (text, click, more = {}) => make("button", { type: "button", onclick: click, ...more }, text);

  const roles = (state) => make("div", { class: "roles" }, ...posts.map(({ post }) => {
    const has = state.roles.includes(post), what = has ? say("hand back") : say("take over");
    return button(`${has ? "● " : "○ "}${name(post)}: ${what}`, () => tell("act", { act: { kind: has ? "hand_back_role" : "take_role", target: post } }), { "aria-pressed": String(has), "data-post": post });
  }));

  const step = (drawn, work, row, shown, own) => {
    const train = row.part === "train" ? chosen.get(work.block) || work.train : "";
    const act = (kind) => () => tell("act", { act: { kind, target: own, step: row.step, block: work.block, ...(train ? { train } : {}) } });
    const text = inWords(row, "says").replaceAll("{train}", train || "…"), open = !["done", "left out", "under way"].includes(shown.state);
    const title = ja ? row.name_ja : row.step.replaceAll("_", " "), early = open && shown.state !== "next";
    return make("li", { class: shown.state === "next" ? "next" : null },
      `${SIGNS[shown.state]} `, open ? button(`${early ? "⚠ " : ""}${title}`, act("do_step"), { "aria-label": `${work.block} ${title}: ${early ? say("out of its turn") : say("next")}`, "data-step": `${work.block} ${row.step}` }) : make("b", {}, title),
      ` ${say(shown.state)} `, open ? button(say("leave out"), act("leave_out_step"), { class: "small", "aria-label": `${work.block} ${title}: ${say("leave out")}` }) : null,
      make("div", { class: "words" }, `${inWords(row, "who")} → ${inWords(row, "to")}: «${text}»`,
        open && row.waits ? make("div", {}, `${say("waits for")}: ${inWords(row, "waits")}`) : null, shown.state === "later" && row.needs.length ? make("div", {}, `${say("needs")}: ${row.needs.map((need) => stepName(drawn, need)).join(", ")}`) : null));
  };
  const stepName = (drawn, id) => { const row = drawn.rows.find((one) => one.step === id); return ja && row ? row.name_ja : id; };

  const book = (work, state) => {
    const drawn = welcome.works.find((one) => one.block === work.block);
    const rows = drawn.rows.map((row) => ({ row, shown: work.steps.find((one) => one.step === row.step) ?? { state: "later", posts: [] } }))
      .map((one) => ({ ...one, own: posts.map(({ post }) => post).find((post) => state.roles.includes(post) && mine(one, post, work.block)) }));
    const own = rows.filter((one) => one.own), now = own.filter((one) => ["next", "waits", "under way"].includes(one.shown.state)), rest = own.filter((one) => !now.includes(one));
    if (!own.length) return null;
    const others = rows.filter((one) => !one.own && ["next", "waits", "under way"].includes(one.shown.state)).map(({ row, shown }) => `${inWords(row, "who")}: ${ja ? row.name_ja : row.step} (${say(shown.state)})`);
    const train = make("select", { "aria-label": `${work.block}: ${say("train")}`, onchange: ({ target }) => { chosen.set(work.block, target.value); before = ""; show(state); } }, ...["", ...drawn.trains].map((value) => make("option", { value }, value || work.train || "–")));
    train.value = chosen.get(work.block) ?? "";
    const more = make("details", { ontoggle: ({ target }) => { if (target.open) opened.add(work.block); else opened.delete(work.block); } },
      make("summary", {}, say("all steps, also out of their turn")), make("p", {}, `${say("for train")} `, train), make("ul", {}, ...rest.map((one) => step(drawn, work, one.row, one.shown, one.own))));
    more.open = opened.has(work.block);
    return make("section", { class: "book", "data-block": work.block, "aria-label": work.block }, make("h3", {}, `${work.block} · ${work.train || "–"} · ${say("pilot")}: ${work.pilot || "–"}`),
      make("ul", {}, ...now.map((one) => step(drawn, work, one.row, one.shown, one.own))), others.length ? make("p", { class: "words" }, `${say("others")}: ${others.join("; ")}`) : null, more);
  };
  // For another train than that in the book a step may be another's; the desk says so then.
  const mine = ({ row, shown }, post, block) => shown.posts.includes(post) || (row.part === "train" && chosen.get(block) && post.split(" ")[0] === row.post);

  const show = (state) => {
    const now = JSON.stringify([state.roles, state.works]);
    if (now === before) return;
    before = now;
    const at = host.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label") : null;
    const books = state.works.map((work) => book(work, state)).filter(Boolean);
    host.replaceChildren(make("h2", {}, say("substitute working")), roles(state), ...(state.works.length ? books : [make("p", { class: "words" }, say("not in force"))]));
    if (at) [...host.querySelectorAll("[aria-label]")].find((one) => one.getAttribute("aria-label") === at)?.focus();
  };
  return { host, show };
}
