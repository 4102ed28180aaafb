"""Many cases, one after the other, and what they come to in figures."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from tests.system.chaos.case import Case
from tests.system.chaos.families import Family
from tests.system.chaos.generator import case_of
from tests.system.chaos.replay import shrunk, slug, write
from tests.system.chaos.run_one import Outcome, outcome_of, undisturbed

LONG_S: Final = 10.0
KEPT: Final = 3
Seen = Callable[[Case, Outcome], bool]  # whether to go on


@dataclass(slots=True)
class Figures:
    """Sums over cases. `stopped_s`: time that trains stood beyond the undisturbed run, of each case that ended well."""

    runs: int = 0
    faults: int = 0
    acts: int = 0
    simulated_s: float = 0.0
    stopped_s: list[float] = field(default_factory=list[float])
    kinds: Counter[str] = field(default_factory=Counter[str])
    came: Counter[str] = field(default_factory=Counter[str])  # cases that came to what of `sometimes`
    seeds: dict[str, list[int]] = field(default_factory=lambda: defaultdict(list))

    @property
    def failed(self) -> int:
        """Cases that did not end well."""
        return self.runs - self.kinds["fine"]

    @property
    def stood(self) -> int:
        """Cases that ended well and in which trains stood for long beyond plan."""
        return sum(stopped_s > LONG_S for stopped_s in self.stopped_s)

    def __str__(self) -> str:
        """In one line."""
        stood_s = sorted(self.stopped_s) or [0.0]
        return (
            f"{self.runs} runs, {self.faults} faults, {self.acts} acts of staff, {self.simulated_s / 3600.0:.1f} h"
            f" simulated; stopped beyond plan {sum(stood_s) / 3600.0:.1f} h in all, {stood_s[len(stood_s) // 2]:.0f} s"
            f" in the middle run, {stood_s[-1]:.0f} s at most, {self.stood} runs over 10 s; {self.failed} failed"
            f" ({', '.join(f'{count} {kind}' for kind, count in self.kinds.most_common())})"
        )

    def by_kind(self) -> str:
        """A line for each kind of outcome, the most frequent first."""
        rows = self.kinds.most_common()
        return "".join(f"{count:6d}  {kind}  {_few(self.seeds[kind])}\n" for kind, count in rows)


def _few(seeds: list[int]) -> str:
    return "" if len(seeds) > 200 else f"seeds {', '.join(map(str, seeds[:12]))}"


def campaign(
    family: Family, seeds: Iterable[int], nets: Path, seen: Seen | None = None, *, swarm: bool = False
) -> Figures:
    """Run the cases of these seeds; `seen` is called after each, and ends them by False."""
    figures = Figures()
    for seed in seeds:
        case = case_of(family, seed, nets, swarm=swarm)
        outcome = outcome_of(case, nets)
        figures.runs += 1
        figures.faults += len(case.faults)
        figures.acts += len(outcome.acts) + len(case.acts)
        figures.simulated_s += outcome.simulated_s
        figures.kinds[outcome.kind] += 1
        figures.seeds[outcome.kind].append(seed)
        figures.came.update(outcome.came)
        if outcome.fine:
            planned_s = undisturbed(case.ground, nets)[1].stopped_s
            figures.stopped_s.append(max(0.0, outcome.stopped_s - planned_s))
        if seen is not None and not seen(case, outcome):
            break
    return figures


def none_fails(family: Family, seeds: range, nets: Path, found: Path, *, swarm: bool = False) -> Figures:
    """As `campaign`, of cases that all end well: the first that do not are made small and left below `found`."""
    written: list[Path] = []

    def keep(case: Case, outcome: Outcome) -> bool:
        if not outcome.fine and len(written) < KEPT:
            small, ended = shrunk(case, outcome.kind, nets)
            written.append(write(small, ended, found / slug(outcome.kind)))
        return True

    figures = campaign(family, seeds, nets, keep, swarm=swarm)
    assert not figures.failed, f"{figures}\n{figures.by_kind()}made small: {', '.join(map(str, written))}"
    return figures
