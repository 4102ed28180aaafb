// The line to the desk: a seat is taken, what is said is answered by its number, and a line that breaks is made again.

export const VERSION = 3;
const AGAIN_MS = 500;
const SILENT_MS = 5000; // without a word of a run that goes on, what the page shows is old
const NO_LINE = { good: false, why: "" }; // what is asked while there is none is not done
const UNHEARD = { ...NO_LINE, sent: true }; // what was asked before it broke may have been

/** What a page knows after one more state; what only grows is kept as long as the run is on the same branch. */
export function taken(known, state) {
  const same = known.state && known.state.branch === state.branch;
  return {
    ...known,
    state,
    events: [...(same ? known.events : []), ...state.events],
    graph: [...(same ? known.graph : []), ...state.graph],
    forecast: state.forecast ?? (same ? known.forecast : null) ?? [],
  };
}

/**
 * Connects, and goes on to; `show` is given what is known when there is more of it, null while there is no line or nothing is
 * heard. Between two times as long passes as the first took to be seen: what comes meanwhile is taken, and the present alone is shown.
 */
export function connect(path, seat, token, show, unit = "") {
  const waiting = new Map();
  let socket = null, number = 0, known = { events: [], graph: [] }, met = null, shown = known, busy = false, silence = null;
  const draw = () => {
    const began_ms = performance.now();
    if (known.state) show((shown = known));
    requestAnimationFrame(() => setTimeout(() => setTimeout(() => { busy = false; news(); }, performance.now() - began_ms)));
  };
  const news = () => {
    if (busy || known === shown) return;
    busy = true;
    requestAnimationFrame(draw);
  };
  const open = () => {
    socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/${path}`);
    known = { events: [], graph: [] };
    socket.onopen = () => socket.send(JSON.stringify({ say: "hello", seat, unit, token, version: VERSION }));
    socket.onmessage = ({ data }) => {
      const message = JSON.parse(data);
      if (message.say === "welcome") {
        if (met !== null && met !== data) return location.reload(); // another run: no form or heading of the old one fits it
        [met, known] = [data, { ...known, welcome: message }];
      } else if (message.say === "state") {
        known = taken(known, message);
        news();
        clearTimeout(silence);
        if (message.running) silence = setTimeout(show, SILENT_MS, null);
      } else waiting.get(message.number)?.(message);
    };
    socket.onclose = ({ reason }) => {
      for (const unheard of [...waiting.values()]) unheard(UNHEARD);
      clearTimeout(silence);
      shown = known; // nothing of the old line is drawn any more
      show(null, reason);
      setTimeout(open, AGAIN_MS);
    };
  };
  open();
  return (say, fields = {}) => new Promise((resolve) => {
    number += 1;
    const own = number;
    if (socket.readyState !== WebSocket.OPEN) return resolve(NO_LINE);
    waiting.set(own, (answer) => { waiting.delete(own); resolve(answer); });
    socket.send(JSON.stringify({ say, number: own, ...fields }));
  });
}
