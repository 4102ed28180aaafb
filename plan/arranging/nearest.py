"""Of some days the one with the nearest plan, within counted work for all of them; and tracks that a day lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Final

from plan.arranging.lacking import NO_HALTS, Halts, MoreTracks, fewest_tracks, more_tracks
from plan.arranging.model import PRESOLVED_S, REACH_S, Aim, ArrangeModel, NoRoomError
from plan.arranging.problem import Arranged, TrainToArrange
from plan.arranging.search import improved
from plan.arranging.telling import Tell, tell_nobody

# one after the other: a plan is found sooner with less
REACHES_S: Final = (300, 600, 1200, 2400, 4800, REACH_S)
# Of the solver's counted work, of which a unit takes a processor 10 to 20 s:
WORK_MAX: Final = 1.5  # for all days and reaches
FIRST_WORK: Final = 0.1  # for any plan of a day
FEWEST_WORK: Final = 0.2  # for one with as few tracks as may be that stations do not have
WHOLE_WORK: Final = 1.0  # for the least of a day as a whole
WIDE_WORK: Final = 0.3  # the same where printed times move far: such a proof is rare
WIDE_TRAINS_MAX: Final = 20  # with more it is not looked for: that takes time which is not counted
FAR_S: Final = PRESOLVED_S  # nor, with more, a plan that moves times further, where more tracks would do
BESIDE_WORK: Final = 0.3  # for moves beyond the limit, where it is known which tracks would keep it
STEPS_WORK: Final = 0.7  # for a better plan in steps, where there is no proof, on an account of its own


@dataclass(frozen=True, slots=True)
class NearestPlan:
    """The plan, and which of the days it is; with how few more tracks printed times would be moved less far.

    `none_within_s`: it is proven of all the days that no plan moves each printed time by so much at most.
    """

    index: int
    arranged: Arranged
    lacking: MoreTracks | None = None
    none_within_s: int = 0


class NothingFoundError(ValueError):
    """No plan without tracks that stations do not have; `lacking`: with these there is one."""

    def __init__(self, why: str, lacking: MoreTracks | None) -> None:
        super().__init__(why)
        self.lacking: Final = lacking


def nearest_plan(
    days: Sequence[Sequence[TrainToArrange]],
    limit_s: int,
    halts: Halts = NO_HALTS,
    tell_all: Tell = tell_nobody,
) -> NearestPlan:
    """Of some days the first of which a plan keeps the limit, else the plan that is the least beyond, and its day.

    Raises NothingFoundError where none has one. `halts`: where tracks could be laid with which the limit is kept.
    `tell_all` takes what is being done.
    """
    lacking_tracks = cache(partial(more_tracks, days, halts, limit_s, tell_all))
    left = WORK_MAX
    why = "no plan keeps all trains apart"
    none_within_s = 0
    far_s = max(FAR_S, min(reach_s for reach_s in REACHES_S if reach_s >= limit_s))
    for reach_s in REACHES_S:
        if reach_s > far_s and max(map(len, days)) > WIDE_TRAINS_MAX:
            lacking = lacking_tracks()
            if lacking is not None:
                raise NothingFoundError(_not_within(far_s, none_within_s), lacking)
        found: list[tuple[int, int, Arranged]] = []
        certain = True
        for index, trains in enumerate(days):
            if left <= (WIDE_WORK + FIRST_WORK if found else 0.0):
                why, certain = "none was found", False
                break
            tell = _of_reach(tell_all, reach_s)
            try:
                arranged, spent = _nearest(trains, limit_s, reach_s, left, tell)
            except NoRoomError as none:
                why = str(none)
                left -= none.work
                certain = certain and none.certain
                if not none.certain:
                    break  # with more room one is found sooner than for another day with as little
                continue
            left -= spent
            beyond_s = sum(max(0, abs(move.by_s) - limit_s) for move in arranged.moves)
            if not beyond_s:
                return NearestPlan(index, arranged)
            found.append((beyond_s, index, arranged))
        if found:
            _, index, arranged = min(found, key=lambda one: one[:2])
            lacking = lacking_tracks()
            worst_s = max(abs(move.by_s) for move in arranged.moves)
            if lacking is not None and lacking.worst_s >= worst_s:
                lacking = None  # it would gain nothing
            return NearestPlan(index, arranged, lacking, none_within_s)
        if certain:
            none_within_s = reach_s
            if reach_s >= limit_s and max(map(len, days)) > WIDE_TRAINS_MAX and lacking_tracks() is not None:
                left = min(left, BESIDE_WORK)
    raise NothingFoundError(why, lacking_tracks())


def _not_within(far_s: int, none_within_s: int) -> str:
    if none_within_s >= far_s:
        return f"proven: no plan moves every time by {none_within_s} s or less"
    known = f"; proven: none by {none_within_s} s or less" if none_within_s else ""
    return f"no plan was found that moves every time by {far_s} s or less{known}"


def _of_reach(tell: Tell, reach_s: int) -> Tell:
    return lambda text: tell(f"moves by {reach_s} s at most: {text}")


def _nearest(
    trains: Sequence[TrainToArrange], limit_s: int, reach_s: int, left: float, tell: Tell
) -> tuple[Arranged, float]:
    """The least of the day as a whole, or else what is better in steps than any plan; and the work for it."""
    begun, spent, bound_s = None, 0.0, 0.0
    work = WHOLE_WORK if reach_s == REACHES_S[0] else WIDE_WORK
    if reach_s <= PRESOLVED_S or len(trains) <= WIDE_TRAINS_MAX:
        tell("looking for the least")
        try:
            begun = ArrangeModel(trains, limit_s, reach_s).solve(min(left, work), tell=tell)
        except NoRoomError as none:
            if none.certain:
                raise
            spent, bound_s = none.work, none.bound_s
        else:
            spent, bound_s = begun.work, begun.bound_s
            if begun.proven:
                return begun, spent
    if begun is None:
        tell("looking for any plan")
        begun, more = _first_plan(trains, limit_s, reach_s, max(left - spent, 0.0), spent)
        spent += more
    plan, steps = improved(trains, begun, limit_s, {}, STEPS_WORK, tell)
    return replace(plan, proven=False, bound_s=bound_s), spent + steps


def _first_plan(
    trains: Sequence[TrainToArrange], limit_s: int, reach_s: int, left: float, spent: float
) -> tuple[Arranged, float]:
    """Any plan; where the quick search finds none, one with the fewest more tracks, as these may be none.

    `spent`: what errors count besides.
    """
    try:
        plan = ArrangeModel(trains, limit_s, reach_s).solve(min(left, FIRST_WORK), Aim.ANY)
    except NoRoomError as none:
        first = none.work
        if none.certain:
            raise NoRoomError(str(none), work=spent + first) from none
    else:
        return plan, plan.work
    try:
        work_max = min(max(left - first, 0.0), FEWEST_WORK)
        plan, work = fewest_tracks(trains, NO_HALTS, limit_s, reach_s, work_max)
    except NoRoomError as none:
        raise NoRoomError(str(none), certain=none.certain, work=none.work + spent + first) from none
    if plan.more_tracks:
        why = "no plan keeps all trains apart" if plan.proven else "none was found"
        raise NoRoomError(why, certain=plan.proven, work=spent + first + work)
    return plan, first + work
