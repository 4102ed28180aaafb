"""What stands within a value: times, a train at a station (EkiJikoku), and what its set does there (Operation).

A station of a train is `how;arrival/departure$track`, parts that lack left out: how 1 stops, 2 passes, nothing or 0 no
service, 3 (OuDia only) another way; the track is an index. Times are HMM, HHMM or with seconds HHMMSS, without a day.
An operation is a kind and up to five parts, between them `/`, `$`, `/`, `$`, `/` in turn.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

from network.timetable import DAY_S

DAY_BEGINS_S: Final = 3 * 3600  # a train that begins before it belongs to the end of the operating day
_CELL: Final = re.compile(
    r"(?P<how>\d*)(?:;(?:(?P<arrival>[^/$]*)/)?(?P<departure>[^/$]*))?(?:\$(?P<track>\d*))?"
)
_CLOCK: Final = re.compile(r"(\d{1,2})[:]?(\d\d)(?:[:]?(\d\d))?")
_COLONS: Final = re.compile(r"(\d{1,2}):(\d\d)(?::(\d\d))?")


class CallHandling(Enum):
    """What a train does at a station (駅扱)."""

    NONE = 0
    STOP = 1
    PASS = 2
    OTHER_WAY = 3  # the train runs on another branch (経由なし)


@dataclass(frozen=True, slots=True)
class OudiaCell:
    """A train at a station: times in s after some midnight, the index of its track; None for what is not there."""

    how: CallHandling
    arrival_s: int | None = None
    departure_s: int | None = None
    track: int | None = None


NOTHING: Final = OudiaCell(CallHandling.NONE)


@dataclass(frozen=True, slots=True)
class StationOperation:
    """What a set does at a station before a train leaves or after it came, in parts as they are written."""

    kind: int
    parts: tuple[str, ...]

    def part(self, index: int) -> str:
        """A part, empty where it is not written."""
        return self.parts[index] if index < len(self.parts) else ""


class BeforeTrain(Enum):
    """What a set does before a train, where the train begins."""

    OUT = 3  # comes out of where it stood (出区)
    OUTER = 4  # comes from a place beyond the stations (路線外始発)
    JUNCTION = 5  # came as another train (前列車接続)


class AfterTrain(Enum):
    """What a set does after a train, where the train ends."""

    IN = 3  # is stabled (入区)
    OUTER = 4  # goes on to a place beyond the stations (路線外終着)
    JUNCTION = 5  # goes on as another train (次列車接続)


def seconds(text: str) -> int | None:
    """Seconds after midnight of a time; None for an empty one. Raises ValueError for what is none."""
    text = text.strip()
    if not text:
        return None
    match = (_COLONS if ":" in text else _CLOCK).fullmatch(text)
    if match is None:
        raise ValueError(text)
    hours, minutes, rest = (int(part or 0) for part in match.groups())
    if hours > 23 or minutes > 59 or rest > 59:
        raise ValueError(text)
    return hours * 3600 + minutes * 60 + rest


def time_text(time_s: int | None) -> str:
    """HMM or HHMM, with seconds where there are any; of the day's time alone."""
    if time_s is None:
        return ""
    time_s %= DAY_S
    hours, minutes, rest = time_s // 3600, time_s // 60 % 60, time_s % 60
    return f"{hours}{minutes:02d}{f'{rest:02d}' if rest else ''}"


def cell(text: str) -> OudiaCell:
    """A station of a train. Raises ValueError for what is none."""
    match = _CELL.fullmatch(text.strip())
    if match is None:
        raise ValueError(text)
    how = CallHandling(int(match["how"] or 0))
    if how in (CallHandling.NONE, CallHandling.OTHER_WAY):
        return OudiaCell(how)
    track = int(match["track"]) if match["track"] else None
    return OudiaCell(how, seconds(match["arrival"] or ""), seconds(match["departure"] or ""), track)


def cell_text(of: OudiaCell) -> str:
    """A station of a train as it is written."""
    if of.how is CallHandling.NONE:
        return ""
    text = str(of.how.value)
    if of.arrival_s is not None:
        text += f";{time_text(of.arrival_s)}/{time_text(of.departure_s)}"
    elif of.departure_s is not None:
        text += f";{time_text(of.departure_s)}"
    return text if of.track is None else f"{text}${of.track}"


def operation(text: str) -> StationOperation:
    """One operation. Raises ValueError for one without a kind."""
    kind, _, rest = text.partition("/")
    parts: list[str] = []
    for mark in ("$", "/", "$", "/"):
        part, found, rest = rest.partition(mark)
        parts.append(part)
        if not found:
            break
    else:
        parts.append(rest)
    return StationOperation(int(kind), tuple(parts))


def operation_text(kind: int, *parts: str) -> str:
    """One operation as it is written."""
    text = str(kind)
    for mark, part in zip(("/", "$", "/", "$", "/"), parts, strict=False):
        text += mark + part
    return text


def operating_day(times: Sequence[int | None]) -> tuple[int | None, ...]:
    """Times of a train in its order, s after the midnight before its operating day, from those of the clock.

    A first time before DAY_BEGINS_S is of the night after; one over 12 h before the one before it of the next day.
    """
    found: list[int | None] = []
    last_s: int | None = None
    for time_s in times:
        if time_s is None:
            found.append(None)
            continue
        if last_s is None:
            last_s = time_s + (DAY_S if time_s < DAY_BEGINS_S else 0)
        else:
            last_s = time_s + DAY_S * max(0, math.ceil((last_s - DAY_S // 2 - time_s) / DAY_S))
        found.append(last_s)
    return tuple(found)


def index_of(text: str, default: int = 0) -> int:
    """An index as it is written; `default` for what is none."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else default
