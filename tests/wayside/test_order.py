"""The order of trains: kept while the train that is first is not too late, changed by its rule, and never for ever."""

import dataclasses

import pytest
from msgspec.structs import replace

from radio.messages import RefusalReason, RouteGranted, RouteRefused
from tests.wayside.loop_line import Play, config_of
from wayside import solved_order
from wayside.config import OrderRule
from wayside.journeys import DayProgress
from wayside.order import is_disturbed, played_through
from wayside.order_question import LastOrder, OrderAnswer, OrderQuestion
from wayside.places import stands_of
from wayside.said import HeldBack, OrderChanged

# The first is planned first over the line between the two stations, from the west; the other comes from the east.
TRACKS, WAYS = [2, 2], [["0.1", "1.1"], ["1.2", "0.2"]]
FIRST_DUE_S, SECOND_DUE_S = 100.0, 101.0
LATE_S, HOLD_S = 240.0, 900.0


def play_of(order: OrderRule, ways: list[list[str]] = WAYS, overtaken_max: int = 2, **more: object) -> Play:
    config = config_of(TRACKS, ways, order=order, overtaken_max=overtaken_max, **more)
    return Play(config, ways)


def why_held(play: Play) -> list[str]:
    return [note.why for note in play.notes if isinstance(note, HeldBack)]


def why_changed(play: Play) -> list[str]:
    return [note.why for note in play.notes if isinstance(note, OrderChanged)]


def test_who_asks_first_has_it_unless_an_order_is_asked_for() -> None:
    play = play_of(OrderRule.FIRST_COME)
    assert isinstance(play.asks(1), RouteGranted)
    assert play.register.plan.days is None


@pytest.mark.parametrize("order", [OrderRule.PLANNED, OrderRule.LEAST_DELAY])
def test_the_planned_order_is_kept_below_the_threshold(order: OrderRule) -> None:
    play = play_of(order)
    play.now_s = FIRST_DUE_S + LATE_S - 1.0
    refused = play.asks(1)
    assert isinstance(refused, RouteRefused)
    assert (refused.reason, refused.section_id, refused.holder) == (RefusalReason.NOT_ITS_TURN, "1.1", "u0")
    assert why_held(play) == ["1 waits for 0, planned first; it is 3 min late, threshold 4"]
    play.asks(0)
    assert isinstance(play.asks(1), RouteGranted)
    assert why_changed(play) == []


def test_beyond_the_threshold_who_asks_first_goes() -> None:
    play = play_of(OrderRule.PLANNED)
    play.now_s = FIRST_DUE_S + LATE_S
    assert isinstance(play.asks(1), RouteGranted)
    assert why_changed(play) == ["order changed: 1 goes before 0, planned first; it is 4 min late"]


def test_least_delay_counts_all_trains_and_changes_only_for_a_gain() -> None:
    """A run takes a minute either way: whoever waits, the other is a minute later, and nothing is gained."""
    play = play_of(OrderRule.LEAST_DELAY)
    play.now_s = FIRST_DUE_S + LATE_S
    assert isinstance(play.asks(1), RouteRefused)
    (why,) = why_held(play)
    assert why == "1 waits for 0, planned first; it is 4 min late: 8 min late in all, the other way 8"


def test_least_delay_lets_a_train_on_when_the_late_one_is_still_far() -> None:
    """The first is ten minutes late and has another run to make before it comes to the line that both want."""
    ways = [["0.1", "1.1", "2.1"], ["2.2", "1.2"]]
    config = config_of([2, 2, 2], ways, order=OrderRule.LEAST_DELAY)
    first, second = config.dispatch.journeys
    moves = tuple(
        replace(m, departs_s=m.departs_s + 150.0, arrives_s=m.arrives_s + 150.0) for m in second.moves
    )
    journeys = (first, replace(second, moves=moves))
    play = Play(replace(config, dispatch=replace(config.dispatch, journeys=journeys)), ways)
    play.now_s = 700.0
    assert isinstance(play.asks(1), RouteGranted)
    (why,) = why_changed(play)
    assert why.startswith("order changed: 1 goes before 0, planned first; it is 10 min late: ")


def test_nobody_waits_for_longer_than_it_may() -> None:
    play = play_of(OrderRule.PLANNED, late_s=10_000.0)
    play.now_s = FIRST_DUE_S
    assert isinstance(play.asks(1), RouteRefused)
    play.now_s = SECOND_DUE_S + HOLD_S - 1.0
    assert isinstance(play.asks(1), RouteRefused)
    play.now_s = SECOND_DUE_S + HOLD_S
    assert isinstance(play.asks(1), RouteGranted)
    assert why_changed(play) == ["order changed: 1 has waited 15 min for 0, the most it may"]


