"""Units and devices that boot while people take their time, and parties whose durable state is lost: all arrive.

K1 is on the open line when the power fails; K2 is the next train, and would be granted the section in which K1 stands.
"""

from pathlib import Path
from typing import Any, Final

import pytest

from tests.nightly import others_nightly
from tests.system.chaos import run_one
from tests.system.chaos.case import Case
from tests.system.chaos.families import Family, ground_of
from tests.system.chaos.run_one import Outcome, Verdict
from tests.system.switchboard import SWITCHES

QUICK: Final = {"react": True, "power_s": 60.0, "points_s": 30.0, "picture_s": 20.0, "silent_s": 90.0}
LEAVES: Final = {"start": "train T1 departs A"}
UNIT_OFF: Final = {"kind": "power_off", "target": "K1", **LEAVES, "after_s": 23.0, "duration_s": 20.0}
MANAGER: Final = {"kind": "restart", "target": "block-manager", **LEAVES, "after_s": 24.0}


@pytest.fixture(scope="module")
def nets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("nets")


def two_trains(nets: Path, *faults: dict[str, Any], boot_s: float = 10.0, limit_s: float = 3600.0) -> Outcome:
    """Truthful people put right what they see; crews enter their numbers `boot_s` after a boot."""
    ground = ground_of(Family.TEST_LINE, 0)
    head = {"people": {"boot_s": boot_s, "sigma": 0.0, **QUICK}, "limits": {"time_limit_s": limit_s}}
    return run_one.outcome_of(Case("boots", ground, head, faults), nets)


PARTIES: Final = ("block-manager", "K1", "K2", "B-W", "A-E")
AGAIN: Final = UNIT_OFF | {"after_s": 50.0, "duration_s": 5.0}
BOOTS: Final[dict[str, tuple[dict[str, Any], ...]]] = {
    "both": (UNIT_OFF, MANAGER),
    "the unit alone": (UNIT_OFF,),
    "the unit twice": (UNIT_OFF, AGAIN, MANAGER),
    "the manager after it": (UNIT_OFF, MANAGER | {"after_s": 60.0}),
    "the manager before it": (UNIT_OFF | {"duration_s": 90.0}, MANAGER),
    "the manager twice": (UNIT_OFF, MANAGER, MANAGER | {"after_s": 55.0}),
}


@pytest.mark.parametrize("boots", others_nightly(BOOTS, ["both", "the unit twice"]))
@pytest.mark.parametrize("boot_s", others_nightly((10.0, 0.5, 45.0, 180.0), [10.0]))
def test_a_crew_that_comes_late_loses_nothing_but_time(boots: str, boot_s: float, nets: Path) -> None:
    outcome = two_trains(nets, *BOOTS[boots], boot_s=boot_s)
    assert outcome.fine, outcome.details


@pytest.mark.nightly
def test_a_crew_that_comes_after_half_an_hour_is_no_danger(nets: Path) -> None:
    """People speak for its train meanwhile, and nothing is broken by what they say."""
    outcome = two_trains(nets, UNIT_OFF, MANAGER, boot_s=1800.0)
    assert outcome.verdict in (Verdict.FINE, Verdict.NOT_ARRIVED), outcome.details


def test_a_unit_that_forgets_is_found_out_before_two_trains_meet(
    nets: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is in what nobody gave it; but for its empty claim the line is swept, and its sign-on stops the others."""
    SWITCHES["forgets_that_it_was_on_the_line"](monkeypatch)
    outcome = two_trains(nets, UNIT_OFF, MANAGER)
    assert outcome.kind.startswith("inside-holding")
    assert outcome.verdict is Verdict.BROKEN


# lost stores ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("after_s", others_nightly((30.0, -20.0, 1.0, 75.0), [30.0]))
@pytest.mark.parametrize("party", others_nightly(PARTIES, ["block-manager", "K1", "B-W"]))
def test_a_store_is_lost_at_any_time_and_people_commission_it_again(
    party: str, after_s: float, nets: Path
) -> None:
    start = {"start": "train T1 departs A", "after_s": after_s} if after_s > 0.0 else {"start": "09:59:40"}
    outcome = two_trains(nets, {"kind": "lost_store", "target": party, **start, "duration_s": 20.0})
    assert outcome.fine, outcome.details
    assert [act.kind.value for act in outcome.acts].count("commission") == 1


def test_all_stores_are_lost_at_once(nets: Path) -> None:
    lost = [
        {"kind": "lost_store", "target": party, **LEAVES, "after_s": 30.0, "duration_s": 20.0}
        for party in PARTIES
    ]
    outcome = two_trains(nets, *lost)
    assert outcome.fine, outcome.details


@pytest.mark.parametrize("party", others_nightly(["block-manager", "K1", "B-W"], ["K1"]))
def test_without_commissioning_the_summary_says_what_everybody_waits_for(
    party: str, nets: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simulation.duties.Duties.commission", lambda *_: None)
    monkeypatch.setattr("simulation.world.points.WaysideWorld.commission", lambda *_: None)
    lost = {"kind": "lost_store", "target": party, **LEAVES, "after_s": 20.0, "duration_s": 20.0}
    outcome = two_trains(nets, lost, limit_s=600.0)
    assert any("people must commission it" in text for text in outcome.details), outcome.details
