"""The most trains each way that repeat after a given time, not evenly spaced if need be, and why there are no more."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

from plan.least_interval import (
    AS_UNITS_ASK,
    TERMS,
    LeastWaits,
    RepeatedPaths,
    least_waits,
    pattern_of,
    tracks_in_turn,
)
from plan.moving.bounds import counted_again
from simulation.setup import Setup
from study.capacity.compression import held_sections
from study.capacity.rules import Rules

EVENLY: Final = 0.5  # of the solver's work at most, for each number of evenly spaced trains: a small question
TRAINS_MAX: Final = 24  # assumed: of more the model alone takes minutes; those are looked for evenly spaced


@dataclass(frozen=True, slots=True)
class MostTrains:
    """So many trains each way fit into a period, and more than `at_most` surely do not.

    `section_id`: the one that a train each way has longest, for `held_s` together. `pattern` and `waits`: the trains,
    and how they run; None where not one fits. They repeat every `repeats_s`, which is less than the period where they
    are evenly spaced. `undecided`: the numbers of trains of which `work` of the solver says nothing, and those beyond
    `TRAINS_MAX`.
    """

    trains: int
    at_most: int
    section_id: str
    held_s: float
    pattern: RepeatedPaths
    repeats_s: int
    waits: LeastWaits | None
    undecided: tuple[int, ...]
    work: float


def most_trains(
    setup: Setup,
    every_s: int,
    work_max: float,
    rules: Rules = AS_UNITS_ASK,
    tell: Callable[[str], None] = lambda _: None,
) -> MostTrains:
    """The most trains each way every so many seconds. Raises InputError where none run from one end to the other.

    Sets that never leave the line follow one another round and round, and turn on the tracks of each end by turns.
    `work_max`: of the solver for how many fit, all numbers together. `tell` hears what is tried.
    """
    one = pattern_of(setup, rules)
    if one.goes_round:
        one = pattern_of(setup, rules, math.lcm(*map(len, tracks_in_turn(setup, one))))
    section_id, held_s = _longest_held(setup, one)
    search = _NumberSearch(setup, rules, one, every_s, work_max, tell)
    search.run(int(every_s // held_s))
    pattern, repeats_s, waits = search.best()
    undecided = tuple(search.undecided)
    at_most = max((search.trains, *undecided))
    return MostTrains(
        search.trains, at_most, section_id, held_s, pattern, repeats_s, waits, undecided, search.work
    )


@dataclass(slots=True)
class _NumberSearch:
    """First the most that are evenly spaced, then more than those by all moves that trains can make, one by one.

    Where sets come and go by portals more trains than do not fit do not fit either, as any may be left out: all work
    goes to the least number that is not decided. Sets that go round would then turn in another order, so that nothing
    follows, and each number has its share. `trains`, `fitting`: the most that fit, every how many s they repeat, how.
    """

    setup: Setup
    rules: Rules
    one: RepeatedPaths
    every_s: int
    work_max: float
    tell: Callable[[str], None]
    trains: int = 0
    fitting: tuple[RepeatedPaths, int, LeastWaits] | None = None
    undecided: list[int] = field(default_factory=list)
    work: float = 0.0

    def run(self, at_most: int) -> None:
        """With no more than so many trains."""
        for trains in range(at_most, 0, -1):
            self.tell(f"{trains} trains each way of at most {at_most}")
            if self._fit_evenly(trains):
                self.trains = trains
                break
        for trains in range(self.trains + 1, at_most + 1):
            self.tell(f"{trains} trains each way of at most {at_most}")
            left = max(0.0, self.work_max - self.work)
            share = left / (at_most + 1 - trains) if self.one.goes_round else left
            if share <= 0.0 or trains > TRAINS_MAX:
                self.undecided.append(trains)
                continue
            pattern = pattern_of(self.setup, self.rules, trains)
            found = self._waits(pattern, self.every_s, share)
            if found.moves_s:
                self.trains, self.fitting, self.undecided = trains, (pattern, self.every_s, found), []
            elif not found.impossible:
                self.undecided.append(trains)
            elif not self.one.goes_round:
                break

    def best(self) -> tuple[RepeatedPaths, int, LeastWaits | None]:
        """The trains that fit, every how many s they repeat, and the least waits known; none where none fit."""
        if self.fitting is None:
            return self.one, self.every_s, None
        fitting, repeats_s, known = self.fitting
        if known.proven and repeats_s == self.every_s:
            return self.fitting
        known = replace(known, waits_s=known.waits_s * (self.every_s / repeats_s), proven=False)
        if self.trains > TRAINS_MAX:
            return fitting, repeats_s, known
        pattern = pattern_of(self.setup, self.rules, self.trains)
        waits = least_waits(pattern, pattern.bounds(), round(self.every_s / TERMS.tick_s))
        better = bool(waits.moves_s) and waits.waits_s <= known.waits_s
        return (pattern, self.every_s, waits) if better else (fitting, repeats_s, known)

    def _fit_evenly(self, trains: int) -> bool:
        """Whether so many trains fit that are spaced by whole seconds, as far as little work says."""
        each_way = self.one.trains_each_way
        repeats_s, over_s = divmod(self.every_s * each_way, trains)
        if over_s or trains % each_way:
            return False
        found = self._waits(self.one, repeats_s, EVENLY)
        self.fitting = (self.one, repeats_s, found) if found.moves_s else None
        return self.fitting is not None

    def _waits(self, pattern: RepeatedPaths, repeats_s: int, work: float) -> LeastWaits:
        found = least_waits(pattern, pattern.bounds(), round(repeats_s / TERMS.tick_s), work)
        self.work += found.work
        return found


def _longest_held(setup: Setup, pattern: RepeatedPaths) -> tuple[str, float]:
    """The section that a train each way has longest, with the shortest stands, and for how long, s.

    Of the tracks of an end that sets take by turns none is longer held than the one that is held least.
    """
    bounds = pattern.bounds()
    stands = {(b.before, b.after): b.least * TERMS.tick_s for b in bounds.always if not b.section_id}
    lengths_s: dict[str, float] = defaultdict(float)
    for one in held_sections(pattern.all_legs):
        if not counted_again(one, pattern.all_legs, pattern.again):
            waits_s = stands[one.begins, one.ends] if one.begins != one.ends else 0.0
            lengths_s[one.occupation.section_id] += one.occupation.length_s + waits_s
    if pattern.goes_round:
        for names in tracks_in_turn(setup, pattern):
            *longer, _ = sorted(names, key=lambda name: lengths_s[name])[::-1]
            lengths_s = {name: length_s for name, length_s in lengths_s.items() if name not in longer}
    section_id, held_s = max(lengths_s.items(), key=lambda item: (item[1], item[0]))
    return section_id, held_s / pattern.trains_each_way
