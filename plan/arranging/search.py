"""A plan found in steps where a whole day at once is too much: any plan first, then better ones a few trains at a time.

The trains that run in a stretch of the day are arranged anew around all others, which keep their times and tracks. The
stretch goes through the day, and is made longer when nothing is gained by it any more.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from network.clock import first_given
from plan.arranging.model import (
    ANOTHER,
    BEYOND_COST,
    EARLY_COST,
    MORE_COST,
    SECOND,
    STOP_COST,
    TRACK_COST,
    Aim,
    ArrangeModel,
    NoRoomError,
)
from plan.arranging.problem import Arranged, ArrangedVisit, PrintedMove, Standing, TrainToArrange
from plan.arranging.telling import Tell, tell_nobody

MINUTE_S: Final = 60
SPANS_S: Final = (3600, 7200, 10_800)  # assumed: how long a stretch is, one after the other
STRETCH_WORK: Final = 0.02  # of the solver's counted work for one stretch
GAIN_MIN: Final = 0.01  # of what moves in a stretch count: who gains less there goes on elsewhere
BUILDING_WORK: Final = 0.01  # counted for each besides: to state it takes time, too

Visits = Mapping[str, tuple[ArrangedVisit, ...]]


def improved(
    trains: Sequence[TrainToArrange],
    plan: Arranged,
    limit_s: int,
    more: Mapping[str, int],
    work_max: float,
    tell: Tell = tell_nobody,
) -> tuple[Arranged, float]:
    """A plan that is better, where so much counted work finds one, and how much it took."""
    spent = 0.0
    for gain_min in (GAIN_MIN, 0.0):  # what gains little comes last, with the work that is left
        for span_s in SPANS_S:
            tried: dict[frozenset[str], object] = {}
            while (free := _worst(trains, plan, limit_s, span_s, tried)) is not None:
                if spent >= work_max:
                    return plan, spent
                total_s = sum(abs(move.by_s) for move in plan.moves)
                tell(f"better in steps of {span_s // MINUTE_S} min, moves of {total_s} s in all so far")
                worth = _worth(plan, free, limit_s)
                tried[free] = _state(plan, free)
                better, work = _better(trains, plan, free, limit_s, more, worth)
                spent += work + BUILDING_WORK
                if better is not None:
                    plan = better
                    if _worth(plan, free, limit_s) > (1.0 - gain_min) * worth:
                        tried[free] = None
    return plan, spent


def _worst(
    trains: Sequence[TrainToArrange],
    plan: Arranged,
    limit_s: int,
    span_s: int,
    tried: Mapping[frozenset[str], object],
) -> frozenset[str] | None:
    """The trains of the stretch in which moves count most, of those that are not tried as they are.

    `tried`: the state in which a stretch was; None: it gains next to nothing.
    """
    found = [
        _running(trains, plan.visits, from_s, from_s + span_s) for from_s in _stretches(plan.visits, span_s)
    ]
    new = [
        free
        for free in found
        if tried.get(free, ()) not in {None, _state(plan, free)} and _worth(plan, free, limit_s)
    ]
    return max(new, key=lambda free: _worth(plan, free, limit_s), default=None)


def _state(plan: Arranged, free: frozenset[str]) -> object:
    return tuple(plan.visits[number] for number in sorted(free))


def _worth(plan: Arranged, free: frozenset[str], limit_s: int) -> int:
    """What the moves of these trains and the tracks that lack count."""
    return cost_of((move for move in plan.moves if move.number in free), plan.more_tracks, limit_s)


def with_fewer_tracks(
    trains: Sequence[TrainToArrange], plan: Arranged, limit_s: int, work_max: float
) -> tuple[Arranged, float]:
    """The same with fewer tracks that stations do not have, where trains around those that stand there allow it."""
    spent = 0.0
    for span_s in SPANS_S:
        tried: set[int] = set()
        while plan.more_tracks and spent < work_max:
            stands_s = sorted(
                visit.arrival_s
                for own in plan.visits.values()
                for visit in own
                if visit.track == ANOTHER and visit.arrival_s not in tried
            )
            if not stands_s:
                break
            tried.add(stands_s[0])
            from_s = stands_s[0] - span_s // 2
            free = _running(trains, plan.visits, from_s, from_s + span_s)
            worth = MORE_COST * sum(plan.more_tracks.values())
            better, work = _better(trains, plan, free, limit_s, plan.more_tracks, worth)
            spent += work + BUILDING_WORK
            plan = better or plan
    return plan, spent


def cost_of(moves: Iterable[PrintedMove], lacking: Mapping[str, int], limit_s: int) -> int:
    """What moves of printed times and tracks that lack count together, as in the model."""
    by_s = [move.by_s for move in moves]
    beyond_s = sum(max(0, abs(s) - limit_s) for s in by_s)
    early_s = sum(max(0, -s) for s in by_s)
    moved = SECOND * sum(map(abs, by_s)) + EARLY_COST * early_s
    return moved + BEYOND_COST * beyond_s + MORE_COST * sum(lacking.values())


def gap_of(trains: Sequence[TrainToArrange], plan: Arranged, limit_s: int) -> tuple[float, float]:
    """By how much a plan is from the least at most, s, and which share of what it counts: 0 where it is proven.

    As the model weighs it: a second beyond the limit as many, a stop that nobody prints or another track as a part.
    """
    if plan.proven:
        return 0.0, 0.0
    counts = cost_of(plan.moves, plan.more_tracks, limit_s)
    for train in trains:
        for visit, here in zip(train.visits, plan.visits[train.number], strict=True):
            counts += STOP_COST * (here.stands and visit.standing is Standing.MAY)
            counts += TRACK_COST * (here.track in visit.tracks[1:])
    gap_s = max(0.0, counts / SECOND - plan.bound_s)
    return gap_s, gap_s * SECOND / counts if counts else 0.0


def _better(
    trains: Sequence[TrainToArrange],
    plan: Arranged,
    free: frozenset[str],
    limit_s: int,
    more: Mapping[str, int],
    worth: int,
) -> tuple[Arranged | None, float]:
    """With these trains arranged anew, if that counts less than `worth`; and what was spent on it."""
    own = [move for move in plan.moves if move.number in free]
    reach_s = max(limit_s, *(abs(move.by_s) for move in own)) if own else limit_s
    settled = {number: visits for number, visits in plan.visits.items() if number not in free}
    model = ArrangeModel(trains, limit_s, reach_s, more, settled)
    model.begin_with(plan.visits)
    try:
        found = model.solve(STRETCH_WORK, Aim.BETTER, below=worth)
    except NoRoomError as none:
        return None, none.work
    kept = tuple(move for move in plan.moves if move.number not in free)
    return replace(
        plan,
        visits={**plan.visits, **found.visits},
        moves=(*kept, *found.moves),
        more_tracks=found.more_tracks,
    ), found.work


def _stretches(visits: Visits, span_s: int) -> Iterator[int]:
    first_s = min(own[0].departure_s for own in visits.values())
    last_s = max(own[-1].arrival_s for own in visits.values())
    return iter(range(first_s, last_s, span_s // 2))


def _running(trains: Sequence[TrainToArrange], visits: Visits, from_s: int, to_s: int) -> frozenset[str]:
    """The trains that are on their way then, or were to begin by print."""
    found: set[str] = set()
    for train in trains:
        own = visits[train.number]
        begins_s = min(own[0].departure_s, first_given(train.visits[0].departure_s, own[0].departure_s))
        if begins_s < to_s and own[-1].arrival_s > from_s:
            found.add(train.number)
    return frozenset(found)
