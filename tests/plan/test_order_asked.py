"""The order of all trains that delays them least, asked by the manager: a day with known minutes, bounds, its lack."""

import dataclasses
import math
import subprocess
from collections.abc import Sequence
from typing import Final

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from host import order_solver
from host.order_solver import SolverProcess
from host.parties import PartyError
from plan.dispatching.asked import answer_to
from radio.messages import RouteGranted, RouteRefused, RouteRequest
from study.evaluate import order_of_trains
from study.evaluate.order_of_trains import lost_min
from tests.wayside.loop_line import Play, config_of
from wayside import order, solved_order
from wayside.config import JourneyMove, ManagerConfig, OrderRule
from wayside.journeys import DayProgress, Stands, days_of
from wayside.order import is_disturbed
from wayside.order_question import OrderAnswer, OrderMove, OrderQuestion, OrderTrain, OrderWay, without_solver
from wayside.places import stands_of
from wayside.said import HeldBack, OrderLacking
from wayside.solved_order import question_of

# A slow train, late by its doors, is planned first from the middle to the east; a fast one comes against it and goes on
# to the west, from where a third is planned after it. All three ask at once, so late is the slow one.
TRACKS, WAYS = [2, 3, 2], [["1.1", "2.1"], ["0.1", "1.2"], ["2.2", "1.3", "0.2"]]
ASKS_S = 901.0
SLOW_S, FAST_S, STAYS_S, AGAIN_S = 600.0, 60.0, 20.0, 5.0
SLOW_DUE_S, THIRD_DUE_S, FAST_DUE_S = 100.0 + SLOW_S, 900.0 + FAST_S, 800.0 + FAST_S


def planned_at(given: ManagerConfig, times: Sequence[Sequence[tuple[float, float]]]) -> ManagerConfig:
    """With every move of each stock at its time, for as long as it lasts."""
    journeys = tuple(
        replace(
            journey,
            moves=tuple(
                replace(move, departs_s=at_s, arrives_s=at_s + lasts_s)
                for move, (at_s, lasts_s) in zip(journey.moves, own, strict=True)
            ),
        )
        for journey, own in zip(given.dispatch.journeys, times, strict=True)
    )
    return replace(given, dispatch=replace(given.dispatch, journeys=journeys))


def config(rule: OrderRule, **dispatch: object) -> ManagerConfig:
    given = config_of(TRACKS, WAYS, order=rule, certificate=True, **dispatch)
    times = [[(100.0, SLOW_S)], [(900.0, FAST_S)], [(720.0, FAST_S), (800.0, FAST_S)]]
    return planned_at(given, times)


