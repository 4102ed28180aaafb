"""A search for a run in which the truth leaves the bounds that its unit states: by places, sizes and joint faults.

A candidate is a run of `papers.joint_faults`: its line, tags, wheels and rails as drawn by a number, and faults of the
sensors that it carries, each within its sensor's contract (`papers.joint_faults.FAILS`). The search keeps those
that come nearest to their bounds, and changes what fails, where, for how long and by how much; most often it moves a
fault to where another one, or a slippery stretch, begins or ends. All is drawn from the seed; each run is counted.

How near: the greatest error as a share of the bound on its side, while that spans metres; beyond them, metres.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from papers.fusion_runs import FusionRule, draw, run_of
from papers.joint_faults import FAILS, MOST, carried_in, rule_of, trouble, troubles_of
from papers.position_run import PositionResult, in_motion
from papers.position_sets import Trouble, moments_of, path_of_run
from radio.chance import generator
from simulation.faults.fault import InForce

KEPT: Final = 12
FRESH_SHARE: Final = 0.3  # of the candidates: drawn anew
TOGETHER_SHARE: Final = 0.6  # of the changes: a fault is moved to where something else begins or ends
NEAR_M: Final = 60.0
BOUND_MIN_M: Final = 2.0  # a bound below it is that of a train that has just read a tag
SHORT_LINE: Final = "rtri_test_line"
LASTS_M: Final = (50.0, 3000.0)


@dataclass(frozen=True, slots=True)
class Candidate:
    """A run that is drawn by a number, and what fails in it."""

    number: int
    troubles: tuple[Trouble, ...]


@dataclass(frozen=True, slots=True)
class TriedRun:
    """A candidate and what came of it. `out_m`: by how much the truth was out at worst; > 0: the bounds are broken."""

    candidate: Candidate
    out_m: float
    near: float

    @property
    def broken(self) -> bool:
        """Whether the truth left the bounds."""
        return not self.out_m <= 0.0


@dataclass(slots=True)
class Searched:
    """What a search found. `nearest`: the best of all; `broken`: those outside, as found."""

    runs: int
    nearest: TriedRun | None
    broken: list[TriedRun]


def search(
    seed: int,
    runs: int,
    rule: FusionRule,
    *,
    until_broken: bool = False,
    anywhere: bool = False,
    watch: Callable[[int, TriedRun], None] = lambda _count, _best: None,
) -> Searched:
    """So many runs; with `until_broken` only until the first outside. `anywhere`: on long lines too."""
    chance = generator(seed, "falsifier")
    kept, found = list[TriedRun](), Searched(0, None, [])
    numbers = _Numbers(seed, anywhere=anywhere)
    while found.runs < runs and not (until_broken and found.broken):
        fresh = len(kept) < KEPT or chance.random() < FRESH_SHARE
        candidate = (
            numbers.fresh() if fresh else changed(chance, kept[chance.integers(len(kept))].candidate, seed)
        )
        tried = try_out(seed, candidate, rule)
        found.runs += 1
        if tried.broken:
            found.broken.append(tried)
        kept = sorted([*kept, tried], key=lambda one: (-one.near, one.candidate.number))[:KEPT]
        found.nearest = kept[0]
        watch(found.runs, kept[0])
    return found


class _Numbers:
    """The numbers of runs on the lines that are searched, one after another."""

    def __init__(self, seed: int, *, anywhere: bool) -> None:
        self._seed: Final = seed
        self._anywhere: Final = anywhere
        self._next = 0

    def fresh(self) -> Candidate:
        while True:
            number, self._next = self._next, self._next + 1
            drawn = draw(self._seed, number)
            if self._anywhere or drawn.scenario == SHORT_LINE:
                length_m = path_of_run(drawn.setup).length_m
                return Candidate(number, tuple(troubles_of(self._seed, number, length_m)))


def try_out(seed: int, candidate: Candidate, rule: FusionRule) -> TriedRun:
    """Let a candidate run."""
    drawn = draw(seed, candidate.number)
    run, force = run_of(drawn, rule_of(candidate.number, rule)), InForce()
    stock_id = drawn.setup.timetable.diagrams[0].stock_id
    for key, failing in enumerate(candidate.troubles):
        run.at(moments_of(failing, stock_id, key, force))
    result = run.run()
    return TriedRun(
        candidate, result.out_m, result.out_m if not result.out_m <= 0.0 else nearness(result) - 1.0
    )


def nearness(result: PositionResult) -> float:
    """The greatest error as a share of the bound on its side."""
    seen = in_motion(result.trace[result.stated])
    shares = [0.0]
    for side, bound_m in ((-1.0, seen["bound_ahead_m"]), (1.0, seen["bound_behind_m"])):
        wide = bound_m > BOUND_MIN_M
        shares += (side * seen["estimate_error_m"][wide] / bound_m[wide]).tolist()
    return min(1.0, max(shares))


def changed(chance: np.random.Generator, candidate: Candidate, seed: int) -> Candidate:
    """The same run with one thing about its faults changed."""
    drawn, troubles = draw(seed, candidate.number), list(candidate.troubles)
    length_m = path_of_run(drawn.setup).length_m
    kinds = [
        (kind, fill) for one in carried_in(candidate.number) for kind, fill in FAILS.get(one, {}).items()
    ]
    if kinds and (not troubles or (len(troubles) < MOST and chance.random() < 0.2)):
        troubles.append(trouble(chance, kinds, LASTS_M, length_m))
    at = int(chance.integers(len(troubles))) if troubles else -1
    if at < 0:
        return candidate
    one = troubles[at]
    if chance.random() < TOGETHER_SHARE:
        places_m = [m for s in drawn.stretches for m in (s.from_m, s.to_m)]
        places_m += [m for other in troubles if other is not one for m in (other.from_m, other.to_m)]
        from_m = float(chance.choice(places_m)) if places_m else float(chance.uniform(0.0, length_m))
        from_m += float(chance.normal(0.0, NEAR_M))
    else:
        from_m = one.from_m + float(chance.normal(0.0, NEAR_M))
    from_m = min(max(from_m, 0.0), length_m)
    lasts_m = float(np.clip((one.to_m - one.from_m) * np.exp(chance.normal(0.0, 0.4)), *LASTS_M))
    fill = dict(kinds).get(one.kind)
    keys: Mapping[str, float] = one.keys
    if fill is not None and chance.random() < 0.5:
        keys = fill(chance)
    troubles[at] = replace(one, from_m=from_m, to_m=min(from_m + lasts_m, length_m), keys=keys)
    if len(troubles) > 1 and chance.random() < 0.1:
        del troubles[int(chance.integers(len(troubles)))]
    return Candidate(candidate.number, tuple(troubles))


def in_words(seed: int, tried: TriedRun) -> list[str]:
    """What is out of order in a candidate, a line for each: sensors, and the rail."""
    slippery = [
        f"slippery from {s.from_m:.0f} m to {s.to_m:.0f} m, {s.share:.2f} of the dry rail"
        for s in draw(seed, tried.candidate.number).stretches
    ]
    return slippery + [
        f"{failing.kind} from {failing.from_m:.0f} m to {failing.to_m:.0f} m"
        + "".join(f", {name} {value:.3g}" for name, value in failing.keys.items())
        for failing in tried.candidate.troubles
    ]
