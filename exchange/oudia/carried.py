"""What OuDia has no place for, in the places that it leaves to people: the route's comment and a train's remark.

The comment ends in a table of TOML: the head of the timetable file, ids of stations and order of sets. A remark has
words, each with ids of stations: `運転停車=OGN,KRS`, where the train stands without passengers and OuDia has a stop;
`番線=OGN`, where its track is named, the usual one as it is; `推定=OGN`, where a time is not the source's but computed;
and `日=+1`, by how many days it begins later than its first time says. Who edits the file may change or drop them; then
they are not read.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Annotated, Final

from pydantic import Field

from exchange.timetable_writer import head_toml
from network.files.timetable_schema import HeadTable
from network.files.toml_input import Record, parse_toml
from network.files.toml_text import text_toml

_BEGINS: Final = "# branchline: what OuDia has no place for; read back from here"
_OPERATIONAL: Final = "運転停車"
_TRACK: Final = "番線"
_INFERRED: Final = "推定"
_DAY: Final = "日"
_WORD: Final = re.compile(rf"(?:^|\s)({_OPERATIONAL}|{_TRACK}|{_INFERRED}|{_DAY})=(\S+)")


class WrittenTable(Record):
    """`[oudia]`: name of the Dia that is the plan, ids of stations in order, ids of sets in order."""

    dia: str
    stations: list[str] = Field(min_length=1)
    stock: list[str]


class CommentTable(Record):
    """The table in the comment."""

    timetable: HeadTable
    oudia: Annotated[WrittenTable, Field()]


@dataclass(frozen=True, slots=True)
class RemarkFacts:
    """What a remark carries: ids of stations where the train stands without passengers, where its track is named though
    it is the usual one, where a time is inferred, and days to add.
    """

    operational: frozenset[str] = frozenset()
    named_tracks: frozenset[str] = frozenset()
    inferred: frozenset[str] = frozenset()
    days: int = 0


def comment(title: str, carried: CommentTable) -> str:
    """The route's comment."""
    written = carried.oudia
    rows = [title, "", _BEGINS, *head_toml(carried.timetable), "[oudia]", f"dia = {text_toml(written.dia)}"]
    for key, names in (("stations", written.stations), ("stock", written.stock)):
        rows.append(f"{key} = [{', '.join(text_toml(name) for name in names)}]")
    return "\n".join(rows) + "\n"


def carried_in(text: str, file: str) -> CommentTable | None:
    """What a comment carries; None where it carries nothing. InputError for what is no longer whole."""
    _, found, table = text.replace("\r\n", "\n").partition(_BEGINS)
    return parse_toml(table, file, CommentTable) if found else None


def remark(words: RemarkFacts) -> str:
    """A train's remark; empty where OuDia has a place for all."""
    stations = ((_OPERATIONAL, words.operational), (_TRACK, words.named_tracks), (_INFERRED, words.inferred))
    parts = [f"{name}={','.join(sorted(ids))}" for name, ids in stations if ids]
    if words.days:
        parts.append(f"{_DAY}={words.days:+d}")
    return " ".join(parts)


def is_ours(text: str) -> bool:
    """Whether a remark is what was written by branchline, and nobody's own words."""
    return remark(words_in(text)) == text


def words_in(text: str) -> RemarkFacts:
    """What a remark carries; other words of it are somebody's own."""
    found = dict(_WORD.findall(text))
    days = found.get(_DAY, "0")
    operational, named_tracks, inferred = (
        frozenset(found.get(name, "").split(",")) - {""} for name in (_OPERATIONAL, _TRACK, _INFERRED)
    )
    return RemarkFacts(
        operational, named_tracks, inferred, days=int(days) if re.fullmatch(r"[+-][0-9]", days) else 0
    )
