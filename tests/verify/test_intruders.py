"""An intruder on the air: no effect, each telegram counted; without codes he has one."""

import pytest

from radio.envelope import DropReason
from tests.nightly import others_nightly
from tests.system import switches_radio  # noqa: F401 - they enter themselves
from tests.system.switchboard import SWITCHES
from tests.system.switches_radio import lets_pass
from verify.evidence.inside_runs import load
from verify.evidence.intruders import ATTACKS, THREATS, Attack, intruded

SLICE = "rtri_test_line"
SCENARIOS = (SLICE, "rtri/06_unit_manager_link", "karasuyama_weekday")
ALLOWED = {attack: {r.value for r in threat.reasons} for threat in THREATS for attack in threat.attacks}


@pytest.mark.parametrize("scenario", others_nightly(SCENARIOS, [SLICE]))
def test_an_intruder_has_no_effect(scenario: str) -> None:
    for found in intruded(load(scenario), 7, tuple(ATTACKS)):
        assert found.held, found
        assert set(found.dropped) <= ALLOWED[found.attack]


@pytest.mark.parametrize("attack", [Attack.MASQUERADE, Attack.MASQUERADE_WITH_KEYS])
def test_without_codes_he_has(attack: Attack, monkeypatch: pytest.MonkeyPatch) -> None:
    SWITCHES["believes_any_code"](monkeypatch)
    (found,) = intruded(load(SLICE), 1, (attack,))
    assert not found.held


@pytest.mark.parametrize(
    ("attack", "reason"),
    [(Attack.REPETITION, DropReason.REPEATED), (Attack.DELAY, DropReason.STALE)],
)
def test_without_its_check_a_telegram_passes(
    attack: Attack, reason: DropReason, monkeypatch: pytest.MonkeyPatch
) -> None:
    lets_pass(monkeypatch, reason, DropReason.REPEATED)
    (found,) = intruded(load(SLICE), 1, (attack,))
    assert not found.held
