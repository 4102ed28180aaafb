"""The least interval at which a line takes a train each way again and again, and why no smaller one does.

The trains are standard paths (`study.capacity.standard`): as fast as they are driven, on the tracks of the timetable,
with stops as short as can be, that may wait wherever they stop and a set can stand. They repeat at whole seconds, and
every time of theirs is a whole second. What a smaller interval would need is told by proof for every second of it;
whether an interval fits need not be monotone, so that a greater one than the least need not fit.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from network.errors import InputError
from plan.moving.bounds import LegBounds, MoveTerms, bounds_of
from plan.moving.model import MovingModel
from plan.moving.proof import Circle, ExcludedPeriods, Impossibility, circles_of
from plan.moving.recount import Recount
from plan.moving.refutation import excluded_by, refutation_of
from simulation.setup import Setup
from study.capacity.legs import SetLeg
from study.capacity.more import template
from study.capacity.rules import Rules
from study.capacity.standard import StandardPath, round_path, standard_paths, turning_tracks

AS_UNITS_ASK: Final = Rules(throws=True)
SET_LATE: Final = Rules(throws=True, late=True)
INTERVAL_S_MAX: Final = 4 * 3600
TERMS: Final = MoveTerms(tick_s=1.0, periodic=True)
IN_TENTHS: Final = MoveTerms(periodic=True)
WORK: Final = 4.0  # of the solver, for the least waits


@dataclass(frozen=True, slots=True)
class RepeatedPaths:
    """Trains that repeat: standard paths, and the legs of each, one path after the other.

    `goes_round`: the one path is of sets that never leave the line, there and back once or more often; its last leg is
    its first one once more, so many periods later as there are sets.
    """

    paths: tuple[StandardPath, ...]
    legs: tuple[tuple[SetLeg, ...], ...]
    goes_round: bool = False

    @property
    def trains_each_way(self) -> int:
        """How many there are in a period."""
        if self.goes_round:
            return len(self.paths[0].trains) // 2
        return max(Counter(path.name for path in self.paths).values())

    @property
    def again(self) -> int | None:
        """The leg that is the first one once more."""
        return len(self.all_legs) - 1 if self.goes_round else None

    def bounds(self, terms: MoveTerms = TERMS) -> LegBounds:
        """What holds between the moves of its legs, whatever the period."""
        return bounds_of(self.all_legs, terms, self.again)

    def recount(self) -> Recount:
        """The same for one who checks a proof."""
        return Recount(self.all_legs, TERMS.tick_s, self.again)

    @property
    def all_legs(self) -> tuple[SetLeg, ...]:
        """The legs of all paths."""
        return tuple(leg for own in self.legs for leg in own)


@dataclass(frozen=True, slots=True)
class LeastWaits:
    """By how much each leg of each path is moved, s (none: no moves were found), and how long all trains wait, s.

    `proven`: the least; `impossible`: there are no moves. `work`: what the solver counts.
    """

    moves_s: tuple[tuple[float, ...], ...]
    waits_s: float
    proven: bool
    impossible: bool
    work: float


@dataclass(frozen=True, slots=True)
class LeastInterval:
    """The least interval, s, or none up to `INTERVAL_S_MAX`; a timetable at it, and the proof that none is smaller.

    `moves_s`: of each leg of each path. `waits_s`: of all trains together, beyond the shortest stands; `least_waits`:
    proven to be the least. `in_tenths_s`: the least interval where times need not be whole seconds but tenths of them,
    which no timetable has. `circle`: the one that alone excludes most, and up to how many s it does.
    """

    pattern: RepeatedPaths
    interval_s: int | None
    moves_s: tuple[tuple[float, ...], ...]
    waits_s: float
    least_waits: bool
    proof: Impossibility
    in_tenths_s: float | None
    circle: tuple[Circle, int] | None

    @property
    def each_s(self) -> float:
        """The interval by the trains in it, s; infinite where there is none."""
        return math.inf if self.interval_s is None else self.interval_s / self.pattern.trains_each_way

    def circles(self) -> list[tuple[Circle, ...]]:
        """Of each range of intervals that is excluded: the circle, or those of all cases."""
        return [circles_of(one.because) for one in self.proof.excluded]


def pattern_of(setup: Setup, rules: Rules, trains: int = 1) -> RepeatedPaths:
    """So many trains each way of a line. Raises InputError where its timetable has none from end to end."""
    named = [(path, f"{path.name} {at}") for at in range(trains) for path in standard_paths(setup)]
    if named:
        legs = tuple(template(setup, path, rules, name) for path, name in named)
        return RepeatedPaths(tuple(path for path, _ in named), legs)
    path = round_path(setup, trains)
    if path is None:
        raise InputError(setup.name, "timetable", None, "trains each way that run from one end to the other")
    way = template(setup, path, rules)
    turns = next(at for at, leg in enumerate(way) if leg.number != path.trains[0].number)
    return RepeatedPaths((path,), (way[turns - 1 :],), goes_round=True)


def least_of_tracks(setup: Setup, rules: Rules = AS_UNITS_ASK) -> LeastInterval:
    """The least interval; of two trains where sets go round that turn on two tracks of an end, if that is less a train.

    Where sets come and go by portals they stand on the tracks of the timetable.
    """
    one = least_interval(setup, rules)
    if not one.pattern.goes_round or max(map(len, tracks_in_turn(setup, one.pattern))) < 2:
        return one
    two = least_interval(setup, rules, 2)
    return two if two.interval_s is not None and two.each_s < one.each_s else one


def tracks_in_turn(setup: Setup, pattern: RepeatedPaths) -> list[tuple[str, ...]]:
    """The sections of the tracks on which sets that go round can turn, at both ends."""
    calls = pattern.paths[0].trains[0].calls
    stations = (setup.line.stations[calls[at].station_id] for at in (0, -1))
    return [tuple(track.section_id for track in turning_tracks(station)) for station in stations]


def least_interval(setup: Setup, rules: Rules = AS_UNITS_ASK, trains: int = 1) -> LeastInterval:
    """The least interval of so many trains of a line with ways set by rules; see `LeastInterval`."""
    pattern = pattern_of(setup, rules, trains)
    bounds = pattern.bounds()
    interval_s, found = _excluded(bounds)
    excluded = _needed(found)
    alone = [
        (e.because, e.to_ticks) for e in found if isinstance(e.because, Circle) and e.to_ticks is not None
    ]
    circle = alone[-1] if alone else None
    proof = Impossibility(TERMS.tick_s, pattern.recount().names, excluded)
    if interval_s is None:
        return LeastInterval(
            pattern, None, (), math.nan, least_waits=False, proof=proof, in_tenths_s=None, circle=circle
        )
    waits = least_waits(pattern, bounds, interval_s)
    if not waits.moves_s:
        raise AssertionError(f"{interval_s} s is neither refuted nor found")
    tenths, _ = _excluded(pattern.bounds(IN_TENTHS))
    in_tenths_s = None if tenths is None else tenths / 10
    return LeastInterval(
        pattern, interval_s, waits.moves_s, waits.waits_s, waits.proven, proof, in_tenths_s, circle
    )


def recounted(setup: Setup, rules: Rules, proof: Impossibility) -> list[str]:
    """What is wrong with a proof that no smaller interval does, by the line's own times; nothing where it holds."""
    one = pattern_of(setup, rules)
    twice = one.goes_round and len(proof.legs) > len(one.all_legs)
    try:
        (pattern_of(setup, rules, 2) if twice else one).recount().refuse(proof)
    except ValueError as error:
        return [str(error)]
    return []


