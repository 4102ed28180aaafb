"""Each role killed with -9 and started again at many points over Zenoh: the run is the one without processes."""

from __future__ import annotations

import os
from pathlib import Path

import psutil
import pytest

from network.clock import clock
from scenario.scenario import load_scenario
from study.runner.run import CarrierKind, PartyLink, UnitsAt, execute
from tests.nightly import others_nightly
from wayside.config import MANAGER_ID

pytestmark = pytest.mark.system

POINTS = 20
FROM_S, EVERY_S = 36_000, 15
ROLES = {"manager": MANAGER_ID, "terminal": "A-E", "unit": "K1"}
CASES = [(role, number) for role in ROLES for number in range(POINTS)]
SLICE = [(role, 5) for role in ROLES]


@pytest.mark.parametrize("case", others_nightly(CASES, SLICE))
def test_a_party_killed_at_any_point_leaves_nothing_and_the_day_ends(
    case: tuple[str, int], tmp_path: Path
) -> None:
    role, number = case
    file = tmp_path / "killed.toml"
    at = clock(FROM_S + EVERY_S * number)
    file.write_text(
        f'extends = "rtri_test_line"\nid = "killed"\nname = "killed"\ntimetable = "rtri_two_trains"\n'
        f'[people]\nreact = true\n[[fault]]\nkind = "restart"\ntarget = "{ROLES[role]}"\nstart = "{at}"\n',
        "utf-8",
    )
    alone = execute(load_scenario(str(file)), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
    apart = execute(
        load_scenario(str(file)), PartyLink.ZENOH, units=UnitsAt.PROCESSES, carrier=CarrierKind.PLAIN
    )
    assert not apart.failures
    assert apart.result.digest == alone.result.digest
    assert [
        child.name() for child in psutil.Process(os.getpid()).children() if "serve" in child.cmdline()
    ] == []
