"""A timetable as somebody has published it: what every reader of a foreign format gives, and every writer takes.

Nothing here knows a line of ours. Times are seconds after the midnight before the operating day; trains before
03:00 belong to the day before, so their times are beyond 24 h.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from network.timetable import Call

NAMED_MAX: Final = 8  # trains or stations named in one sentence


@dataclass(frozen=True, slots=True)
class PublishedStation:
    """A station of the source. `key` is what its calls name it by; names are empty where it has none.

    `usual` names the track that trains of a direction ("down", "up") take whose calls name none, where it is said.
    """

    key: str
    name: str
    name_ja: str = ""
    km: float | None = None
    tracks: tuple[str, ...] = ()  # names of its platform tracks (番線), where the source has them
    usual: Mapping[str, str] = field(default_factory=dict[str, str])


@dataclass(frozen=True, slots=True)
class PublishedTrain:
    """A train of the source. `direction` is "down" (下り) or "up" in the order of the source's stations.

    Its calls have the times that are given, None where there is none. `follows` and `becomes` name trains that the
    same set runs before and after, where the source says so; `comes_from` and `goes_to` name places beyond the
    source's stations. `working` names what one set runs in the day (運用), where the source numbers that; `said`: words
    that the source has beside it for people, such as the days on which it runs.
    """

    number: str
    direction: str
    calls: tuple[Call, ...]
    name: str = ""
    kind: str = ""  # local, rapid, empty (回送), ... as the source calls it
    revenue: bool = True
    follows: tuple[str, ...] = ()
    becomes: tuple[str, ...] = ()
    comes_from: str = ""
    goes_to: str = ""
    working: str = ""
    said: str = ""


@dataclass(frozen=True, slots=True)
class PublishedTimetable:
    """One operating day. `left` says in sentences what the source holds and this does not; `source` names it."""

    name: str
    stations: tuple[PublishedStation, ...]
    trains: tuple[PublishedTrain, ...]
    source: str
    left: tuple[str, ...] = ()


def some_names(names: Sequence[str], most: int = NAMED_MAX) -> str:
    """Some of many names, and how many more there are."""
    shown, more = ", ".join(names[:most]), len(names) - most
    return f"{shown} and {more} more" if more > 0 else shown
