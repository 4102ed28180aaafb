"""Duties (運用): what each set runs over the day, where it turns, stands over and leaves, and how far and how long.

As planned, from a timetable; or as run, with the trains of a run in place of those planned. Distances are along the
kilometrage from the first call to the last, without what a set runs beyond the line.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from itertools import pairwise
from typing import Any

from network.model import Direction, Line
from network.timetable import (
    AtPortal,
    BecomesTrain,
    Begin,
    Diagram,
    End,
    FromTrain,
    Timetable,
    TimetableTrain,
)


class GapKind(Enum):
    """What a set does where it runs no train."""

    TURN = "turn"  # stands and goes on as the next train (折返し)
    STABLED = "stabled"  # stands before, after or between trains (留置)
    OUTSIDE = "outside"  # is on another line, beyond a portal
    CUT_SHORT = "cut short"  # was last at a call here that was not its train's last


@dataclass(frozen=True, slots=True)
class DutyTrain:
    """A train in a duty; times in s, `distance_m` along the kilometrage.

    `late_s` at its end: None as planned, and where it did not come there (`cut_short`).
    """

    number: str
    direction: str
    revenue: bool
    from_id: str
    to_id: str
    begins_s: int
    ends_s: int
    distance_m: float
    planned_begins_s: int
    planned_ends_s: int
    late_s: int | None = None
    cut_short: bool = False


@dataclass(frozen=True, slots=True)
class DutyGap:
    """A set between two trains at a station (or outside it), from and to in s.

    `after` and `before` are the trains round it; None before the first and after the last, where the time beyond is
    None too.
    """

    kind: str
    station_id: str
    after: str | None
    before: str | None
    from_s: int | None
    to_s: int | None

    @property
    def length_s(self) -> int | None:
        """How long, s; None before the first and after the last train."""
        return None if self.from_s is None or self.to_s is None else self.to_s - self.from_s


@dataclass(frozen=True, slots=True)
class SetDuty:
    """What one set runs: its trains, and what it does before, between and after them.

    `on_duty_s` is from its first departure to its last arrival, `running_s` what of it is in trains, `turn_min_s` its
    shortest turn-back (None without one). `missing` are planned trains that it did not run.
    """

    stock_id: str
    trains: tuple[DutyTrain, ...]
    gaps: tuple[DutyGap, ...]
    distance_m: float
    empty_m: float
    on_duty_s: int
    running_s: int
    turn_min_s: int | None
    missing: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """As JSON has it."""
        found = asdict(self)
        for gap, table in zip(self.gaps, found["gaps"], strict=True):
            table["length_s"] = gap.length_s
        return found


def duties_of(
    line: Line, timetable: Timetable, as_run: Iterable[TimetableTrain] | None = None
) -> tuple[SetDuty, ...]:
    """The duty of every set, in the order of the timetable's diagrams.

    `as_run` are the trains of a run with their true times; those that it lacks did not run.
    """
    ran = timetable.trains if as_run is None else {train.number: train for train in as_run}
    return tuple(
        _duty(line, timetable, diagram, ran, planned=as_run is None) for diagram in timetable.diagrams
    )


def _duty(
    line: Line, timetable: Timetable, diagram: Diagram, ran: Mapping[str, TimetableTrain], *, planned: bool
) -> SetDuty:
    running = [ran[number] for number in diagram.train_numbers if number in ran]
    trains = tuple(_train(line, train, timetable.trains[train.number], planned=planned) for train in running)
    gaps = tuple(_gaps(running, {train.number for train in trains if train.cut_short}))
    turns = [gap.length_s for gap in gaps if gap.kind == GapKind.TURN.value and gap.length_s is not None]
    return SetDuty(
        diagram.stock_id,
        trains,
        gaps,
        sum(train.distance_m for train in trains),
        empty_m=sum(train.distance_m for train in trains if not train.revenue),
        on_duty_s=trains[-1].ends_s - trains[0].begins_s if trains else 0,
        running_s=sum(train.ends_s - train.begins_s for train in trains),
        turn_min_s=min(turns, default=None),
        missing=tuple(number for number in diagram.train_numbers if number not in ran),
    )


def _train(line: Line, train: TimetableTrain, plan: TimetableTrain, *, planned: bool) -> DutyTrain:
    """One train: from its departure to its arrival."""
    first, last = train.calls[0], train.calls[-1]
    ends_m = [line.stations[call.station_id].position_m for call in (first, last)]
    cut_short = last.station_id != plan.calls[-1].station_id
    return DutyTrain(
        train.number,
        "down" if train.direction is Direction.DOWN else "up",
        train.revenue,
        first.station_id,
        last.station_id,
        first.last_s,
        last.first_s,
        abs(ends_m[1] - ends_m[0]),
        planned_begins_s=plan.calls[0].last_s,
        planned_ends_s=plan.calls[-1].first_s,
        late_s=None if planned or cut_short else last.first_s - plan.calls[-1].first_s,
        cut_short=cut_short,
    )


def _gaps(trains: list[TimetableTrain], cut_short: Collection[str]) -> Iterable[DutyGap]:
    """Before the first train, between each two, after the last one."""

    def kind(train: TimetableTrain) -> str:
        return GapKind.CUT_SHORT.value if train.number in cut_short else _kind(train.ends)

    if not trains:
        return
    first, last = trains[0], trains[-1]
    yield DutyGap(
        _kind(first.begins), first.calls[0].station_id, None, first.number, None, first.calls[0].last_s
    )
    for before, after in pairwise(trains):
        here = before.calls[-1]
        yield DutyGap(
            kind(before),
            here.station_id,
            before.number,
            after.number,
            here.first_s,
            after.calls[0].last_s,
        )
    yield DutyGap(kind(last), last.calls[-1].station_id, last.number, None, last.calls[-1].first_s, None)


def _kind(how: Begin | End) -> str:
    match how:
        case AtPortal():
            return GapKind.OUTSIDE.value
        case FromTrain() | BecomesTrain():
            return GapKind.TURN.value
        case _:
            return GapKind.STABLED.value
