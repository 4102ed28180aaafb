"""The null method of every reproduction, run by itself on a short slice: it misses what the idea meets."""

from typing import Final

import pytest

from papers import trainruns, ttobench
from papers.reference_data import BESIDE
from papers.reproduction import Options
from papers.specification import REPRODUCTIONS, reproduction
from tests.nightly import others_nightly
from vehicle.compiled import INTERPRETED

# Whole days of a line, hundreds of runs or stops, scans.
LONG: Final = {
    *("line-stops", "line-driving", "battery-day", "virtual-blocks", "stop-window", "harada-accuracy"),
    *("oda-scale-track", "yasunobu-energy", "stop-statistics", "journeys"),
    *("position-compare", "position-fusion", "position-operations", "mochizuki-patterns", "mochizuki-speed"),
}
READS: Final = {"trainruns": trainruns.FOLDER, "ttobench": ttobench.FOLDER}


@pytest.mark.skipif(INTERPRETED, reason="thousands of stops, and scans")
@pytest.mark.parametrize("name", others_nightly(sorted(REPRODUCTIONS), set(REPRODUCTIONS) - LONG))
def test_it_misses_every_criterion_that_it_must(name: str) -> None:
    if name in READS and not (BESIDE / READS[name]).is_dir():
        pytest.skip(f"reference data {READS[name]} absent")
    null = reproduction(name).null
    judged = [row for row in null.run(Options(quick=True)) if row.case.endswith(null.fails)]
    assert all(any(row.case.endswith(end) for row in judged) for end in null.fails)
    assert [row.case for row in judged if row.passed] == []
