"""What each seat knows of a level crossing, from a journal written by hand: who has said what to whom, and when."""

from dataclasses import replace
from typing import Final

import pytest

from console.crossings_seen import CrossingsSeen
from console.protocol import CrossingKnown, RoadState
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import CrossingClass, CrossingControl, LevelCrossing
from onboard import crossing_notes
from onboard.crossing_notes import WhyProofLost
from radio.messages import CrossingClear, CrossingOver, CrossingOverHeard, CrossingProof, CrossingRequest
from radio.noted import TookEffect
from simulation.events import (
    WORLD,
    BarrierState,
    CrossingBarriers,
    CrossingEntered,
    CrossingLamps,
    Event,
    JournalEntry,
    PowerOff,
    PowerOn,
    RoadGuarded,
)
from wayside import crossing_said
from wayside.crossing_said import WhyUnproven

CROSSING: Final = LevelCrossing(
    "C1", "C1", CrossingClass.BARRIERS, CrossingControl.RADIO, "6", 750.0, 6.0, 8.0, 15.0, 20.0
)
DEPARTURES: Final = replace(CROSSING, control=CrossingControl.CONTACTS, warns_departures=True)
PROTECTED: Final = replace(CROSSING, control=CrossingControl.CONTACTS, has_protection=True)
LIT, DARK = (CrossingLamps(crossing_id="C1", lit=lit) for lit in (True, False))
DOWN, UP = (CrossingBarriers(crossing_id="C1", state=s) for s in (BarrierState.LOWERED, BarrierState.RAISED))
WARNS, PROVEN = crossing_said.CrossingWarns(unit_id="K1"), crossing_said.CrossingProven()
OPENS = crossing_said.CrossingOpens()


def took(kind: type, source: str, receiver: str) -> TookEffect:
    return TookEffect(
        source=source, receiver=receiver, epoch=1, sequence=1, kind=kind.__name__, correlation=1
    )


ASKS, SAYS_OVER = (took(kind, "K1", "C1") for kind in (CrossingRequest, CrossingOver))
SAYS, OVER_HEARD, IS_CLEAR = (
    took(kind, "C1", "K1") for kind in (CrossingProof, CrossingOverHeard, CrossingClear)
)


def seen(*lines: tuple[float, str, Event], crossing: LevelCrossing = CROSSING) -> CrossingsSeen:
    line = replace(load_line(shipped_line("rtri_test_line")), crossings={"C1": crossing})
    found = CrossingsSeen(line)
    for t_s, who, event in lines:
        found.see(JournalEntry(t_s, who, event))
    return found


CLOSES: Final = (
    (0.0, "C1", ASKS),
    (10.0, "C1", WARNS),
    (10.0, WORLD, LIT),
    (25.0, WORLD, DOWN),
    (25.0, "C1", PROVEN),
    (25.2, "K1", SAYS),
)


def only(shown: tuple[CrossingKnown, ...]) -> CrossingKnown:
    (one,) = shown
    return one


def test_by_radio_a_crossing_is_what_it_has_said_to_anybody() -> None:
    """Warning since 10 s, which no telegram has said; proven at 25 s, said at 25.2 s."""
    states = [only(seen(*CLOSES[:k]).known(26.0)).state for k in range(len(CLOSES) + 1)]
    assert states == [*[RoadState.UNHEARD] * 6, RoadState.CLOSED]
    assert only(seen(*CLOSES).known(26.0)).heard_s == 25.2
    assert only(seen(*CLOSES).known(26.0)).announced == ("K1",)


@pytest.mark.parametrize(("now_s", "state"), [(40.1, RoadState.CLOSED), (40.3, RoadState.UNHEARD)])
def test_a_word_dies_with_the_proof_that_it_was(now_s: float, state: RoadState) -> None:
    """15 s, as long as a unit believes it."""
    assert only(seen(*CLOSES).known(now_s)).state is state


def test_an_open_crossing_says_nothing_for_hours_but_not_to_a_train_that_comes() -> None:
    left = ((50.0, "C1", SAYS_OVER), (50.0, "C1", OPENS), (50.1, "K1", OVER_HEARD))
    later = 50.1 + 3 * 3600.0
    opened = seen(*CLOSES, *left)
    assert only(opened.known(later)).state is RoadState.OPEN
    assert only(opened.known(later)).announced == ()
    opened.see(JournalEntry(later, "C1", ASKS))
    assert only(opened.known(later + 1.0)).state is RoadState.UNHEARD


