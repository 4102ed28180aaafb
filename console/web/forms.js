// What can be done from a seat: each fault by the keys of its schema, each act by the fields that it has.
import { element } from "./tables.js";

const ACT_FIELDS = {
  confirm_outside: ["unit", "place"], confirm_holding: ["unit", "sections"], take_back: ["unit"], accept_picture: ["pace"],
  power_on: ["party"], commission: ["party"], repair_points: ["points", "position"], enter_section: ["unit?", "sections"],
  reenter_by_hand: ["pace"], reenter_assisted: ["pace"], bar_unit: ["unit"], unbar_unit: ["unit"], haul_away: ["unit"], bring_power: ["unit"], free_road: ["crossing"], guard_road: ["crossing"], leave_road: ["crossing"], give_back: ["unit", "hold"],
  hold_train: ["unit", "hold", "behind", "over"], let_go: ["unit"], end_train: ["unit", "train"], drive: ["unit", "notch"], drive_by_ato: ["unit"],
  take_role: ["role"], hand_back_role: ["role"], do_step: ["role", "step", "block", "train?"], leave_out_step: ["role", "step", "block", "train?"],
};
// Acts under the name that a dispatcher has for them: a train is confirmed as stabled by what it holds, its track.
const PRESETS = { confirm_stabled: { kind: "confirm_holding", fields: ["unit", "track"] } };
const field = (name, node, id) => [element(document, "label", { for: id }, name), node];

function choice(id, values, called = (value) => value) {
  return element(document, "select", { id, name: id }, ...values.map((value) => element(document, "option", { value }, called(value))));
}

/** The faults that may hit something of this name, as a form; `ask` begins one. */
export function faultForm(welcome, hit, words, ask) {
  const kinds = welcome.faults.filter((kind) => kind.targets.includes(hit.id));
  const kindBox = element(document, "select", { id: "fault-kind" },
    ...kinds.map((kind) => element(document, "option", { value: kind.kind }, words.lang === "ja" ? kind.name_ja : kind.name)));
  const keys = element(document, "div", { class: "wide" });
  const form = element(document, "form", { id: "fault-form" }, element(document, "h2", {}, words.say("Break {what}", { what: hit.id }, "desk")),
    ...field(words.say("fault", {}, "desk"), kindBox, "fault-kind"), keys,
    element(document, "button", { type: "submit" }, words.say("Begin the fault", {}, "desk")));
  const fill = () => {
    const kind = kinds.find((one) => one.kind === kindBox.value);
    if (!kind) return keys.replaceChildren(words.say("nothing of this kind can be broken", {}, "desk"));
    const rows = [];
    if (kind.aims_at === "link") rows.push(["other", element(document, "input", { id: "key-other", value: kind.targets.find((name) => name !== hit.id), list: "targets" })]);
    for (const [name, schema] of Object.entries(kind.schema.properties)) {
      if (name !== "target") rows.push([name, keyInput(name, schema, kind.schema)]);
    }
    if (!kind.momentary) rows.push(["duration_s", element(document, "input", { id: "key-duration_s", type: "number", min: 0.1, step: 0.1, placeholder: "∞" })]);
    return keys.replaceChildren(element(document, "datalist", { id: "targets" }, ...kind.targets.map((value) => element(document, "option", { value }))),
      ...rows.flatMap(([name, node]) => [element(document, "div", {}, element(document, "label", { for: node.id, title: kind.schema.properties[name]?.description }, `${name} `), node)]));
  };
  kindBox.addEventListener("change", fill);
  fill();
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const kind = kinds.find((one) => one.kind === kindBox.value);
    if (!kind) return;
    const fault = { kind: kind.kind, target: hit.id };
    for (const node of keys.querySelectorAll("[id^=key-]")) {
      const name = node.id.slice(4);
      if (name === "other") fault.target = `${hit.id} <-> ${node.value}`;
      else if (node.value !== "") fault[name] = node.type === "number" ? Number(node.value) : node.type === "checkbox" ? node.checked : node.value;
    }
    ask("fail", { fault });
  });
  return form;
}

function keyInput(name, schema, whole) {
  const shape = schema.$ref ? whole.$defs[schema.$ref.split("/").at(-1)] : schema.anyOf?.[0] ?? schema;
  const id = `key-${name}`;
  if (shape.enum) return choice(id, shape.enum);
  if (shape.type === "boolean") return element(document, "input", { id, type: "checkbox", checked: schema.default === true });
  const number = shape.type === "number" || shape.type === "integer";
  return element(document, "input", { id, type: number ? "number" : "text", step: "any", value: schema.default ?? schema.examples?.[0] ?? "" });
}