def test_a_train_that_cannot_come_first_is_not_waited_for() -> None:
    """The first is to go to the track on which the other stands: it must go, whatever the plan says."""
    ways = [["0.1", "1.2"], ["1.2", "0.2"]]
    play = play_of(OrderRule.PLANNED, ways)
    play.now_s = FIRST_DUE_S
    assert isinstance(play.asks(1), RouteGranted)
    assert why_changed(play) == ["order changed: 0 cannot come before 1 has gone"]


def test_no_train_is_let_on_before_one_that_was_overtaken_so_often() -> None:
    """Two have gone over its line while it asked: the third waits, though the late one is far beyond the threshold."""
    tracks = [3, 4]
    ways = [["0.1", "1.1"], ["0.2", "1.2"], ["0.3", "1.3"], ["1.4", "0.1"]]
    play = Play(config_of(tracks, ways, order=OrderRule.PLANNED, overtaken_max=2, late_s=60.0), ways)
    play.now_s = 90.0
    assert isinstance(play.asks(3), RouteRefused)  # it is planned last
    for k in (0, 1):
        assert isinstance(play.asks(k), RouteGranted)
    play.now_s = 110.0
    assert isinstance(play.asks(2), RouteRefused)
    assert why_held(play)[-1] == "2 waits for 3, before which 2 trains have gone"
    assert isinstance(play.asks(3), RouteGranted)
    assert isinstance(play.asks(2), RouteGranted)


@pytest.mark.parametrize("first", [True, False], ids=["planned first", "planned later"])
@pytest.mark.parametrize("stands", [True, False])
def test_nobody_waits_for_a_train_in_whose_way_another_stands(first: bool, stands: bool) -> None:
    """It was overtaken as often as may be, and a third stands on its track. Once that has gone it is next."""
    late, other, third = (0, 1, 2) if first else (1, 0, 2)
    ways = [["0.1", "1.1"], ["1.2", "0.2"], ["1.1", "2.1"]]
    if not first:
        ways[:2] = ways[1::-1]
    play = Play(config_of([2, 2, 1], ways, order=OrderRule.PLANNED, late_s=60.0), ways, now_s=300.0)
    play.register = play.register.with_trip(f"u{late}", DayProgress(asked_s=200.0, overtaken=2))
    if not stands:
        assert isinstance(play.asks(third), RouteGranted)
    assert isinstance(play.asks(other), RouteGranted if stands else RouteRefused)


def test_nobody_waits_for_a_train_that_was_overtaken_on_other_line() -> None:
    ways = [["0.1", "1.1"], ["1.2", "2.1"]]
    play = Play(config_of([1, 2, 1], ways, order=OrderRule.PLANNED, late_s=60.0), ways, now_s=300.0)
    play.register = play.register.with_trip("u1", DayProgress(asked_s=200.0, overtaken=2))
    assert isinstance(play.asks(0), RouteGranted)


@pytest.mark.parametrize("certificate", [True, False])
def test_nobody_waits_for_a_train_that_may_not_go_by_the_certificate(certificate: bool) -> None:
    """If it went, it and the one that comes against it would stand before each other for ever."""
    ways = [["0.1", "1.2", "2.1"], ["1.1", "0.2"], ["2.1", "1.2", "0.3"]]
    config = config_of([3, 2, 1], ways, order=OrderRule.PLANNED, certificate=certificate, late_s=60.0)
    play = Play(config, ways, now_s=300.0)
    play.register = play.register.with_trip("u0", DayProgress(asked_s=200.0, overtaken=2))
    assert isinstance(play.asks(1), RouteGranted if certificate else RouteRefused)


