"""The most trains each way that repeat after a given time, not evenly spaced if need be, and why there are no more."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
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

TRIED: Final = 1.0  # of the solver's work, for each number of trains: those that fit are found in far less


@dataclass(frozen=True, slots=True)
class MostTrains:
    """So many trains each way fit into a period, and more than `at_most` surely do not.

    `section_id`: the one that a train each way has longest, for `held_s` together. `pattern` and `waits`: the trains,
    and how they run; None where not one fits.
    """

    trains: int
    at_most: int
    section_id: str
    held_s: float
    pattern: RepeatedPaths
    waits: LeastWaits | None


def most_trains(
    setup: Setup, every_s: int, rules: Rules = AS_UNITS_ASK, tell: Callable[[str], None] = lambda _: None
) -> MostTrains:
    """The most trains each way every so many seconds. Raises InputError where none run from one end to the other.

    Sets that never leave the line follow one another round and round, and turn on the tracks of each end by turns.
    `tell` hears what is tried.
    """
    one = pattern_of(setup, rules)
    if one.goes_round:
        one = pattern_of(setup, rules, math.lcm(*map(len, tracks_in_turn(setup, one))))
    section_id, held_s = _longest_held(setup, one)
    trains = at_most = int(every_s // held_s)
    while trains > 0:
        tell(f"{trains} trains each way of at most {at_most}")
        pattern, period = pattern_of(setup, rules, trains), round(every_s / TERMS.tick_s)
        bounds = pattern.bounds()
        found = least_waits(pattern, bounds, period, TRIED)
        if found.moves_s:
            found = found if found.proven else least_waits(pattern, bounds, period)
            return MostTrains(trains, at_most, section_id, held_s, pattern, found)
        if found.impossible and at_most == trains and not one.goes_round:  # others may turn in another order
            at_most -= 1
        trains -= 1
    return MostTrains(0, at_most, section_id, held_s, one, None)


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
