"""What the dispatcher orders: given only if it can be done at once and all can then finish; lost, refused, doubled."""

import itertools
import random
from collections.abc import Sequence
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from radio.messages import (
    AnyMessage,
    HoldingReport,
    OrderRefusalReason,
    OrderRefused,
    RefusalReason,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    RouteTakenBack,
    TrackOrdered,
)
from tests.wayside.loop_line import Play, config_of, random_case, route_of
from wayside import orders
from wayside.actions import Send, Show
from wayside.block_manager import Heard, step
from wayside.config import DispatcherMeans, ManagerConfig, OrderRule
from wayside.register import start
from wayside.said import NotDone, RouteAskedBack, TrackChanged

BOTH = tuple(DispatcherMeans)


def with_choice(tracks: Sequence[int], ways: Sequence[Sequence[str]], **dispatch: object) -> ManagerConfig:
    """The line with routes between all tracks of neighbours, where every stop but the last may be on any track."""
    config = config_of(tracks, ways, **{"certificate": True, "may": BOTH, **dispatch})
    places = [["P"], *([f"{s}.{t}" for t in range(1, n + 1)] for s, n in enumerate(tracks)), ["Q"]]
    pairs = [
        (a, b)
        for here, there in itertools.pairwise(places)
        for one, other in ((here, there), (there, here))
        for a in one
        for b in other
    ]
    routes = {route.route_id: route for route in (route_of(a, b) for a, b in pairs)}

    def others(section_id: str) -> tuple[str, ...]:
        own = next(place for place in places if section_id in place)
        return tuple(section for section in own if section != section_id)

    journeys = tuple(
        replace(
            journey,
            moves=tuple(
                replace(move, others=others(move.section_id))
                if move.route_id and move is not journey.moves[-1]
                else move
                for move in journey.moves
            ),
        )
        for journey in config.dispatch.journeys
    )
    return replace(
        config, routes=tuple(routes.values()), dispatch=replace(config.dispatch, journeys=journeys)
    )


def heard_from(k: int, message: AnyMessage) -> Heard[AnyMessage]:
    return Heard(f"u{k}", 1, True, 0, message)


# Down train 0 stands at the loop on the track that down train 1, behind it, is to go to.
TRACKS, FOLLOWS = [1, 2, 2], [["1.1", "2.1"], ["0.1", "1.1", "2.2"]]


def test_a_train_whose_track_is_held_goes_to_another() -> None:
    play = Play(with_choice(TRACKS, FOLLOWS), [list(way) for way in FOLLOWS])
    answer = play.hear(1, RouteRequest("u1", "0.1>1.1", ("0-1", "1.1")))
    assert answer == TrackOrdered("0.1>1.1", "0.1>1.2")
    (said,) = [note.why for note in play.notes if isinstance(note, TrackChanged)]
    assert said == "1 goes to 1.2 instead of 1.1: 1.1 is held by u0"
    assert play.hear(1, RouteRequest("u1", "0.1>1.1", ("0-1", "1.1"))) == answer  # the first one was lost
    granted = play.hear(1, RouteRequest("u1", "0.1>1.2", ("0-1", "1.2")))
    assert isinstance(granted, RouteGranted)
    play.at[1], play.ways[1][1] = 0, "1.2"  # type: ignore[index]
    play.runs(1)
    play.ways[0][1] = "2.1"  # type: ignore[index]
    play.asks(0)
    assert isinstance(play.hear(1, RouteRequest("u1", "1.2>2.2", ("1-2", "2.2"))), RouteGranted)


def test_one_that_refuses_is_not_ordered_there_again_on_this_move() -> None:
    play = Play(with_choice(TRACKS, FOLLOWS), FOLLOWS)
    request = RouteRequest("u1", "0.1>1.1", ("0-1", "1.1"))
    assert isinstance(play.hear(1, request), TrackOrdered)
    refusal = heard_from(1, OrderRefused("0.1>1.1", OrderRefusalReason.UNKNOWN_TRACK))
    play.register, actions = step(play.register, refusal, 1.0)
    (note,) = [action.note for action in actions if isinstance(action, Show)]
    assert note == NotDone(unit_id="u1", route_id="0.1>1.1", why="unknown track")
    assert play.hear(1, request) == RouteRefused("0.1>1.1", RefusalReason.HELD, "1.1", "u0")


