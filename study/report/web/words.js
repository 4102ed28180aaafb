// The page's words: said in English by the modules, in Japanese by the catalogue that comes with the day.

/**
 * Words in a language, and names of places and stations in it. `japanese` has the words by their English, or by context and
 * English with "\u0004" between, as gettext does.
 */
export function wordsIn(lang, stations = new Map(), japanese = {}) {
  const place = (entry) => {
    const station = typeof entry === "string" ? stations.get(entry) : entry;
    if (!station) return entry ?? "–";
    return lang === "ja" ? station.ja || station.name : station.name;
  };
  const say = (english, values = {}, context = "") => {
    const text = lang === "ja" ? japanese[context ? `${context}\u0004${english}` : english] ?? english : english;
    return text.replace(/\{(\w+)\}/g, (_, name) => values[name] ?? "");
  };
  // What comes as [English, Japanese], or as words of the modules.
  const said = (words) => (Array.isArray(words) ? words[lang === "ja" ? 1 : 0] : say(words));
  return { lang, say, said, place };
}