@pytest.mark.parametrize("let_on", [True, False])
@pytest.mark.parametrize("hears", [True, False])
def test_a_train_that_was_overdue_and_asks_is_news(
    let_on: bool, hears: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was expected later when the order was made, and asks or was let on; else an order holds for its minute."""
    if not hears:
        monkeypatch.setattr(solved_order, "HEARS", False)
    ways = [["0.1", "1.1", "0.1"], ["1.2", "0.2"]]
    play, questions = play_of(OrderRule.OPTIMAL, ways), list[OrderQuestion]()

    def solver(question: OrderQuestion) -> OrderAnswer:
        questions.append(question)
        return OrderAnswer((0, 1))

    play.register = replace(play.register, plan=dataclasses.replace(play.register.plan, solver=solver))
    for play.now_s in (FIRST_DUE_S + 300.0, FIRST_DUE_S + 305.0):
        assert isinstance(play.asks(1), RouteRefused)
    assert len(questions) == 1
    at_s = FIRST_DUE_S + 305.0
    trip = DayProgress(1, 305.0, granted_s=at_s) if let_on else DayProgress(asked_s=at_s)
    holders = {"1.1" if let_on else "0.1": "u0", "1.2": "u1"}
    play.register = replace(play.register, holders=holders).with_trip("u0", trip)
    for play.now_s in (FIRST_DUE_S + 306.0, FIRST_DUE_S + 307.0):
        if not play.done(1):
            play.asks(1)
    assert len(questions) == 1 + hears


def test_an_order_given_for_the_day_is_kept_and_never_for_ever() -> None:
    """The second is given first, though the first is planned first and asks first."""
    play = play_of(OrderRule.FIRST_COME, given=("u1", "u0"))
    play.now_s = FIRST_DUE_S
    assert isinstance(play.asks(0), RouteRefused)
    assert why_held(play) == ["0 waits for 1: so is the order given for the day"]
    play.now_s = FIRST_DUE_S + HOLD_S
    assert isinstance(play.asks(0), RouteGranted)
    play = play_of(OrderRule.FIRST_COME, given=("u1", "u0"))
    play.now_s = FIRST_DUE_S
    assert isinstance(play.asks(1), RouteGranted)
    assert isinstance(play.asks(0), RouteGranted)


@pytest.mark.parametrize(
    ("given", "goes"),
    [(("u1", "u0", "u1"), True), (("u1", "u1", "u0"), False), (("u1", "u1"), False), ((), True)],
    ids=["between", "last", "not in it", "none"],
)
def test_of_an_order_each_move_counts_for_itself(given: tuple[str, ...], goes: bool) -> None:
    """The second comes over another line first. What is not in the order comes last."""
    ways = [["0.1", "1.1"], ["2.1", "1.2", "0.2"]]
    play = Play(config_of([2, 2, 2], ways, given=given), ways)
    play.now_s = FIRST_DUE_S
    assert isinstance(play.asks(0), RouteGranted if goes else RouteRefused)


def test_nobody_waits_by_an_order_for_who_is_astray() -> None:
    play = play_of(OrderRule.FIRST_COME, given=("u1", "u0"))
    play.now_s = FIRST_DUE_S
    play.register = play.register.with_trip("u1", DayProgress(astray=True))
    assert isinstance(play.asks(0), RouteGranted)


@pytest.mark.parametrize("astray", [False, True])
def test_who_is_astray_disturbs_nobody(astray: bool) -> None:
    play = play_of(OrderRule.LEAST_DELAY)
    register = replace(play.register, now_s=FIRST_DUE_S + 600.0).with_trip("u1", DayProgress(astray=astray))
    days = register.days
    assert days is not None
    assert is_disturbed(register, days, stands_of(register, days), 0) is not astray


def test_what_is_left_of_an_order() -> None:
    """Stock and place in its day; what was made meanwhile is not left, in whatever order it was."""
    known = LastOrder(0.0, (0, 1), OrderAnswer((0, 1, 0, 1)))
    assert known.left((0, 1)) == [(0, 0), (1, 1), (0, 1), (1, 2)]
    assert known.left((0, 2)) == [(0, 0), (0, 1), (1, 2)]
    assert known.left((2, 3)) == []


def test_the_order_never_grants_what_the_certificate_refuses() -> None:
    """On time, the second is planned first into the siding that the third needs; that would be the end."""
    tracks = [2, 1, 2, 1, 2]
    ways = [["2.1", "3.1", "4.1"], ["0.2", "1.1", "2.2", "3.1", "4.2"], ["3.1", "2.2", "1.1", "0.1"]]
    for certificate in (True, False):
        play = Play(config_of(tracks, ways, order=OrderRule.PLANNED, certificate=certificate), ways)
        play.now_s = 99.0
        assert isinstance(play.asks(1), RouteRefused) is certificate
        assert play.finishes() is certificate


def test_a_day_is_played_through_before_midnight_too() -> None:
    """The first leaves its track 900 s before midnight, as planned, and the second when the line is free again."""
    play = play_of(OrderRule.LEAST_DELAY)
    days = play.register.days
    assert days is not None
    hops = tuple(
        tuple(replace(hop, departs_s=hop.departs_s - 1000.0, arrives_s=hop.arrives_s - 1000.0) for hop in own)
        for own in days.hops
    )
    register = replace(play.register, now_s=-2000.0)
    moves = played_through(register, dataclasses.replace(days, hops=hops), stands_of(register, days))
    assert moves is not None
    assert [move.leaves_s for move in moves] == [FIRST_DUE_S - 1000.0, FIRST_DUE_S - 940.0]
