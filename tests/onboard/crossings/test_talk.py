"""What a unit takes from a level crossing's telegrams: answers to what it has said now, and nothing older."""

import math

import pytest
from msgspec.structs import replace

from onboard.crossings.machine import CrossingPlace
from onboard.crossings.talk import CrossingTalk
from onboard.duty.records import DutyPhase, DutyState, StopLimit
from radio.envelope import Received
from radio.messages import (
    AnyMessage,
    CrossingOver,
    CrossingOverHeard,
    CrossingProof,
    CrossingRequest,
    Restarted,
)

RUNS = DutyState(phase=DutyPhase.RUNNING, limit=StopLimit(3, None, "end of the path"))
NEAR = CrossingPlace("C", 2, 0, 35.0, 15.0, 15.0, arrives_s=40.0, fastest_s=32.0, proof_s=28.0)
PROOF = CrossingProof(True, 12.0)


def heard(message: AnyMessage, correlation: int, *, fresh: bool = True) -> Received:
    return Received("C", 1, 1, fresh, correlation, 0.0, None, 0, message)


def asked() -> CrossingTalk:
    """A unit that has asked once, under correlation 1."""
    talk = CrossingTalk(forgot=False)
    talk.look((NEAR,), RUNS, math.inf, 0.0)
    assert [(each.message, each.correlation) for each in talk.letters] == [(CrossingRequest(40.0, 28.0), 1)]
    return talk


@pytest.mark.parametrize(
    ("correlation", "fresh", "held"), [(1, True, ""), (0, True, "C"), (2, True, "C"), (1, False, "C")]
)
def test_only_the_answer_to_its_own_request_is_a_proof(correlation: int, fresh: bool, held: str) -> None:
    talk = asked()
    assert talk.held_before(1.0) == "C"
    assert talk.hear(heard(PROOF, correlation, fresh=fresh), 1.0)
    assert talk.held_before(1.0) == held


def test_announced_anew_it_takes_no_proof_of_before() -> None:
    """Off its path it gives the crossing up; on it again, the old answer comes late."""
    talk = asked()
    talk.look((), RUNS, math.inf, 10.0)
    assert talk.hear(heard(CrossingOverHeard(), 1), 11.0)
    talk.look((NEAR,), RUNS, math.inf, 20.0)
    assert talk.hear(heard(PROOF, 1), 21.0)
    assert talk.held_before(21.0) == "C"
    assert talk.hear(heard(PROOF, 2), 22.0)
    assert talk.held_before(22.0) == ""


@pytest.mark.parametrize(
    ("state", "stop"),
    [
        (replace(RUNS, limit=StopLimit(2, "6", "not held")), 0),  # its way ends before the crossing's section
        (RUNS, 1),  # it has yet to call at a stop before the crossing
        (replace(RUNS, phase=DutyPhase.FINISHED), 0),
        (replace(RUNS, halted=True), 0),
    ],
)
def test_a_train_that_does_not_come_there_yet_asks_nothing_and_may_not_pass(
    state: DutyState, stop: int
) -> None:
    talk = CrossingTalk(forgot=False)
    talk.look((replace(NEAR, stop=stop),), state, math.inf, 0.0)
    assert talk.letters == []
    assert talk.held_before(0.0) == "C"


def test_it_comes_to_a_crossing_before_a_stop_at_which_it_was_counted_as_arrived_too_early() -> None:
    talk = CrossingTalk(forgot=False)
    talk.look((NEAR,), replace(RUNS, at=1), math.inf, 0.0)
    assert [each.message for each in talk.letters] == [CrossingRequest(40.0, 28.0)]


def test_a_unit_that_has_lost_its_position_on_a_crossing_does_not_take_itself_to_be_on_it_for_ever() -> None:
    """It comes another time, and needs a proof again."""
    on_it = replace(NEAR, arrives_s=0.0, fastest_s=0.0, proof_s=0.0, entered=True, under=True)
    talk = asked()
    talk.hear(heard(PROOF, 1), 1.0)
    talk.look((on_it,), RUNS, math.inf, 2.0)
    assert talk.held_before(2.0) == ""
    talk.look(None, RUNS, math.inf, 3.0)
    talk.look((replace(on_it, under=False, stands=True),), RUNS, math.inf, 60.0)
    assert talk.held_before(60.0) == "C"


