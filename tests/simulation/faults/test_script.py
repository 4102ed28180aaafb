"""Words for events, and the watch that says when a trigger has come due."""

import pytest

from network.model import Position
from onboard.notes import Departs, Holds, LimitSet, MissionBegun, Proven
from simulation.events import EVENTS, WORLD, JournalEntry, TagPassed
from simulation.faults.script import Matcher, Trigger, TriggerWatch, matcher_of
from simulation.journal import Journal


@pytest.mark.parametrize(
    "words",
    [
        "train 323M passes tag 4",
        "train 323M departs OGN",
        "train 323M arrives OGN",
        "train 323M enters",
        "train 323M holds OGN.1",
        "points OGN.11 move",
        "points OGN.11 lock",
        "V1 restarts",
    ],
)
def test_words_name_events_that_a_journal_can_have(words: str) -> None:
    matcher = matcher_of(words)
    assert matcher is not None
    assert set(matcher.events) <= set(EVENTS.values())


@pytest.mark.parametrize("words", ["", "train 323M", "train 323M passes tag four", "V1 dances", "10:00"])
def test_other_words_name_nothing(words: str) -> None:
    assert matcher_of(words) is None


@pytest.mark.parametrize(
    ("actual", "wanted", "same"),
    [
        (("5", "6"), "5", True),
        (("5", "6"), ["6", "5"], True),
        (("5", "6"), ["5", "7"], False),
        (("5", "6"), "7", False),
    ],
)
def test_a_list_matches_what_it_contains(actual: tuple[str, ...], wanted: object, same: bool) -> None:
    matcher = Matcher("m", (Holds,), data={"section_ids": wanted})
    assert matcher.matches(JournalEntry(0.0, "x", Holds(section_ids=actual, token=1)), {}) is same


@pytest.mark.parametrize(
    ("before", "wanted", "same"), [("5", "5", True), ("5", "6", False), (None, "5", False)]
)
def test_a_value_matches_itself(before: str | None, wanted: str, same: bool) -> None:
    limit = LimitSet(kilometrage_m=1.0, piece_id="p", before=before, why="not held")
    assert (
        Matcher("m", (LimitSet,), data={"before": wanted}).matches(JournalEntry(0.0, "x", limit), {}) is same
    )


@pytest.mark.parametrize(("wanted", "same"), [("normal", True), ("reverse", False)])
def test_a_position_matches_its_word(wanted: str, same: bool) -> None:
    proven = Proven(points_id="P7", position=Position.NORMAL, token=1)
    assert (
        Matcher("m", (Proven,), data={"position": wanted}).matches(JournalEntry(0.0, "x", proven), {}) is same
    )


def test_another_event_or_party_does_not_match() -> None:
    proven = Proven(points_id="P7", position=Position.NORMAL, token=1)
    assert Matcher("m", (Proven,), who="K1").matches(JournalEntry(0.0, "K1", proven), {})
    assert not Matcher("m", (Proven,), who="K2").matches(JournalEntry(0.0, "K1", proven), {})
    assert not Matcher("m", (Holds,)).matches(JournalEntry(0.0, "K1", proven), {})


def test_data_that_an_event_does_not_have_are_refused_at_once() -> None:
    with pytest.raises(ValueError, match="proven has no field tag"):
        Matcher("m", (Proven,), data={"tag": 4})


def test_a_trigger_fires_once_with_its_delay_for_the_train_of_the_moment() -> None:
    fired: list[tuple[int, float]] = []
    on = matcher_of("train T2 departs B")
    watch = TriggerWatch(
        {7: Trigger(on=on, after_s=5.0), 8: Trigger(at_s=3.0)}, lambda k, t: fired.append((k, t))
    )
    journal = Journal()
    journal.watch(watch.see)
    journal.write(1.0, "K1", MissionBegun(train="T1", direction="down"))
    journal.write(2.0, "K1", Departs(station="B"))
    assert fired == []
    journal.write(3.0, "K1", MissionBegun(train="T2", direction="up"))
    journal.write(4.0, "K1", Departs(station="B"))
    journal.write(9.0, "K1", Departs(station="B"))
    assert fired == [(7, 9.0)]


def test_an_event_of_the_world_about_a_unit_is_the_units_trains() -> None:
    on = matcher_of("train T1 passes tag 4")
    assert on is not None
    entry = JournalEntry(1.0, WORLD, TagPassed(unit_id="K1", tag_id=4))
    assert on.matches(entry, {"K1": "T1"})
    assert not on.matches(entry, {"K1": "T2"})
