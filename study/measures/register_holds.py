"""Who had which section when: the register played again from the journal, and where trains truly were meanwhile.

Granted, or taken as signed on, until freed; what the unit asked, commanded, had proven and reported of a section stands
with it. The tables `blocks` and `blocking` and the causes of waiting are made from these alone.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple, get_args

from network.model import Direction, Line
from onboard import notes
from onboard.crossing_notes import CrossingNote
from radio.messages import CrossingMessage
from radio.noted import Noted, Sent, TelegramNoted, TookEffect
from simulation.events import MANAGER, JournalEntry
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from study.measures.visits import SectionVisit, visits_of
from wayside import said

ROUTE_REQUEST: Final = "RouteRequest"
SIGNS_ON: Final = ("SignOn", "Claim")
POINTS_COMMAND: Final = "PointsCommand"
_TO_CROSSINGS: Final = frozenset(kind.__name__ for kind in get_args(CrossingMessage))
COUNTS_WAITING = False  # off: what is waited for while another has it is no part of an occupation


def section_holds(result: RunResult, line: Line, lengths_m: Mapping[str, float]) -> tuple[SectionHold, ...]:
    """Every section that the register had as a unit's, in the order of the grants; `lengths_m` of stock, m."""
    register = _Register(result.begin_step / STEPS_PER_S)
    for entry in result.journal.entries:
        if not is_of_crossing(entry.event):
            register.take(entry)
    visits = visits_of(result, line, lengths_m)
    for hold in register.holds:
        own = visits.get(hold.unit, ())
        hold.visit = _visit(hold, own)
        hold.number = _number(hold, own)
    return tuple(register.holds)


def is_of_crossing(event: Noted) -> bool:
    """Whether it is between a unit and a level crossing, which changes nothing of sections or of who waits for them."""
    telegram = isinstance(event, TelegramNoted) and event.kind in _TO_CROSSINGS
    return telegram or isinstance(event, CrossingNote)


def _visit(hold: SectionHold, visits: Iterable[SectionVisit]) -> SectionVisit | None:
    """How the unit was in the section while it had it; None: never."""
    own = (v for v in visits if v.section_id == hold.section_id)
    return next((v for v in own if v.begin_s <= hold.freed_s and v.rear_s >= hold.asked.wanted_s), None)


def _number(hold: SectionHold, visits: Sequence[SectionVisit]) -> str:
    """The train for which a section was had; where none was named, the one that is in it, or was seen last."""
    seen = [v for v in visits if v.begin_s <= hold.asked.heard_s] or visits[:1]
    seen = seen if hold.visit is None else [hold.visit]
    return hold.number or (seen[-1].number if seen else "")


@dataclass(slots=True)
class Throwing:
    """Points of a section are set for a train, s: the command is sent, taken, the points lie locked, it has the proof.

    Points that lay right are locked when the command is taken. `dropped`: the proof has gone since.
    """

    sent_s: float
    taken_s: float
    locked_s: float = math.inf
    proven_s: float = math.inf
    points_id: str = ""
    dropped: bool = False


@dataclass(slots=True)
class _Asking:
    """What a unit has asked for since it last held a route or changed its mind: when first, and what was sent when."""

    first_s: float | None = None
    sent_s: dict[tuple[int, int], float] = field(default_factory=dict[tuple[int, int], float])
    heard: tuple[int, int] | None = None  # the telegram that took effect last


@dataclass(slots=True)
class Tenure:
    """A section as one stock's while the block manager knew of it; `to_s` infinite: to the end of the run."""

    unit: str
    from_s: float
    to_s: float = math.inf


class AskedAt(NamedTuple):
    """When a section was wanted, the request for it that was granted was sent, and the register heard that, s."""

    wanted_s: float
    sent_s: float
    heard_s: float


