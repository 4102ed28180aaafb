"""Blocking times of a run: from what parties and world wrote in the journal, and where trains truly were.

The register says whose a section is: granted, or taken as signed on, until freed. What the unit asked, held, commanded,
had proven and reported are the lines of its own; front and rear are the trace's. A section is wanted from the first
request on; while another has it, or another section of the same route, it is waited for, which is no part of the
occupation. What a run that was cut short leaves open ends with it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from network.model import Direction, Line, SectionKind
from onboard import notes
from radio.noted import Sent, TookEffect
from simulation.events import MANAGER, JournalEntry, Left
from simulation.result import BatteryEvent, EnergyPhase, RunResult
from simulation.setup import STEPS_PER_S, Setup
from study.capacity import passage
from study.capacity.occupation import TOUCH_S, Occupation, OccupationPart
from study.capacity.passage import PassageStand, SectionPassage, Throwing, occupation_of, setting_out
from study.capacity.visits import SectionVisit, visits_of
from wayside import said

PART_OF: Final = {
    EnergyPhase.AT_STOP: OccupationPart.DWELL,
    EnergyPhase.HELD: OccupationPart.HELD,
    EnergyPhase.LAYOVER: OccupationPart.LAYOVER,
    EnergyPhase.STABLED: OccupationPart.LAYOVER,
}
ROUTE_REQUEST: Final = "RouteRequest"
SIGNS_ON: Final = ("SignOn", "Claim")
POINTS_COMMAND: Final = "PointsCommand"
COUNTS_WAITING = False  # off: what is waited for while another has it is no part of an occupation


@dataclass(frozen=True, slots=True)
class RegisteredHolding:
    """A section as one unit's: by the register from `granted_s` until `freed_s`, and when it was in it by the truth, s.

    `number`: the train for which it was had. `freed_s` is infinite, and `visit` None, where that never comes.
    """

    section_id: str
    unit: str
    number: str
    token: int
    granted_s: float
    freed_s: float
    visit: SectionVisit | None


def held_of(result: RunResult, line: Line, lengths_m: Mapping[str, float]) -> tuple[RegisteredHolding, ...]:
    """Every section that the register had as a unit's, in the order of the grants."""
    visits = visits_of(result, line, lengths_m)
    found: list[RegisteredHolding] = []
    for hold in _played(result).holds:
        own = visits.get(hold.unit, ())
        visit = _visit(hold, own)
        had = hold.unit, _number(hold, visit, own), hold.token, hold.asked.heard_s, hold.freed_s
        found.append(RegisteredHolding(hold.section_id, *had, visit))
    return tuple(found)


def observed(result: RunResult, setup: Setup) -> tuple[Occupation, ...]:
    """The blocking times of a run, in order of their begin."""
    register = _played(result)
    lengths_m = {stock_id: float(kind.row[0]["length_m"]) for stock_id, kind in setup.trains.items()}
    visits = visits_of(result, setup.line, lengths_m)
    standing = _standing(result, setup, register.holds)
    ends_s = result.end_step / STEPS_PER_S
    portals = {section.id for section in setup.line.sections.values() if section.kind is SectionKind.PORTAL}
    found: list[Occupation] = []
    for hold in register.holds:
        own = visits.get(hold.unit, ()), standing[hold.unit]
        moments = _passage(hold, *own, portal=hold.section_id in portals)
        found.append(occupation_of(moments, ends_s))
    return tuple(sorted(found, key=lambda o: (o.begin_s, o.section_id)))


def _played(result: RunResult) -> _Register:
    register = _Register(result.begin_step / STEPS_PER_S)
    for entry in result.journal.entries:
        register.take(entry)
    return register


@dataclass(slots=True)
class _Asking:
    """What a unit has asked for since it last held a route or changed its mind: when first, and what was sent when."""

    first_s: float | None = None
    sent_s: dict[tuple[int, int], float] = field(default_factory=dict[tuple[int, int], float])
    heard: tuple[int, int] | None = None  # the telegram that took effect last


class AskedAt(NamedTuple):
    """When a section was wanted, and the request for it sent and heard, s."""

    wanted_s: float
    sent_s: float
    heard_s: float


