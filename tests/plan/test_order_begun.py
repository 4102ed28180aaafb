"""What the best order begins with, what is decided by chance, where a question ends, for how long anybody waits."""

import dataclasses
import math
import random
import statistics

import pytest
from msgspec.structs import replace

from plan.dispatching import asked
from plan.dispatching.asked import answer_to
from plan.dispatching.chances import is_better
from radio.messages import RouteGranted, RouteRefused
from tests.plan.test_order_asked import ASKS_S, planned_at
from tests.plan.test_order_asked import asked as asked_play
from tests.wayside.loop_line import Play, config_of
from wayside import order, solved_order
from wayside.config import OrderRule
from wayside.journeys import Stands
from wayside.order_question import OrderAnswer, OrderMove, OrderQuestion, OrderTrain
from wayside.solved_order import question_of

STATIONS, LEG_S = 6, 400


def many(seed: int, work: float) -> OrderQuestion:
    """Eight trains that meet at every station of two tracks, 50 s to spare on each leg; two of them are late."""
    chance = random.Random(seed)
    late = chance.sample(range(8), 2)
    trains: list[OrderTrain] = []
    for k in range(8):
        east, due_s, moves = k % 2 == 0, (k // 2) * 900 + (k % 2) * 450, list[OrderMove]()
        stations = list(range(STATIONS))[:: 1 if east else -1]
        place = [10 * s + (0 if east else 1) for s in stations]
        for here, there, to in zip(stations, stations[1:], place[1:], strict=False):
            section = 100 + min(here, there)
            end = there == stations[-1]
            moves.append(OrderMove((section, to), () if end else (to,), due_s, LEG_S, 30, due_s + LEG_S, end))
            due_s += 450
        ready_s = chance.randrange(300, 1500) if k in late else 0
        trains.append(OrderTrain((), 0, (), ready_s, tuple(moves)))
    return OrderQuestion(tuple(trains), (), 7200, work)


@pytest.mark.parametrize("seed", range(4))
def test_what_it_begins_with_is_good_already(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The least that is proven by much work is there without any; begun with the plan's order it is far from there."""
    least = answer_to(many(seed, 1.0))
    assert least.delay_s == least.bound_s
    assert answer_to(many(seed, 1e-9)).delay_s == least.delay_s
    monkeypatch.setattr(asked, "RULES", False)
    assert answer_to(many(seed, 1e-9)).delay_s > 2 * least.delay_s


@pytest.mark.parametrize("extends", [True, False])
def test_a_train_that_goes_on_beyond_the_time_ahead_is_in_nobodys_way(
    extends: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A set that was to pass a station of one track first comes late from its depot; another stands there, and goes on
    after more than two hours by the plan. There is an order, as it need not stand there when the late one comes.
    """
    monkeypatch.setattr(solved_order, "EXTENDS", extends)
    ways = [["0.1", "1.1", "2.1"], ["0.2", "1.1", "2.2"]]
    given = config_of([2, 1, 2], ways, order=OrderRule.OPTIMAL, certificate=True)
    times = [[(900.0, 60.0), (20_000.0, 60.0)], [(50.0, 60.0), (200.0, 60.0)]]
    play = Play(planned_at(given, times), ways, now_s=1000.0)
    days = play.register.days
    assert days is not None
    stands = Stands((1, 0), (days.bits["1.1"], days.bits["0.2"]))
    question = question_of(play.register, days, stands)
    answer = answer_to(question)
    assert [len(train.moves) for train in question.trains] == [int(extends), 2]
    assert (answer.order == (0, 1, 1)) == (not answer.lacking) == extends


@pytest.mark.parametrize("by_time", [True, False])
def test_in_an_order_of_all_the_time_bounds_a_wait(by_time: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The slow train waits for the fast one, however many others went before; a minute before its time, too."""
    monkeypatch.setattr(order, "BY_TIME", by_time)
    play = asked_play(hold_s_max=900.0)
    assert isinstance(play.asks(0), RouteRefused)
    often = replace(play.register.trip("u0"), overtaken=9)
    play.register, play.now_s = play.register.with_trip("u0", often), ASKS_S + 840.0
    assert isinstance(play.asks(0), RouteRefused if by_time else RouteGranted)


@pytest.mark.parametrize(("held_s", "overtaken"), [(899.0, 2), (900.0, 1), (900.0, 2)])
def test_who_has_waited_long_enough_goes_first_once_two_have_gone(held_s: float, overtaken: int) -> None:
    """The fast train is first in the order, and comes when the slow one has waited for it."""
    play = asked_play(hold_s_max=900.0)
    assert isinstance(play.asks(0), RouteRefused)
    waits = replace(play.register.trip("u0"), overtaken=overtaken)
    play.register, play.now_s = play.register.with_trip("u0", waits), ASKS_S + held_s
    assert isinstance(play.asks(2), RouteRefused if (held_s, overtaken) == (900.0, 2) else RouteGranted)


@pytest.mark.parametrize(
    ("saved_s", "better"), [((300, 300, 300), True), ((900, -60, 60), False), ((20, 20, 20), False)]
)
def test_it_is_decided_otherwise_where_more_is_saved_than_chance_alone_may_show(
    saved_s: tuple[int, ...], better: bool
) -> None:
    """More in the mean than a minute, and than the standard error of the mean."""
    error = statistics.stdev(saved_s) / math.sqrt(len(saved_s))
    assert (statistics.mean(saved_s) >= max(60.0, error)) == better
    usual = [1000] * len(saved_s)
    assert is_better([1000 - saved for saved in saved_s], usual, usual) == better


@pytest.mark.parametrize("hears", [True, False])
def test_what_was_decided_ends_once_one_has_gone_that_was_waited_for(
    hears: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two ask, and each is asked about alone. The third waits for both moves of the fast one; one later it is new."""
    monkeypatch.setattr(solved_order, "HEARS", hears)
    play, found = asked_play(), list[int]()

    def solver(question: OrderQuestion) -> OrderAnswer:
        found.append(question.asks)
        return OrderAnswer((2, 2, 1) if question.asks == 1 else (2,), otherwise_s=0)

    play.register = replace(play.register, plan=dataclasses.replace(play.register.plan, solver=solver))
    assert isinstance(play.asks(1), RouteRefused)
    assert isinstance(play.asks(2), RouteGranted)
    play.now_s = ASKS_S + 10.0
    play.asks(1)
    assert found == [1, 2, *([1] if hears else [])]