/** The acts of a seat as a form; what is picked on the schematic stands in it. */
export function actForm(welcome, words, ask, lead) {
  const kindBox = element(document, "select", { id: "act-kind" },
    ...[...welcome.acts, ...Object.keys(PRESETS).filter((name) => welcome.acts.includes(PRESETS[name].kind))].map((kind) => element(document, "option", { value: kind }, actName(kind, words))));
  const rest = element(document, "div", { class: "wide" });
  const terminals = welcome.points.map((points) => points.terminal), crossings = welcome.crossings.filter((one) => one.has_device).map((one) => one.id);
  const makes = {
    unit: () => choice("act-target", welcome.units), "unit?": () => choice("act-target", ["", ...welcome.units]),
    party: () => choice("act-target", [...welcome.units, "block-manager", ...new Set(terminals), ...crossings]), points: () => choice("act-target", welcome.points.map((points) => points.id)),
    position: () => choice("act-position", ["normal", "reverse"]), place: () => choice("act-place", ["", ...welcome.sections.filter((s) => s.kind === "portal").map((s) => s.id)]),
    sections: () => element(document, "select", { id: "act-sections", multiple: true, size: 4 }, ...welcome.sections.map((s) => element(document, "option", { value: s.id }, s.id))),
    hold: () => element(document, "input", { id: "act-hold_s", type: "number", value: 300, min: 0 }), pace: () => element(document, "input", { id: "act-pace_s", type: "number", min: 0, step: 0.1, placeholder: "–" }),
    person: () => choice("act-person", ["controller", "staff", "crew"], (value) => words.say(value, {}, "party")), behind: () => choice("act-behind", ["", ...welcome.units]),
    over: () => choice("act-place", ["", ...welcome.sections.map((s) => s.id)]), track: () => choice("act-sections", welcome.sections.filter((s) => s.kind === "track").map((s) => s.id)),
    train: () => choice("act-train", welcome.plan.map((one) => one.train)), "train?": () => choice("act-train", ["", ...welcome.plan.map((one) => one.train)]),
    crossing: () => choice("act-target", crossings),
    role: () => choice("act-target", welcome.posts.map((one) => one.post)), block: () => choice("act-block", welcome.works.map((one) => one.block)),
    step: () => choice("act-step", [...new Set(welcome.works.flatMap((one) => one.rows.map((row) => row.step)))]), notch: () => element(document, "input", { id: "act-notch", type: "number", value: 0, min: -10, max: 10, step: 1 }),
  };
  const fill = () => rest.replaceChildren(...[...(PRESETS[kindBox.value]?.fields ?? ACT_FIELDS[kindBox.value]), ...(lead ? ["person"] : [])].map((name) => {
    const node = makes[name]();
    return element(document, "div", {}, element(document, "label", { for: node.id }, `${words.say(name.replace("?", ""), {}, "desk")} `), node);
  }));
  kindBox.addEventListener("change", fill);
  fill();
  const form = element(document, "form", { id: "act-form" }, element(document, "h2", {}, words.say("Act, by telephone or on the spot", {}, "desk")),
    ...field(words.say("act", {}, "desk"), kindBox, "act-kind"), rest, element(document, "button", { type: "submit" }, words.say("Read back, then do it", {}, "desk")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const act = { kind: PRESETS[kindBox.value]?.kind ?? kindBox.value }, spoken = [actName(kindBox.value, words)];
    for (const node of rest.querySelectorAll("[id^=act-]")) {
      const name = node.id.slice(4);
      if (name === "sections") spoken.push(...(act.sections = [...node.selectedOptions].map((option) => option.value)));
      else if (node.value !== "") {
        act[name] = node.type === "number" ? Number(node.value) : node.value;
        spoken.push(node.type === "number" ? `${node.previousElementSibling.textContent.trim()} ${node.value}${name.endsWith("_s") ? " s" : ""}` : node.value);
      }
    }
    readBack(form, words.say("Read back: {what}", { what: spoken.join(" ") }, "desk"), words, () => ask("act", { act }));
  });
  return form;
}

const actName = (kind, words) => words.lang === "ja" ? words.say(kind, {}, kind in PRESETS ? "desk" : "act") : kind.replaceAll("_", " ");

