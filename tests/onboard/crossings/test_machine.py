"""Where a unit stands with one crossing, event by event: what it says, what it may do, when it looks again."""

import math

import pytest
from msgspec.structs import replace

from onboard import crossing_notes
from onboard.crossings.machine import (
    EARLY_S,
    GIVE_UP_S,
    REPEAT_S,
    STILL_S,
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
    CrossingUnplaced,
    CrossingView,
    ends_s,
    may_pass,
    starts_too_soon,
    step,
    wake_s,
)
from radio.messages import CrossingOver, CrossingRequest
from radio.table import rows
from wayside.level_crossing import FREES_S

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
PROVEN_VIEW = replace(VIEW, phase=PROVEN, said_s=0.0, since_s=0.0, until_s=12.0, answered=True)
PASSING_VIEW = replace(PROVEN_VIEW, phase=PASSING)
LEAVING_VIEW = replace(VIEW, phase=LEAVING, said_s=0.0, passed=True)
GIVES_UP = (crossing_notes.CrossingLeftBehind(crossing_id="C", passed=False), CrossingOver(False))
IS_OVER = (crossing_notes.CrossingLeftBehind(crossing_id="C", passed=True), CrossingOver(True))


def test_it_is_asked_six_seconds_before_its_warning_must_begin() -> None:
    """35 s of warning and 6 s; or, to be proved in time, 15 s to close and 6 s."""
    assert FAR.due_s == pytest.approx(100.0 - 35.0 - EARLY_S)
    assert replace(FAR, proof_s=30.0).due_s == pytest.approx(30.0 - 15.0 - EARLY_S)
    assert step(VIEW, CrossingSeen(FAR), 0.0) == (VIEW, ())
    assert wake_s(VIEW, FAR, 7.0) == 7.0 + 59.0
    # it is to stop before it, and something happens then
    later = replace(FAR, arrives_s=math.inf, proof_s=math.inf)
    assert wake_s(VIEW, later, 7.0) == math.inf
    asked, said = step(VIEW, CrossingSeen(NEAR), 0.0)
    assert asked == replace(ASKED_VIEW, begins_s=5.0)
    assert said == (crossing_notes.CrossingAsked(crossing_id="C", arrives_s=40.0), REQUEST)


