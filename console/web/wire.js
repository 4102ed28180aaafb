// The line to the desk: a seat is taken, what is said is answered by its number, and a line that breaks is made again.

export const VERSION = 3;
const AGAIN_MS = 500;
const NO_LINE = { good: false, why: "" }; // what is asked while there is none is not done, as far as anybody here knows

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

/** Connects, and goes on to; `show` is given what is known whenever there is more of it, null while there is no line. */
export function connect(path, seat, token, show, unit = "") {
  const waiting = new Map();
  let socket = null, number = 0, known = { events: [], graph: [] };
  const open = () => {
    socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/${path}`);
    known = { events: [], graph: [] };
    socket.onopen = () => socket.send(JSON.stringify({ say: "hello", seat, unit, token, version: VERSION }));
    socket.onmessage = ({ data }) => {
      const message = JSON.parse(data);
      if (message.say === "welcome") known = { ...known, welcome: message };
      else if (message.say === "state") show((known = taken(known, message)));
      else waiting.get(message.number)?.(message);
    };
    socket.onclose = ({ reason }) => {
      for (const unheard of [...waiting.values()]) unheard(NO_LINE);
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