@pytest.mark.parametrize(
    ("rule", "lost_s"),
    [
        # The slow one goes at once, and the fast one waits for it; the third has nobody in its way.
        (
            OrderRule.FIRST_COME,
            ASKS_S + SLOW_S - SLOW_DUE_S
            + ASKS_S + SLOW_S + FAST_S + STAYS_S + FAST_S - FAST_DUE_S
            + ASKS_S + FAST_S - THIRD_DUE_S,
        ),
        # The same, and the third waits for the fast one until that is four minutes late, too.
        (
            OrderRule.LEAST_DELAY,
            ASKS_S + SLOW_S - SLOW_DUE_S
            + ASKS_S + SLOW_S + FAST_S + STAYS_S + FAST_S - FAST_DUE_S
            + 961.0 + FAST_S - THIRD_DUE_S,
        ),
        # The fast one and the third go at once, the slow one when it asks again after that.
        (
            OrderRule.OPTIMAL,
            ASKS_S + FAST_S + AGAIN_S + SLOW_S - SLOW_DUE_S
            + ASKS_S + FAST_S + STAYS_S + FAST_S - FAST_DUE_S
            + ASKS_S + FAST_S - THIRD_DUE_S,
        ),
    ],
)  # fmt: skip
def test_a_day_on_which_the_order_of_all_is_better(
    rule: OrderRule, lost_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def doors_s(_: int, move: JourneyMove, place: int, _share: float) -> float:
        return 0.0 if place else ASKS_S - move.departs_s

    monkeypatch.setattr(order_of_trains, "doors_s", doors_s)
    # All are ready in this second, though one asks first.
    monkeypatch.setattr(solved_order, "STANDS_ON", False)
    assert lost_min(config(rule), 1) == pytest.approx(lost_s / 60.0)


def asked(*, solved: bool = True, **dispatch: object) -> Play:
    play = Play(config(OrderRule.OPTIMAL, **dispatch), WAYS, now_s=ASKS_S)
    plan = dataclasses.replace(play.register.plan, solver=answer_to if solved else without_solver)
    play.register = replace(play.register, plan=plan)
    for unit_id in ("u1", "u2"):
        play.register = play.register.with_trip(unit_id, DayProgress(asked_s=ASKS_S))
    return play


def questions_of(play: Play) -> list[OrderQuestion]:
    """What the manager asks from now on; nobody has an answer."""
    questions = list[OrderQuestion]()

    def solver(question: OrderQuestion) -> OrderAnswer:
        questions.append(question)
        return without_solver(question)

    plan = dataclasses.replace(play.register.plan, solver=solver)
    play.register = replace(play.register, plan=plan)
    return questions


def test_its_reason_is_a_sentence() -> None:
    """If the slow train waits it is 861 s late, the fast one 181, the third 1: 17 min. If it goes, 801, 781 and 1."""
    play = asked()
    assert isinstance(play.asks(0), RouteRefused)
    (held,) = [note.why for note in play.notes if isinstance(note, HeldBack)]
    assert held == "0 waits for 2: 17 min late in all in the mean, the other way 26"


def test_nobody_waits_by_it_for_longer_than_it_may(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fast train has asked, is waited for and never asks again."""
    for bounded in (True, False):
        monkeypatch.setattr(order, "BOUNDED", bounded)
        play = asked(hold_s_max=900.0)
        assert isinstance(play.asks(0), RouteRefused)
        play.now_s = ASKS_S + 899.0
        assert isinstance(play.asks(0), RouteRefused)
        play.now_s = ASKS_S + 900.0
        assert isinstance(play.asks(0), RouteGranted if bounded else RouteRefused)


def test_without_a_solver_the_order_is_that_of_less_delay_and_says_so_once() -> None:
    without, pairwise = asked(solved=False), Play(config(OrderRule.LEAST_DELAY), WAYS)
    for play in (without, pairwise):
        for play.now_s in (ASKS_S, ASKS_S + 100.0):
            play.asks(0 if play.now_s > ASKS_S else 1)
            play.asks(1)
    lacking = [note for note in without.notes if isinstance(note, OrderLacking)]
    assert [note.why for note in lacking] == ["there is no solver: the extra `plan` is not installed"]
    assert [note for note in without.notes if note not in lacking] == pairwise.notes


def test_what_is_asked_is_what_the_manager_knows() -> None:
    """The fast train has left 181 s late, and gives nothing back yet: it comes 60 s from now, is ready 20 s later."""
    play = asked()
    fast = play.config.dispatch.journeys[2].moves[0]
    assert isinstance(play.hear(2, RouteRequest("u2", fast.route_id, ("1-2", fast.section_id))), RouteGranted)
    register = play.register.with_trip("u1", DayProgress(astray=True))
    days = register.plan.days
    assert days is not None
    numbers = {section_id: k for k, section_id in enumerate(days.bits)}
    slow, third, fast_one = question_of(register, days, stands_of(register, days)).trains
    held = tuple(sorted(numbers[s] for s in ("2.2", "1-2", "1.3")))
    assert (fast_one.holds, fast_one.keeps) == (held, (numbers["1.3"],))
    assert (fast_one.comes_s, fast_one.ready_s) == (FAST_S, STAYS_S)
    line = tuple(sorted(numbers[s] for s in ("0-1", "0.2")))
    assert fast_one.moves == (OrderMove(line, (numbers["0.2"],), 0, 60, 20, int(FAST_DUE_S - ASKS_S), True),)
    assert third == OrderTrain((), 0, (), 0, ())  # it goes where nobody knows
    assert (slow.comes_s, slow.moves[0].due_s) == (0, int(SLOW_DUE_S - ASKS_S))


def ready_in_s(overdue_s: float, trip: DayProgress) -> int:
    """After how long the slow train is said to be ready that is so much overdue."""
    play = asked()
    register = replace(play.register, now_s=100.0 + overdue_s).with_trip("u0", trip)
    days = register.days
    assert days is not None
    return question_of(register, days, stands_of(register, days)).trains[0].ready_s


@pytest.mark.parametrize(("overdue_s", "in_s"), [(-40.0, 0), (0.0, 0), (1.0, 1), (301.0, 301)])
def test_who_is_due_and_does_not_ask_is_not_expected_this_second(
    overdue_s: float, in_s: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After as long again: nobody says when doors shut. One that asks is there."""
    assert ready_in_s(overdue_s, DayProgress()) == in_s
    assert ready_in_s(overdue_s, DayProgress(asked_s=100.0)) == 0
    monkeypatch.setattr(solved_order, "STANDS_ON", False)
    assert ready_in_s(overdue_s, DayProgress()) == 0


@pytest.mark.parametrize("stands_on", [True, False])
def test_nobody_waits_for_a_train_whose_doors_stay_open(
    stands_on: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two trains a minute long meet on one line; the one planned first is four minutes overdue and has not asked. The
    other is off the line before it could come, so it goes; counted as ready this second the late one is waited for.
    """
    monkeypatch.setattr(solved_order, "STANDS_ON", stands_on)
    ways = [["0.1", "1.1"], ["1.2", "0.2"]]
    play = Play(config_of([2, 2], ways, order=OrderRule.OPTIMAL, certificate=True), ways, now_s=340.0)
    plan = dataclasses.replace(play.register.plan, solver=answer_to)
    play.register = replace(play.register, plan=plan)
    assert isinstance(play.asks(1), RouteGranted if stands_on else RouteRefused)


def test_each_train_of_a_stock_counts_where_it_ends() -> None:
    given = config(OrderRule.OPTIMAL)
    *others, fast = given.dispatch.journeys
    for first, counts in (("2", [False, True]), ("another", [True, True])):
        moves = (replace(fast.moves[0], train=first), fast.moves[1])
        days = days_of(
            replace(given, dispatch=replace(given.dispatch, journeys=(*others, replace(fast, moves=moves))))
        )
        assert days is not None
        asked_of = question_of(asked().register, days, Stands((0, 0, 0), (0, 0, 0)))
        assert [move.counts for move in asked_of.trains[2].moves] == counts


def test_it_is_asked_only_where_one_is_late_and_others_want_the_line_and_once_a_minute() -> None:
    play = asked()
    questions = questions_of(play)
    for play.now_s, count in ((100.0, 0), (339.0, 0), (340.0, 1), (399.0, 1), (400.0, 2)):
        play.hear(0, RouteRequest("u0", "1.1>2.1", ("1-2", "2.1")))
        play.register = replace(
            play.register, holders={s: u for s, u in play.register.holders.items() if "-" not in s}
        )
        assert len(questions) == count
        play.register = play.register.with_trip("u0", DayProgress())
    days = play.register.plan.days
    assert days is not None
    assert is_disturbed(play.register, days, Stands((0, 0, 0), (0, 0, 0)), 0)
    assert not is_disturbed(play.register, days, Stands((0, 1, 2), (0, 0, 0)), 0)  # all others are through


def test_an_order_of_which_more_may_be_hoped_says_so() -> None:
    play = asked()
    plan = dataclasses.replace(play.register.plan, solver=lambda _: OrderAnswer((2, 1, 2, 0), 120, 60))
    play.register = replace(play.register, plan=plan)
    play.asks(0)
    (held,) = [note.why for note in play.notes if isinstance(note, HeldBack)]
    assert held == "0 waits for 2: 2 min late in all in the best order known"


def test_where_a_train_leaves_or_has_not_come_yet_nobody_else_can_be() -> None:
    """The second wants the place that the first leaves, or the line on which it still is for 40 s."""
    wants = OrderTrain((5,), 0, (5,), 0, (OrderMove((1,), (1,), 0, 10, 0, 10, True),))
    leaves = OrderTrain((1,), 0, (1,), 0, (OrderMove((100, 2), (2,), 0, 60, 0, 60, True),))
    comes = OrderTrain((1, 2), 40, (2,), 0, ())
    for first, late_s in ((leaves, 60), (comes, 40)):
        found = answer_to(OrderQuestion((first, wants), (), 7200, 0.5))
        assert (found.delay_s, found.bound_s) == (late_s, late_s)


def test_an_answer_names_trains_as_they_were_asked() -> None:
    off_the_line = OrderTrain((), 0, (), 0, ())
    assert answer_to(OrderQuestion((off_the_line, *ONE.trains), (), 7200, 0.1)).order == (1,)


ONE: Final = OrderQuestion(
    (OrderTrain((1,), 0, (1,), 30, (OrderMove((100, 11), (11,), 0, 60, 20, 60, True),)),), (), 7200, 0.1
)
ENDED: Final = OrderAnswer(lacking="the solver has ended without an answer")
NOTHING: Final = OrderQuestion((), (), 7200, 0.01)


@pytest.mark.parametrize("module", ["plan.dispatching.missing", "tests.plan.odd_solver"])
def test_a_solver_that_ends_is_none_from_then_on(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ODD_SOLVER", "ends")
    monkeypatch.setattr(order_solver, "MODULE", module)
    solver = SolverProcess()
    assert solver(NOTHING) == ENDED
    monkeypatch.setattr(order_solver, "started", None)
    assert solver(NOTHING) == ENDED


def test_a_solver_that_was_killed_is_started_again_and_answers_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start, started = order_solver.started, list[subprocess.Popen[bytes]]()
    monkeypatch.setattr(order_solver, "started", lambda: started.append(start()) or started[-1])
    for starts, answer in ((2, answer_to(ONE)), (1, ENDED)):
        monkeypatch.setattr(order_solver, "STARTS", starts)
        solver = SolverProcess()
        assert solver(ONE) == answer_to(ONE)
        started[-1].kill()
        started[-1].wait()
        assert solver(ONE) == answer
        solver.close()


@pytest.mark.parametrize(("does", "said"), [("nothing", "hangs"), ("nonsense", "what is no answer")])
def test_a_solver_that_hangs_or_answers_nonsense_ends_the_run(
    does: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ODD_SOLVER", does)
    monkeypatch.setattr(order_solver, "MODULE", "tests.plan.odd_solver")
    if does == "nothing":
        monkeypatch.setattr(order_solver, "LOOKS_S", 0.01)
        monkeypatch.setattr(order_solver, "HANGS_S", 0.0)
    solver = SolverProcess()
    with pytest.raises(PartyError, match=said):
        solver(NOTHING)
    solver.close()


def test_a_question_larger_than_a_pipe_is_answered() -> None:
    question = OrderQuestion(ONE.trains, (9,) * (1 << 16), 7200, 0.1)
    assert len(msgspec.json.encode(question)) > 1 << 16
    assert order_solver.order_solver()(question) == answer_to(question)


@pytest.mark.parametrize("order", [(7,), (-1,), (0, 0)], ids=["no train", "below none", "a move too many"])
def test_an_order_of_other_moves_than_were_asked_for_is_none(order: tuple[int, ...]) -> None:
    play = asked()
    plan = dataclasses.replace(play.register.plan, solver=lambda _: OrderAnswer(order))
    play.register = replace(play.register, plan=plan)
    play.asks(0)
    (lacking,) = [note.why for note in play.notes if isinstance(note, OrderLacking)]
    assert lacking == "the solver's order is not of the moves asked for"


@st.composite
def questions(draw: st.DrawFn) -> OrderQuestion:
    """Trains that start at either end of a line of three stations, two tracks each, and go to the other."""
    count = draw(st.integers(1, 4))
    trains: list[OrderTrain] = []
    for k in range(count):
        east, track = k % 2 == 0, k // 2
        stations = (0, 1, 2) if east else (2, 1, 0)
        place = [10 * s + track + (0 if east else 2) for s in stations]
        due_s, moves = draw(st.integers(0, 300)), list[OrderMove]()
        for here, there, to in zip(stations, stations[1:], place[1:], strict=False):
            runs_s = draw(st.integers(30, 300))
            section = 100 + min(here, there)
            moves.append(
                OrderMove((section, to), (to,), due_s, runs_s, 20, due_s + runs_s, there == stations[-1])
            )
            due_s += runs_s + 20
        trains.append(OrderTrain((place[0],), 0, (place[0],), draw(st.integers(0, 600)), tuple(moves)))
    return OrderQuestion(tuple(trains), (), 7200, 0.5)


def best_s(question: OrderQuestion) -> int:
    """The least delay of all orders, tried one by one; nobody is in anybody's way but on the line between stations."""

    def rest(at: tuple[int, ...], ready: tuple[int, ...], free: tuple[int, int]) -> float:
        costs = [0.0] if all(a == len(t.moves) for a, t in zip(at, question.trains, strict=True)) else []
        for k, train in enumerate(question.trains):
            if at[k] == len(train.moves):
                continue
            move = train.moves[at[k]]
            line = move.needs[0] - 100
            comes_s = max(ready[k], move.departs_s, free[line]) + move.runs_s
            late_s = max(0, comes_s - move.due_s) if move.counts else 0
            then = tuple(comes_s if i == line else f for i, f in enumerate(free))
            costs.append(
                late_s
                + rest(
                    (*at[:k], at[k] + 1, *at[k + 1 :]),
                    (*ready[:k], comes_s + move.stays_s, *ready[k + 1 :]),
                    (then[0], then[1]),
                )
            )
        return min(costs, default=math.inf)

    count = len(question.trains)
    return int(rest((0,) * count, tuple(train.ready_s for train in question.trains), (0, 0)))


@given(questions())
def test_the_order_delays_least(question: OrderQuestion) -> None:
    found = answer_to(question)
    assert (found.delay_s, found.bound_s) == (best_s(question), best_s(question))
    assert found == answer_to(question)


@pytest.mark.parametrize(("work", "goes_where"), [(3.0, ()), (1e-9, ()), (3.0, (5,))])
def test_a_track_settled_early_is_no_bound_of_what_could_be_done(
    work: float, goes_where: tuple[int, ...]
) -> None:
    """One stands on the first of two tracks for an hour, which another has to have after fifty minutes.

    Nothing speaks against the first when the near third is settled; on the second nobody is late. Where the one is to
    go to the place of the other (5), neither could go on from the first.
    """
    west, one, two, middle, east, beyond = range(6)
    by_two, from_two = OrderWay(west, (middle, two), (two,)), OrderWay(two, (east, *goes_where), ())
    stands = (
        OrderMove((middle, one), (one,), 0, 100, 4000, 100, False, west, (by_two,)),
        OrderMove((east, *goes_where), (), 4100, 100, 0, 4200, True, one, (from_two,)),
    )
    comes = (
        OrderMove((east, one), (one,), 3000, 100, 20, 3100, False, beyond),
        OrderMove((middle, west), (), 3200, 100, 0, 3300, True, one),
    )
    trains = OrderTrain((west,), 0, (west,), 0, stands), OrderTrain((beyond,), 0, (beyond,), 0, comes)
    found = answer_to(OrderQuestion(trains, (), 7200, work))
    assert not found.lacking
    assert found.bound_s == 0
    assert found.delay_s == 0 or work < 1.0


def test_the_process_answers_as_the_function() -> None:
    assert order_solver.order_solver()(ONE) == answer_to(ONE)
    assert answer_to(ONE).delay_s == 30
