"""How many random cases it takes to find a planted defect: that random runs find nothing says only so much."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.system.chaos.families import Family
from tests.system.chaos.generator import case_of
from tests.system.chaos.run_one import outcome_of
from tests.system.switchboard import Switch


@dataclass(frozen=True, slots=True)
class Found:
    """The case that found it, after so many that did not. It ends well without the defect."""

    runs: int
    seed: int
    kind: str


def found_by(switch: Switch, family: Family, seeds: Iterable[int], nets: Path) -> Found | None:
    """The first case that ends well, and does not where the behaviour is taken away."""
    for runs, seed in enumerate(seeds, 1):
        case = case_of(family, seed, nets)
        with pytest.MonkeyPatch.context() as patch:
            switch(patch)
            outcome = outcome_of(case, nets)
        if not outcome.fine and outcome_of(case, nets).fine:
            return Found(runs, seed, outcome.kind)
    return None
