"""A day's trains on a line of ours, before sets are given to them: what joining by names makes of published times.

`exchange.workings` makes diagrams of these, `exchange.timetable_writer` the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from network.model import Direction
from network.timetable import Call


@dataclass(frozen=True, slots=True)
class TrainOnLine:
    """A train with its calls at stations of the line.

    `follows` and `becomes` are numbers of this day's trains that the same set runs before and after, where the source
    says so. `from_beyond`, `to_beyond`: it comes from, goes on to, a place beyond the line, over a portal. `working`:
    what one set runs, where the source numbers that.
    """

    number: str
    direction: Direction
    calls: tuple[Call, ...]
    revenue: bool = True
    follows: tuple[str, ...] = ()
    becomes: tuple[str, ...] = ()
    from_beyond: bool = False
    to_beyond: bool = False
    working: str = ""


@dataclass(frozen=True, slots=True)
class Working:
    """What one set runs in a day (運用): train numbers in order; where it begins and ends is in `begins` and `ends`."""

    stock_id: str
    numbers: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Workings:
    """How every train begins and ends, as timetable files write it, and the diagrams.

    `assumed` and `warnings` are sentences: what nobody has published, and what cannot work on these tracks. `tracks`
    are those that sets must take, by (train number, index of its call), where the usual one would not do; `crowded` are
    warnings of places that more sets want than have room, which an arranged plan answers.
    """

    begins: dict[str, str]
    ends: dict[str, str]
    diagrams: tuple[Working, ...]
    assumed: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    tracks: Mapping[tuple[str, int], str] = field(default_factory=dict[tuple[str, int], str])
    crowded: tuple[str, ...] = ()
