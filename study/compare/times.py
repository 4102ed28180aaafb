"""Which trains came and left at another time, and which ran, or came, in one of two runs only."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any, TypeAlias

from network.timetable import CallKind
from study.report.data import ReportedRun

# Train, station, how often the train was there before, and what it did.
Key: TypeAlias = tuple[str, str, int, "CallEvent"]


class CallEvent(Enum):
    """What a train does at a station, at a time."""

    ARRIVAL = "arrival"
    DEPARTURE = "departure"
    PASSING = "passing"  # the one time of a train that does not stop


@dataclass(frozen=True, slots=True)
class CallTimes:
    """When a train came or left: true and planned, s; None where it did not, or was not planned."""

    true_s: float | None
    planned_s: float | None


@dataclass(frozen=True, slots=True)
class MovedTime:
    """An arrival, departure or passing at another time.

    `by_s` > 0 is later in the new run; `plan_by_s` is by how much the plan moved, None where one of both has none.
    """

    train: str
    direction: str
    station: str
    what: CallEvent
    old_s: float
    new_s: float
    by_s: float
    plan_by_s: float | None

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV."""
        return asdict(self) | {"what": self.what.value}


@dataclass(frozen=True, slots=True)
class UnmatchedTime:
    """An arrival or departure of a train of both runs that came in one of them; `at_s` is when."""

    train: str
    station: str
    what: CallEvent
    in_new: bool
    at_s: float

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV."""
        return asdict(self) | {"what": self.what.value}


@dataclass(frozen=True, slots=True)
class ComparedTimes:
    """All of it. `compared` counts what came in both runs, `largest_s` is the most that any of it moved, unsigned."""

    compared: int
    largest_s: float
    moved: tuple[MovedTime, ...]
    once: tuple[UnmatchedTime, ...]
    only_base: tuple[str, ...]
    only_new: tuple[str, ...]


def times_of(run: ReportedRun) -> dict[Key, CallTimes]:
    """Every arrival and departure of the table of stops, by train and station: never by its row."""
    found: dict[Key, CallTimes] = {}
    visits: Counter[tuple[str, str]] = Counter()
    for row in run.tables.stops.iter_rows(named=True):
        train, station = row["train"], row["station"]
        visit = visits[train, station]
        visits[train, station] += 1
        passes = row["kind"] == CallKind.PASS.value
        whats = (CallEvent.PASSING,) if passes else (CallEvent.ARRIVAL, CallEvent.DEPARTURE)
        for what in whats:
            name = CallEvent.DEPARTURE.value if passes else what.value
            at = CallTimes(row[f"{name}_s"], row[f"planned_{name}_s"])
            if at.true_s is not None or at.planned_s is not None:
                found[train, station, visit, what] = at
    return found


def compare_times(base: ReportedRun, new: ReportedRun, over_s: float) -> ComparedTimes:
    """What moved by more than `over_s`, in order of time; times are of steps of 0.1 s and compared as such."""
    olds, news = times_of(base), times_of(new)
    trains = {key[0] for key in olds}, {key[0] for key in news}
    both = trains[0] & trains[1]
    moved: list[MovedTime] = []
    compared, largest_s = 0, 0.0
    for key, old, late in _pairs(olds, news):
        by_s = _less(late.true_s, old.true_s)
        if by_s is None or old.true_s is None or late.true_s is None:
            continue
        compared += 1
        largest_s = max(largest_s, abs(by_s))
        if abs(by_s) > over_s:
            train, station, _, what = key
            direction = new.directions[train].name.lower()
            plan_by_s = _less(late.planned_s, old.planned_s)
            moved.append(MovedTime(train, direction, station, what, old.true_s, late.true_s, by_s, plan_by_s))
    once = [
        UnmatchedTime(key[0], key[1], key[3], in_new, at.true_s)
        for mine, others, in_new in ((olds, news, False), (news, olds, True))
        for key, at in mine.items()
        if key[0] in both and at.true_s is not None and (key not in others or others[key].true_s is None)
    ]
    return ComparedTimes(
        compared,
        largest_s,
        tuple(sorted(moved, key=lambda m: (m.new_s, m.train, m.what.value))),
        tuple(sorted(once, key=lambda o: (o.at_s, o.train, o.what.value))),
        tuple(number for number in base.trains if number in trains[0] - trains[1]),
        tuple(number for number in new.trains if number in trains[1] - trains[0]),
    )


def _pairs(
    olds: Mapping[Key, CallTimes], news: Mapping[Key, CallTimes]
) -> Iterator[tuple[Key, CallTimes, CallTimes]]:
    for key, old in olds.items():
        late = news.get(key)
        if late is not None:
            yield key, old, late


def _less(new_s: float | None, old_s: float | None) -> float | None:
    return None if new_s is None or old_s is None else round(new_s - old_s, 3)
