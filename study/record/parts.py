"""What is written into a page as it stands: facts in two languages, tables of text, and parts with a title."""

from __future__ import annotations

from dataclasses import dataclass, field

from study.wording.phrase import Phrase


@dataclass(frozen=True, slots=True)
class Fact:
    """One line of the headline; `bad` is set in red."""

    name: Phrase
    value: Phrase
    bad: bool = False


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table of text: numbers stand to the right from column `numbers_from` on, up to `numbers_to`."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers_from: int = 99
    numbers_to: int = 99


@dataclass(frozen=True, slots=True)
class PagePart:
    """A part of a page: what it shows, how to read it, its figures, its tables (folded when long).

    Title, caption and tables in Japanese too; where one is empty the English one stands for both.
    """

    title: str
    caption: str
    figures: tuple[str, ...] = ()
    grids: tuple[TextTable, ...] = ()
    folded: str = ""
    notes: tuple[str, ...] = field(default=())
    title_ja: str = ""
    caption_ja: str = ""
    grids_ja: tuple[TextTable, ...] = ()
    folded_ja: str = ""


def signed(value: float, digits: int = 0, unit: str = "") -> str:
    """A number with its sign, as it is set: +3 s, −12 s."""
    text = f"{value:+,.{digits}f}"
    return f"{text} {unit}".rstrip().replace("-", "−")