@pytest.mark.parametrize(
    ("view", "event", "now_s", "after", "said"),
    [
        (ASKED_VIEW, CrossingSeen(NEAR), 1.9, ASKED_VIEW, ()),
        (ASKED_VIEW, CrossingSeen(NEAR), REPEAT_S, replace(ASKED_VIEW, said_s=REPEAT_S, begins_s=7.0), (REQUEST,)),
        (ASKED_VIEW, CrossingAnswered(False, 12.0), 1.0, replace(ASKED_VIEW, answered=True), ()),
        (
            ASKED_VIEW,
            CrossingAnswered(True, 21.0),
            9.0,
            replace(PROVEN_VIEW, since_s=9.0, until_s=21.0),
            (crossing_notes.CrossingHeardClosed(crossing_id="C"),),
        ),
        (ASKED_VIEW, CrossingSeen(ON_IT), 3.0, replace(ASKED_VIEW, phase=PASSING, said_s=3.0),
         (CrossingRequest(0.0, 0.0),)),
        (ASKED_VIEW, CrossingSeen(None), 3.0, replace(VIEW, phase=LEAVING, said_s=3.0), GIVES_UP),
        (ASKED_VIEW, CrossingSeen(STANDS), 3.0, replace(ASKED_VIEW, idle_s=3.0), ()),
        (replace(ASKED_VIEW, idle_s=3.0), CrossingSeen(STANDS), 3.0 + GIVE_UP_S,
         replace(VIEW, phase=LEAVING, said_s=33.0), GIVES_UP),
        (PROVEN_VIEW, CrossingSeen(NEAR), 5.9, PROVEN_VIEW, ()),
        (PROVEN_VIEW, CrossingSeen(NEAR), 6.0, replace(PROVEN_VIEW, said_s=6.0, answered=False), (REQUEST,)),
        (PROVEN_VIEW, CrossingAnswered(True, 18.0), 6.0, replace(PROVEN_VIEW, until_s=18.0), ()),
        (PROVEN_VIEW, CrossingAnswered(False, 18.0), 6.0, replace(ASKED_VIEW, said_s=6.0, answered=True),
         (crossing_notes.CrossingProofLost(crossing_id="C", why=crossing_notes.WhyProofLost.NOT_CLOSED),)),
        (PROVEN_VIEW, CrossingSeen(NEAR), 12.0, replace(ASKED_VIEW, said_s=12.0, begins_s=17.0),
         (crossing_notes.CrossingProofLost(crossing_id="C", why=crossing_notes.WhyProofLost.SILENCE), REQUEST)),
        (PROVEN_VIEW, CrossingSeen(ON_IT), 11.9, PASSING_VIEW, ()),
        (PROVEN_VIEW, CrossingSeen(BEHIND), 9.0, replace(LEAVING_VIEW, said_s=9.0), IS_OVER),
        (PROVEN_VIEW, CrossingSeen(PERHAPS), 11.0, replace(PROVEN_VIEW, said_s=11.0, answered=False),
         (CrossingRequest(0.0, 0.0),)),
        (replace(PROVEN_VIEW, since_s=-4.0), CrossingSeen(PERHAPS), 11.0,
         replace(PASSING_VIEW, since_s=-4.0), ()),
        (PASSING_VIEW, CrossingSeen(ON_IT), STILL_S, replace(PASSING_VIEW, said_s=STILL_S, answered=False),
         (CrossingRequest(0.0, 0.0),)),
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
        (replace(VIEW, forgot=True), CrossingSeen(STANDS), 5.0, replace(VIEW, phase=LEAVING, said_s=5.0), GIVES_UP),
        # It stands with its front perhaps on the road: nothing is given up.
        (replace(VIEW, forgot=True), CrossingSeen(replace(PERHAPS, stands=True, arrives_s=math.inf, proof_s=math.inf)),
         5.0, replace(VIEW, forgot=True), ()),
        # Surely short of the road again, by bounds that are narrower, while the proof holds; and when it does no more.
        (PASSING_VIEW, CrossingSeen(NEAR), 3.0, PASSING_VIEW, ()),
        (PASSING_VIEW, CrossingSeen(NEAR), 12.0, replace(ASKED_VIEW, said_s=12.0, begins_s=17.0, forgot=True),
         (crossing_notes.CrossingAsked(crossing_id="C", arrives_s=40.0), REQUEST)),
        # Its front perhaps on the road, it stands for longer than the proof holds: it needs one again.
        (PASSING_VIEW, CrossingSeen(replace(PERHAPS, stands=True)), 11.0, PASSING_VIEW, ()),
        (PASSING_VIEW, CrossingSeen(replace(PERHAPS, stands=True)), 12.0,
         replace(ASKED_VIEW, said_s=12.0, forgot=True),
         (crossing_notes.CrossingAsked(crossing_id="C", arrives_s=0.0), CrossingRequest(0.0, 0.0))),
        (PASSING_VIEW, CrossingSeen(replace(ON_IT, stands=True)), 12.0, PASSING_VIEW, ()),
        (PASSING_VIEW, CrossingUnplaced(), 3.0, replace(VIEW, forgot=True), ()),
        (PROVEN_VIEW, CrossingUnplaced(), 3.0, PROVEN_VIEW, ()),
        (replace(VIEW, forgot=True), CrossingOffLine(), 9.0, replace(LEAVING_VIEW, said_s=9.0), IS_OVER),
        (VIEW, CrossingOffLine(), 9.0, VIEW, ()),
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


def test_on_the_road_it_looks_again_when_it_is_to_say_that_it_still_is() -> None:
    assert wake_s(PASSING_VIEW, ON_IT, 1.0) == STILL_S


def place_at(now_s: float, front_s: float = 50.0) -> CrossingPlace:
    """How a train that is on the road at `front_s` sees it: it must begin to warn 35 s before that."""
    left_s = front_s - now_s
    return replace(NEAR, arrives_s=left_s, fastest_s=left_s, proof_s=left_s - 10.0)


def said_until(now_s: float, answers: bool, closes_s: float = math.inf) -> list[float]:
    """When a unit that asks at 9 s, 6 s before the warning, has spoken; it looks when it wants to."""
    view, said_s = replace(ASKED_VIEW, said_s=9.0), [9.0]
    at_s = 9.0
    while at_s <= now_s:
        if answers:
            view, _ = step(view, CrossingAnswered(at_s >= closes_s, at_s + 15.0), at_s)
        wakes_s = wake_s(view, place_at(at_s), at_s)
        assert wakes_s > at_s
        at_s = min(wakes_s, closes_s) if at_s < closes_s else wakes_s
        view, said = step(view, CrossingSeen(place_at(at_s)), at_s)
        said_s += [at_s] * any(isinstance(one, CrossingRequest) for one in said)
    return [at_s for at_s in said_s if at_s <= now_s]


def test_it_speaks_when_that_matters() -> None:
    """Answered: 1 s after it should be closed at 30 s, and every 4 s. Closed then, the proof of 15 s is asked for again
    6 s before its end; that of 39 s lasts until the front is there at 50 s.
    """
    assert said_until(30.9, answers=True) == pytest.approx([9.0])
    assert said_until(35.5, answers=True) == pytest.approx([9.0, 31.0, 35.0])
    assert said_until(49.9, answers=True, closes_s=30.0) == pytest.approx([9.0, 39.0])
    assert said_until(14.0, answers=False) == pytest.approx([9.0, 11.0, 13.0])


def test_who_asked_early_looks_once_more_before_the_warning() -> None:
    """It is to begin at 30 s. Asked at 0 s, standing, it is looked at 3 s before; asked at 24 s it is known well."""
    early = replace(ASKED_VIEW, begins_s=30.0, answered=True)
    assert wake_s(early, place_at(0.0, front_s=65.0), 0.0) == 27.0
    in_time = replace(early, said_s=24.0)
    assert wake_s(in_time, place_at(24.0, front_s=65.0), 24.0) == 46.0


@pytest.mark.parametrize(
    ("begins_s", "says"), [(7.5, True), (6.6, True), (6.4, False), (4.6, False), (4.4, True), (2.0, False)]
)
def test_of_a_time_that_has_changed_it_hears_at_once(begins_s: float, says: bool) -> None:
    """At 2.5 s it is to begin at 5.5 s. What was to begin at 2 s has begun."""
    view = replace(ASKED_VIEW, said_s=2.4, begins_s=begins_s, answered=True)
    place = replace(NEAR, arrives_s=38.0, proof_s=28.0)
    after, said = step(view, CrossingSeen(place), 2.5)
    assert bool(said) is says
    assert after.begins_s == (5.5 if says else begins_s)


def test_a_proof_that_would_end_too_soon_is_asked_for_three_times() -> None:
    view, said_s = replace(PROVEN_VIEW, until_s=12.0), []
    for tenth in range(120):
        view, said = step(view, CrossingSeen(NEAR), tenth / 10.0)
        said_s += [tenth / 10.0] * bool(said)
    assert said_s == [6.0, 8.0, 10.0]


def test_by_a_proof_that_lasts_it_looks_again_where_its_front_is_not_on_the_road_by_then() -> None:
    """It should be there at 9 s, and by a proof until 12.5 s may come 3 s later; that until 11.9 s is asked for again
    wherever it is, as is one that has not been answered.
    """
    soon = replace(NEAR, arrives_s=9.0, fastest_s=8.0, proof_s=-1.0)
    old = replace(PROVEN_VIEW, since_s=-20.0)
    assert ends_s(replace(old, until_s=12.5), soon, 0.0) == 10.5
    for view, place in (
        (replace(old, until_s=11.9), soon),
        (replace(old, until_s=12.5, answered=False), soon),
        # not closed for its least time when it could be there
        (replace(old, until_s=12.5, since_s=0.0), soon),
        (replace(old, until_s=12.5), ON_IT),
        (replace(old, until_s=12.5, phase=PASSING), soon),
    ):
        assert ends_s(view, place, 0.0) == math.inf


def test_a_crossing_that_persons_free_hears_twice_of_a_train_on_it() -> None:
    assert 2.0 * STILL_S < FREES_S


def test_every_row_says_what_happens() -> None:
    assert len(rows(TABLE)) == len(TABLE)


@pytest.mark.parametrize(
    ("said_s", "answered", "now_s", "too_soon"),
    [
        (0.0, True, 2.9, True),  # proven by 0 + 15 + 1 s, and 15 s before the front: in 2.9 + 28 - 15 s
        (0.0, True, 3.1, False),
        (0.0, False, 3.1, True),
        (4.0, True, 3.1, True),
    ],
)
def test_a_departure_that_warns_waits_for_what_the_road_still_needs(
    said_s: float, answered: bool, now_s: float, too_soon: bool
) -> None:
    """28 s from its start to the road, braking from 20 s on; of a crossing whose contact it has passed it need not."""
    place = replace(NEAR, arrives_s=28.0, proof_s=20.0, stands=True, departs=True)
    view = replace(ASKED_VIEW, said_s=said_s, begins_s=-7.0, answered=answered)
    assert starts_too_soon(view, place, now_s) is too_soon
    assert not starts_too_soon(view, replace(place, departs=False), now_s)
    assert not starts_too_soon(PROVEN_VIEW, place, now_s)
