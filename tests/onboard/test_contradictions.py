"""Register and unit contradict each other, and what must be swept: what the train does, by its unit and brakes."""

import math

import pytest
from msgspec.structs import replace

from onboard.authority.records import Authority, RequestKind
from onboard.duty.machine import step
from onboard.duty.records import DutyPhase, FoundByOtherSensor, SwitchedOn
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_MOVING,
    EVENT_STOPPED,
    MODE_DRIVE,
    MODE_HOLD,
    NO_INTERVENTION,
)
from onboard.unit_records import UnitParameters
from radio.messages import (
    Claim,
    ClaimQuery,
    Contested,
    HoldingConfirmed,
    HoldingReport,
    RefusalReason,
    RouteGranted,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)
from tests.onboard.duty.stage import NOW_S, ON_6, ON_SIGHT, PLAN, TIMES, moved
from tests.onboard.unit_bench import DEPARTURE_S, LEAD_S, MANAGER, SECTIONS, TOKEN, Bench, capabilities, proof

# contradictions -------------------------------------------------------------------------------------------------


def check_braked_until_agreed(bench: Bench) -> None:
    """Each of its reports gets an answer; it moves again only after the one that has all and nothing contested."""
    assert bench.row.intervention == EMERGENCY_INTERVENTION
    assert bench.row.mode == MODE_HOLD
    bench.row.speed_mps = 0.0
    bench.ticked(EVENT_STOPPED)
    for answer in (HoldingConfirmed(("5", "6"), TOKEN), HoldingConfirmed(bench.held, TOKEN, ("7",))):
        bench.hear(MANAGER, answer)
        bench.at(bench.now_s + UnitParameters().emergency_release_s)
        assert HoldingReport(bench.held, TOKEN) in bench.said  # again, until it is over
        assert bench.row.intervention == EMERGENCY_INTERVENTION
        assert bench.row.mode == MODE_HOLD
    bench.hear(MANAGER, HoldingConfirmed(bench.held, TOKEN))
    assert "agreed" in bench.notes
    bench.at(bench.now_s + UnitParameters().emergency_release_s)
    assert bench.row.intervention == NO_INTERVENTION
    assert bench.row.mode == MODE_DRIVE


def test_a_train_whose_section_another_claims_is_braked_until_that_is_over(running: Bench) -> None:
    running.hear(MANAGER, Contested(("7",)))
    assert "mismatch" in running.notes
    assert running.held == SECTIONS  # what the tags read so far prove to be behind is given back first
    assert running.said[-1] == HoldingReport(SECTIONS, TOKEN)
    check_braked_until_agreed(running)


def test_a_train_whose_claim_is_refused_is_braked_until_that_is_over(running: Bench) -> None:
    running.hear(MANAGER, ClaimQuery())
    assert running.said == [Claim(running.held, TOKEN)]
    running.hear(MANAGER, SignOnRefused(RefusalReason.HELD, "7", "K2"))
    assert running.held == SECTIONS  # what the tags read so far prove to be behind is given back first
    assert running.said[-1] == HoldingReport(SECTIONS, TOKEN)
    check_braked_until_agreed(running)


