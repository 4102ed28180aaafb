"""A train that stands with nothing to come is found, and one that waits for something is left alone."""

from dataclasses import replace

import pytest

from simulation.judge.liveness import LOOKS_EVERY_S, ROAD_WAITS_S, STANDS_S, LivenessWatch, TrainAndDisplay
from simulation.judge.log import Log

DEAD = TrainAndDisplay(
    "K1", "section 6", bound=True, run_m=100.0, timer=False, pulls=False, awaits=False, waits_for="route 3>8"
)


def found(*looks: TrainAndDisplay) -> list[str]:
    """What is found of one train in looks one after the other."""
    log = Log()
    watch = LivenessWatch(log)
    for number, seen in enumerate(looks):
        watch.look(number * LOOKS_EVERY_S, [seen])
    return [violation.text for violation in log.violations]


def long(seen: TrainAndDisplay, more: int = 0) -> list[TrainAndDisplay]:
    """As many looks as it takes to be found, and some more."""
    return [seen] * (round(STANDS_S / LOOKS_EVERY_S) + 1 + more)


def test_no_timer_and_nothing_to_come_is_dead_whatever_it_shows() -> None:
    (text,) = found(*long(DEAD, more=5))
    assert text == (
        "K1 stands in section 6 and waits for route 3>8: no timer runs and nothing comes by itself"
    )
    assert found(*long(DEAD)[1:]) == []


def test_one_that_waits_for_nothing_is_dead_though_a_timer_runs() -> None:
    for shown in ("nothing", ""):
        (text,) = found(*long(replace(DEAD, timer=True, waits_for=shown)))
        assert "waits for nothing: it says so itself" in text


@pytest.mark.parametrize(
    "alive",
    [
        replace(DEAD, timer=True),
        replace(DEAD, pulls=True, waits_for="nothing"),
        replace(DEAD, awaits=True, waits_for="nothing"),
        replace(DEAD, bound=False, waits_for="nothing"),
    ],
    ids=["a timer runs", "it pulls", "a word will come", "its duty is over, or its unit is dead or frozen"],
)
def test_one_for_which_something_will_happen_is_left_alone(alive: TrainAndDisplay) -> None:
    assert found(*long(alive, more=20)) == []
    assert found(*long(DEAD)[1:], alive, *long(DEAD)[1:]) == []


def test_only_a_train_that_truly_stands_is_dead() -> None:
    moving = [replace(DEAD, run_m=100.0 + 0.1 * number) for number in range(30)]
    assert found(*moving) == []
    assert len(found(*moving, *long(moving[-1]))) == 1


def test_each_stand_is_found_once_and_each_train_by_itself() -> None:
    again = replace(DEAD, run_m=300.0)
    assert len(found(*long(DEAD, more=3), *long(again, more=3))) == 2
    log = Log()
    watch = LivenessWatch(log)
    for number in range(9):
        watch.look(number * LOOKS_EVERY_S, [DEAD, replace(DEAD, unit_id="K2", timer=True)])
    assert [violation.text.split()[0] for violation in log.violations] == ["K1"]


def test_a_road_that_stays_closed_for_nothing_is_dead_after_an_hour() -> None:
    log = Log()
    watch = LivenessWatch(log)
    watch.look_at_roads(0.0, ["C1"])
    watch.look_at_roads(ROAD_WAITS_S - 1.0, ["C1"])
    assert log.violations == ()
    watch.look_at_roads(ROAD_WAITS_S, ["C1"])
    (found,) = log.violations
    assert found.text == "the road at level crossing C1 stays closed, and no train comes"


def test_a_road_that_was_open_meanwhile_begins_anew() -> None:
    log = Log()
    watch = LivenessWatch(log)
    watch.look_at_roads(0.0, ["C1"])
    watch.look_at_roads(1800.0, [])
    watch.look_at_roads(1830.0, ["C1"])
    watch.look_at_roads(1830.0 + ROAD_WAITS_S - 1.0, ["C1"])
    assert log.violations == ()
