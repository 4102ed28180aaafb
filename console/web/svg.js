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
