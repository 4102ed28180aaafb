"""What exploring a line whole finds: that the machines are safe and alive, and what they once did wrong."""

import pytest

from onboard.duty_parameters import ReleaseRule
from tests.nightly import others_nightly
from tests.system import switches_wayside  # noqa: F401 - they enter themselves
from tests.system.switchboard import SWITCHES
from verify.composition import TWO_TRAINS
from verify.explore import ExploredSpace, explored
from verify.explored_line import Budgets, ExploredLine
from verify.restored import restored
from verify.train import ExploredTrain

# How often telegrams are lost or late, power fails and persons say what is not so.
IN_EVERY_RUN = (Budgets(), Budgets(loss=2), Budgets(set_back=1))
AT_NIGHT = (
    Budgets(loss=1, delay=1),  # every run explores it with times, for what runs are inside of
    Budgets(power=1),
    Budgets(word=1),
    Budgets(points=1),
    Budgets(sensor=1),
    Budgets(delay=1, set_back=1),
    Budgets(loss=1, power=1),
    Budgets(loss=1, delay=1, power=1),
)


@pytest.mark.parametrize("budgets", others_nightly((*IN_EVERY_RUN, *AT_NIGHT), IN_EVERY_RUN))
def test_every_state_is_safe_and_alive(budgets: Budgets) -> None:
    found = explored(ExploredLine(budgets=budgets))
    assert found.holds, found.story


ONE_TRAIN = (
    Budgets(power=1),
    Budgets(loss=1, delay=1, points=1),
    Budgets(power=2),
    Budgets(loss=1, delay=1, power=2),
    Budgets(loss=1, power=1, points=1),
    Budgets(loss=1, delay=1, power=1, word=1),
    Budgets(loss=2, delay=2, power=2),
    Budgets(loss=2, delay=2, word=1),
)


@pytest.mark.parametrize("budgets", others_nightly(ONE_TRAIN, ONE_TRAIN[:2]))
def test_one_train_is_safe_and_leaves_a_line_that_is_free(budgets: Budgets) -> None:
    """The next could come in."""
    found = explored(ExploredLine(trains=1, budgets=budgets))
    assert found.holds, found.story


def test_a_command_that_is_repeated_can_throw_points_under_who_believes_their_proof() -> None:
    """Sent before the proof was heard, and carried out since that is withdrawn, which was lost."""
    line = ExploredLine(trains=1, budgets=Budgets(loss=1, delay=1, points=1))
    with restored("repeated-command-throws"):
        found = explored(line)
    assert found.broken == "points do not lie, or are not locked, as the train on them needs"
    assert "t2 loses PointsProof PY False False" in found.story


def dead_end(line: ExploredLine, *off: str) -> ExploredSpace:
    """What is found without these rules: nothing unsafe, and states from which not all can finish."""
    with restored(*off):
        found = explored(line)
    assert not found.broken
    assert found.dead > 0
    return found


def test_one_train_can_leave_a_line_that_is_never_free_again() -> None:
    found = dead_end(ExploredLine(trains=1, budgets=Budgets(power=2)), "booted-leaver-unheard")
    assert found.story[-1] == "u1 power fails"


@pytest.mark.nightly
@pytest.mark.parametrize("budgets", [Budgets(), Budgets(loss=1), Budgets(power=1)])
def test_three_trains_are_safe_and_alive(budgets: Budgets) -> None:
    """The larger case, for what stands for any number of trains."""
    found = explored(ExploredLine(trains=3, budgets=budgets))
    assert found.holds, found.story


def test_the_first_states_of_three_trains_are_safe() -> None:
    found = explored(ExploredLine(trains=3), states_max=15_000)
    assert not found.broken, found.story


def test_a_sign_off_that_frees_leads_to_a_collision_by_one_lost_telegram() -> None:
    line = ExploredLine(budgets=Budgets(loss=1))
    with restored("sign-off-frees"):
        found = explored(line, collisions_alone=True)
    assert found.broken == TWO_TRAINS
    assert "block-manager hears SignOff" in found.story
    assert not any("SignOffAccepted" in line for line in found.story), "u1 has not heard that it may leave"
    assert found.story[-1] == "u2 enters"
    assert found.chart.startswith("sequenceDiagram")
    assert "    u1->>block-manager: SignOff\n" in found.chart
    assert not explored(line, collisions_alone=True).broken


