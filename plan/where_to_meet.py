"""Where one or two more loops shorten the least interval of a line most: every choice worked out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from network.errors import InputError
from network.model import Line
from plan.least_interval import AS_UNITS_ASK, LeastInterval, least_interval
from plan.moving.refutation import TooManyCasesError
from simulation.setup import Setup
from study.capacity.rules import Rules


@dataclass(frozen=True, slots=True)
class LoopChoice:
    """Loops laid at halts, and the least interval with them; `why_not` where they cannot be laid or nothing runs."""

    loops: tuple[str, ...]
    setup: Setup | None
    found: LeastInterval | None
    why_not: str = ""

    @property
    def rank(self) -> tuple[float, float, int, tuple[str, ...]]:
        """The best first: the least interval, then the least waits, then the fewest loops."""
        if self.found is None or self.found.interval_s is None:
            return float("inf"), 0.0, len(self.loops), self.loops
        return self.found.interval_s, self.found.waits_s, len(self.loops), self.loops


def halts_of(line: Line) -> tuple[str, ...]:
    """Where a loop could be laid, along the line."""
    stations = sorted(line.stations.values(), key=lambda station: station.position_m)
    return tuple(station.id for station in stations if station.is_halt)


def laying(loops: Sequence[str]) -> dict[str, Any]:
    """The tables of a scenario that lay loops at halts."""
    return {"patch": {"line": {"add_loops": list(loops)}}} if loops else {}


def loop_choices(
    with_loops: Callable[[Sequence[str]], Setup], halts: Iterable[str], most: int, rules: Rules = AS_UNITS_ASK
) -> list[LoopChoice]:
    """All choices of no more than so many loops, the best first. `with_loops`: the line with loops at these halts."""
    at = tuple(halts)
    return sorted(
        (_choice(with_loops, loops, rules) for count in range(most + 1) for loops in combinations(at, count)),
        key=lambda choice: choice.rank,
    )


def _choice(with_loops: Callable[[Sequence[str]], Setup], loops: tuple[str, ...], rules: Rules) -> LoopChoice:
    try:
        setup = with_loops(loops)
        return LoopChoice(loops, setup, least_interval(setup, rules))
    except TooManyCasesError:
        raise
    except InputError as error:
        return LoopChoice(loops, None, None, str(error))
