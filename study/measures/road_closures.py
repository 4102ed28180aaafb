"""When the road at level crossings was closed (遮断時間), and for how long each had warned as a front came (警報時間).

From the journal alone, as the road sees it: a crossing is closed while its lamps shine or its barriers are not raised,
by radio and by contacts alike. A crossing without any device says nothing, and is none here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from onboard.notes import Moving
from simulation.events import (
    BarrierState,
    CrossingBarriers,
    CrossingEntered,
    CrossingLamps,
    EventType,
    JournalEntry,
)

READS: Final[tuple[EventType, ...]] = (CrossingLamps, CrossingBarriers, CrossingEntered, Moving)
_DIGITS: Final = 1  # the run's own step is 0.1 s


@dataclass(frozen=True, slots=True)
class RoadClosure:
    """One stretch of time in which a crossing was closed, s; one that is not over lasts to the end of the run."""

    crossing_id: str
    from_s: float
    to_s: float

    @property
    def length_s(self) -> float:
        """How long it was."""
        return _tenths(self.to_s - self.from_s)


@dataclass(frozen=True, slots=True)
class FrontAtCrossing:
    """A front that came onto a crossing at `at_s`.

    `warned_s`: for how long its lamps had shone, 0 where none did; `closed_s`: for how long its barriers had been down,
    None where they were not; `ran_s`: since the train had last begun to move, None where its unit had not said so.
    """

    crossing_id: str
    unit_id: str
    at_s: float
    speed_mps: float
    warned_s: float
    closed_s: float | None
    ran_s: float | None

    @property
    def from_stand(self) -> bool:
        """Whether it began to move while the crossing warned: its start, and not its speed, made the time."""
        return self.ran_s is not None and self.ran_s < self.warned_s


@dataclass(frozen=True, slots=True)
class RoadsClosed:
    """All of a run, each in the order of its end."""

    closures: tuple[RoadClosure, ...]
    fronts: tuple[FrontAtCrossing, ...]

    @property
    def closed_s(self) -> float:
        """The closed time of all crossings together, s."""
        return _tenths(math.fsum(closure.length_s for closure in self.closures))

    @property
    def least_warned_s(self) -> float | None:
        """The shortest warning of a front, s; None where none came."""
        return min((front.warned_s for front in self.fronts), default=None)


@dataclass(slots=True)
class _RoadSeen:
    """Since when lamps shine, barriers are down, and the road is closed, s; None: they do not, are not, is not."""

    lit_s: float | None = None
    lowered_s: float | None = None
    closed_s: float | None = None
    raised: bool = True


@dataclass(slots=True)
class _Reading:
    roads: dict[str, _RoadSeen] = field(default_factory=dict[str, _RoadSeen])
    moved_s: dict[str, float] = field(default_factory=dict[str, float])
    closures: list[RoadClosure] = field(default_factory=list[RoadClosure])

    def road(self, crossing_id: str) -> _RoadSeen:
        return self.roads.setdefault(crossing_id, _RoadSeen())

    def changed(self, t_s: float, crossing_id: str) -> None:
        """A closure begins or ends with what has just changed."""
        road = self.road(crossing_id)
        closed = road.lit_s is not None or not road.raised
        if closed and road.closed_s is None:
            road.closed_s = t_s
        elif not closed and road.closed_s is not None:
            self.closures.append(RoadClosure(crossing_id, road.closed_s, t_s))
            road.closed_s = None

    def front(self, t_s: float, entered: CrossingEntered) -> FrontAtCrossing:
        road = self.road(entered.crossing_id)
        return FrontAtCrossing(
            entered.crossing_id,
            entered.unit_id,
            t_s,
            entered.speed_mps,
            _since(road.lit_s, t_s) or 0.0,
            _since(road.lowered_s, t_s),
            _since(self.moved_s.get(entered.unit_id), t_s),
        )


def roads_closed(entries: Iterable[JournalEntry], end_s: float) -> RoadsClosed:
    """The closures and fronts of a journal that ends at `end_s`, s."""
    seen = _Reading()
    fronts: list[FrontAtCrossing] = []
    for entry in entries:
        match entry.event:
            case CrossingLamps(crossing_id=crossing_id, lit=lit):
                seen.road(crossing_id).lit_s = entry.t_s if lit else None
                seen.changed(entry.t_s, crossing_id)
            case CrossingBarriers(crossing_id=crossing_id, state=state):
                road = seen.road(crossing_id)
                road.raised = state is BarrierState.RAISED
                road.lowered_s = entry.t_s if state is BarrierState.LOWERED else None
                seen.changed(entry.t_s, crossing_id)
            case CrossingEntered() as entered:
                fronts.append(seen.front(entry.t_s, entered))
            case Moving():
                seen.moved_s[entry.who] = entry.t_s
            case _:
                pass
    for crossing_id, road in sorted(seen.roads.items()):
        if road.closed_s is not None:
            seen.closures.append(RoadClosure(crossing_id, road.closed_s, end_s))
    return RoadsClosed(tuple(seen.closures), tuple(fronts))


def _since(begun_s: float | None, t_s: float) -> float | None:
    return None if begun_s is None else _tenths(t_s - begun_s)


def _tenths(value_s: float) -> float:
    return round(value_s, _DIGITS)