@dataclass(slots=True)
class SectionHold:
    """A section as one unit's, s: by the register from `asked.heard_s` until `freed_s`, by the truth as `visit` has it.

    `number`: the train for which it was had. `waited_s`: while another had it, or its route. `held_s`: the unit counts
    it as held, `reported_s`: as given back, `arrived_s`: it has stood in it at its last stop and then left the line.
    `tenures`: while the manager knew of it, which a restart ends.
    """

    section_id: str
    unit: str
    number: str
    direction: Direction
    route_id: str
    asked: AskedAt
    token: int
    waited_s: float = 0.0
    held_s: float | None = None
    reported_s: float | None = None
    arrived_s: float = math.inf
    freed_s: float = math.inf
    visit: SectionVisit | None = None
    throwing: list[Throwing] = field(default_factory=list[Throwing])
    tenures: list[Tenure] = field(default_factory=list[Tenure])

    def known(self, t_s: float) -> None:
        """The manager knows of it from now on, if it does not yet."""
        if not self.tenures or self.tenures[-1].to_s < math.inf:
            self.tenures.append(Tenure(self.unit, t_s))

    def forgotten(self, t_s: float) -> None:
        """It knows no more of it."""
        self.tenures[-1].to_s = min(self.tenures[-1].to_s, t_s)

    def throw_of(self, points_id: str) -> Throwing | None:
        """The last time that points were set for it."""
        return next((t for t in reversed(self.throwing) if t.points_id == points_id), None)