def test_an_old_token_that_is_obeyed_moves_points_under_a_train(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its command is on the air while its crew sets the route back, and another is let onto the points."""
    SWITCHES["obeys_an_old_token"](monkeypatch)
    found = explored(ExploredLine(budgets=Budgets(delay=1, set_back=1)))
    assert found.broken == "points do not lie, or are not locked, as the train on them needs"
    assert "u1 has its crew set its route back" in found.story
    assert found.story[-1] == "t1 hears PointsCommand PX normal X"


@pytest.mark.nightly
def test_a_leaver_that_counts_as_on_the_line_can_leave_its_portal_held_for_ever() -> None:
    line = ExploredLine(budgets=Budgets(delay=1))
    found = dead_end(line, "leaver-counts-as-on-the-line")
    assert found.story[-1] == "block-manager hears LeavingClaim P", (
        "made once the contact had counted the train out"
    )
    assert explored(line).dead == 0


@pytest.mark.nightly
def test_a_leaver_in_dispute_that_counts_as_on_the_line_can_hold_a_section_for_ever() -> None:
    """By one wrong word of a person: said of a train that has just left, and another let into its portal meanwhile."""
    found = dead_end(ExploredLine(budgets=Budgets(word=1)), "disputed-leaver-stays")
    assert any(line.startswith("manager") and "says that u1 is in" in line for line in found.story)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "names", [("counted-out-forgotten", "booted-leaver-unheard"), ("silent-off-the-line",)]
)
def test_a_train_that_has_left_can_hold_its_portal_for_ever_if_its_unit_then_boots(
    names: tuple[str, ...],
) -> None:
    line = ExploredLine(budgets=Budgets(delay=1, power=1))
    found = dead_end(line, *names)
    assert found.story[-1] == "u1 power fails"


@pytest.mark.nightly
@pytest.mark.parametrize("rule", ReleaseRule)
def test_with_a_tag_between_it_is_safe_and_alive(rule: ReleaseRule) -> None:
    found = explored(ExploredLine(budgets=Budgets(power=1), tag_between=rule))
    assert found.holds, found.story


@pytest.mark.nightly
def test_a_unit_that_has_booted_at_its_mark_and_keeps_what_is_behind_can_lock_both_in() -> None:
    """Released by section: another is in the portal by then, and each holds what the other needs."""
    line = ExploredLine(budgets=Budgets(power=1), tag_between=ReleaseRule.SECTION)
    dead_end(line, "booted-at-its-mark-keeps-all")


BARRED = ExploredLine(trains=1, budgets=Budgets(word=1), bars=True)
NOT_HEARD = ExploredLine(trains=1, budgets=Budgets(loss=2, delay=2, word=1))


@pytest.mark.parametrize("line", others_nightly((BARRED, BARRED._replace(trains=2), NOT_HEARD), [BARRED]))
def test_who_speaks_for_a_unit_that_may_enter_says_what_it_shows(
    line: ExploredLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """People who see its train before the portal, and not that it may come in, free the portal under it."""
    assert explored(line).holds
    monkeypatch.setattr(ExploredTrain, "seen_or_shown", ExploredTrain.occupied)
    found = explored(line)
    assert found.broken == "free in a defined register, and a train stands in it"
    assert found.story[-1] == "u1 enters"


@pytest.mark.nightly
def test_two_persons_who_are_wrong_together_break_nothing_but_after_the_managers_power_has_failed() -> None:
    """Of a unit that speaks no word counts; while nothing is known of any, two persons and nobody else say what is so.

    A train that waits before the portal, allowed in, is off the line to the eye.
    """
    assert explored(ExploredLine(budgets=Budgets(word=1), agree=True)).holds
    found = explored(ExploredLine(budgets=Budgets(power=1, word=1), agree=True))
    assert found.broken == "free in a defined register, and a train stands in it"
    assert "manager power fails" in found.story
    assert found.story[-3:] == (
        "manager Mori and Sato say that u1 is off the line",
        "manager a person accepts the picture",
        "u1 enters",
    )
