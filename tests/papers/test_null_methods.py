"""The null method of every reproduction, run by itself on a short slice: it misses what the idea meets."""

from __future__ import annotations

from typing import Final

import pytest

from papers.reproduction import REPRODUCTIONS, Options, reproduction
from papers.specification import Specification
from vehicle.compiled import INTERPRETED

# whole days of a line or hundreds of runs
LONG: Final = {"line-stops", "position-fusion", "position-operations"}
SPECIFIED: Final = [
    pytest.param(found, id=name, marks=[pytest.mark.nightly] if name in LONG else [])
    for name in sorted(REPRODUCTIONS)
    if isinstance(found := reproduction(name), Specification)
]


@pytest.mark.skipif(INTERPRETED, reason="thousands of stops, and scans")
@pytest.mark.parametrize("specification", SPECIFIED)
def test_it_misses_every_criterion_that_it_must(specification: Specification) -> None:
    null = specification.null
    judged = [row for row in null.run(Options(quick=True)) if row.case.endswith(null.fails)]
    assert all(any(row.case.endswith(end) for row in judged) for end in null.fails)
    assert [row.case for row in judged if row.passed] == []
