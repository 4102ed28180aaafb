// Two runs side by side, each as a page of the desk: what one is asked the other is asked too.
import { element } from "./tables.js";

const lang = (new URLSearchParams(location.search).get("lang") ?? navigator.language).startsWith("ja") ? "ja" : "en";
const frames = ["desk", "beside"].map((run) =>
  element(document, "iframe", { name: run, title: run, src: `./?${new URLSearchParams({ seat: "instructor", run, lang })}${location.hash}` }));
document.documentElement.lang = lang;
document.body.replaceChildren(...frames);
addEventListener("message", ({ origin, source, data }) => {
  if (origin !== location.origin) return;
  for (const frame of frames) if (frame.contentWindow !== source) frame.contentWindow.postMessage(data, origin);
});
