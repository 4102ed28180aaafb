"""Words for events, and the watch that says when a trigger has come due."""

from __future__ import annotations

import pytest

from simulation.faults.script import Matcher, Trigger, Watch, matcher_of
from simulation.journal import Journal
from simulation.vocabulary import WORDS


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
    assert set(matcher.what) <= WORDS


@pytest.mark.parametrize("words", ["", "train 323M", "train 323M passes tag four", "V1 dances", "10:00"])
def test_other_words_name_nothing(words: str) -> None:
    assert matcher_of(words) is None


@pytest.mark.parametrize(
    ("actual", "wanted", "same"),
    [
        (["5", "6"], "5", True),
        (["5", "6"], ["6", "5"], True),
        (["5", "6"], ["5", "7"], False),
        (["5", "6"], "7", False),
        ("5", "5", True),
        (None, "5", False),
    ],
)
def test_a_list_matches_what_it_contains(actual: object, wanted: object, same: bool) -> None:
    matcher = Matcher("m", ("freed",), data={"sections": wanted})
    assert matcher.matches({"who": "x", "what": "freed", "sections": actual}, {}) is same


def test_a_trigger_fires_once_with_its_delay_for_the_train_of_the_moment() -> None:
    fired: list[tuple[int, float]] = []
    on = matcher_of("train T2 departs B")
    watch = Watch({7: Trigger(on=on, after_s=5.0), 8: Trigger(at_s=3.0)}, lambda k, t: fired.append((k, t)))
    journal = Journal()
    journal.watch(watch.see)
    journal.write(1.0, "K1", "mission", train="T1")
    journal.write(2.0, "K1", "departs", station="B")
    assert fired == []
    journal.write(3.0, "K1", "mission", train="T2")
    journal.write(4.0, "K1", "departs", station="B")
    journal.write(9.0, "K1", "departs", station="B")
    assert fired == [(7, 9.0)]


def test_an_event_of_the_world_about_a_unit_is_the_units_trains() -> None:
    on = matcher_of("train T1 passes tag 4")
    assert on is not None
    entry = {"t": 1.0, "who": "world", "what": "tag_passed", "unit": "K1", "tag": 4}
    assert on.matches(entry, {"K1": "T1"})
    assert not on.matches(entry, {"K1": "T2"})
