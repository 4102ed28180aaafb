// The driver's cab: what the unit shows, and the handle, by keys or by buttons.
import { element } from "./tables.js";
import { clock } from "./view.js";

const KMH = 3.6, TOP = 110;
const OWN_MS = 500; // as long the page goes by what was asked here, and not by what it is shown
const KEYS = { ArrowUp: 1, ArrowDown: -1 };

/** The cab as a part of the page; `tell` does what the driver does, and what is shown comes by the function returned. */
export function cab(welcome, words, tell) {
  const say = (english, values = {}) => words.say(english, values, "desk");
  const make = (...parts) => element(document, ...parts);
  const cells = new Map();
  const row = (name, id) => { const cell = make("td", { id: `cab-${id}` }); cells.set(id, cell); return make("tr", {}, make("th", { scope: "row" }, name), cell); };
  let shown = null, handle = 0, asked_ms = -OWN_MS;
  const act = (kind, more = {}) => tell("act", { act: { kind, target: shown.unit, ...more } });
  const set = (notch) => {
    if (!shown) return;
    const to = Math.max(-shown.brake_notches, Math.min(shown.power_notches, notch));
    if (to === handle && fresh()) return; // a key that is held down repeats itself, and each act takes a step of its own
    [handle, asked_ms] = [to, performance.now()];
    act("drive", { notch: handle });
  };
  const fresh = () => performance.now() - asked_ms < OWN_MS;
  const step = (by) => set((fresh() || shown?.by_hand ? handle : 0) + by);
  const release = (kind) => { asked_ms = -OWN_MS; act(kind); };
  const button = (text, key, click) => make("button", { type: "button", onclick: click, "aria-keyshortcuts": key }, `${text} (${key})`);
  const host = make("div", { class: "cab" },
    make("div", { class: "dial" }, make("div", { class: "speed", id: "cab-speed" }), make("div", { class: "scale", role: "img", id: "cab-scale" })),
    make("table", {}, make("caption", { class: "unseen" }, say("driver")), make("tbody", {},
      row(say("limit"), "limit"), row(say("automatic driving stays under"), "target"), row(say("notch"), "notch"), row(say("drives"), "drives"), row(say("authority"), "authority"),
      row(say("next stop"), "stop"), row(say("distance"), "distance"), row(say("arrives"), "arrives"), row(say("departs"), "departs"), row(say("waits for"), "waits"), ...(welcome.crossings.length ? [row(say("level crossing"), "crossing")] : []), row(say("holds"), "held"))),
    make("div", { class: "handle", role: "group", "aria-label": say("handle") },
      button(say("power"), "↑", () => step(1)), button(say("brake"), "↓", () => step(-1)), button(say("coast"), "0", () => set(0)),
      button(say("full brake"), "B", () => set(-shown.brake_notches)), button(say("back to ATO"), "A", () => release("drive_by_ato")), button(say("return the route"), "G", () => act("give_back"))),
    make("p", {}, say("Whatever the handle asks for, the train brakes at limits and at the end of its authority.")));
  const keys = { 0: () => set(0), b: () => set(-shown.brake_notches), a: () => release("drive_by_ato"), g: () => act("give_back") };
  document.addEventListener("keydown", (event) => {
    if (!shown || event.ctrlKey || event.altKey || event.metaKey || ["INPUT", "SELECT", "TEXTAREA"].includes(event.target.tagName)) return;
    const does = event.key in KEYS ? () => step(KEYS[event.key]) : keys[event.key.toLowerCase()];
    if (!does) return;
    event.preventDefault();
    if (!event.repeat || event.key in KEYS) does();
  });
  const metres = (value) => value === null ? "–" : value >= 1000 ? `${(value / 1000).toFixed(2)} km` : `${value.toFixed(0)} m`;
  const kmh = (value) => value === null ? "–" : `${(value * KMH).toFixed(0)} km/h`;
  const scale = (now) => {
    const bar = (kind, text) => make("div", { class: kind }, text);
    const share = (mps) => `${Math.min(100, ((mps ?? 0) * KMH / TOP) * 100).toFixed(1)}%`;
    const own = bar("now", ""), limit = bar("limit", "▼"), aim = bar("aim", "▽");
    own.style.width = share(now.speed_mps);
    limit.style.left = share(now.permitted_mps);
    aim.style.left = share(now.target_mps);
    return [own, limit, aim];
  };
  const show = (now) => {
    shown = now;
    if (now.by_hand && !fresh()) handle = now.handle;
    host.querySelector("#cab-speed").textContent = `${(now.speed_mps * KMH).toFixed(0)} km/h`;
    const bars = host.querySelector("#cab-scale");
    bars.setAttribute("aria-label", `${say("speed")} ${kmh(now.speed_mps)}, ${say("limit")} ${kmh(now.permitted_mps)}`);
    bars.replaceChildren(...scale(now));
    const put = (id, text, bad = false) => { cells.get(id).textContent = text; cells.get(id).className = bad ? "bad" : ""; };
    put("limit", kmh(now.permitted_mps));
    put("target", kmh(now.target_mps));
    const braked = now.intervention ? ` ⚠ ${(now.intervention === 2 ? say("emergency brake") : say("the unit brakes"))}` : "";
    put("notch", `${now.notch > 0 ? "P" : now.notch < 0 ? "B" : "N"}${Math.abs(now.notch).toFixed(0)}${braked}`, now.intervention > 0);
    put("drives", `${now.powered ? (now.by_hand ? say("by hand") : say("by ATO")) : `✕ ${say("no power")}`}${now.on_sight ? ` ⚠ ${say("on sight")}` : ""}`, now.on_sight || !now.powered);
    put("authority", `${metres(now.authority_m)} (${words.lang === "ja" ? now.why_ja : now.why})`);
    put("stop", words.place(now.next_stop || null));
    put("distance", metres(now.next_stop_m));
    put("arrives", now.arrives_s === null ? "–" : clock(now.arrives_s, true));
    put("departs", now.departs_s === null ? "–" : clock(now.departs_s, true));
    put("waits", (words.lang === "ja" ? now.waits_for_ja : now.waits_for) || "–");
    const road = now.crossing;
    if (cells.has("crossing")) put("crossing", road === null ? "–" : `${road.name} ${metres(road.ahead_m)}: ${say(road.state)}${road.creeps ? ` ⚠ ${say("leave to creep")}` : ""}`, road !== null && (road.creeps || road.state === "not proven"));
    put("held", now.held.join(" ") || "–");
  };
  return { host, show };
}
