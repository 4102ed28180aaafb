"""The pilot's rule, with trains and words placed by hand: who comes into a section, and by whose leave."""

import pytest

from simulation.events import CutIn, CutOut, ProcedureStep
from simulation.judge.log import Checker, Log
from simulation.judge.pilot import PilotWatch
from simulation.procedure import Regime, WorkingStep, before_entry

NEEDS = before_entry(Regime.TELEPHONE)
TO_BEGIN = (WorkingStep.ORDER, WorkingStep.MAN, WorkingStep.CLEAR, WorkingStep.PILOT)


class Scene:
    """Sections S and T between stations, and one within a station, which is nobody's."""

    def __init__(self, *cut_out: str) -> None:
        self.log = Log()
        self.watch = PilotWatch({"S": NEEDS, "T": NEEDS}, self.log)
        for unit_id in cut_out:
            self.watch.see(CutOut(unit_id=unit_id))

    def say(self, step: WorkingStep, unit_id: str = "", block: str = "S") -> None:
        self.watch.see(ProcedureStep(block=block, step=step.value, to_whom="", says="", unit_id=unit_id))

    def say_all(self, unit_id: str, but: WorkingStep | None = None) -> None:
        for step in NEEDS:
            if step is not but:
                self.say(step, "" if step in TO_BEGIN else unit_id)

    def come(self, unit_id: str) -> tuple[str, ...]:
        self.watch.came_in(1.0, unit_id, ("S", "station"))
        assert {v.checker for v in self.log.violations} <= {Checker.PILOTS_LEAVE}
        return tuple(v.text for v in self.log.violations)


def test_what_must_be_done_before_a_train_comes_in_is_what_the_rules_say() -> None:
    # Ordinance 15 of 1987: operators at both ends, the section confirmed clear, one pilot named for it, the other end's
    # consent for each train, and the pilot aboard. Points, the cut-out and the word to go are assumed.
    assert {
        WorkingStep.MAN,
        WorkingStep.CLEAR,
        WorkingStep.PILOT,
        WorkingStep.ASK,
        WorkingStep.AGREE,
        WorkingStep.BOARD,
    } <= set(NEEDS)
    assert WorkingStep.ARRIVED not in NEEDS
    assert {WorkingStep.ASK, WorkingStep.AGREE}.isdisjoint(before_entry(Regime.SHUTTLE))  # one operator alone


def test_by_the_pilots_leave_a_train_comes_in() -> None:
    scene = Scene("V1")
    scene.say_all("V1")
    assert scene.come("V1") == ()


def test_the_pilot_of_another_section_takes_no_leave_away() -> None:
    scene = Scene("V1")
    scene.say_all("V1")
    scene.say(WorkingStep.BOARD, "V2", "T")
    assert scene.come("V1") == ()


@pytest.mark.parametrize("left_out", NEEDS)
def test_each_step_that_was_not_done_is_named(left_out: WorkingStep) -> None:
    scene = Scene("V1")
    scene.say_all("V1", but=left_out)
    (text,) = scene.come("V1")
    assert text.endswith(f"no {left_out.value}")


def test_leave_is_for_one_train_and_one_time() -> None:
    scene = Scene("V1", "V2")
    scene.say_all("V1")
    assert len(scene.come("V2")) == 1  # by another's
    assert len(scene.come("V1")) == 2  # V2 is in there


def test_it_is_used_up_as_the_train_comes_in() -> None:
    scene = Scene("V1")
    scene.say_all("V1")
    scene.come("V1")
    scene.say(WorkingStep.ARRIVED, "V1")
    (text,) = scene.come("V1")
    assert "ask" in text


def test_who_is_let_in_before_the_last_one_was_reported_breaks_it() -> None:
    scene = Scene("V1", "V2")
    scene.say_all("V1")
    scene.come("V1")
    scene.say_all("V2")
    (text,) = scene.come("V2")
    assert text.endswith("no arrived of V1")


def test_there_is_one_pilot() -> None:
    scene = Scene("V1", "V2")
    scene.say_all("V1")
    scene.say(WorkingStep.BOARD, "V2")  # he has gone over to V2
    (text,) = scene.come("V1")
    assert text.endswith("no board")


def test_his_ticket_is_as_good_as_he_and_stays_so_when_he_rides_with_the_next() -> None:
    scene = Scene("V1", "V2")
    scene.say_all("V1", but=WorkingStep.BOARD)
    scene.say(WorkingStep.TICKET, "V1")
    scene.say_all("V2")
    assert scene.come("V1") == ()
    (text,) = scene.come("V1")
    assert text.endswith("no ask, agree, points, board, cut_out, go"), "it is for one time"


def test_who_rides_elsewhere_gives_no_ticket() -> None:
    scene = Scene("V1", "V2")
    scene.say(WorkingStep.BOARD, "V2")
    scene.say_all("V1", but=WorkingStep.BOARD)
    scene.say(WorkingStep.TICKET, "V1")
    (text,) = scene.come("V1")
    assert text.endswith("no board")
    scene.say(WorkingStep.ARRIVED, "V1")
    scene.say(WorkingStep.ALIGHT, "V2")
    scene.say_all("V1", but=WorkingStep.BOARD)
    scene.say(WorkingStep.TICKET, "V1")
    assert scene.come("V1") == (text,), "he is back"


def test_authority_has_no_place_where_a_pilot_has_the_section() -> None:
    scene = Scene()
    assert scene.come("V1") == ()
    scene.say(WorkingStep.PILOT)
    assert len(scene.come("V1")) == 1
    scene = Scene()
    scene.say(WorkingStep.PILOT)
    scene.say(WorkingStep.RELEASE)
    assert scene.come("V1") == ()


def test_a_unit_that_is_cut_in_again_runs_under_authority() -> None:
    scene = Scene("V1")
    scene.watch.see(CutIn(unit_id="V1"))
    assert scene.come("V1") == ()


@pytest.mark.parametrize("left_out", [WorkingStep.CLEAR, WorkingStep.AGREE])
@pytest.mark.parametrize("ends_with", [WorkingStep.STOP, WorkingStep.RELEASE])
def test_nothing_that_was_done_counts_when_it_is_worked_so_again(
    left_out: WorkingStep, ends_with: WorkingStep
) -> None:
    """Ended before there was a pilot, and with one, V1 having been asked for and not having come."""
    scene = Scene("V1")
    for step in NEEDS:
        if step is not WorkingStep.PILOT or ends_with is WorkingStep.RELEASE:
            scene.say(step, "" if step in TO_BEGIN else "V1")
    scene.say(ends_with)
    scene.say_all("V1", but=left_out)
    (text,) = scene.come("V1")
    assert text.endswith(f"no {left_out.value}")
