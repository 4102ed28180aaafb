"""Swarms: cases that leave out half of what could fail, with a fault a minute at least, and all that they come to."""

from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Final

import pytest

from simulation.faults.table import FAULTS
from tests.nightly import others_nightly
from tests.system.chaos.campaign import none_fails
from tests.system.chaos.families import Family
from tests.system.chaos.generator import FAULTS_MAX, case_of
from tests.system.chaos.sometimes import ALL, come_to

SLICE: Final = ((Family.TEST_LINE, 0, 3),)
CHUNKS: Final = (
    *((Family.TEST_LINE, *chunk) for chunk in pairwise(range(0, 1001, 250))),
    (Family.HOUR, 0, 60),
    (Family.LINES, 0, 100),
    (Family.WIDE, 0, 100),
)


@pytest.mark.parametrize("chunk", others_nightly((*SLICE, *CHUNKS), SLICE))
def test_swarms_end_well(chunk: tuple[Family, int, int], nets: Path, tmp_path: Path) -> None:
    family, low, high = chunk
    none_fails(family, range(low, high), nets, tmp_path, swarm=True)


@pytest.mark.nightly
def test_swarms_come_to_everything_that_is_meant(nets: Path, tmp_path: Path) -> None:
    parts = (Family.TEST_LINE, 300), (Family.HOUR, 40), (Family.CROSSINGS, 60), (Family.WIDE, 150)
    came = Counter[str]()
    for family, count in parts:
        came += none_fails(family, range(count), nets, tmp_path, swarm=True).came
    assert [name for name in ALL if not came[name]] == []


def test_a_case_that_nothing_happens_in_comes_to_nothing() -> None:
    assert come_to(()) == frozenset()


def test_a_swarm_leaves_half_out_and_has_a_fault_a_minute(nets: Path) -> None:
    cases = [case_of(Family.TEST_LINE, seed, nets, swarm=True) for seed in range(8)]
    kinds = [{FAULTS[str(fault["kind"])].changes for fault in case.faults} for case in cases]
    everything = set().union(*kinds)
    assert all(len(some) <= len(everything) // 2 + 1 for some in kinds)
    assert all(len(case.faults) <= FAULTS_MAX for case in cases)
    assert sum(len(case.faults) for case in cases) >= 5 * len(cases), "windows of half a minute to six"
