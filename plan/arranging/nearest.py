"""Of some days the one with the nearest plan, within counted work for all of them; and tracks that a day lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from plan.arranging.model import REACH_S, Aim, ArrangeModel, NoRoomError
from plan.arranging.problem import Arranged, TrainToArrange
from plan.arranging.search import cost_of, improved, with_fewer_tracks

REACHES_S: Final = (
    300,
    600,
    1200,
    2400,
    4800,
    REACH_S,
)  # one after the other: a plan is found sooner with less
# Of the solver's counted work, of which a unit takes a processor 10 to 20 s:
WORK_MAX: Final = 1.3  # for all days and reaches
FIRST_WORK: Final = 0.1  # for any plan of a day
FEWEST_WORK: Final = 0.4  # for one with as few tracks as may be that stations do not have
WHOLE_WORK: Final = 0.8  # for the least of a day as a whole
WIDE_WORK: Final = 0.1  # the same where printed times move far: such a proof is rare
STEPS_WORK: Final = 0.4  # for a better plan in steps, where there is no proof
MORE_TRACKS_MAX: Final = 6  # that a station is thought to be given, where a day lacks them


@dataclass(frozen=True, slots=True)
class MoreTracks:
    """What a day lacks: tracks by station, and the furthest move with them, s."""

    by_station: dict[str, int]
    worst_s: int


@dataclass(frozen=True, slots=True)
class NearestPlan:
    """The plan, and which of the days it is; with how few more tracks printed times would be moved less far."""

    index: int
    arranged: Arranged
    lacking: MoreTracks | None = None


class NothingFoundError(ValueError):
    """No plan without tracks that stations do not have; `lacking`: with these there is one."""

    def __init__(self, why: str, lacking: MoreTracks | None) -> None:
        super().__init__(why)
        self.lacking: Final = lacking


def nearest_plan(days: Sequence[Sequence[TrainToArrange]], limit_s: int) -> NearestPlan:
    """Of some days the first of which a plan keeps the limit, else the plan that is the least beyond, and its day.

    Raises NothingFoundError where none has one.
    """
    left = WORK_MAX
    why = "no plan keeps all trains apart"
    lacking: tuple[Sequence[TrainToArrange], Arranged] | None = None
    for reach_s in REACHES_S:
        found: list[tuple[int, int, Arranged]] = []
        for index, trains in enumerate(days):
            if left <= 0:
                why = "none was found"
                break
            try:
                begun, spent = _first_plan(trains, limit_s, reach_s, left)
            except NoRoomError as none:
                why = str(none)
                left -= none.work
                if not none.certain:
                    break  # with more room one is found sooner than for another day with as little
                continue
            left -= spent
            if begun.more_tracks:
                why = "no plan keeps all trains apart"
                if lacking is None or _count(begun) < _count(lacking[1]):
                    lacking = trains, begun
                continue
            arranged, spent = _nearest(trains, begun, limit_s, reach_s, left)
            left -= spent
            beyond_s = sum(max(0, abs(move.by_s) - limit_s) for move in arranged.moves)
            if not beyond_s:
                return NearestPlan(index, arranged)
            found.append((beyond_s, index, arranged))
        if found:
            _, index, arranged = min(found, key=lambda one: one[:2])
            return NearestPlan(index, arranged, _lacking(lacking, limit_s, left))
    raise NothingFoundError(why, _lacking(lacking, limit_s, left))


def _first_plan(
    trains: Sequence[TrainToArrange], limit_s: int, reach_s: int, left: float
) -> tuple[Arranged, float]:
    """Any plan; where none is found, one with as few tracks as may be that stations do not have."""
    try:
        plan = ArrangeModel(trains, limit_s, reach_s).solve(min(left, FIRST_WORK), Aim.ANY)
    except NoRoomError as none:
        spent = none.work
    else:
        return plan, plan.work
    stations = {visit.station_id for train in trains for visit in train.visits if visit.tracks}
    more = dict.fromkeys(sorted(stations), MORE_TRACKS_MAX)
    left -= spent
    try:
        plan = ArrangeModel(trains, limit_s, reach_s, more).solve(
            max(min(left, FEWEST_WORK), 0.0), Aim.FEWEST
        )
    except NoRoomError as none:
        raise NoRoomError(str(none), certain=none.certain, work=none.work + spent) from none
    spent += plan.work
    if not plan.more_tracks or plan.proven:
        return plan, spent
    plan, more_spent = with_fewer_tracks(trains, plan, limit_s, min(left, STEPS_WORK))
    return plan, spent + more_spent


def _count(plan: Arranged) -> int:
    return sum(plan.more_tracks.values())


def _lacking(
    found: tuple[Sequence[TrainToArrange], Arranged] | None, limit_s: int, left: float
) -> MoreTracks | None:
    """How far printed times move with these tracks, in a plan that is made better."""
    if found is None:
        return None
    trains, begun = found
    plan, _ = improved(trains, begun, limit_s, begun.more_tracks, min(left, STEPS_WORK))
    return MoreTracks(plan.more_tracks, max((abs(move.by_s) for move in plan.moves), default=0))


def _nearest(
    trains: Sequence[TrainToArrange], begun: Arranged, limit_s: int, reach_s: int, left: float
) -> tuple[Arranged, float]:
    """The least of the day as a whole, or else what is better in steps; and the work for it."""
    work = min(left, WHOLE_WORK if reach_s == REACHES_S[0] else WIDE_WORK)
    best, spent, bound_s = begun, work, 0.0
    try:
        whole = ArrangeModel(trains, limit_s, reach_s).solve(work)
    except NoRoomError:
        pass
    else:
        if whole.proven:
            return whole, whole.work
        bound_s = whole.bound_s
        best = min(whole, begun, key=lambda plan: cost_of(plan.moves, plan.more_tracks, limit_s))
    plan, steps = improved(trains, best, limit_s, {}, min(max(left - spent, 0.0), STEPS_WORK))
    return replace(plan, proven=False, bound_s=bound_s), spent + steps
