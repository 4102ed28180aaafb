"""Who holds which section from when to when as planned (閉そく), by the rules of the run.

A train obtains all sections of a route before it leaves the track behind it, and gives that track and what lies between
back when it has arrived on the next one; there it stays until it has arrived on the one after, also as the next train
of its set, and for ever where its day ends. Sections of a route are thus held from the departure on one side to the
arrival on the other. Where a train runs through, its time there counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from study.feasibility.planned import SIGNS_S, PlannedDay, PlannedTrain


@dataclass(slots=True)
class Hold:
    """One set holds a section from `from_s` to `to_s`; `arrives_s` is when it comes to the end of that route.

    `trains` are those as which it does: one, or those that it becomes while it stands there. On the track at the end of
    its route it stands from `arrives_s` to `leaves_s`.
    """

    section_id: str
    stock_id: str
    trains: list[PlannedTrain]
    from_s: float
    arrives_s: float
    to_s: float = math.inf
    leaves_s: float = math.inf

    def train_at(self, time_s: float) -> PlannedTrain:
        """As which train the set holds the section at a time."""
        begun = [train for train in self.trains if train.nodes[0].arrives_s <= time_s]
        return begun[-1] if begun else self.trains[0]


@dataclass(frozen=True, slots=True)
class HoldingConflict:
    """Two sets want one section at a time: the `second` one would wait for `wait_s`, if it ever gets there."""

    first: Hold
    second: Hold

    @property
    def section_id(self) -> str:
        """The section."""
        return self.first.section_id

    @property
    def begins_s(self) -> float:
        """When the second needs the section; where both have it before they begin, when the first of them does, s."""
        if math.isfinite(self.second.from_s):
            return self.second.from_s
        return min(hold.trains[0].nodes[0].departs_s for hold in (self.first, self.second))

    @property
    def wait_s(self) -> float:
        """From when the second needs the section to when the first gives it back, s."""
        return self.first.to_s - self.second.from_s if math.isfinite(self.second.from_s) else math.inf

    @property
    def together_s(self) -> float:
        """For how long both would stand there at once by the plan's own times, s; negative where they never do."""
        begin_s = max(self.first.arrives_s, self.second.arrives_s)
        return min(self.first.leaves_s, self.second.leaves_s) - begin_s

    @property
    def trains(self) -> tuple[PlannedTrain, PlannedTrain]:
        """As which trains they do."""
        second = self.second.train_at(max(self.second.from_s, self.first.from_s))
        return self.first.train_at(max(self.second.arrives_s, self.first.from_s)), second


def holds_of(day: PlannedDay) -> dict[str, list[Hold]]:
    """All holds by section, in order of their beginning."""
    by_section: dict[str, list[Hold]] = {}
    for trains in day.trains.values():
        for hold in _holds_of_set(trains):
            by_section.setdefault(hold.section_id, []).append(hold)
    for holds in by_section.values():
        holds.sort(key=lambda hold: hold.from_s)
    return by_section


def clashes_of(by_section: dict[str, list[Hold]]) -> list[HoldingConflict]:
    """Every two holds of one section by different sets that overlap."""
    clashes: list[HoldingConflict] = []
    for holds in by_section.values():
        for index, first in enumerate(holds):
            for second in holds[index + 1 :]:
                if second.from_s >= first.to_s:
                    break  # they are in order of their beginning
                if first.stock_id != second.stock_id:
                    clashes.append(HoldingConflict(first, second))
    return clashes


def _holds_of_set(trains: Sequence[PlannedTrain]) -> Iterator[Hold]:
    standing: Hold | None = None
    for train in trains:
        start = train.nodes[0]
        if standing is None:
            from_s = start.departs_s - SIGNS_S if train.duty.enters else -math.inf
            standing = Hold(start.section_id, train.stock_id, [train], from_s, from_s)
        else:
            standing.trains.append(train)
        for route, here, there in zip(train.routes, train.nodes[:-1], train.nodes[1:], strict=True):
            for section_id in route.section_ids[:-1]:
                comes_s = there.arrives_s
                yield Hold(section_id, train.stock_id, [train], here.departs_s, comes_s, comes_s, comes_s)
            standing.to_s, standing.leaves_s = there.arrives_s, here.departs_s
            yield standing
            standing = Hold(there.section_id, train.stock_id, [train], here.departs_s, there.arrives_s)
        if train.duty.leaves:
            standing.to_s = standing.leaves_s = train.nodes[-1].arrives_s + SIGNS_S
            yield standing
            standing = None
    if standing is not None:
        yield standing
