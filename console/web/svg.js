// A picture as elements of the page.

const NS = "http://www.w3.org/2000/svg";

/** An element of a picture. */
export function drawn(name, attributes = {}, ...children) {
  const made = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value !== undefined) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** Where a kilometrage lies over the box of its section, which is not to scale; never quite at its ends. */
export function along(box, at_m) {
  return box.x + Math.min(Math.max((at_m - box.from_m) / (box.to_m - box.from_m), 0.04), 0.96) * box.width;
}

/** In which of the sections that it holds a train last reported: where that station lies, else the first. */
export function reportedIn(train, stations, boxes) {
  const at_m = stations.find((station) => station.id === train.station)?.at_m;
  return train.sections.find((id) => boxes.get(id).from_m <= at_m && at_m <= boxes.get(id).to_m) ?? train.sections[0];
}
