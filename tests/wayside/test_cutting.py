"""Trains ended where they stand by order: only where allowed and worth it, and sound while nobody knows the answer."""

from collections.abc import Sequence

import pytest
from msgspec.structs import replace

from radio import messages
from tests.wayside.loop_line import Play, config_of, route_of
from wayside import cutting, unanswered
from wayside.actions import Send, Show
from wayside.block_manager import Heard, step
from wayside.certificate import CertificateAnswer, CertificateProof
from wayside.config import CutRules, ManagerConfig, OrderRule
from wayside.journeys import LastSearch
from wayside.order_question import ALL, LastOrder, OrderAnswer
from wayside.register import start
from wayside.said import GoesOnAs, TrainCut

TRACKS = [1, 2, 2]
# Train 0 goes down and comes back as 0b.
WAYS = [["0.1", "1.1", "2.1", "1.1", "0.1"]]
RULES = CutRules(turn_back_at=("1",), late_s=60.0, gain_s=60.0)
ONWARD = messages.RouteRequest("u0", "1.1>2.1", ("1-2", "2.1"))
BACK = messages.RouteRequest("u0", "1.1>0.1", ("0-1", "0.1"))


def with_trains(ways: Sequence[Sequence[str]], cuts: CutRules = RULES, **dispatch: object) -> ManagerConfig:
    """The line on which each move begins at a stop, and the first stock's way back is a train of its own."""
    config = config_of(TRACKS, ways, certificate=True, cuts=cuts, **dispatch)
    journeys = [
        replace(
            journey,
            moves=tuple(
                replace(
                    move,
                    train=f"{move.train}b" if number == 0 and k >= 2 else move.train,
                    begins_at=here.split(".")[0] if "." in here else "",
                )
                for k, (move, here) in enumerate(zip(journey.moves, ways[number], strict=False))
            ),
        )
        for number, journey in enumerate(config.dispatch.journeys)
    ]
    back = [route_of(a, b) for a in ("1.1", "1.2") for b in ("0.1",)]
    routes = {route.route_id: route for route in (*config.routes, *back)}
    dispatch_of = replace(config.dispatch, journeys=tuple(journeys))
    return replace(config, routes=tuple(routes.values()), dispatch=dispatch_of)


def at_the_loop(ways: Sequence[Sequence[str]] = WAYS, cuts: CutRules = RULES, **dispatch: object) -> Play:
    """Train 0 stands at the loop five minutes late (500 s, for 200 s)."""
    play = Play(with_trains(ways, cuts, **dispatch), [list(way) for way in ways])
    assert isinstance(play.asks(0), messages.RouteGranted)
    play.now_s = 500.0
    return play


def says(play: Play, message: messages.AnyMessage, unit_id: str = "u0") -> list[object]:
    play.register, actions = step(play.register, Heard(unit_id, 1, True, 0, message), play.now_s)
    return [a.message if isinstance(a, Send) else a.note for a in actions if isinstance(a, Send | Show)]


def report(play: Play, train: str = "0b") -> messages.NextTrainReport:
    return messages.NextTrainReport(("1.1",), play.register.unit("u0").token, (), train)


def test_a_late_train_is_ended_where_that_saves_enough() -> None:
    """By hand: going on it is 300 s late at its end and 260 s on its way back; ended, it counts for its 300 s, the
    other for 60 s, and is 100 s late: 560 against 460.
    """
    play = at_the_loop()
    heard = says(play, ONWARD)
    assert messages.TrainOrdered("1.1>2.1", "0b") in heard
    (cut,) = [note for note in heard if isinstance(note, TrainCut)]
    assert cut.trains == ("0", "0b")
    assert cut.why.endswith("7 min late in all, as stated for what is cut, instead of 9")
    for gain_s, ordered in ((100.0, True), (101.0, False)):
        play = at_the_loop(cuts=replace(RULES, gain_s=gain_s))
        assert (messages.TrainOrdered("1.1>2.1", "0b") in says(play, ONWARD)) is ordered


@pytest.mark.parametrize("others", range(3))
def test_each_train_that_does_not_run_costs_what_is_stated(others: int) -> None:
    """The one that is ended counts for the 300 s that it is late, each of the others for 60 s."""
    register = at_the_loop().register
    assert register.days is not None
    trains, register = ("0", "0b", "0c")[: 1 + others], replace(register, now_s=500.0)
    assert cutting._stated_s(register, register.days, 0, 1, trains) == 300.0 + 60.0 * others


def test_a_cut_that_saves_nothing_is_none_whatever_it_must_gain() -> None:
    """By the same hand, with 160 s for the other train: 560 against 560."""
    for late_s, ordered in ((159.0, True), (160.0, False)):
        play = at_the_loop(cuts=replace(RULES, late_s=late_s, gain_s=0.0))
        assert (messages.TrainOrdered("1.1>2.1", "0b") in says(play, ONWARD)) is ordered


@pytest.mark.parametrize(
    "cuts",
    [CutRules(), replace(RULES, turn_back_at=("2",)), CutRules(trains=("0", "0b"), late_s=0.0, gain_s=0.0)],
)
def test_nothing_is_cut_that_may_not_be(cuts: CutRules) -> None:
    """Nowhere, elsewhere; or whole trains alone, and this one has run a part of its way."""
    assert not [m for m in says(at_the_loop(cuts=cuts), ONWARD) if isinstance(m, messages.TrainOrdered)]