def test_a_unit_that_has_given_a_crossing_up_says_so_again_without_its_position() -> None:
    talk = asked()
    talk.look((), RUNS, math.inf, 10.0)
    talk.letters.clear()
    talk.look(None, RUNS, math.inf, 12.0)
    assert [each.message for each in talk.letters] == [CrossingOver(False)]


def test_booted_it_hears_that_a_crossing_does_not_wait_for_it() -> None:
    """One that it may have asked before its boot, and has not asked since: far ahead, it ends no way any more."""
    far = replace(NEAR, arrives_s=math.inf, fastest_s=80.0, proof_s=math.inf, stands=True)
    talk = CrossingTalk(forgot=True)
    talk.look((far,), RUNS, math.inf, 0.0)
    assert [each.message for each in talk.letters] == [CrossingOver(False)]
    assert talk.held_before(0.0) == "C"
    assert talk.hear(heard(CrossingOverHeard(), talk.letters[0].correlation), 0.5)
    assert talk.held_before(0.5) == ""
    talk.letters.clear()
    talk.look((far,), RUNS, math.inf, 60.0)
    assert talk.letters == []


def test_nobody_asks_for_leave_to_creep_over_a_crossing_that_is_proven_and_has_but_to_be_so_for_its_time() -> (
    None
):
    at_road = replace(NEAR, arrives_s=5.0, fastest_s=3.0, proof_s=0.0, stands=True)
    talk = asked()
    talk.look((at_road,), RUNS, math.inf, 30.0)
    assert talk.kept_standing_by(30.0) == "C"
    talk.hear(heard(PROOF, 1), 31.0)
    assert talk.held_before(31.0) == "C"
    assert talk.kept_standing_by(31.0) == ""


def test_a_road_far_ahead_ends_nothing_but_what_a_unit_that_acts_no_more_may_run() -> None:
    talk = CrossingTalk(forgot=False)
    talk.look((replace(NEAR, arrives_s=200.0, fastest_s=80.0, proof_s=190.0),), RUNS, math.inf, 0.0)
    assert talk.held_before(0.0) == ""
    assert talk.guarded(0.0) == "C"
    near = asked()
    near.hear(heard(PROOF, 1), 1.0)
    assert near.guarded(1.0) == ""


def test_of_two_roads_that_are_proven_it_looks_at_the_second_wherever_it_is() -> None:
    """Proven to 14.5 s and 15.5 s, it is there at 9 s and 10 s: at 12.5 s it looks if it is not on the first."""
    roads = [replace(NEAR, crossing_id=id_, least_s=0.0, fastest_s=1.0, proof_s=-1.0) for id_ in "CD"]
    talk = CrossingTalk(forgot=False)
    talk.look(roads, RUNS, math.inf, 0.0)
    for at, valid_s in (("C", 14.5), ("D", 15.5)):
        talk.hear(replace(heard(CrossingProof(True, valid_s), 1), source=at), 0.0)
    talk.look([replace(road, arrives_s=9.0 + n) for n, road in enumerate(roads)], RUNS, math.inf, 0.0)
    assert talk.proof_ends(0.0) == (12.5, "C")
    assert talk.wake_s(0.0, "C") == 13.5
    assert talk.wake_s(0.0, "") == 12.5


def test_at_a_stop_the_time_counts_from_its_departure() -> None:
    """It leaves in 1 s: 41 s are just in time to ask."""
    talk = CrossingTalk(forgot=False)
    standing = replace(RUNS, phase=DutyPhase.STANDING)
    talk.look((replace(NEAR, stands=True),), standing, 4.0, 0.0)
    assert talk.letters == []
    talk.look((replace(NEAR, stands=True),), standing, 1.0, 3.0)
    assert [each.message for each in talk.letters] == [CrossingRequest(41.0, 29.0)]


def test_a_device_that_has_booted_hears_it_again() -> None:
    talk = asked()
    talk.letters.clear()
    assert talk.hear(heard(Restarted(), 0), 0.5)
    talk.look((NEAR,), RUNS, math.inf, 0.5)
    assert len(talk.letters) == 1


def test_others_telegrams_are_not_its() -> None:
    assert not CrossingTalk(forgot=False).hear(heard(PROOF, 1), 0.0)
