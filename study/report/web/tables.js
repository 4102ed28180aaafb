// Tables behind the charts: sorted by a click on a heading, cut where long, saved as CSV, in the page's language.
import { clock } from "./view.js";

const SHOWN = 200;
const CALLS = { stop: ["stop", {}, "call"], operational: ["operational stop"], pass: ["passes"] };
const NUMBERS = new Set(["number", "signed", "clock"]);

/** An element with attributes, listeners (keys that begin with "on") and children; text is always set as text. */
export function element(doc, tag, attributes = {}, ...children) {
  const made = doc.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/** A value as it is read. */
export function written(value, column, words) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  switch (column.kind) {
    case "place": return value === "" ? words.say("whole line") : words.place(value);
    case "clock": return clock(value, true);
    case "word": return words.say(value);
    case "said": return words.said(value);
    case "call": return words.say(...CALLS[value]);
    case "number": return fixed(value, column.digits, words.lang);
    case "signed": return (value > 0 ? "+" : "") + fixed(value, column.digits, words.lang);
    default: return String(value);
  }
}

function fixed(value, digits, lang) {
  const text = value.toLocaleString(lang, { minimumFractionDigits: digits, maximumFractionDigits: digits });
  return text.replace("-", "−");
}

/** A column's heading. */
export const headingOf = (column, words) => words.said(column.heading);

/** Values of a table as CSV: a heading, then a row a line; numbers as they are, times as HH:MM:SS. */
export function csvOf(table, words) {
  const quoted = (text) => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const cell = (value, column) => {
    if (value === null || value === undefined || Number.isNaN(value)) return "";
    return quoted(column.kind === "number" || column.kind === "signed" ? String(value) : written(value, column, words));
  };
  const count = table.columns[0]?.values.length ?? 0;
  const lines = [table.columns.map((column) => quoted(headingOf(column, words))).join(",")];
  for (let i = 0; i < count; i++) lines.push(table.columns.map((column) => cell(column.values[i], column)).join(","));
  return `${lines.join("\r\n")}\r\n`;
}

function compared(column, words) {
  const { values } = column;
  return (i, j) => {
    const [a, b] = [values[i], values[j]];
    const none = (value) => value === null || value === undefined || Number.isNaN(value);
    if (none(a) || none(b)) return Number(none(a)) - Number(none(b));
    if (NUMBERS.has(column.kind)) return a - b;
    return written(a, column, words).localeCompare(written(b, column, words), words.lang, { numeric: true });
  };
}

/**
 * A table as an element: {id, title, columns: [{label, heading, kind, digits, values}], notes}. `open` shows it at once, else it is made when it
 * is opened. `context`: words, showTrain(number).
 */
export function makeTable(doc, table, context, open = false) {
  const { words } = context;
  const title = words.said(table.title);
  const count = table.columns[0]?.values.length ?? 0;
  const body = element(doc, "div", { class: "grid" });
  const details = element(doc, "details", { class: "table", id: `table-${table.id}` },
    element(doc, "summary", {}, `${title} · ${words.say(count === 1 ? "{count} row" : "{count} rows", { count: count.toLocaleString(words.lang) })}`), body);
  const fill = () => body.childElementCount || fillTable(doc, body, table, context, title);
  details.addEventListener("toggle", () => details.open && fill());
  if (open) {
    details.open = true;
    fill();
  }
  return details;
}

function fillTable(doc, body, table, context, title) {
  const { words } = context;
  const count = table.columns[0]?.values.length ?? 0;
  const order = Array.from({ length: count }, (_, i) => i);
  let [sorted, falling, all] = [null, false, false];
  const save = element(doc, "button", {
    type: "button", class: "quiet", "aria-label": words.say("Save {table} as CSV", { table: title }),
    onclick: () => saveText(doc, `${table.id}.csv`, csvOf(table, words)),
  }, words.say("CSV"));
  const grid = element(doc, "table", { "aria-label": title });
  const more = element(doc, "button", { type: "button", class: "quiet", onclick: () => { all = true; draw(); } });
  const draw = () => {
    grid.replaceChildren(element(doc, "thead", {}, element(doc, "tr", {}, ...table.columns.map((column) => {
      const sort = sorted === column ? (falling ? "descending" : "ascending") : "none";
      const turn = () => {
        falling = sorted === column && !falling;
        sorted = column;
        order.sort(compared(column, words));
        if (falling) order.reverse();
        draw();
      };
      return element(doc, "th", { "aria-sort": sort, class: NUMBERS.has(column.kind) ? "number" : null },
        element(doc, "button", { type: "button", onclick: turn }, headingOf(column, words)));
    }))));
    const shown = all ? order : order.slice(0, SHOWN);
    grid.append(element(doc, "tbody", {}, ...shown.map((i) => element(doc, "tr", {}, ...table.columns.map((column) => cellOf(doc, column, i, context))))));
    more.textContent = words.say("Show all {count} rows", { count: count.toLocaleString(words.lang) });
    more.hidden = shown.length === count;
  };
  draw();
  body.append(save, grid, more, ...(table.notes ?? []).map((note) => element(doc, "p", { class: "caption" }, words.said(note))));
}

function cellOf(doc, column, i, context) {
  const value = column.values[i];
  const text = written(value, column, context.words);
  const bad = Array.isArray(value) && value[0] === "NOT MET";
  if (column.kind !== "train" || !value) return element(doc, "td", { class: NUMBERS.has(column.kind) ? "number" : bad ? "bad" : text.length > 30 ? "long" : null }, text);
  return element(doc, "td", {}, element(doc, "button", { type: "button", class: "train", onclick: () => context.showTrain(value) }, text));
}

function saveText(doc, name, text) {
  const url = URL.createObjectURL(new Blob(["\uFEFF", text], { type: "text/csv" }));
  const link = element(doc, "a", { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}
