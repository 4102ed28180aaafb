"""A day played by the block manager alone, in blocks: it is asked as its host does it, no train is driven, no radio."""

from __future__ import annotations

from dataclasses import replace

from msgspec.structs import replace as replace_in

from host.order_solver import order_solver
from network.graph import all_routes
from radio import messages
from radio.keys import KEY_BYTES
from scenario.scenario import load_scenario
from study.runner.journeys import dispatch_of
from wayside.actions import Send
from wayside.block_manager import Heard, step
from wayside.config import (
    DispatcherMeans,
    JourneyMove,
    ManagerConfig,
    OrderRule,
    RouteEntry,
    StockMoves,
    manager_config,
)
from wayside.register import Register, start
from wayside.said import BoundaryPassed

AGAIN_S = 5.0  # a refused train asks again


class ManagerDay:
    """A manager and all its stock, each at a place of its journey: `at[k]` is the next move of the k-th."""

    def __init__(self, config: ManagerConfig, journeys: tuple[StockMoves, ...]) -> None:
        self.journeys = journeys
        self.moves = [list(journey.moves) for journey in journeys]  # as orders have changed them
        keys = {
            terminal: bytes(KEY_BYTES) for section in config.sections for terminal in section.terminal_ids
        }
        self.register: Register = start(config, 1, keys, solver=order_solver())
        self.at = [0] * len(journeys)
        # the place of each in the day as planned
        self.planned_at = [list(range(len(moves))) for moves in self.moves]
        self.leaves_s: dict[int, float] = {}  # when a stock leaves that holds its route already
        self.given_back: dict[int, float] = {}  # who has given it back, and until when it asks for none
        self.cut: dict[
            int, tuple[int, float]
        ] = {}  # how many trains of a stock were cut, and when it is ready again
        self._number = {journey.unit_id: k for k, journey in enumerate(journeys)}
        self._routes: dict[str, RouteEntry] = {route.route_id: route for route in config.routes}
        self._between = {(r.from_section, r.section_ids[-1]): r.route_id for r in config.routes}
        for k, journey in enumerate(journeys):
            first = self._routes.get(journey.moves[0].route_id) if journey.moves else None
            self.hear(k, messages.Claim((first.from_section,) if first else (), 0), 0.0)

    def move(self, k: int) -> JourneyMove | None:
        """The next move of a stock; None: its day is over."""
        moves, at = self.moves[k], self.at[k]
        return moves[at] if at < len(moves) else None

    def request(self, k: int) -> messages.AnyMessage:
        """What a stock asks for its next move."""
        unit_id, move = self.journeys[k].unit_id, self.moves[k][self.at[k]]
        route = self._routes.get(move.route_id)
        if route is None:
            return messages.SignOn(unit_id, (move.section_id,))
        return messages.RouteRequest(unit_id, route.route_id, route.section_ids)

    def hear(self, k: int, message: messages.AnyMessage, now_s: float) -> bool:
        """The manager hears a stock; whether it granted it something. What it orders is done at once, or refused."""
        before = self.register.counter
        heard = Heard(self.journeys[k].unit_id, 1, True, 0, message)
        self.register, actions = step(self.register, heard, now_s)
        sends = [action for action in actions if isinstance(action, Send)]
        assert sends or isinstance(message, messages.OrderRefused)
        granted = self.register.counter != before
        for send in sends:
            match send.message:
                case messages.TrackOrdered(_, instead):
                    self._go_by(k, instead)
                    return self.hear(k, self.request(k), now_s)
                case messages.TrainOrdered(_, train):
                    self._goes_on_as(k, train, now_s)
                case messages.RouteTakenBack():
                    self._asked_back(self._number[send.destination], send.message, now_s)
                case _:
                    pass
        return granted

    def _go_by(self, k: int, instead: str) -> None:
        """A stock goes by another route to its next station, and on from there."""
        moves, at, end = self.moves[k], self.at[k], self._routes[instead].section_ids[-1]
        moves[at] = replace_in(moves[at], route_id=instead, section_id=end)
        if at + 1 < len(moves):
            moves[at + 1] = replace_in(moves[at + 1], route_id=self._between[end, moves[at + 1].section_id])

    def _goes_on_as(self, k: int, train: str, now_s: float) -> None:
        """A stock ends its train where it stands, says so, and goes on from there as another."""
        moves, at, unit_id = self.moves[k], self.at[k], self.journeys[k].unit_id
        here = self._routes[moves[at].route_id].from_section
        of_it = (j for j in range(at + 1, len(moves)) if moves[j].train == train)
        to = next(j for j in of_it if moves[j].begins_at == moves[at].begins_at)
        turn_s = next(move.stays_s for move in reversed(moves[:to]) if move.train != train)
        self.cut[k] = (len(dict.fromkeys(move.train for move in moves[at:to])), now_s + turn_s)
        first = replace_in(moves[to], route_id=self._between[here, moves[to].section_id])
        self.moves[k] = [*moves[:at], first, *moves[to + 1 :]]
        del self.planned_at[k][at:to]
        self.hear(k, messages.NextTrainReport((here,), self.register.unit(unit_id).token, (), train), now_s)

    def _asked_back(self, k: int, order: messages.RouteTakenBack, now_s: float) -> None:
        """Who stands yet gives its route back, and asks again later; else it refuses."""
        unit_id, move = self.journeys[k].unit_id, self.moves[k][self.at[k]]
        if move.route_id != order.route_id or now_s >= self.leaves_s.get(k, now_s):
            self.hear(
                k, messages.OrderRefused(order.route_id, messages.OrderRefusalReason.NOT_AT_A_STOP), now_s
            )
            return
        self.given_back[k] = now_s + order.hold_s
        here = self._routes[move.route_id].from_section
        self.hear(k, messages.HoldingReport((here,), self.register.unit(unit_id).token), now_s)

    def arrives(self, k: int, now_s: float) -> JourneyMove:
        """A stock has made its move: what lies behind is given back. Tells the move."""
        unit_id, move = self.journeys[k].unit_id, self.moves[k][self.at[k]]
        if move.route_id in self._routes:
            token = self.register.unit(unit_id).token
            self.hear(k, messages.HoldingReport((move.section_id,), token), now_s)
            if move.leaves:
                self.hear(k, messages.SignOff(unit_id, token), now_s)
                self.register, _ = step(self.register, BoundaryPassed(move.section_id), now_s)
        self.at[k] += 1
        return move


def config_of(
    scenario: str,
    order: OrderRule | None = None,
    may: tuple[DispatcherMeans, ...] = (),
    *,
    cuts: bool = False,
) -> ManagerConfig:
    """The manager of a scenario, with the certificate; `order` instead of the order of trains that it has.

    `cuts`: any train may be left out, or end at any station where it stops.
    """
    setup = load_scenario(scenario).setup
    rule = setup.dispatch.order if order is None else order
    update: dict[str, object] = {"certificate": True, "order": rule, "may": may}
    if cuts:
        update |= {
            "turn_back_at": tuple(setup.line.stations),
            "cancel_trains": tuple(setup.timetable.trains),
        }
    entry = setup.dispatch.model_copy(update=update)
    unit_ids = tuple(diagram.stock_id for diagram in setup.timetable.diagrams)
    given = dispatch_of(replace(setup, dispatch=entry))
    return manager_config(setup.line, all_routes(setup.line), unit_ids, dispatch=given)