@dataclass(slots=True)
class _Hold:
    """A section in the register as one unit's. `waited_s`: while another had it, or its route."""

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
    arrived_s: float = math.inf  # stood in it at its last stop and then left the line
    freed_s: float = math.inf
    throwing: list[_Throw] = field(default_factory=list["_Throw"])

    @property
    def thrown(self) -> tuple[Throwing, ...]:
        """Its points, as they were set."""
        return tuple(Throwing(t.sent_s, t.taken_s, t.locked_s, t.proven_s) for t in self.throwing)

    def throw_of(self, points_id: str) -> _Throw | None:
        """The last time that points were set for it."""
        return next((t for t in reversed(self.throwing) if t.points_id == points_id), None)


@dataclass(slots=True)
class _Throw:
    """Points set for a hold: moments as of `Throwing`; `dropped`: their proof has gone since."""

    points_id: str
    sent_s: float
    taken_s: float
    locked_s: float = math.inf
    proven_s: float = math.inf
    dropped: bool = False


class _Register:
    """The register played again, with what units say about what they have of it."""

    def __init__(self, begin_s: float) -> None:
        self.holds: list[_Hold] = []
        self._begin_s: Final = begin_s
        self._open: dict[str, dict[str, _Hold]] = defaultdict(dict)  # unit -> section -> hold
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
            hold = _Hold(section_id, unit, number, direction, route_id, asked, token)
            hold.waited_s = wanted_s - first_s if wanted_s > first_s else 0.0
            self._open[unit][section_id] = hold
            self.holds.append(hold)

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
        hold.throwing.append(_Throw(event.points_id, sent_s, t_s))

    def _proof(self, t_s: float, unit: str, points_id: str, *, holds: bool) -> None:
        """The unit has a proof of points, or it has gone."""
        for hold in self._open[unit].values():
            last = hold.throw_of(points_id)
            if last is not None and holds:
                last.proven_s = min(last.proven_s, t_s)
            elif last is not None:
                last.dropped = True


def _visit(hold: _Hold, visits: Iterable[SectionVisit]) -> SectionVisit | None:
    """How the unit was in the section while it had it; None: never."""
    own = (v for v in visits if v.section_id == hold.section_id)
    return next((v for v in own if v.begin_s <= hold.freed_s and v.rear_s >= hold.asked.wanted_s), None)


def _number(hold: _Hold, visit: SectionVisit | None, visits: Sequence[SectionVisit]) -> str:
    """The train for which a section was had; who has told of none is the train that is in it, or was seen last."""
    seen = (
        [visit] if visit is not None else [v for v in visits if v.begin_s <= hold.asked.heard_s] or visits[:1]
    )
    return hold.number or (seen[-1].number if seen else "")


def _passage(
    hold: _Hold, visits: Sequence[SectionVisit], standing: tuple[PassageStand, ...], *, portal: bool
) -> SectionPassage:
    """The moments of a hold: those of the register and the unit, and those of the truth."""
    visit = _visit(hold, visits)
    number = _number(hold, visit, visits)
    if visit is None:
        visit = SectionVisit(hold.section_id, math.inf, math.inf)
    leaves_s, rear_s = visit.leaves_s, visit.rear_s
    reported_s = hold.freed_s if hold.reported_s is None else hold.reported_s
    if (
        portal and hold.reported_s is None and visit.enters_s <= hold.arrived_s < hold.freed_s
    ):  # signed off there
        leaves_s = rear_s = reported_s = hold.arrived_s
    wanted_s, sent_s, heard_s = hold.asked
    held_s = heard_s if hold.held_s is None else hold.held_s
    if visit.enters_s == -math.inf and not hold.route_id:  # there before anybody asked
        wanted_s = sent_s = heard_s = held_s = min(wanted_s, visit.begin_s)
    return SectionPassage(
        hold.section_id,
        hold.unit,
        number,
        hold.direction,
        hold.route_id,
        wanted_s,
        sent_s,
        heard_s,
        held_s,
        visit.enters_s,
        leaves_s,
        rear_s,
        reported_s,
        hold.freed_s,
        hold.thrown,
        tuple(s for s in standing if s.end_s > wanted_s and s.begin_s < hold.freed_s),
        hold.waited_s,
    )