def test_nothing_is_ordered_unless_the_scenario_allows_it() -> None:
    play = Play(with_choice(TRACKS, FOLLOWS, may=()), FOLLOWS)
    assert isinstance(play.asks(1), RouteRefused)


# A loop of two tracks, with one of them taken and its train to go where the other comes from.
MEETS = [["0.1", "1.1", "2.1"], ["2.1", "1.1", "0.1"], ["1.2", "0.1"]]


def test_no_order_after_which_not_all_can_finish(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last free track of the loop is not given to a train whose way on is taken by one that comes to it."""
    tracks, ways = [1, 2, 1], [["0.1", "1.1", "2.1"], ["1.1", "2.1"], ["2.1", "1.1", "0.1"]]
    for proof in (True, False):
        monkeypatch.setattr(orders, "BY_PROOF", proof)
        play = Play(with_choice(tracks, ways), ways)
        ordered = play.hear(0, RouteRequest("u0", "0.1>1.1", ("0-1", "1.1")))
        assert isinstance(ordered, RouteRefused if proof else TrackOrdered)


def test_what_others_were_granted_meanwhile_takes_an_order_back() -> None:
    """Ordered to 1.2; before it asks for that, one comes in against it that can only go there."""
    ways = [["0.1", "1.1", "2.1", "Q"], ["1.1", "2.1", "Q"], ["Q", "2.1", "1.2", "0.1", "P"]]
    play = Play(with_choice([1, 2, 1], ways), [list(way) for way in ways])
    request = RouteRequest("u0", "0.1>1.1", ("0-1", "1.1"))
    assert play.hear(0, request) == TrackOrdered("0.1>1.1", "0.1>1.2")
    play.asks(2)
    assert isinstance(play.asks(2), RouteGranted)
    other = RouteRequest("u0", "0.1>1.2", ("0-1", "1.2"))
    assert play.hear(0, other) == TrackOrdered("0.1>1.2", "0.1>1.1")
    assert play.register.tracks == {}


# Train 0 holds the line to the east and does not leave; 1 comes against it and is late for it.
STANDS = [["0.1", "1.1"], ["1.2", "0.2"]]


def held_up(**dispatch: object) -> Play:
    play = Play(with_choice([2, 2], STANDS, **dispatch), STANDS)
    play.now_s = 100.0
    assert isinstance(play.hear(0, RouteRequest("u0", "0.1>1.1", ("0-1", "1.1"))), RouteGranted)
    return play


def other_sends(play: Play, now_s: float) -> list[Send]:
    play.now_s = now_s
    heard = heard_from(1, RouteRequest("u1", "1.2>0.2", ("0-1", "0.2")))
    play.register, actions = step(play.register, heard, now_s)
    play.notes += [action.note for action in actions if isinstance(action, Show)]
    return [a for a in actions if isinstance(a, Send) and a.destination == "u0"]


def test_who_does_not_leave_is_asked_for_its_route_and_the_other_goes_first() -> None:
    play = held_up()
    assert other_sends(play, 159.0) == []
    (order,) = other_sends(play, 161.0)
    token = play.register.unit("u0").token
    assert order.message == RouteTakenBack("0.1>1.1", token, orders.HOLD_S)
    (asked,) = [note for note in play.notes if isinstance(note, RouteAskedBack)]
    assert asked.why == "0 is to give its route back to 1 if it has not left, 1 min after it could"
    assert play.register.held_by("u0") == ("0.1", "0-1", "1.1")  # nothing is freed by the order itself
    play.hear(0, HoldingReport(("0.1",), token))
    assert isinstance(play.asks(1), RouteGranted)


def test_who_has_left_keeps_its_route_and_is_not_asked_again() -> None:
    play = held_up()
    assert other_sends(play, 161.0)
    refusal = heard_from(0, OrderRefused("0.1>1.1", OrderRefusalReason.NOT_AT_A_STOP))
    play.register, _ = step(play.register, refusal, 162.0)
    assert other_sends(play, 166.0) == []


def test_nobody_is_asked_for_its_route_who_was_overtaken_as_often_as_may_be() -> None:
    assert other_sends(held_up(overtaken_max=0), 161.0) == []


def test_nor_where_by_the_order_of_trains_the_other_would_wait_all_the_same() -> None:
    planned = held_up(order=OrderRule.PLANNED, late_s=240.0)
    assert other_sends(planned, 161.0) == []
    assert other_sends(planned, 100.0 + 241.0)


def test_the_tracks_are_kept_over_a_power_cut() -> None:
    play = Play(with_choice(TRACKS, FOLLOWS), FOLLOWS)
    play.hear(1, RouteRequest("u1", "0.1>1.1", ("0-1", "1.1")))
    play.hear(1, RouteRequest("u1", "0.1>1.2", ("0-1", "1.2")))
    assert play.register.tracks == {"u1": {0: "1.2"}}
    again = start(play.config, 2, {}, play.register.ledger, (), {"u1": 1}, play.register.tracks)
    assert again.days is not None
    assert [hop.route_id for hop in again.days.hops[1]] == ["0.1>1.2", "1.2>2.2"]


@dataclass
class Unruly(Play):
    """Trains that obey, refuse or never hear what is ordered, by chance, and take their time to leave."""

    chance: random.Random = field(default_factory=lambda: random.Random(1))
    waits: set[int] = field(default_factory=set[int])  # who holds its route and has not left
    orders: int = 0

    def turn(self) -> None:
        """One train does what it can; a minute passes."""
        self.now_s += 61.0
        k = self.chance.choice([k for k in range(len(self.ways)) if not self.done(k)])
        if k in self.waits:
            if self.chance.random() < 0.5:
                self.waits.discard(k)
                self.runs(k)
            return
        if self.outside[k]:
            super().asks(k)
            return
        self._asks(k)

    def _asks(self, k: int) -> None:
        way, unit_id = self.ways[k], f"u{k}"
        route = route_of(way[self.at[k]], way[self.at[k] + 1])
        heard = heard_from(k, RouteRequest(unit_id, route.route_id, route.section_ids))
        self.register, actions = step(self.register, heard, self.now_s)
        for send in [action for action in actions if isinstance(action, Send)]:
            other = int(send.destination[1:])
            match send.message:
                case RouteGranted():
                    self.waits.add(other)
                case TrackOrdered(route_id, instead):
                    self.orders += 1
                    self._other_track(other, route_id, instead)
                case RouteTakenBack() if self.chance.random() < 0.8:
                    self.orders += 1
                    self._asked_back(other, send.message)
                case _:
                    pass

    def _other_track(self, k: int, route_id: str, instead: str) -> None:
        drawn = self.chance.random()
        if drawn < 0.6:
            self.ways[k][self.at[k] + 1] = instead.split(">")[1]  # type: ignore[index]
        elif drawn < 0.8:
            self._says(k, OrderRefused(route_id, OrderRefusalReason.UNKNOWN_TRACK))

    def _asked_back(self, k: int, order: RouteTakenBack) -> None:
        if k in self.waits and self.chance.random() < 0.5:
            self.waits.discard(k)
            self._says(k, HoldingReport((self.ways[k][self.at[k]],), order.token))
        else:
            self._says(k, OrderRefused(order.route_id, OrderRefusalReason.NOT_AT_A_STOP))

    def _says(self, k: int, message: AnyMessage) -> None:
        self.register, _ = step(self.register, heard_from(k, message), self.now_s)


@given(
    st.integers(0, 10**6), st.sampled_from([OrderRule.FIRST_COME, OrderRule.PLANNED, OrderRule.LEAST_DELAY])
)
def test_whatever_trains_make_of_orders_all_finish(seed: int, rule: OrderRule) -> None:
    chance = random.Random(seed)
    tracks, ways = random_case(chance)
    play = Unruly(with_choice(tracks, ways, order=rule), [list(way) for way in ways], chance=chance)
    if not play.finishes():
        return
    for _ in range(400):
        if all(play.done(k) for k in range(len(ways))):
            return
        play.turn()
    assert all(play.done(k) for k in range(len(ways))), (play.ways, play.at)