def test_one_that_contacts_close_is_not_known_as_open_for_longer_than_a_word_holds() -> None:
    """A train that departs asks it; the next one comes over its contact, and nobody hears that the road closes."""
    left = ((50.0, "C1", SAYS_OVER), (50.0, "C1", OPENS), (50.1, "K1", OVER_HEARD), (120.0, "C1", WARNS))
    found = seen(*CLOSES, *left, crossing=DEPARTURES)
    assert only(found.known(65.0)).state is RoadState.OPEN
    assert only(found.known(121.0)).state is RoadState.UNHEARD
    assert only(found.truth()).state is RoadState.WARNING


@pytest.mark.parametrize(
    ("lines", "truth"),
    [
        ((), RoadState.OPEN),
        (CLOSES[:3], RoadState.WARNING),
        (CLOSES, RoadState.CLOSED),
        ((*CLOSES, (26.0, WORLD, DARK)), RoadState.UNPROVEN),  # it has not noticed yet
        ((*CLOSES, (26.0, "C1", OPENS)), RoadState.OPENING),
        ((*CLOSES, (26.0, "C1", OPENS), (34.0, WORLD, UP)), RoadState.OPEN),
        ((*CLOSES, (26.0, WORLD, PowerOff(device_id="C1"))), RoadState.UNPROVEN),
        (((1.0, WORLD, PowerOff(device_id="C1")), (9.0, WORLD, PowerOn(device_id="C1"))), RoadState.OPEN),
    ],
)
def test_the_truth_is_what_the_equipment_does(
    lines: tuple[tuple[float, str, Event], ...], truth: RoadState
) -> None:
    assert only(seen(*lines).truth()).state is truth


def test_why_it_is_not_proven_and_what_stands_on_it_are_for_who_sees_the_truth() -> None:
    unproven = crossing_said.CrossingUnproven(why=WhyUnproven.OBSTACLE)
    found = seen(*CLOSES, (30.0, "C1", unproven), (30.1, "K1", SAYS))
    truth, known = only(found.truth(["C1"])), only(found.known(31.0))
    assert (truth.state, truth.why, truth.occupied) == (RoadState.UNPROVEN, "something is on it", True)
    assert truth.why_ja == "踏切道に支障物があります"
    assert (known.state, known.why, known.occupied) == (RoadState.UNPROVEN, "", False)


def test_a_driver_knows_what_the_own_unit_has_heard() -> None:
    notes = (
        (0.0, "K1", crossing_notes.CrossingAsked(crossing_id="C1", arrives_s=60.0)),
        (26.0, "K1", crossing_notes.CrossingHeardClosed(crossing_id="C1")),
        (30.0, "K1", crossing_notes.CrossingProofLost(crossing_id="C1", why=WhyProofLost.NOT_CLOSED)),
        (31.0, "K1", crossing_notes.CrossingProofLost(crossing_id="C1", why=WhyProofLost.SILENCE)),
        (90.0, "K1", crossing_notes.CrossingLeftBehind(crossing_id="C1", passed=True)),
    )
    states = [only(seen(*notes[:k]).heard_by("K1")).state for k in range(len(notes) + 1)]
    none, asked, proven = RoadState.UNHEARD, RoadState.ASKED, RoadState.CLOSED
    assert states == [none, asked, proven, RoadState.UNPROVEN, none, none]
    assert only(seen(*notes[:2]).heard_by("K2")).state is none


def test_leave_to_creep_is_over_as_the_front_comes_onto_the_road_and_a_guard_stays() -> None:
    leave = crossing_notes.CrossingCreep(crossing_id="C1", guarded=True)
    guard = RoadGuarded(crossing_id="C1", there=True)
    found = seen((0.0, WORLD, guard), (1.0, "K1", leave))
    for shown in (found.known(2.0), found.heard_by("K1"), found.truth()):
        assert (only(shown).creeps, only(shown).guarded) == (("K1",), True)
    assert only(found.heard_by("K2")).creeps == ()
    found.see(JournalEntry(9.0, WORLD, CrossingEntered(unit_id="K1", crossing_id="C1", speed_mps=3.0)))
    assert (only(found.known(9.0)).creeps, only(found.known(9.0)).guarded) == ((), True)


def test_one_that_contacts_close_says_by_radio_only_whether_anything_is_on_it() -> None:
    lines = (
        (0.0, "C1", ASKS),
        (0.2, "K1", IS_CLEAR),
        (0.2, "K1", crossing_notes.CrossingHeardClear(crossing_id="C1")),
        (10.0, "C1", WARNS),
        (11.0, "K1", IS_CLEAR),
        (15.0, "K1", crossing_notes.CrossingProofLost(crossing_id="C1", why=WhyProofLost.NOT_CLOSED)),
    )
    at_s = [only(seen(*lines[:k], crossing=PROTECTED).known(15.1)).state for k in (2, 5, 6)]
    assert at_s == [RoadState.UNHEARD, RoadState.CLEAR, RoadState.UNPROVEN]
