"""A run with parties on other machines: the same run."""

from __future__ import annotations

from pathlib import Path

import pytest

from host.certificates import make_certificates
from scenario.scenario import load_scenario
from study.runner.devices import party_ids_of
from study.runner.run import CarrierKind, PartyLink, UnitsAt, execute
from tests.host.far_parties import ADDRESS, Machines
from tests.nightly import others_nightly

pytestmark = pytest.mark.system

SOME = ("block-manager", "B-E", "K1")
EVERY = ()


@pytest.mark.parametrize("elsewhere", others_nightly([SOME, EVERY], [SOME]))
def test_a_run_with_parties_elsewhere_is_the_same_to_the_byte(
    tmp_path: Path, elsewhere: tuple[str, ...]
) -> None:
    scenario = load_scenario("rtri_test_line")
    here = execute(scenario, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
    ids = party_ids_of(scenario.setup)
    assert set(SOME) < set(ids)
    make_certificates(tmp_path / "made", ids, ADDRESS)
    with Machines(tmp_path / "made", elsewhere or ids) as machines:
        far = execute(
            scenario,
            PartyLink.ZENOH,
            units=UnitsAt.PROCESSES,
            carrier=CarrierKind.PLAIN,
            elsewhere=machines.elsewhere,
        )
        assert [machines.ended(name) for name in machines.started] == [(0, "")] * len(elsewhere or ids)
    assert far.result.journal.to_bytes() == here.result.journal.to_bytes()
    assert far.result.digest == here.result.digest
