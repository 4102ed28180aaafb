"""A run with parties on other machines: the same run."""

from pathlib import Path

import pytest

from host.certificates import make_certificates
from study.runner.devices import party_ids_of
from study.runner.run import CarrierKind, PartyLink, UnitsAt, execute
from tests.host.far_parties import ADDRESS, Machines
from tests.nightly import others_nightly
from verify.evidence.inside_runs import load

SOME = ("block-manager", "B-E", "K1")
SLICE = ("rtri_test_line", SOME)
RUNS = (SLICE, ("rtri_test_line", ()), ("rtri/16a_manager_store_lost", ()), ("rtri/16b_unit_store_lost", ()))


@pytest.mark.parametrize(("scenario", "elsewhere"), others_nightly(RUNS, [SLICE], columns=True))
def test_a_run_with_parties_elsewhere_is_the_same_to_the_byte(
    tmp_path: Path, scenario: str, elsewhere: tuple[str, ...]
) -> None:
    """All of them where none is named, and with power cuts and lost stores."""
    loaded = load(scenario)
    here = execute(loaded, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
    ids = party_ids_of(loaded.setup)
    assert set(SOME) < set(ids)
    make_certificates(tmp_path / "made", ids, ADDRESS)
    with Machines(tmp_path / "made", elsewhere or ids) as machines:
        far = execute(
            loaded,
            PartyLink.ZENOH,
            units=UnitsAt.PROCESSES,
            carrier=CarrierKind.PLAIN,
            elsewhere=machines.elsewhere,
        )
        assert [machines.ended(name) for name in machines.started] == [(0, "")] * len(elsewhere or ids)
    assert far.result.journal.to_bytes() == here.result.journal.to_bytes()
    assert far.result.digest == here.result.digest
