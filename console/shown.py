"""What each seat is shown of a session: the line once, and the present as often as it is asked for."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import msgspec

from console.books import posts_drawn, roles_taken, works_drawn, works_shown
from console.cab import cab_of, wait_text
from console.line_drawn import CrossingDrawn, FaultKind, PointsDrawn, SectionDrawn, StationDrawn, TrainOnPlan
from console.line_seen import LineSeen, SeenEvent
from console.protocol import (
    VERSION,
    CabShown,
    CrossingKnown,
    DeedShown,
    GraphPoint,
    PointsShown,
    RuleShown,
    SeatMessage,
    State,
    TrainForecast,
    TrainShown,
    Welcome,
)
from console.seats import RIGHTS, Seat
from console.session import Session
from network.model import Line, Section
from simulation.faults.fault import Names
from simulation.faults.script import AT_CROSSING, BY_ROLE, ActKind
from simulation.faults.table import KINDS
from simulation.judge.checkers import Checker
from simulation.setup import STEPS_PER_S, Setup
from study.wording.phrase import names_of
from study.wording.script import fault_name, item_text

CREW_SEEN: Final = "crew"  # whose acts drivers know of
EVENTS_AT_ONCE: Final = 60  # in one message; the rest follows


@dataclass(frozen=True, slots=True)
class DeskMoment:
    """The present of a session, made once for everybody: `truth` for seats that see it, `known` for the others.

    The events and the graph of `line` grow on; a moment has the first so many of them. `sees_all`: of a run that is
    only looked at, every seat sees the truth.
    """

    truth: State
    known: State
    events: tuple[list[SeenEvent], int]
    graph: tuple[list[GraphPoint], int]
    forecast: tuple[TrainForecast, ...] = ()
    cabs: Mapping[str, CabShown] = field(default_factory=dict[str, CabShown])
    crossings_by_unit: Mapping[str, tuple[CrossingKnown, ...]] = field(
        default_factory=dict[str, tuple[CrossingKnown, ...]]
    )
    messages: tuple[SeatMessage, ...] = ()
    sees_all: bool = False


@dataclass(frozen=True, slots=True)
class SentSoFar:
    """How much of the events and of the graph a connection has had, of which branch, and which forecast."""

    branch: int = -1
    events: int = 0
    graph: int = 0
    forecast: tuple[TrainForecast, ...] | None = None


def state_for(moment: DeskMoment, seat: Seat, had: SentSoFar, unit: str = "") -> tuple[State, SentSoFar]:
    """What a connection is sent that has had so much, and what it has had then."""
    leads = RIGHTS[seat].leads or moment.sees_all
    seat = Seat.INSTRUCTOR if moment.sees_all else seat
    state = _of_cab(moment, unit) if seat is Seat.DRIVER else moment.truth if leads else moment.known
    had = had if had.branch == state.branch else SentSoFar(state.branch)
    (events, count), (graph, points) = moment.events, moment.graph
    upto = min(count, had.events + EVENTS_AT_ONCE)
    new = tuple(
        e.shown
        for e in events[had.events : upto]
        if (leads or not e.truth) and (seat is not Seat.DRIVER or e.shown.who in (unit, CREW_SEEN))
    )
    state = msgspec.structs.replace(
        state,
        events=new,
        graph=() if seat is Seat.DRIVER else tuple(graph[had.graph : points]),
        forecast=None
        if moment.forecast is had.forecast or not RIGHTS[seat].sees_forecast
        else moment.forecast,
        cab=moment.cabs.get(unit) if seat is Seat.DRIVER else None,
        messages=tuple(m for m in moment.messages if leads or m.seat in ("", seat.value)),
    )
    return state, replace(had, events=upto, graph=points, forecast=moment.forecast)


def _of_cab(moment: DeskMoment, unit: str) -> State:
    """What the driver of a unit knows of it: the unit's own part."""
    known = moment.known
    own = tuple(train for train in known.trains if train.unit == unit)
    return msgspec.structs.replace(
        known,
        sections=tuple(section for section in known.sections if section.unit == unit),
        trains=own,
        crossings=moment.crossings_by_unit.get(unit, ()),
        bids=(),
        works=tuple(work for work in known.works if work.train in {train.train for train in own}),
    )