def _excluded(bounds: LegBounds) -> tuple[int | None, list[ExcludedPeriods]]:
    """The least period that is not excluded, and proofs for all below it, each for as many as it holds for."""
    found: list[ExcludedPeriods] = []
    period, longest = 1.0, INTERVAL_S_MAX / bounds.terms.tick_s
    while period <= longest and (why := refutation_of(bounds, int(period))) is not None:
        least, most = excluded_by(why)
        found.append(ExcludedPeriods(int(least), None if math.isinf(most) else int(most), why))
        period = most + 1
    return int(period) if period <= longest else None, found


def _needed(found: Sequence[ExcludedPeriods]) -> tuple[ExcludedPeriods, ...]:
    """No more proofs than exclude all that all of them do."""
    needed: list[ExcludedPeriods] = []
    for one in reversed(found):
        if not needed or one.from_ticks < needed[-1].from_ticks:
            needed.append(one)
        if one.from_ticks <= 1:
            break
    return tuple(reversed(needed))


def least_waits(pattern: RepeatedPaths, bounds: LegBounds, period: int, work: float = WORK) -> LeastWaits:
    """The moves with which trains wait least on their way, repeated after so many ticks, as counted work finds them."""
    model = MovingModel(bounds, bounds.in_a_period(period), period)
    own = _slices(pattern.legs)
    model.model.minimize(sum(model.moves[part][-1] - model.moves[part][0] for part in own))
    found = model.solve(work)
    if found.moves is None:
        return LeastWaits((), math.nan, proven=False, impossible=found.impossible, work=found.work)
    stands = (bound for bound in bounds.always if not bound.section_id and bound.after > bound.before)
    waits = found.cost - sum(bound.least for bound in stands)
    moves_s = [move * bounds.terms.tick_s for move in found.moves]
    return LeastWaits(
        tuple(tuple(moves_s[part]) for part in own),
        waits * bounds.terms.tick_s,
        found.proven,
        impossible=False,
        work=found.work,
    )


def _slices(legs: Sequence[Sequence[SetLeg]]) -> list[slice]:
    found: list[slice] = []
    for own in legs:
        begins = found[-1].stop if found else 0
        found.append(slice(begins, begins + len(own)))
    return found
