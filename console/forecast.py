"""What comes of the day from here, as the dispatcher's own rules play it through (`wayside.order`): in blocks, each
train as late as it left, each move as soon as its sections are free.

It knows what the block manager's journal says, and nothing of where trains truly are.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Final

from msgspec.structs import replace

from console.protocol import TrainForecast
from network.graph import all_routes
from onboard.notes import Departs
from simulation.events import MANAGER, JournalEntry
from simulation.setup import Setup
from study.feasibility.planned import planned_day
from study.runner.journeys import journeys_of
from wayside import said
from wayside.config import DispatchEntry, OrderRule, manager_config
from wayside.journeys import DayProgress, Days, next_hop
from wayside.order import played_through
from wayside.places import stands_of
from wayside.register import Register, start

MADE_ANEW_S: Final = 30.0  # of the run, where nothing else has happened


class DayForecast:
    """The day of all stock as far as the manager has let it, and what follows."""

    def __init__(self, setup: Setup) -> None:
        self._line: Final = setup.line
        units = tuple(diagram.stock_id for diagram in setup.timetable.diagrams)
        journeys = journeys_of(setup, planned_day(setup))
        entry = DispatchEntry(order=OrderRule.PLANNED, journeys=journeys)
        config = manager_config(setup.line, all_routes(setup.line), units, dispatch=entry)
        keys = dict.fromkeys((p.terminal_id for p in setup.line.points.values()), b"")
        self._register: Register = start(config, 1, keys)
        self._made_s = -inf
        self._said: tuple[TrainForecast, ...] = ()
        self._stations = {t.section_id: s.position_m for s in setup.line.stations.values() for t in s.tracks}

    def see(self, entry: JournalEntry, held: Mapping[str, tuple[str, ...]]) -> None:
        """An entry was written; `held`: what each unit has, after it."""
        days = self._register.days
        if days is None or not (entry.who == MANAGER or isinstance(entry.event, Departs)):
            return
        match entry.event:
            case said.Granted(unit_id=unit, route_id=route):
                self._made(days, unit, route, "", entry.t_s)
            case said.Accepted(unit_id=unit, section_ids=sections, was="outside"):
                self._made(days, unit, "", next(iter(sections), ""), entry.t_s)
            case said.GoesOnAs(unit_id=unit, train=train):
                place = self._at(days, unit)
                self._register = self._register.with_cut(unit, place, train) or self._register
            case said.WaitBidden(unit_id=unit, hold_s=hold_s):
                self._keep(unit, entry.t_s + hold_s)
            case said.WaitOver(unit_id=unit):
                self._keep(unit, -inf)
            case Departs(station=station):
                self._left(days, entry.who, station, entry.t_s)
            case (
                said.Accepted()
                | said.Freed()
                | said.Outside()
                | said.Started()
                | said.ConfirmedByHand()
                | said.PictureChanged()
            ):
                pass
            case _:
                return
        holders = {section: unit for unit, sections in held.items() for section in sections}
        self._register = replace(self._register, holders=holders)
        self._made_s = -inf

    def trains(self, now_s: float) -> tuple[TrainForecast, ...]:
        """What follows for each train that has not ended; none where no order is known by which all can finish."""
        if now_s - self._made_s >= MADE_ANEW_S:
            self._made_s, self._said = now_s, self._played(now_s)
        return self._said

    def _played(self, now_s: float) -> tuple[TrainForecast, ...]:
        days = self._register.days
        if days is None:
            return ()
        register = self._register = replace(self._register, now_s=now_s)
        stands = stands_of(register, days)
        moves = played_through(register, days, stands)
        if moves is None:
            return ()
        points: dict[str, list[tuple[float, float]]] = {}
        for index, at in enumerate(stands.at):  # who is on the way comes as late as it left
            before = days.hops[index][at - 1] if at else None
            late_s = register.trip(days.unit_ids[index]).late_s
            if before is not None and before.arrives_s + late_s > now_s:
                points.setdefault(before.train, []).append(
                    (before.arrives_s + late_s, self._m(before.section_id))
                )
        for move in moves:
            hop = days.hops[move.stock][move.place]
            if not hop.route_id:
                continue
            own = points.setdefault(hop.train, [])
            own.append((move.leaves_s, self._m(days.ways.routes[hop.route_id].from_section)))
            own.append((move.comes_s, self._m(hop.section_id)))
        return tuple(
            TrainForecast(
                train=train, times_s=tuple(round(t) for t, _ in own), at_m=tuple(round(m) for _, m in own)
            )
            for train, own in points.items()
        )

    def _m(self, section_id: str) -> float:
        at_m = self._stations.get(section_id)
        if at_m is None:
            pieces = [self._line.pieces[piece] for piece in self._line.sections[section_id].piece_ids]
            at_m = (min(p.from_m for p in pieces) + max(p.to_m for p in pieces)) / 2.0
        return at_m

    def _at(self, days: Days, unit: str) -> int:
        return stands_of(self._register, days).at[days.index[unit]]

    def _made(self, days: Days, unit: str, route: str, portal: str, t_s: float) -> None:
        index = days.index.get(unit)
        if index is None:
            return
        place = next_hop(days, index, self._at(days, unit), route, portal)
        if place is not None:
            late_s = max(0.0, t_s - days.hops[index][place].departs_s)
            self._register = self._register.with_trip(unit, DayProgress(place + 1, late_s, granted_s=t_s))

    def _left(self, days: Days, unit: str, station: str, t_s: float) -> None:
        index = days.index.get(unit)
        if index is None:
            return
        trip, at = self._register.trip(unit), self._at(days, unit)
        if at and days.hops[index][at - 1].begins_at == station:
            late_s = max(0.0, t_s - days.hops[index][at - 1].departs_s)
            self._register = self._register.with_trip(unit, replace(trip, late_s=late_s))

    def _keep(self, unit: str, until_s: float) -> None:
        self._register = self._register.with_trip(unit, replace(self._register.trip(unit), back_s=until_s))
