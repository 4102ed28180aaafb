// What can be done from a seat: each fault by the keys of its schema, each act by the fields that it has.
import { element } from "./tables.js";

const ACT_FIELDS = {
  confirm_outside: ["unit", "place"], confirm_holding: ["unit", "sections"], take_back: ["unit"], accept_picture: ["pace"],
  power_on: ["party"], commission: ["party"], repair_points: ["points", "position"], enter_section: ["unit?", "sections"],
  reenter_by_hand: ["pace"], reenter_assisted: ["pace"], bar_unit: ["unit"], unbar_unit: ["unit"], haul_away: ["unit"], give_back: ["unit", "hold"],
};
const field = (name, node, id) => [element(document, "label", { for: id }, name), node];

function choice(id, values) {
  return element(document, "select", { id, name: id }, ...values.map((value) => element(document, "option", { value }, value)));
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
    ...welcome.acts.map((kind) => element(document, "option", { value: kind }, words.lang === "ja" ? words.say(kind, {}, "act") : kind.replaceAll("_", " "))));
  const rest = element(document, "div", { class: "wide" });
  const terminals = welcome.points.map((points) => points.terminal);
  const makes = {
    unit: () => choice("act-target", welcome.units), "unit?": () => choice("act-target", ["", ...welcome.units]),
    party: () => choice("act-target", [...welcome.units, "block-manager", ...new Set(terminals)]), points: () => choice("act-target", welcome.points.map((points) => points.id)),
    position: () => choice("act-position", ["normal", "reverse"]), place: () => choice("act-place", ["", ...welcome.sections.filter((s) => s.kind === "portal").map((s) => s.id)]),
    sections: () => element(document, "select", { id: "act-sections", multiple: true, size: 4 }, ...welcome.sections.map((s) => element(document, "option", { value: s.id }, s.id))),
    hold: () => element(document, "input", { id: "act-hold_s", type: "number", value: 300, min: 0 }), pace: () => element(document, "input", { id: "act-pace_s", type: "number", min: 0, step: 0.1, placeholder: "–" }),
    person: () => choice("act-person", ["controller", "staff", "crew"]),
  };
  const fill = () => rest.replaceChildren(...[...ACT_FIELDS[kindBox.value], ...(lead ? ["person"] : [])].map((name) => {
    const node = makes[name]();
    return element(document, "div", {}, element(document, "label", { for: node.id }, `${words.say(name.replace("?", ""), {}, "desk")} `), node);
  }));
  kindBox.addEventListener("change", fill);
  fill();
  const form = element(document, "form", { id: "act-form" }, element(document, "h2", {}, words.say("Act, by telephone or on the spot", {}, "desk")),
    ...field(words.say("act", {}, "desk"), kindBox, "act-kind"), rest, element(document, "button", { type: "submit" }, words.say("Read back, then do it", {}, "desk")));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const act = { kind: kindBox.value };
    for (const node of rest.querySelectorAll("[id^=act-]")) {
      const name = node.id.slice(4);
      if (name === "sections") act.sections = [...node.selectedOptions].map((option) => option.value);
      else if (node.value !== "") act[name] = node.type === "number" ? Number(node.value) : node.value;
    }
    const spoken = [act.kind.replaceAll("_", " "), act.target, ...(act.sections ?? []), act.position, act.place].filter(Boolean).join(" ");
    readBack(form, words.say("Read back: {what}", { what: spoken }, "desk"), words, () => ask("act", { act }));
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
