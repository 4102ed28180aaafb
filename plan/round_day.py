"""A day of sets that go round and round without leaving the line: where each begins in the morning and ends at night.

When the day begins, each set stands where the pattern has it then, or at the next place to which it is on its way: that
is its own already, so no two begin in one. It ends the day in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from network.model import Line
from network.timetable import BecomesTrain, FromTrain, Stabled, TimetableTrain

Working = tuple[TimetableTrain, ...]


def cut_to_day(line: Line, working: Sequence[TimetableTrain], from_s: int, to_s: int) -> Working:
    """The trains of a set from where it is at one time to where it is at another; none where it runs none between."""
    found: list[TimetableTrain] = []
    for train in working:
        ends = len(train.calls) - 1
        first = 0 if found else next(_standing(line, train, from_s), ends)
        last = next(_standing(line, train, to_s), ends)
        if first < last:
            calls = list(train.calls[first : last + 1])
            calls[0] = replace(calls[0], arrival_s=None)
            calls[-1] = replace(calls[-1], departure_s=None)
            found.append(replace(train, calls=tuple(calls)))
        if last < ends:
            break
    return tuple(
        replace(
            train,
            begins=FromTrain(found[at - 1].number) if at else Stabled(),
            ends=BecomesTrain(found[at + 1].number) if at + 1 < len(found) else Stabled(),
        )
        for at, train in enumerate(found)
    )


def _standing(line: Line, train: TimetableTrain, at_s: int) -> Iterator[int]:
    """The calls at places that a train has not left at a time, in order."""
    for index, call in enumerate(train.calls):
        if (
            call.departure_s is not None
            and call.departure_s >= at_s
            and not line.stations[call.station_id].is_halt
        ):
            yield index