/** Other figures of a fault in force, as lines of `key = value`. */
export function changeForm(deed, words, ask) {
  const keys = element(document, "textarea", { id: "change-keys", rows: 3, "aria-label": words.say("keys that change, as in a drill: loss = 0.5", {}, "desk") });
  const form = element(document, "form", { id: "change-form" }, element(document, "h2", {}, words.say("Change fault {n}", { n: deed.deed }, "desk")),
    element(document, "div", { class: "wide" }, words.say("keys that change, as in a drill: loss = 0.5", {}, "desk")), element(document, "div", { class: "wide" }, keys),
    element(document, "button", { type: "submit" }, words.say("change", {}, "desk")));
  form.addEventListener("submit", (event) => { event.preventDefault(); ask("change_fault", { deed: deed.deed, keys: tableOf(keys.value) }); });
  return form;
}

/** Lines of `key = value` as a table; numbers and truth values are such, all else is text. */
function tableOf(text) {
  const value = (word) => word === "true" || word === "false" ? word === "true" : word !== "" && !Number.isNaN(Number(word)) ? Number(word) : word.replace(/^"(.*)"$/, "$1");
  return Object.fromEntries(text.split("\n").filter((line) => line.includes("=")).map((line) => [line.slice(0, line.indexOf("=")).trim(), value(line.slice(line.indexOf("=") + 1).trim())]));
}

/** What the instructor says to a seat. */
export function messageForm(words, ask) {
  const text = element(document, "input", { id: "tell-text", maxlength: 400 });
  const to = choice("tell-seat", ["", "dispatcher", "staff", "driver"]);
  for (const option of to.options) option.textContent = option.value ? words.say(option.value, {}, "desk") : words.say("all", {}, "desk");
  const form = element(document, "form", { id: "tell-form" }, element(document, "h2", {}, words.say("Message to a seat", {}, "desk")), ...field(words.say("seat", {}, "desk"), to, "tell-seat"),
    ...field(words.say("text", {}, "desk"), text, "tell-text"), element(document, "button", { type: "submit" }, words.say("send", {}, "desk")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (text.value) ask("tell", { text: text.value, ...(to.value ? { seat: to.value } : {}) });
    text.value = "";
  });
  return form;
}

/** A fault armed for a time to come. */
export function armForm(welcome, words, ask) {
  const kinds = welcome.faults.filter((kind) => kind.aims_at !== "link");
  const kindBox = element(document, "select", { id: "arm-kind" }, ...kinds.map((kind) => element(document, "option", { value: kind.kind }, words.lang === "ja" ? kind.name_ja : kind.name)));
  const target = element(document, "select", { id: "arm-target" }), start = element(document, "input", { id: "arm-start", size: 8, placeholder: "HH:MM:SS" });
  const lasts = element(document, "input", { id: "arm-duration", type: "number", min: 0.1, step: 0.1, placeholder: "∞" });
  const fill = () => target.replaceChildren(...(kinds.find((kind) => kind.kind === kindBox.value)?.targets ?? []).map((value) => element(document, "option", { value }, value)));
  kindBox.addEventListener("change", fill);
  fill();
  const form = element(document, "form", { id: "arm-form" }, element(document, "h2", {}, words.say("Arm a fault for later", {}, "desk")), ...field(words.say("fault", {}, "desk"), kindBox, "arm-kind"),
    ...field(words.say("target", {}, "desk"), target, "arm-target"), ...field(words.say("time", {}, "desk"), start, "arm-start"), ...field(words.say("lasts, s", {}, "desk"), lasts, "arm-duration"),
    element(document, "button", { type: "submit" }, words.say("arm", {}, "desk")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const fault = { kind: kindBox.value, target: target.value, start: start.value, ...(lasts.value ? { duration_s: Number(lasts.value) } : {}) };
    ask("arm", { faults: [fault] });
  });
  return form;
}

function readBack(form, text, words, yes) {
  const box = element(document, "div", { class: "wide", role: "group", "aria-label": text }, element(document, "strong", {}, text), " ",
    element(document, "button", { type: "button", onclick: () => { box.remove(); yes(); } }, words.say("right: do it", {}, "desk")), " ",
    element(document, "button", { type: "button", onclick: () => box.remove() }, words.say("wrong", {}, "desk")));
  form.querySelectorAll("[role=group]").forEach((old) => old.remove());
  form.append(box);
  box.querySelector("button").focus();
}