class _Register:
    """The register as it goes on, with what units say about what they have of it."""

    def __init__(self, begin_s: float) -> None:
        self.holds: list[SectionHold] = []
        self._begin_s: Final = begin_s
        self._open: dict[str, dict[str, SectionHold]] = defaultdict(dict)  # unit -> section -> hold
        self._freed_s: dict[str, tuple[str, float]] = {}  # section -> who had it last, until when
        self._train: dict[str, tuple[str, Direction]] = {}
        self._asks: dict[tuple[str, bool], _Asking] = defaultdict(_Asking)  # unit, whether it signs on
        self._commands_s: dict[tuple[str, str, int], float] = {}  # unit, terminal, correlation -> first sent
        self._commanding: dict[
            tuple[str, str], int
        ] = {}  # unit, terminal -> correlation of the last one taken
        self._arrived_s: dict[str, float] = {}

    def take(self, entry: JournalEntry) -> None:
        """One line of the journal."""
        t_s, who, event = entry.t_s, entry.who, entry.event
        match event:
            case Sent():
                self._sent(t_s, event)
            case TookEffect():
                self._heard(event)
            case said.Granted(unit_id=unit, section_ids=sections, route_id=route, token=token):
                self._begin(t_s, unit, sections, token, route)
            case said.Accepted() | said.ConfirmedByHand():
                self._exactly(t_s, event.unit_id, event.section_ids, event.token)
            case said.Freed(unit_id=unit, section_ids=sections):
                self._end(t_s, unit, sections)
            case said.Outside(unit_id=unit):
                self._end(t_s, unit, tuple(self._open[unit]))
            case said.Started() if who == MANAGER:
                for hold in (hold for own in self._open.values() for hold in own.values()):
                    hold.forgotten(t_s)
            case said.PointsCommanded() | said.PointsProven():
                self._points(t_s, who, event)
            case _:
                self._unit(t_s, who, event)

    def _unit(self, t_s: float, unit: str, event: object) -> None:
        """What a unit says of itself."""
        match event:
            case notes.MissionBegun(train=train, direction=direction):
                self._train[unit] = train, Direction[direction.upper()]
                self._asks.pop((unit, False), None)
                if not self._open[unit]:  # what it claimed as it left, or outside, was no wish to come in
                    self._asks.pop((unit, True), None)
            case notes.Holds(section_ids=sections):
                self._holds(t_s, unit, sections)
            case notes.RouteHeld() | notes.GaveBack() | notes.UnitRestarted():
                self._asks.pop((unit, False), None)
            case notes.SignedOn():
                self._asks.pop((unit, True), None)
            case notes.Reported(section_ids=sections):
                self._reports(t_s, unit, sections)
            case notes.Arrived():
                self._arrived_s[unit] = t_s
            case notes.Proven(points_id=points):
                self._proof(t_s, unit, points, holds=True)
            case notes.ProofDropped(points_id=points):
                self._proof(t_s, unit, points, holds=False)
            case _:
                pass

    def _holds(self, t_s: float, unit: str, sections: tuple[str, ...]) -> None:
        for section_id in sections:
            hold = self._open[unit].get(section_id)
            if hold is not None and hold.held_s is None:
                hold.held_s = t_s

    def _reports(self, t_s: float, unit: str, sections: tuple[str, ...]) -> None:
        for section_id, hold in self._open[unit].items():
            if section_id not in sections and hold.reported_s is None:
                hold.reported_s = t_s

    # requests ---------------------------------------------------------------------------------------------------------

    def _sent(self, t_s: float, event: Sent) -> None:
        if event.epoch is None or event.sequence is None or event.correlation is None:
            return
        if event.kind == POINTS_COMMAND:
            self._commands_s.setdefault((event.source, event.receiver, event.correlation), t_s)
        elif event.receiver == MANAGER and event.kind in (ROUTE_REQUEST, *SIGNS_ON):
            asking = self._asks[event.source, event.kind in SIGNS_ON]
            asking.first_s = t_s if asking.first_s is None else asking.first_s
            asking.sent_s[event.epoch, event.sequence] = t_s

    def _heard(self, event: TookEffect) -> None:
        if event.kind == POINTS_COMMAND:
            self._commanding[event.source, event.receiver] = event.correlation
        elif event.receiver == MANAGER and event.kind in (ROUTE_REQUEST, *SIGNS_ON):
            self._asks[event.source, event.kind in SIGNS_ON].heard = (event.epoch, event.sequence)

    def _begin(
        self, t_s: float, unit: str, sections: tuple[str, ...], token: int, route_id: str = ""
    ) -> None:
        """Sections are the unit's from now on. Wanted since it asked, or since the last of them was free."""
        asking = self._asks[unit, not route_id]
        first_s = t_s if asking.first_s is None else min(asking.first_s, t_s)
        sent_s = t_s if asking.heard is None else min(asking.sent_s.get(asking.heard, t_s), t_s)
        new = [section_id for section_id in sections if section_id not in self._open[unit]]
        for section_id in new:  # whatever the journal lacks: one section is never two units'
            for other, held in self._open.items():
                if other != unit and section_id in held:
                    self._end(t_s, other, (section_id,))
        free_s = [s for who, s in map(self._last, new) if who != unit]
        free_s = [] if COUNTS_WAITING else free_s
        wanted_s = min(max(first_s, max(free_s, default=-math.inf), self._begin_s), t_s)
        number, direction = self._train.get(unit, ("", Direction.DOWN))
        for section_id in new:
            asked = AskedAt(wanted_s, max(sent_s, wanted_s), t_s)
            hold = SectionHold(
                section_id, unit, number, direction, route_id, asked, token, max(wanted_s - first_s, 0.0)
            )
            self._open[unit][section_id] = hold
            self.holds.append(hold)
        for section_id in sections:
            self._open[unit][section_id].known(t_s)

    def _last(self, section_id: str) -> tuple[str, float]:
        return self._freed_s.get(section_id, ("", -math.inf))

    def _exactly(self, t_s: float, unit: str, sections: tuple[str, ...], token: int) -> None:
        """The register has just these as the unit's; what stood on the line as the day began is so from then on."""
        self._end(t_s, unit, tuple(s for s in self._open[unit] if s not in sections))
        self._begin(t_s, unit, sections, token)

    def _end(self, t_s: float, unit: str, sections: tuple[str, ...]) -> None:
        for section_id in sections:
            hold = self._open[unit].pop(section_id, None)
            if hold is None:
                continue
            hold.freed_s = t_s
            hold.forgotten(t_s)
            self._freed_s[section_id] = unit, t_s
            if hold.reported_s is None:
                hold.arrived_s = self._arrived_s.get(unit, math.inf)

    # points -----------------------------------------------------------------------------------------------------------

    def _points(self, t_s: float, terminal: str, event: said.PointsCommanded | said.PointsProven) -> None:
        """A terminal has taken a command, or found the points locked by it."""
        hold = self._open[event.unit_id].get(event.section_id)
        if hold is None:
            return
        last = hold.throw_of(event.points_id)
        if isinstance(event, said.PointsProven):
            if last is not None:
                last.locked_s = min(last.locked_s, t_s)
            return
        if last is not None and not last.dropped:
            return  # the same command again
        correlation = self._commanding.get((event.unit_id, terminal), -1)
        sent_s = self._commands_s.get((event.unit_id, terminal, correlation), t_s)
        hold.throwing.append(Throwing(sent_s, t_s, points_id=event.points_id))

    def _proof(self, t_s: float, unit: str, points_id: str, *, holds: bool) -> None:
        """The unit has a proof of points, or it has gone."""
        for hold in self._open[unit].values():
            last = hold.throw_of(points_id)
            if last is not None and holds:
                last.proven_s = min(last.proven_s, t_s)
            elif last is not None:
                last.dropped = True