def _standing(result: RunResult, setup: Setup, holds: Sequence[_Hold]) -> dict[str, tuple[PassageStand, ...]]:
    """What each stock stood for, by the truth; of what went on at once the last one told counts.

    A stand of no length is that of a train that comes to a stand as the run ends.
    """
    found: dict[str, list[PassageStand]] = defaultdict(list)
    ends_s = result.end_step / STEPS_PER_S
    for record in result.energy:
        lasts = passage.LAST_STANDS and abs(record.end_s - ends_s) <= TOUCH_S
        if record.phase in PART_OF and (record.end_s > record.begin_s or lasts):
            found[record.stock_id].append(PassageStand(PART_OF[record.phase], record.begin_s, record.end_s))
    stood = {unit: tuple(own) for unit, own in found.items()}
    for unit, charged in _charging(result, setup):
        found[unit] += [both for both in (_both(charged, s) for s in stood.get(unit, ())) if both is not None]
    for unit, start in _starts(result.journal.entries):
        found[unit] += [both for both in (_both(start, s) for s in stood.get(unit, ())) if both is not None]
    for unit, setting in _settings_out(result.journal.entries, holds):
        found[unit].append(setting)
    for unit, change in _changes(result.journal.entries):
        found[unit].append(change)
    return {stock_id: tuple(found[stock_id]) for stock_id in result.stock_ids}


def _both(one: PassageStand, other: PassageStand) -> PassageStand | None:
    """What of a stand falls into another."""
    begin_s, end_s = max(one.begin_s, other.begin_s), min(one.end_s, other.end_s)
    return PassageStand(one.part, begin_s, end_s) if end_s > begin_s else None


def _charging(result: RunResult, setup: Setup) -> Iterator[tuple[str, PassageStand]]:
    """The time at chargers on the line, with raising and lowering the pantograph: since the set stood there."""
    stood_s: dict[str, float] = {}
    since_s: dict[str, float] = {}
    for record in result.battery:
        unit, charger = record.stock_id, setup.line.chargers.get(record.station)
        if record.event is BatteryEvent.STANDS:
            stood_s[unit] = record.t_s
        elif record.event is BatteryEvent.CONNECTED and charger is not None:
            since_s[unit] = min(stood_s.get(unit, record.t_s), record.t_s - charger.connect_s)
        elif record.event is BatteryEvent.DISCONNECTED and unit in since_s and charger is not None:
            yield (
                unit,
                PassageStand(OccupationPart.CHARGING, since_s.pop(unit), record.t_s + charger.disconnect_s),
            )
    for unit, from_s in since_s.items():
        yield unit, PassageStand(OccupationPart.CHARGING, from_s, result.end_step / STEPS_PER_S)


def _starts(entries: Iterable[JournalEntry]) -> Iterator[tuple[str, PassageStand]]:
    """From the word to leave until the train moves."""
    told_s: dict[str, float] = {}
    for entry in entries:
        match entry.event:
            case notes.Departs():
                told_s[entry.who] = entry.t_s
            case notes.Moving() if entry.who in told_s:
                yield entry.who, PassageStand(OccupationPart.START, told_s.pop(entry.who), entry.t_s)
            case _:
                pass


def _settings_out(
    entries: Iterable[JournalEntry], holds: Sequence[_Hold]
) -> Iterator[tuple[str, PassageStand]]:
    """While the first way of a train is set, for which its unit could not ask before it took up its number."""
    begun_s: dict[str, float] = {}
    for entry in entries:
        unit, until_s = entry.who, entry.t_s
        match entry.event:
            case notes.MissionBegun():
                begun_s[unit] = until_s
            case notes.Departs() if unit in begun_s:
                from_s = begun_s.pop(unit)
                for hold in holds:
                    if hold.unit == unit and hold.route_id and from_s <= hold.asked.sent_s <= until_s:
                        held_s = hold.asked.heard_s if hold.held_s is None else hold.held_s
                        ways = hold.asked.sent_s, hold.asked.heard_s, held_s, hold.thrown
                        yield from ((unit, one) for one in setting_out(*ways, until_s))
            case _:
                pass


def _changes(entries: Iterable[JournalEntry]) -> Iterator[tuple[str, PassageStand]]:
    """From the end of a train until the unit takes up the next one where it stands, and what it gives back before."""
    arrived_s: dict[str, float] = {}
    done_s: dict[str, float] = {}
    for entry in entries:
        match entry.event:
            case notes.Arrived():
                arrived_s[entry.who] = entry.t_s
            case notes.MissionDone():
                done_s[entry.who] = entry.t_s
            case Left(unit_id=unit):
                done_s.pop(unit, None)
            case notes.MissionBegun() if entry.who in done_s:
                ended_s = done_s.pop(entry.who)
                yield (
                    entry.who,
                    PassageStand(OccupationPart.RELEASE, arrived_s.get(entry.who, ended_s), ended_s),
                )
                yield entry.who, PassageStand(OccupationPart.CHANGE_ENDS, ended_s, entry.t_s)
            case _:
                pass