def test_a_train_on_sight_whose_claim_is_refused_is_braked_until_it_is_signed_on(running: Bench) -> None:
    """Neither side knew; a tag told it where it is; the manager has that for another."""
    running.unit = running.boot(2)
    running.motion.switch_on(running.mission, running.path, 0.0, 0.0)
    running.row.speed_mps = 0.0
    running.tell([SwitchedOn(running.plan, None)])
    running.hear(MANAGER, SignOnRefused(RefusalReason.CLAIM_NEEDED))
    assert "mismatch" not in running.notes
    running.at(running.now_s + UnitParameters().emergency_release_s)
    assert running.row.intervention == NO_INTERVENTION
    running.row.speed_mps = 3.0
    running.ticked(EVENT_MOVING)
    running.read(602)
    claim = running.said[-1]
    assert isinstance(claim, SignOn)
    assert claim.section_ids
    running.hear(MANAGER, SignOnRefused(RefusalReason.HELD, claim.section_ids[0], "K2"))
    assert "mismatch" in running.notes
    assert (running.row.intervention, running.row.mode) == (EMERGENCY_INTERVENTION, MODE_HOLD)
    running.row.speed_mps = 0.0
    running.ticked(EVENT_STOPPED)
    running.at(running.now_s + UnitParameters().emergency_release_s)
    assert running.row.intervention == EMERGENCY_INTERVENTION  # standing does not end it
    assert running.said[-1] == claim  # said again
    running.hear(MANAGER, SignOnAccepted(claim.section_ids, TOKEN, None, ()))
    assert "agreed" in running.notes
    running.at(running.now_s + UnitParameters().emergency_release_s)
    assert running.row.intervention == NO_INTERVENTION


def test_a_train_that_disagrees_does_not_leave(granted: Bench) -> None:
    granted.hear("A-E", proof("P5"))
    granted.hear(MANAGER, Contested(("7",)))
    granted.at(DEPARTURE_S + 1.0)
    assert granted.phase is DutyPhase.STANDING
    assert granted.waits_for == "agreement with the block manager: contested: 7"
    granted.hear(MANAGER, HoldingConfirmed(granted.held, TOKEN))
    assert granted.phase is DutyPhase.RUNNING
    granted.at(granted.now_s + UnitParameters().emergency_release_s)
    assert granted.row.mode == MODE_DRIVE


# what must be swept ---------------------------------------------------------------------------------------------


def test_what_must_be_swept_it_passes_on_sight_and_says_so(bench: Bench) -> None:
    bench.at(DEPARTURE_S - LEAD_S)
    bench.hear(MANAGER, RouteGranted("3>8", SECTIONS, TOKEN, capabilities(), ("6",)))
    bench.hear("A-E", proof("P5"))
    assert bench.row.restricted_mps == pytest.approx(15.0 / 3.6)  # it stands, and begins on sight
    bench.at(DEPARTURE_S)
    assert bench.phase is DutyPhase.RUNNING
    assert bench.row.stop_limit_m == pytest.approx(520.0)
    bench.row.speed_mps = 4.0
    bench.ticked(EVENT_MOVING)
    for tag_id in (601, 602):
        bench.read(tag_id)
    bench.hear("B-W", proof("P7"))
    bench.read(801)
    assert bench.said == [HoldingReport(("8",), TOKEN, ("6",))]
    assert bench.row.restricted_mps == math.inf


def test_what_must_be_swept_is_not_entered_at_speed(running: Bench) -> None:
    """Told on its way, by the answer to a claim: it stops before the section, then sweeps it."""
    running.row.position_m = 150.0
    running.hear(MANAGER, SignOnAccepted(running.held, TOKEN, None, (), ("6",)))
    assert running.row.stop_limit_m == pytest.approx(170.0)
    assert running.row.restricted_mps == math.inf
    running.stop(165.0)
    assert running.row.stop_limit_m == pytest.approx(520.0)
    assert running.row.restricted_mps == pytest.approx(15.0 / 3.6)


@pytest.mark.parametrize(("sure", "claims"), [(3, ("6",)), (2, None)])
def test_found_surely_in_what_it_does_not_hold_it_stops_and_claims_that(
    sure: int, claims: tuple[str, ...] | None
) -> None:
    """It holds 3 and 5; its front is in 6, or may be."""
    lost = replace(ON_SIGHT, authority=Authority(held=("3", "5"), commandable=("5",), on_line=True))
    place = moved(ON_6, here=sure - 1, sure=sure, clear=sure - 1)
    state, _ = step(PLAN, TIMES, lost, FoundByOtherSensor(), place, NOW_S)
    asked = state.authority.open(RequestKind.SIGN_ON)
    assert (None if asked is None else asked.section_ids) == claims
    assert state.halted is (claims is not None)
