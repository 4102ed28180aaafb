"""What lines and timetables rest on, in Japanese: files hold it in English, in sentences of their makers.

The catalogue has those of `branchline new line` and of imports, and those of the files that come with the program. A
sentence of a file of somebody's own is shown as it is.
"""

from __future__ import annotations

from typing import Final

from network.model import Line
from study.wording.catalogue import phrase, phrases_of
from study.wording.forms import found
from study.wording.phrase import Phrase

MINUTES: Final = phrase("{count} min").ja.removeprefix("{count}")


def assumption(text: str, line: Line) -> Phrase:
    """A sentence of a file in both languages, with the names of the line's stations."""
    japanese = {station.name: station.name_ja or station.name for station in line.stations.values()}

    def said(value: str) -> Phrase:
        names = value.replace(" and ", ", ").split(", ")
        return Phrase(value, "、".join(japanese.get(name, name) for name in names).replace(" min", MINUTES))

    return found(phrases_of("assumption").values(), text, said) or Phrase(text)