def is_behind(moment: DeskMoment, had: SentSoFar) -> bool:
    """Whether there is more than one message could hold."""
    return had.branch == moment.known.branch and had.events < moment.events[1]


def moment_of(
    session: Session,
    line: LineSeen,
    factor: float,
    branch: int,
    *,
    running: bool,
    messages: tuple[SeatMessage, ...] = (),
    units: Collection[str] = (),
) -> DeskMoment:
    """The present of a session; with the cab of each of these units."""
    digest = "" if session.ended is None else session.result.digest
    known = State(
        time_s=session.now_s,
        factor=factor,
        running=running and session.ended is None,
        ended="" if session.ended is None else session.ended.value,
        digest=digest,
        branch=branch,
        defined=line.defined,
        manager_on=line.manager_on,
        sections=line.sections,
        trains=line.trains(session.now_s),
        crossings=line.crossings.known(session.now_s),
        bids=line.bids(session.now_s),
        roles=roles_taken(session),
        works=works_shown(session),
    )
    truth = msgspec.structs.replace(
        known,
        trains=tuple(_true_train(session, train) for train in known.trains),
        points=_points(session),
        crossings=line.crossings.truth(_blocked(session)),
        silent=_silent(session),
        deeds=deeds_shown(session),
        rules=rules_shown(session),
    )
    return DeskMoment(
        truth,
        known,
        (line.events, len(line.events)),
        (line.graph, len(line.graph)),
        line.forecast(session.now_s),
        {unit: cab_of(session, unit, line.crossings) for unit in units},
        {unit: line.crossings.heard_by(unit) for unit in units},
        messages,
    )


def _true_train(session: Session, train: TrainShown) -> TrainShown:
    trains = session.simulation.trains
    slot = trains.slot_of[train.unit]
    if slot not in trains.active():
        return train
    motion = session.motion(slot)
    path = trains.true_path(slot)
    piece = session.scenario.setup.line.pieces[path.step_at(motion.position_m).piece_id]
    said = session.simulation.waits_for(slot) if motion.speed_mps == 0.0 else ""
    waits = wait_text(said, names_of(session.scenario.setup.line))
    duty = trains.duties[slot]  # a unit that is off tells of no train
    return msgspec.structs.replace(
        train,
        train=train.train if duty is None else duty.train.number,
        at_m=path.kilometrage_m(motion.position_m),
        section=piece.section_id,
        speed_mps=motion.speed_mps,
        waits_for=waits.en,
        waits_for_ja=waits.in_("ja"),
    )


def _points(session: Session) -> tuple[PointsShown, ...]:
    machines = session.simulation.wayside.machines.items()
    return tuple(
        PointsShown(
            id=points_id,
            position="" if machine.position is None else machine.position.value,
            state=machine.state.name.lower(),
        )
        for points_id, machine in machines
    )


def _blocked(session: Session) -> tuple[str, ...]:
    """Level crossings on which a vehicle stands; none after the end, when SUMO is gone."""
    crossings = session.simulation.wayside.crossings
    at = () if session.ended is not None else crossings.equipment
    return tuple(crossing_id for crossing_id in at if crossings.is_blocked(crossing_id))


def _silent(session: Session) -> tuple[str, ...]:
    simulation = session.simulation
    units = (simulation.trains.stock_ids[slot] for slot in simulation.on_board.unpowered)
    return tuple(sorted((*units, *simulation.wayside.down)))


def deeds_shown(session: Session) -> tuple[DeedShown, ...]:
    """What was done, in words."""
    return tuple(
        DeedShown(
            deed=number,
            time_s=deed.step / STEPS_PER_S,
            text=words.en,
            text_ja=words.in_("ja"),
            ends=session.can_end(number),
        )
        for number, deed in enumerate(session.deeds)
        for words in (item_text(deed.item),)
    )