def test_what_is_not_worth_it_is_ended_where_nobody_weighs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cutting, "WEIGHED", False)
    play = at_the_loop(cuts=replace(RULES, gain_s=1e6))
    assert messages.TrainOrdered("1.1>2.1", "0b") in says(play, ONWARD)


def test_a_train_in_time_is_not_ended() -> None:
    play = at_the_loop()
    play.now_s = 439.0  # less than the four minutes below which the plan is kept
    assert isinstance(says(play, ONWARD)[-1], messages.RouteGranted)


def test_no_delay_is_the_least_there_is() -> None:
    """Who leaves to the second loses nothing, however soon one counts as late."""
    play = at_the_loop(cuts=replace(RULES, gain_s=0.0), late_s=0.0)
    play.now_s = 200.0
    assert isinstance(says(play, ONWARD)[-1], messages.RouteGranted)


@pytest.mark.parametrize("order", OrderRule)
def test_done_it_goes_on_as_the_other_train_and_doubled_nothing_is_new(order: OrderRule) -> None:
    play = at_the_loop(order=order)
    says(play, ONWARD)
    heard = says(play, report(play))
    assert GoesOnAs(unit_id="u0", train="0b") in heard and isinstance(heard[-1], messages.HoldingConfirmed)
    days = play.register.days
    assert days is not None
    assert [hop.route_id for hop in days.hops[0]] == ["0.1>1.1", "1.1>0.1"]
    assert [type(m) for m in says(play, report(play))] == [messages.HoldingConfirmed]
    assert isinstance(says(play, BACK)[-1], messages.RouteGranted)


def test_what_was_proven_of_the_day_as_it_was_is_not_taken_for_proven_after_a_cut() -> None:
    """Each stock has made as many moves and holds the same, so the old order would seem to lead on from there."""
    kept = at_the_loop().register.kept
    assert kept is not None
    none = LastSearch(kept.at, kept.holds, CertificateAnswer(CertificateProof.NONE), 1, 900.0)
    solved = {ALL: LastOrder(0.0, kept.at, OrderAnswer())}
    register = replace(at_the_loop().register, kept=kept, sought=none, solved=solved)
    after = register.with_cut("u0", 1, "0b")
    assert after is not None
    assert (after.kept, after.sought, after.solved) == (None, None, {})


def test_a_lost_order_is_given_again_and_not_without_end() -> None:
    play = at_the_loop()
    orders = [
        any(isinstance(m, messages.TrainOrdered) for m in says(play, ONWARD))
        for _ in range(cutting.ORDERS_MAX + 2)
    ]
    assert orders == [True] * cutting.ORDERS_MAX + [False, False]
    assert isinstance(says(play, ONWARD)[-1], messages.RouteGranted)


def test_one_that_refuses_goes_on_and_is_not_asked_again() -> None:
    play = at_the_loop()
    says(play, ONWARD)
    says(play, messages.OrderRefused("1.1>2.1", messages.OrderRefusalReason.UNKNOWN_TRAIN))
    assert isinstance(says(play, ONWARD)[-1], messages.RouteGranted)


def test_an_old_report_changes_nothing() -> None:
    play = at_the_loop()
    says(play, ONWARD)
    says(play, replace(report(play), token=play.register.unit("u0").token - 1))
    assert play.register.cuts == {}


def test_of_one_that_goes_on_as_a_train_of_another_no_answer_is_awaited() -> None:
    play = at_the_loop()
    says(play, ONWARD)
    assert GoesOnAs(unit_id="u0", train="X") in says(play, report(play, "X"))
    trip = play.register.trip("u0")
    assert (trip.astray, trip.next_train) == (True, "")


def test_a_unit_that_booted_after_it_took_the_order_is_known_by_what_it_asks() -> None:
    play = at_the_loop()
    says(play, ONWARD)
    assert isinstance(says(play, BACK)[-1], messages.RouteGranted)
    assert play.register.cuts == {"u0": {1: "0b"}}


def test_the_cut_day_outlives_a_power_cut() -> None:
    play = at_the_loop()
    says(play, ONWARD)
    says(play, report(play))
    again = start(
        play.config, 2, {}, play.register.ledger, (), {"u0": 1}, play.register.tracks, cuts=play.register.cuts
    )
    assert again.days == play.register.days


def test_while_the_answer_is_out_nothing_is_granted_that_is_wrong_after_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """1 ends on the other track of the loop, 2 comes in from the west by the loop's first: if 0 goes on down all have
    room; if it has taken its order it stands against 2.
    """
    ways = [[*WAYS[0], "P"], ["2.2", "1.2"], ["P", "0.1", "1.1", "2.2"]]
    for either_way in (True, False):
        monkeypatch.setattr(unanswered, "EITHER_WAY", either_way)
        monkeypatch.setattr(cutting, "WEIGHED", False)
        play = at_the_loop(ways, RULES)
        assert isinstance(play.asks(1), messages.RouteGranted)
        assert any(isinstance(m, messages.TrainOrdered) for m in says(play, ONWARD))
        came_in = says(play, messages.SignOn("u2", ("P",)), "u2")[-1]
        assert isinstance(came_in, messages.SignOnRefused if either_way else messages.SignOnAccepted)
        if isinstance(came_in, messages.SignOnRefused):
            assert came_in.reason is messages.RefusalReason.NO_WAY_ON
