"""Two persons are wrong about a silent train, and its radio comes back at any second: trains stop, nothing collides.

With a place that nobody named (drill 53) their word counts for nothing, and all arrive. With the wrong portal (53b) it
counts; then both sides of the contradiction stop and say why, or the word was never put to the test.
"""

from dataclasses import replace
from typing import Final

import pytest

from onboard.notes import Mismatch
from scenario.scenario import load_scenario
from simulation.faults.script import ActKind, Script
from simulation.result import Ending, RunResult
from study.drilling.drill import find_drill
from study.runner.outcome import broken_rules, unfinished
from study.runner.run import CarrierKind, simulation_of
from tests.nightly import others_nightly

CUT_S: Final = 36_012.0  # 12 s after the departure
RESTART_S: Final = 36_014.0
DEPARTURE_S: Final = 36_300.0  # of the train behind
EVERY_S: Final = 180


def run(drill: str, back_s: float) -> RunResult:
    """The drill with the radio back at that time."""
    setup = load_scenario(find_drill(drill)).setup
    script = setup.script
    cut = replace(script.faults[0], duration_s=back_s - CUT_S)
    moved = Script((cut, *script.faults[1:]), script.acts, script.expectations)
    with simulation_of(replace(setup, script=moved), carrier=CarrierKind.PLAIN) as simulation:
        return simulation.run()


def seconds(every_s: int) -> list[float]:
    return [float(s) for s in range(round(RESTART_S), round(DEPARTURE_S) + 61, every_s)]


@pytest.mark.parametrize("back_s", others_nightly(seconds(1), seconds(EVERY_S)))
def test_the_radio_comes_back(back_s: float) -> None:
    unplaced = run("rtri/53_word_without_a_place", back_s)
    assert broken_rules(unplaced) == []
    assert unfinished(unplaced) == ()

    wrong = run("rtri/53b_two_wrong_persons", back_s)
    assert wrong.collisions == ()
    assert wrong.ended_because is not Ending.COLLISION
    stopped = {e.who for e in wrong.journal.entries if isinstance(e.event, Mismatch)}
    assert stopped in (set(), {"K1", "K2"}) or not unfinished(wrong)
    if unfinished(wrong):  # they stand in one section: both say why
        assert stopped == {"K1", "K2"}
        assert all("agreement" in w.waits_for or "sees a train" in w.waits_for for w in wrong.waiting)


def test_persons_are_needed_for_the_second_drill_to_mean_anything() -> None:
    script = load_scenario(find_drill("rtri/53b_two_wrong_persons")).setup.script
    assert sum(act.kind is ActKind.CONFIRM_OUTSIDE and act.place == "PE" for act in script.acts) == 2
