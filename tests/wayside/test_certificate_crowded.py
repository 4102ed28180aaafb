"""No grant after which not all could finish, on a thousand crowded lines; a slice in every run, all of them at night.

Where the search runs out without a proof nothing is granted, and it is looked for with more steps when it is asked
again. Of a plan that has no order at all, what is planned before the time told can always be run.
"""

import random
from math import inf

import pytest

from radio.messages import RefusalReason, RouteRefused, SignOnRefused
from tests.wayside.crowded_line import AllStates, crowded_play, places, planned_before
from tests.wayside.loop_line import Play
from wayside import dispatch
from wayside.certificate import CertificateAnswer, CertificateProof
from wayside.said import NoOrderKnown

LINES = 1000
SLICE = 40
FEW_STEPS = 2  # with so few the search runs out on many of these lines


def lines_of(numbers: range) -> list[tuple[int, bool, bool]]:
    """Plays lines: the number of each, whether its plan can be run, and whether all came to their ends."""
    found: list[tuple[int, bool, bool]] = []
    for number in numbers:
        case = crowded_play(number)
        if case is not None:
            play, truth, can = case
            found.append((number, can, run_through(play, truth, random.Random(number))))
    return found


def run_through(play: Play, truth: AllStates, chance: random.Random) -> bool:
    """Stocks ask in random order until all have finished, or a dozen rounds let nobody on; whether all have."""
    idle = 0
    while not all(map(play.done, range(len(play.ways)))):
        going = [k for k in range(len(play.ways)) if not play.done(k)]
        chance.shuffle(going)
        granted = [asked(play, k, truth) for k in going[: chance.randint(1, len(going))]]
        idle = 0 if any(granted) else idle + 1
        if idle == 12:
            return False
        play.now_s += 10.0
    return True


def asked(play: Play, k: int, truth: AllStates) -> bool:
    """One stock asks; whether it was let on. Each answer is held against all states that can be reached."""
    before = places(play)
    could = truth.finish(before)
    answer = play.asks(k)
    if isinstance(answer, RouteRefused | SignOnRefused):
        after = tuple(place + (j == k) for j, place in enumerate(before))
        doomed = answer.reason is not RefusalReason.NO_WAY_ON or dispatch.STEPS_MAX == FEW_STEPS
        assert doomed or not could or not truth.finish(after), "a refusal although all could finish"
        return False
    assert not could or truth.finish(places(play)), "a grant after which not all can finish"
    kept = play.register.kept
    if kept is not None and kept.until_s < inf:
        partly = AllStates(planned_before(play, kept.until_s))
        assert partly.finish(places(play)), (
            "a grant after which not even that can be run which was said to be"
        )
    return True


def test_no_grant_after_which_not_all_could_finish() -> None:
    found = lines_of(range(SLICE))
    assert all(arrived for _, can, arrived in found if can)
    assert {can for _, can, _ in found} == {True, False}


@pytest.mark.nightly
def test_no_such_grant_on_a_thousand_lines() -> None:
    found = lines_of(range(LINES))
    runnable = [number for number, can, _ in found if can]
    assert min(len(runnable), len(found) - len(runnable)) > LINES // 4
    assert [number for number, can, arrived in found if can and not arrived] == []


def few_steps(patch: pytest.MonkeyPatch) -> None:
    """The search begins with hardly any steps."""
    patch.setattr(dispatch, "STEPS_MAX", FEW_STEPS)
    patch.setattr(dispatch, "NEAR_STEPS", FEW_STEPS)
    patch.setattr(dispatch, "SHORTER_STEPS", FEW_STEPS)


def test_where_the_search_runs_out_nothing_is_lost_and_all_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    """More steps each time that it is asked again."""
    few_steps(monkeypatch)
    assert all(arrived for _, can, arrived in lines_of(range(SLICE)) if can)


def test_granting_when_the_search_runs_out_loses_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    few_steps(monkeypatch)
    grants_when_the_search_runs_out(monkeypatch)
    with pytest.raises(AssertionError, match="a grant after which not all can finish"):
        lines_of(range(SLICE))


def grants_when_the_search_runs_out(patch: pytest.MonkeyPatch) -> None:
    """As where it is proven that there is no order."""
    patch.setattr(dispatch._Weighing, "_not_known", lambda *_: None)


def test_people_are_told_when_it_is_looked_for_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that never ends in a proof: it has twice the steps each time, to the last; then nothing is tried."""
    steps: list[int] = []

    def runs_out(_trains: object, steps_max: int) -> CertificateAnswer:
        steps.append(steps_max)
        return CertificateAnswer(CertificateProof.UNKNOWN, (), (0, 1), steps_max)

    monkeypatch.setattr(dispatch, "finishing_order", runs_out)
    case = crowded_play(next(number for number, can, _ in lines_with_order() if can))
    assert case is not None
    play = case[0]
    for _ in range(20):
        play.now_s += 10.0
        answers = [play.asks(k) for k in range(len(play.ways)) if not play.done(k)]
        assert all(isinstance(answer, RouteRefused) for answer in answers)
    first = dispatch.STEPS_MAX
    assert steps == [first * 2**k for k in range(5)]
    assert steps[-1] == dispatch.LAST_STEPS
    said = [note.why for note in play.notes if isinstance(note, NoOrderKnown)]
    assert len(said) == 2
    assert said[0].endswith("nothing is granted until one is known")
    assert said[1].endswith("it is looked for no more until something changes: people must")


def lines_with_order() -> list[tuple[int, bool, None]]:
    """The numbers of lines, and whether their plans can be run."""
    cases = ((number, crowded_play(number)) for number in range(SLICE))
    return [(number, case[2], None) for number, case in cases if case is not None]
