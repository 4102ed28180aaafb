"""Where a unit stands with one crossing, event by event: what it says, what it may do, when it looks again."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import replace

from onboard import crossing_notes
from onboard.crossings import machine
from onboard.crossings.machine import (
    EARLY_S,
    GIVE_UP_S,
    REFRESH_S,
    REPEAT_S,
    TABLE,
    CreepAllowed,
    CrossingAnswered,
    CrossingBooted,
    CrossingEvent,
    CrossingOffLine,
    CrossingOverAnswered,
    CrossingPhase,
    CrossingPlace,
    CrossingSeen,
    CrossingView,
    may_pass,
    step,
    table_rows,
    wake_s,
)
from radio.messages import CrossingOver, CrossingRequest

AHEAD, ASKED, PROVEN, PASSING, LEAVING = CrossingPhase
VIEW = CrossingView("C")
FAR = CrossingPlace("C", 2, 0, 35.0, 15.0, 15.0, arrives_s=100.0, fastest_s=80.0, proof_s=88.0)
NEAR = replace(FAR, arrives_s=40.0, fastest_s=32.0, proof_s=28.0)
ON_IT = replace(FAR, arrives_s=0.0, fastest_s=0.0, proof_s=0.0, entered=True, under=True)
PERHAPS = replace(ON_IT, under=False)
BEHIND = replace(ON_IT, beyond=True, clear=True)
STANDS = replace(NEAR, arrives_s=math.inf, proof_s=math.inf, stands=True)
REQUEST = CrossingRequest(40.0, 28.0)
ASKED_VIEW = replace(VIEW, phase=ASKED, said_s=0.0)
PROVEN_VIEW = replace(VIEW, phase=PROVEN, said_s=0.0, since_s=0.0, until_s=12.0)
PASSING_VIEW = replace(PROVEN_VIEW, phase=PASSING)
LEAVING_VIEW = replace(VIEW, phase=LEAVING, said_s=0.0, passed=True)
GIVES_UP = (crossing_notes.CrossingLeftBehind(crossing_id="C", passed=False), CrossingOver(False))
IS_OVER = (crossing_notes.CrossingLeftBehind(crossing_id="C", passed=True), CrossingOver(True))


def test_it_is_asked_ten_seconds_before_its_warning_must_begin() -> None:
    """35 s of warning and 10 s; or, to be proved in time, 15 s to close and 10 s."""
    assert FAR.due_s == pytest.approx(100.0 - 35.0 - EARLY_S)
    assert replace(FAR, proof_s=30.0).due_s == pytest.approx(30.0 - 15.0 - EARLY_S)
    assert step(VIEW, CrossingSeen(FAR), 0.0) == (VIEW, ())
    assert wake_s(VIEW, FAR, 7.0) == 7.0 + 80.0 - machine.HELD_FROM_S
    asked, said = step(VIEW, CrossingSeen(NEAR), 0.0)
    assert asked == ASKED_VIEW
    assert said == (crossing_notes.CrossingAsked(crossing_id="C", arrives_s=40.0), REQUEST)


@pytest.mark.parametrize(
    ("view", "event", "now_s", "after", "said"),
    [
        (ASKED_VIEW, CrossingSeen(NEAR), 1.9, ASKED_VIEW, ()),
        (ASKED_VIEW, CrossingSeen(NEAR), REPEAT_S, replace(ASKED_VIEW, said_s=REPEAT_S), (REQUEST,)),
        (ASKED_VIEW, CrossingAnswered(False, 12.0), 1.0, replace(ASKED_VIEW, answered=True), ()),
        (
            ASKED_VIEW,
            CrossingAnswered(True, 21.0),
            9.0,
            replace(PROVEN_VIEW, since_s=9.0, until_s=21.0, answered=True),
            (crossing_notes.CrossingHeardClosed(crossing_id="C"),),
        ),
        (ASKED_VIEW, CrossingSeen(ON_IT), 3.0, replace(ASKED_VIEW, phase=PASSING, said_s=3.0),
         (CrossingRequest(0.0, 0.0),)),
        (ASKED_VIEW, CrossingSeen(None), 3.0, replace(VIEW, phase=LEAVING, said_s=3.0), GIVES_UP),
        (ASKED_VIEW, CrossingSeen(STANDS), 3.0, replace(ASKED_VIEW, idle_s=3.0), ()),
        (replace(ASKED_VIEW, idle_s=3.0), CrossingSeen(STANDS), 3.0 + GIVE_UP_S,
         replace(VIEW, phase=LEAVING, said_s=33.0), GIVES_UP),
        (PROVEN_VIEW, CrossingSeen(NEAR), REFRESH_S, replace(PROVEN_VIEW, said_s=REFRESH_S), (REQUEST,)),
        (PROVEN_VIEW, CrossingAnswered(True, 18.0), 6.0, replace(PROVEN_VIEW, until_s=18.0), ()),
        (PROVEN_VIEW, CrossingAnswered(False, 18.0), 6.0, replace(ASKED_VIEW, said_s=6.0),
         (crossing_notes.CrossingProofLost(crossing_id="C", why=crossing_notes.WhyProofLost.NOT_CLOSED),)),
        (PROVEN_VIEW, CrossingSeen(NEAR), 12.0, replace(ASKED_VIEW, said_s=12.0),
         (crossing_notes.CrossingProofLost(crossing_id="C", why=crossing_notes.WhyProofLost.SILENCE), REQUEST)),
        (PROVEN_VIEW, CrossingSeen(ON_IT), 11.9, replace(PASSING_VIEW, said_s=11.9),
         (CrossingRequest(0.0, 0.0),)),
        (PROVEN_VIEW, CrossingSeen(PERHAPS), 11.0, replace(PROVEN_VIEW, said_s=11.0), (CrossingRequest(0.0, 0.0),)),
        (replace(PROVEN_VIEW, since_s=-4.0), CrossingSeen(PERHAPS), 11.0,
         replace(PASSING_VIEW, since_s=-4.0, said_s=11.0), (CrossingRequest(0.0, 0.0),)),
        (PASSING_VIEW, CrossingAnswered(False, 18.0), 6.0, PASSING_VIEW, ()),
        (PASSING_VIEW, CrossingSeen(BEHIND), 9.0, replace(LEAVING_VIEW, said_s=9.0), IS_OVER),
        (PASSING_VIEW, CrossingSeen(None), 3.0, PASSING_VIEW, ()),
        (PASSING_VIEW, CrossingOffLine(), 9.0, replace(LEAVING_VIEW, said_s=9.0), IS_OVER),
        (LEAVING_VIEW, CrossingSeen(BEHIND), 1.0, LEAVING_VIEW, ()),
        (LEAVING_VIEW, CrossingSeen(BEHIND), 2.0, replace(LEAVING_VIEW, said_s=2.0), (CrossingOver(True),)),
        (LEAVING_VIEW, CrossingOverAnswered(), 2.0, VIEW, ()),
        (LEAVING_VIEW, CrossingAnswered(True, 18.0), 6.0, LEAVING_VIEW, ()),
        (LEAVING_VIEW, CrossingBooted(), 1.0, replace(LEAVING_VIEW, said_s=-math.inf), ()),
        (ASKED_VIEW, CreepAllowed(), 60.0, replace(ASKED_VIEW, creeps=True),
         (crossing_notes.CrossingCreep(crossing_id="C"),)),
        (PASSING_VIEW, CreepAllowed(), 60.0, PASSING_VIEW, ()),
        (VIEW, CrossingSeen(BEHIND), 0.0, VIEW, ()),
        (replace(VIEW, forgot=True), CrossingSeen(BEHIND), 5.0, replace(LEAVING_VIEW, said_s=5.0), IS_OVER),
        (VIEW, CrossingAnswered(True, 12.0), 0.0, VIEW, ()),
    ],
)  # fmt: skip
def test_what_follows(
    view: CrossingView, event: CrossingEvent, now_s: float, after: CrossingView, said: tuple[object, ...]
) -> None:
    assert step(view, event, now_s) == (after, said)


@pytest.mark.parametrize(
    ("view", "place", "now_s", "may"),
    [
        (VIEW, FAR, 0.0, True),  # further than a minute even at its fastest
        (VIEW, NEAR, 0.0, False),
        (ASKED_VIEW, FAR, 0.0, False),
        (PROVEN_VIEW, NEAR, 1.0, True),
        (PROVEN_VIEW, NEAR, 12.0, False),  # the proof is over
        (PROVEN_VIEW, replace(NEAR, fastest_s=13.9), 1.0, False),  # there 14.9 s after it was closed
        (PROVEN_VIEW, replace(NEAR, fastest_s=14.0), 1.0, True),
        (PASSING_VIEW, ON_IT, 99.0, True),
        (replace(ASKED_VIEW, creeps=True), NEAR, 0.0, True),
        (VIEW, BEHIND, 0.0, True),
    ],
)
def test_who_may_pass(view: CrossingView, place: CrossingPlace, now_s: float, may: bool) -> None:
    assert may_pass(view, place, now_s) is may


def test_it_looks_again_when_the_rear_is_beyond() -> None:
    assert wake_s(PASSING_VIEW, replace(ON_IT, clears_s=2.5), 1.0) == 3.5
    assert wake_s(PASSING_VIEW, ON_IT, 1.0) == REFRESH_S


def test_every_row_says_what_happens() -> None:
    assert len(table_rows()) == len(TABLE)
