"""Words in both languages of a report, and templates of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from network.model import Line

Language = Literal["en", "ja"]


@dataclass(frozen=True, slots=True)
class Phrase:
    """Words in English and in Japanese, for which the English stand where they are empty; a template has {names}."""

    en: str
    ja: str = ""

    def in_(self, language: Language) -> str:
        """The words in a language."""
        return (self.ja or self.en) if language == "ja" else self.en

    def fill(self, **parts: object) -> Phrase:
        """The template filled in, with parts that may be phrases themselves."""
        return Phrase(self.en.format(**_parts(parts, "en")), self.ja.format(**_parts(parts, "ja")))

    @property
    def both(self) -> list[str]:
        """English and Japanese, for a page."""
        return [self.en, self.in_("ja")]


Names = Mapping[str, Phrase]  # of stations, by id
NOTHING = Phrase("", "")


def joined_phrases(phrases: Iterable[Phrase], en: str = ", ", ja: str = "、") -> Phrase:
    """Phrases one after the other; empty ones are left out."""
    said = [phrase for phrase in phrases if phrase.en]
    return Phrase(en.join(phrase.en for phrase in said), ja.join(phrase.in_("ja") for phrase in said))


def names_of(line: Line) -> Names:
    """Names of the stations of a line, by id."""
    return {station.id: Phrase(station.name, station.name_ja) for station in line.stations.values()}


def _parts(parts: Mapping[str, object], language: Language) -> dict[str, object]:
    return {name: part.in_(language) if isinstance(part, Phrase) else part for name, part in parts.items()}
