"""Where another train fits between those that run: legs put into the gaps that occupations leave.

A standard path is a train, or a set there and back, that runs as fast as it is driven and stands no longer than it
must. It leaves at a time; at every place on its way it waits until its next leg is free, as long as it may. What it
then occupies is taken for the next one. Trains that run are never moved.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from study.capacity.legs import SetLeg, stand_of
from study.capacity.occupation import TOUCH_S, Occupation

GRID_S = 1.0  # times of a timetable are whole seconds


@dataclass(frozen=True, slots=True)
class PlacedPath:
    """A standard path in the timetable: its legs, and by how much each has moved, s."""

    legs: tuple[SetLeg, ...]
    moves_s: tuple[float, ...]

    @property
    def departs_s(self) -> float:
        """When it leaves its first place."""
        return self.legs[0].departs_s + self.moves_s[0]

    @property
    def arrives_s(self) -> float:
        """When it is in its last place."""
        return self.legs[-1].arrives_s + self.moves_s[-1]

    @property
    def waits_s(self) -> float:
        """How long it waits on its way."""
        return self.moves_s[-1] - self.moves_s[0]


@dataclass(slots=True)
class OccupiedSpans:
    """By section, from when to when it is somebody's, in order of time, s."""

    spans: dict[str, list[tuple[float, float]]] = field(default_factory=dict[str, list[tuple[float, float]]])

    @staticmethod
    def of_occupations(occupations: Iterable[Occupation]) -> OccupiedSpans:
        """What trains that run take."""
        occupied = OccupiedSpans()
        for one in occupations:
            occupied.add(one.section_id, one.begin_s, one.end_s)
        return occupied

    def add(self, section_id: str, begin_s: float, end_s: float) -> None:
        """One more."""
        insort(self.spans.setdefault(section_id, []), (begin_s, end_s))

    def until_s(self, section_id: str, begin_s: float, end_s: float, buffer_s: float) -> float | None:
        """When what is in the way of a span ends; None where it is free, with a buffer on both sides."""
        spans = self.spans.get(section_id, [])
        # Spans of one section do not overlap but where a plan has conflicts: the longest before counts.
        before = spans[: bisect_left(spans, (end_s + buffer_s - TOUCH_S,))]
        ends = [end for _, end in before if end + buffer_s > begin_s + TOUCH_S]
        return max(ends, default=None)


@dataclass(frozen=True, slots=True)
class PathSearch:
    """What a path may do: wait so long at a place and in all, with so much time between it and others, s."""

    wait_s_max: float = 900.0
    buffer_s: float = 0.0


def place(
    legs: Sequence[SetLeg], departs_s: float, occupied: OccupiedSpans, search: PathSearch
) -> PlacedPath | None:
    """A standard path that leaves at a time; None where it does not fit. Nothing is taken."""
    moves_s: list[float] = []
    for index, leg in enumerate(legs):
        least_s = departs_s - leg.departs_s if index == 0 else moves_s[-1]
        last_s = least_s if index == 0 else least_s + search.wait_s_max
        move_s = _free_move_s(legs, index, (least_s, last_s), moves_s, (occupied, search.buffer_s))
        if move_s is None:
            return None
        moves_s.append(move_s)
    return PlacedPath(tuple(legs), tuple(moves_s))


def _free_move_s(
    legs: Sequence[SetLeg],
    index: int,
    between_s: tuple[float, float],
    moves_s: Sequence[float],
    among: tuple[OccupiedSpans, float],
) -> float | None:
    """The least move of a leg with which nothing is in its way; whole seconds later than the least."""
    occupied, buffer_s = among
    least_s, last_s = between_s
    leg, move_s = legs[index], least_s
    while move_s <= last_s:
        ends = [
            (until_s - one.begin_s + buffer_s - move_s)
            for one in leg.occupations
            if (
                until_s := occupied.until_s(
                    one.section_id, one.begin_s + move_s, _end_s(one) + move_s, buffer_s
                )
            )
            is not None
        ]
        stays = leg.start
        if stays is not None:  # the place that it leaves is its own for as long as it waits there
            begin_s = _begin_s(stays, leg) + (moves_s[-1] if moves_s else move_s)
            until_s = occupied.until_s(stays.section_id, begin_s, stays.end_s + move_s, buffer_s)
            if until_s is not None:
                if moves_s:  # it cannot wait there any longer
                    return None
                ends.append(until_s - begin_s + buffer_s)
        if not ends:
            return move_s
        later_s = move_s + max(ends) - least_s
        move_s = least_s + math.ceil((later_s - TOUCH_S / 2.0) / GRID_S) * GRID_S
    return None


def _end_s(occupation: Occupation) -> float:
    """The end that is sure: of a place where it stays, its arrival."""
    return occupation.end_s if math.isfinite(occupation.end_s) else stand_of(occupation).arrives_s


def _begin_s(start: Occupation, leg: SetLeg) -> float:
    return start.begin_s if math.isfinite(start.begin_s) else leg.occupations[0].begin_s


def take_sections(placed: PlacedPath, occupied: OccupiedSpans) -> None:
    """The sections of a path, taken; its places from when it is let in to when it has left."""
    for index, (leg, move_s) in enumerate(zip(placed.legs, placed.moves_s, strict=True)):
        if index == 0 and leg.start is not None:
            occupied.add(leg.start.section_id, _begin_s(leg.start, leg) + move_s, leg.start.end_s + move_s)
        for one in leg.occupations:
            leaves = index + 1 < len(placed.legs) and placed.legs[index + 1].start is one
            end_s = one.end_s + placed.moves_s[index + 1] if leaves else _end_s(one) + move_s
            occupied.add(one.section_id, one.begin_s + move_s, end_s)


def fill_period(
    paths: Sequence[Sequence[SetLeg]],
    period_s: tuple[float, float],
    occupied: OccupiedSpans,
    search: PathSearch,
    step_s: float = 60.0,
) -> tuple[PlacedPath, ...]:
    """As many more paths as fit into a period, s: each of the kinds in turn, as early as it can leave.

    A path is wholly within the period. What fits depends on the order; this one is stated, and none is the best.
    """
    begins_s, ends_s = period_s
    found: list[PlacedPath] = []
    next_s = [begins_s for _ in paths]
    while True:
        options = [
            _first(legs, next_s[i], (ends_s, step_s), occupied, search) for i, legs in enumerate(paths)
        ]
        for i, option in enumerate(options):
            next_s[i] = math.inf if option is None else option.departs_s
        some = [(next_s[i], i, option) for i, option in enumerate(options) if option is not None]
        if not some:
            return tuple(found)
        _, kind, best = min(some, key=lambda one: one[:2])
        take_sections(best, occupied)
        next_s[kind] += step_s
        found.append(best)


def _first(
    legs: Sequence[SetLeg],
    from_s: float,
    until_s: tuple[float, float],
    occupied: OccupiedSpans,
    search: PathSearch,
) -> PlacedPath | None:
    ends_s, step_s = until_s
    while from_s < ends_s:
        placed = place(legs, from_s, occupied, search)
        if placed is not None:
            return placed if placed.arrives_s <= ends_s else None
        from_s += step_s
    return None
