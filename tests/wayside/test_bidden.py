"""What a dispatcher has a train do at the manager: it only keeps back, ends by itself, and is refused in words."""

import pytest

from radio.messages import (
    NextTrainReport,
    RefusalReason,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    TrainOrdered,
)
from tests.wayside.manager_desk import Desk, defined
from wayside import bidden
from wayside.bidden import TOLD_MAX
from wayside.said import EndTrain, LetGo, LetWait, Refused, TrainEndBidden, WaitBidden, WaitOver

OVER = RouteRequest("u1", "over", ("C", "D", "E"))
BACK = RouteRequest("u2", "back", ("D", "C", "B"))


@pytest.fixture
def desk() -> Desk:
    """u1 stands in B, at the west end of the line between."""
    return defined(u1=("B",))


def bid(desk: Desk, event: bidden.Bid) -> list[type]:
    return desk.act(event)  # type: ignore[arg-type]


def why(desk: Desk, event: bidden.Bid) -> str:
    from wayside.actions import Show
    from wayside.block_manager import step

    _, (shown, *_) = step(desk.register, event, desk.now_s)
    assert isinstance(shown, Show) and isinstance(shown.note, Refused)
    return shown.note.why


def test_a_train_that_is_kept_back_has_its_route_when_the_time_is_over(desk: Desk) -> None:
    assert bid(desk, LetWait("u1", "Abe", 60.0)) == [WaitBidden]
    desk.now_s += 59.9
    refused = desk.hear("u1", OVER)
    assert isinstance(refused, RouteRefused) and refused.reason is RefusalReason.NOT_ITS_TURN
    desk.now_s += 0.1
    assert isinstance(desk.hear("u1", OVER, correlation=2), RouteGranted)


def test_with_waits_switched_off_nobody_is_kept_back(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bidden, "WAITS", False)
    bid(desk, LetWait("u1", "Abe", 60.0))
    assert isinstance(desk.hear("u1", OVER), RouteGranted)


def test_a_train_is_let_go_before_its_time(desk: Desk) -> None:
    bid(desk, LetWait("u1", "Abe", 600.0))
    assert bid(desk, LetGo("u1", "Abe")) == [WaitOver]
    assert isinstance(desk.hear("u1", OVER), RouteGranted)
    assert bid(desk, LetGo("u1", "Abe")) == [Refused]


def test_the_order_of_two_trains_ends_with_the_other_on_the_line() -> None:
    """u2 comes from E to B first; u1 in B may ask as often as it likes, though nobody holds the line."""
    desk = defined(u1=("A",), u2=("E",))
    go = RouteRequest("u1", "in", ("A", "B"))
    assert bid(desk, LetWait("u1", "Abe", 900.0, "u2", "C")) == [WaitBidden]
    refused = desk.hear("u1", go)
    assert isinstance(refused, RouteRefused)
    assert (refused.reason, refused.section_id, refused.holder) == (RefusalReason.NOT_ITS_TURN, "C", "u2")
    assert isinstance(desk.hear("u2", BACK), RouteGranted)
    assert WaitOver in desk.kinds
    assert desk.register.bidden == {}
    assert bid(desk, LetWait("u1", "Abe", 900.0, "u2", "C")) == [WaitBidden, WaitOver]  # it has it already


@pytest.mark.parametrize(
    ("event", "said"),
    [
        (LetWait("u1", "Abe", 60.0, "u2"), "both"),
        (LetWait("u1", "Abe", 60.0, "u1", "C"), "that train"),
        (LetWait("u1", "Abe", 60.0, "u2", "Z"), "no such section"),
        (LetGo("u1", "Abe"), "not kept back"),
        (EndTrain("u3", "Abe", "9"), "one track"),
        (LetWait("u9", "Abe", 60.0), "fleet list"),
    ],
)
def test_what_makes_no_sense_is_refused_in_words_and_changes_nothing(
    desk: Desk, event: bidden.Bid, said: str
) -> None:
    before = desk.register.bidden
    assert said in why(desk, event)
    assert bid(desk, event) == [Refused]
    assert desk.register.bidden == before


def test_two_trains_cannot_be_told_to_wait_for_each_other(desk: Desk) -> None:
    bid(desk, LetWait("u1", "Abe", 60.0, "u2", "C"))
    assert "each other" in why(desk, LetWait("u2", "Abe", 60.0, "u1", "C"))


def test_a_train_is_told_to_end_until_it_says_so_or_often_enough(desk: Desk) -> None:
    assert bid(desk, EndTrain("u1", "Abe", "12")) == [TrainEndBidden]
    assert desk.hear("u1", OVER) == TrainOrdered("over", "12")
    desk.hear("u1", NextTrainReport(("B",), desk.register.unit("u1").token, (), "12"), correlation=2)
    assert isinstance(desk.hear("u1", OVER, correlation=3), RouteGranted)


def test_a_train_is_told_to_end_where_another_has_its_way() -> None:
    """u2 stands in C and cannot go on: u1 in B would wait for it for ever; but who only waits is refused as ever."""
    desk = defined(u1=("B",), u2=("C",))
    bid(desk, EndTrain("u1", "Abe", "12"))
    assert desk.hear("u1", OVER) == TrainOrdered("over", "12")
    bid(desk, LetWait("u1", "Abe", 60.0))
    refused = desk.hear("u1", OVER, correlation=2)
    assert isinstance(refused, RouteRefused) and refused.reason is RefusalReason.HELD


def test_an_order_that_is_never_answered_is_given_up(desk: Desk) -> None:
    bid(desk, EndTrain("u1", "Abe", "12"))
    for number in range(TOLD_MAX):
        assert isinstance(desk.hear("u1", OVER, correlation=number + 1), TrainOrdered)
    assert isinstance(desk.hear("u1", OVER, correlation=TOLD_MAX + 1), RouteGranted)


def test_it_is_forgotten_with_the_power() -> None:
    from tests.wayside.manager_desk import CONFIG, KEYS
    from wayside.register import start

    assert start(CONFIG, 2, KEYS, ledger=("u1",)).bidden == {}
