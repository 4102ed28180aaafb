"""Occupations as a train makes them: leg by leg, from track to track, with when it stands where.

A leg is what lies between two places at which a train may stand (tracks and portals): its sections are obtained
together, and nothing but time can come between two legs. Whatever moves trains against each other (headway,
compression, room for more) moves legs.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from network.model import Direction, Line, SectionKind
from study.capacity.occupation import COST_OF, TOUCH_S, Occupation, OccupationCost, OccupationPart, Slice

# a stand is no longer than needed without these
SLACK: Final = frozenset({OccupationPart.READY, OccupationPart.HELD, OccupationPart.LAYOVER})
# of points; who waits for several waits for the first of these
SETTING: Final = (OccupationPart.THROW, OccupationPart.AIR, OccupationPart.PROOF)
PLACES: Final = frozenset({SectionKind.TRACK, SectionKind.PORTAL})
IsPlace = Callable[[str], bool]


def places_of(line: Line) -> IsPlace:
    """Whether a section of a line is one in which a train may stand."""
    found = frozenset(section.id for section in line.sections.values() if section.kind in PLACES)
    return found.__contains__


@dataclass(frozen=True, slots=True)
class PlaceStand:
    """A train in a place, s: it comes to a stand and starts again, or both are when its front comes in: it passes.

    Infinite where it was there when the day began, or stays. `least_s`: the shortest that it could have stood.
    """

    section_id: str
    arrives_s: float
    departs_s: float
    passes: bool
    least_s: float


@dataclass(frozen=True, slots=True)
class SetLeg:
    """One set from one place to the next: all it occupies on the way, in order of travel, with the place at its end.

    `start` is what it holds of the place it leaves; None where that is not known. `end` is the last of `occupations`
    if the leg ends in a place.
    """

    stock_id: str
    number: str
    direction: Direction
    start: Occupation | None
    occupations: tuple[Occupation, ...]
    ends_in_place: bool

    @property
    def end(self) -> Occupation | None:
        """What it holds of the place at its end."""
        return self.occupations[-1] if self.ends_in_place else None

    @property
    def departs_s(self) -> float:
        """When it starts, or its front leaves the place at its beginning."""
        if self.start is not None and math.isfinite(stand_of(self.start).departs_s):
            return stand_of(self.start).departs_s
        return self.occupations[0].enters_s

    @property
    def arrives_s(self) -> float:
        """When it stands in the place at its end, or its front is in it."""
        return stand_of(self.occupations[-1]).arrives_s

    @property
    def held(self) -> tuple[Occupation, ...]:
        """All that it holds, with the place that it leaves."""
        return self.occupations if self.start is None else (self.start, *self.occupations)


def stands_in(occupation: Occupation) -> tuple[Slice, ...]:
    """What a train does in a section while its front is in it and does not move."""
    enters_s, leaves_s = occupation.enters_s - TOUCH_S, occupation.leaves_s - TOUCH_S
    return tuple(
        s for s in occupation.slices if enters_s <= s.begin_s < leaves_s and s.part is not OccupationPart.RUN
    )


def stand_of(occupation: Occupation, dwell_min_s: float = math.inf) -> PlaceStand:
    """How a train stands in a section; as if it passed where it does not. A dwell longer than the least is slack."""
    stands = stands_in(occupation)
    if not stands:
        at_s = occupation.enters_s if math.isfinite(occupation.enters_s) else occupation.begin_s
        return PlaceStand(occupation.section_id, at_s, at_s, passes=True, least_s=0.0)
    begin_s = stands[0].begin_s if math.isfinite(occupation.enters_s) else -math.inf
    end_s = stands[-1].end_s if math.isfinite(occupation.leaves_s) else math.inf
    slack_s = math.fsum(slack_of(occupation, dwell_min_s).values())
    least_s = math.fsum(s.length_s for s in stands) - slack_s
    return PlaceStand(occupation.section_id, begin_s, end_s, passes=False, least_s=least_s)


def slack_of(occupation: Occupation, dwell_min_s: float = math.inf) -> dict[OccupationCost, float]:
    """What of a stand need not be, by cost, s: waiting for its time or its way, a dwell over the least."""
    found = dict.fromkeys(OccupationCost, 0.0)
    dwells_s = 0.0
    for one in stands_in(occupation):
        if one.part is OccupationPart.DWELL:
            dwells_s += one.length_s
        elif one.part in SLACK:
            found[COST_OF[one.part]] += one.length_s
    found[COST_OF[OccupationPart.DWELL]] += max(dwells_s - dwell_min_s, 0.0)
    return found


def legs_of(occupations: Iterable[Occupation], is_place: IsPlace) -> tuple[SetLeg, ...]:
    """The legs that sets ran, in order of time; an occupation of a place ends the leg into it and starts the next.

    What a set held and never entered is none.
    """
    by_stock: dict[str, list[Occupation]] = defaultdict(list)
    for one in occupations:
        by_stock[one.stock_id].append(one)
    found: list[SetLeg] = []
    for stock_id, own in by_stock.items():
        own.sort(key=lambda o: (o.enters_s, o.begin_s))
        start: Occupation | None = None
        way: list[Occupation] = []
        for one in own:
            if not way and is_place(one.section_id) and (start is None or not _joined(start, one)):
                start = one
                continue
            way.append(one)
            if is_place(one.section_id):
                found.append(_leg(stock_id, start, way, ends=True))
                start, way = one, []
        if way:
            found.append(_leg(stock_id, start, way, ends=False))
    run = (leg for leg in found if math.isfinite(leg.departs_s))
    return tuple(sorted(run, key=lambda leg: (leg.departs_s, leg.stock_id)))


def _leg(stock_id: str, start: Occupation | None, way: list[Occupation], *, ends: bool) -> SetLeg:
    first = way[0]
    if start is not None and not _joined(start, first):
        start = None
    return SetLeg(stock_id, first.number, first.direction, start, tuple(way), ends)


def _joined(start: Occupation, first: Occupation) -> bool:
    """Whether a set goes on from a place: otherwise it has left the line there and come back."""
    return start.leaves_s >= first.enters_s - TOUCH_S or start.end_s >= first.begin_s - TOUCH_S


def costs_between(
    occupation: Occupation, from_s: float, to_s: float, way: Sequence[Occupation] = ()
) -> dict[OccupationCost, float]:
    """What the time from one instant to another goes into by an occupation, s; negative where it runs backwards.

    Before it begins and after it has ended the train is on its way elsewhere: driving, and so is what is set while it
    runs, for that it does not wait. `way`: all of the leg; a train that stands until points further on are set stands
    for these. The costs make up the time.
    """
    if to_s < from_s:
        return {cost: -time_s for cost, time_s in costs_between(occupation, to_s, from_s, way).items()}
    found: dict[OccupationCost, list[float]] = {cost: [] for cost in OccupationCost}
    for cost, begin_s, end_s in _spent(occupation, way):
        found[cost].append(max(0.0, min(end_s, to_s) - max(begin_s, from_s)))
    within_s = math.fsum(time_s for times in found.values() for time_s in times)
    found[OccupationCost.DRIVING].append(to_s - from_s - within_s)
    return {cost: math.fsum(times) for cost, times in found.items()}


def _spent(
    occupation: Occupation, way: Sequence[Occupation]
) -> Iterator[tuple[OccupationCost, float, float]]:
    """What each stretch of an occupation is spent on, as the train is held up by it."""
    waits = [one for other in way if other is not occupation for one in _waited_for(other)]
    runs = False
    for one in occupation.slices:
        runs = runs or one.part is OccupationPart.APPROACH
        before = one.begin_s < occupation.enters_s - TOUCH_S
        if one.part in SETTING and runs and before:
            yield OccupationCost.DRIVING, one.begin_s, one.end_s
        elif one.part is OccupationPart.READY and before:
            yield from _covered(one, waits)
        else:
            yield COST_OF[one.part], one.begin_s, one.end_s


def _waited_for(occupation: Occupation) -> Iterator[Slice]:
    """What is set of a section while its train stands."""
    for one in occupation.slices:
        if one.part is OccupationPart.APPROACH or one.begin_s >= occupation.enters_s - TOUCH_S:
            return
        if one.part in SETTING:
            yield one


def _covered(ready: Slice, waits: Sequence[Slice]) -> Iterator[tuple[OccupationCost, float, float]]:
    """A stand before the departure, by what is set meanwhile; what throws longest counts first."""
    ends = {t for w in waits for t in (w.begin_s, w.end_s) if ready.begin_s < t < ready.end_s}
    for begin_s, end_s in pairwise(sorted({ready.begin_s, ready.end_s, *ends})):
        parts = {w.part for w in waits if w.begin_s <= (begin_s + end_s) / 2.0 < w.end_s}
        part = next((p for p in SETTING if p in parts), ready.part)
        yield COST_OF[part], begin_s, end_s


def follows_on(before: SetLeg, after: SetLeg) -> bool:
    """Whether a leg begins where, and as, the leg before it of the same set ended."""
    return before.end is not None and after.start is before.end


def joined_legs(legs: Iterable[SetLeg]) -> tuple[tuple[SetLeg, SetLeg], ...]:
    """Each two legs of a set of which the second goes on from where the first ended."""
    by_stock: dict[str, list[SetLeg]] = defaultdict(list)
    for leg in legs:
        by_stock[leg.stock_id].append(leg)
    return tuple(pair for own in by_stock.values() for pair in pairwise(own) if follows_on(*pair))