def rules_shown(session: Session) -> tuple[RuleShown, ...]:
    """Every checker, and what it found."""
    counts = session.simulation.checkers.counts
    first = {found.checker: found.text for found in reversed(session.simulation.checkers.violations)}
    return tuple(
        RuleShown(rule=rule.value, broken=counts.get(rule.value, 0), first=first.get(rule.value, ""))
        for rule in Checker
    )


# the line -------------------------------------------------------------------------------------------------------------


def welcome_of(session: Session, seat: Seat) -> Welcome:
    """What does not change while the run goes on, for a seat."""
    scenario, rights = session.scenario, RIGHTS[seat]
    drawn = drawn_line(scenario.setup, seat, scenario.id, scenario.name, session.names.units)
    posts = posts_drawn(session, seat)
    unheard_of: set[ActKind] = set()
    if not posts:
        unheard_of |= BY_ROLE
    if not session.names.crossings:
        unheard_of |= AT_CROSSING
    return msgspec.structs.replace(
        drawn,
        acts=tuple(sorted(kind.value for kind in rights.acts - unheard_of)),
        works=works_drawn(scenario.setup) if posts else (),
        posts=posts,
        faults=_faults(session.names) if rights.leads else (),
        leads=rights.leads,
    )


def drawn_line(setup: Setup, seat: Seat, run: str, name: str, units: tuple[str, ...]) -> Welcome:
    """The line and its plan, for somebody who only looks on."""
    line = setup.line
    return Welcome(
        version=VERSION,
        seat=seat,
        run=run,
        name=name,
        line=line.name,
        line_ja=line.name_ja,
        stations=tuple(
            StationDrawn(id=s.id, name=s.name, name_ja=s.name_ja, at_m=s.position_m)
            for s in line.stations.values()
        ),
        sections=tuple(_drawn(line, section) for section in line.sections.values()),
        points=tuple(
            PointsDrawn(
                id=points.id,
                section=points.section_id,
                terminal=points.terminal_id,
                at_m=line.pieces[points.stem_piece].from_m,
            )
            for points in line.points.values()
        ),
        units=units,
        crossings=tuple(
            CrossingDrawn(
                id=crossing.id,
                name=crossing.name,
                section=line.pieces[crossing.piece_id].section_id,
                at_m=crossing.position_m,
                has_device=crossing.has_device,
                by_radio=crossing.by_radio,
            )
            for crossing in line.crossings.values()
        ),
        plan=_plan(setup),
        acts=(),
        faults=(),
    )


def _drawn(line: Line, section: Section) -> SectionDrawn:
    pieces = [line.pieces[piece] for piece in section.piece_ids]
    return SectionDrawn(
        id=section.id,
        kind=section.kind.value,
        from_m=min(piece.from_m for piece in pieces),
        to_m=max(piece.to_m for piece in pieces),
        lane=sum(piece.offset_m for piece in pieces) / len(pieces),
        station=section.station_id or "",
    )


def _plan(setup: Setup) -> tuple[TrainOnPlan, ...]:
    stations, timetable = setup.line.stations, setup.timetable
    planned: list[TrainOnPlan] = []
    for diagram in timetable.diagrams:
        for number in diagram.train_numbers:
            points = [
                (float(time_s), stations[call.station_id].position_m)
                for call in timetable.trains[number].calls
                for time_s in (call.arrival_s, call.departure_s)
                if time_s is not None
            ]
            planned.append(
                TrainOnPlan(
                    train=number,
                    unit=diagram.stock_id,
                    times_s=tuple(t for t, _ in points),
                    at_m=tuple(m for _, m in points),
                )
            )
    return tuple(planned)


def _faults(names: Names) -> tuple[FaultKind, ...]:
    return tuple(
        FaultKind(
            kind=kind.kind,
            name=fault_name(kind.kind).en,
            name_ja=fault_name(kind.kind).in_("ja"),
            aims_at=kind.aims_at,
            targets=tuple(map(str, kind.targets(names))),
            schema=kind.model_json_schema(),
            momentary=kind.momentary,
        )
        for kind in KINDS
        if kind.targets(names)
    )
