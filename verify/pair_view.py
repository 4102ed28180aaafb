"""What two units and one section are to each other: the projection by which a run is compared with what was explored.

A view of (section, unit, other unit) has of the unit its phase, where it believes itself to be with respect to the
section, whether it holds it, asks for it, and has its points proven; of the other unit whether it holds it and may be
in it; of the register both standings and the holder; of the terminals whether they lock what is proven. It is made by
the same functions of the states of the machines that run, whether they ran in a scenario or were explored.

Left out: metres, times, tokens, telegrams on the air, and all other sections and units. A stop within a plan is as one
at its end. What a third unit holds is looked at with that unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Final, NamedTuple

from network.model import SectionKind
from onboard.authority.records import RequestKind
from onboard.duty.arrival import left_by
from onboard.duty.records import DutyPhase, DutyState
from onboard.plan import DutyPlan, PointsNeeded
from wayside.point_terminal import PointsState, Terminal
from wayside.register import Register, UnitStanding

STANDS_AT_A_STOP: Final = DutyPhase.STANDING
_PHASES: Final = {DutyPhase.FINISHED: STANDS_AT_A_STOP}


class ViewedKind(Enum):
    """What kind of section is looked at."""

    PORTAL = "portal"
    POINTS = "points"
    PLAIN = "plain"  # no points, no portal; or whatever section, without its points


class Believed(Enum):
    """Where a unit believes its train to be with respect to a section."""

    UNKNOWN = "unknown"
    ELSEWHERE = "elsewhere"  # also one before or beyond it that the unit neither holds nor asks for
    BEFORE = "before it"
    PERHAPS_IN = "perhaps in it"
    IN = "in it"
    BEYOND = "beyond it"


class OwnView(NamedTuple):
    """A unit and a section; None for the phase: it has no power. `proven`: all its points, for those that it needs."""

    phase: DutyPhase | None = None
    believed: Believed = Believed.UNKNOWN
    holds: bool = False
    asks: bool = False
    proven: bool = False


class OthersView(NamedTuple):
    """The same of the other unit: only what can stand in the way. None: it does not know."""

    holds: bool = False
    within: bool | None = None


class GroundView(NamedTuple):
    """Register and terminals: standing of the unit, and of the other where it has to do with the section (None: it has
    not, or the manager is without power); whose the section is; and whether its points, where they are proven to the
    unit, are locked for it by all their terminals.
    """

    defined: bool = False
    standing: UnitStanding | None = None
    others_standing: UnitStanding | None = None
    held: bool = False
    held_by_other: bool = False
    locked: bool = False


class PairView(NamedTuple):
    """Two units and one section."""

    kind: ViewedKind
    own: OwnView
    other: OthersView
    ground: GroundView


class Powered(NamedTuple):
    """A unit with power: its plan, and where it is in its duty."""

    plan: DutyPlan
    duty: DutyState


def kind_of(kind: SectionKind, *, points: bool) -> ViewedKind:
    """How a section is looked at."""
    if kind is SectionKind.PORTAL:
        return ViewedKind.PORTAL
    return ViewedKind.POINTS if points else ViewedKind.PLAIN


def needed_in(unit: Powered | None, section_id: str) -> tuple[PointsNeeded, ...]:
    """Points of a section as a unit's plan needs them."""
    if unit is None:
        return ()
    return next((span.points for span in unit.plan.spans if span.section_id == section_id), ())


def own_view(unit: Powered | None, section_id: str) -> OwnView:
    """What a unit is to a section."""
    if unit is None:
        return OwnView()
    authority, phase = unit.duty.authority, unit.duty.phase
    request = authority.open(RequestKind.ROUTE)
    needed, holds = needed_in(unit, section_id), authority.holds(section_id)
    asks = request is not None and section_id in (request.section_ids or ())
    phase, believed = _PHASES.get(phase, phase), _believed(unit, section_id, concerns=holds or asks)
    if phase is STANDS_AT_A_STOP and holds and believed is Believed.BEYOND:
        phase = DutyPhase.RUNNING  # at a halt on open line, where nothing is given back
    return OwnView(
        phase,
        believed,
        holds,
        asks,
        bool(needed) and all(points in authority.proven for points in needed),
    )


def _believed(unit: Powered, section_id: str, *, concerns: bool) -> Believed:
    duty = unit.duty
    if duty.phase in (DutyPhase.OFF, DutyPhase.SIGNING_ON, DutyPhase.GONE) or not duty.place.known:
        return Believed.UNKNOWN
    spans = [index for index, span in enumerate(unit.plan.spans) if span.section_id == section_id]
    if not spans:
        return Believed.ELSEWHERE
    place, left = duty.place, left_by(duty)
    span = next((index for index in spans if left <= index), spans[-1])
    if left <= span < place.perhaps:
        return Believed.IN if place.sure > span else Believed.PERHAPS_IN
    if not concerns:
        return Believed.ELSEWHERE
    return Believed.BEYOND if left > span else Believed.BEFORE


def others_view(own: OwnView) -> OthersView:
    """What of a unit can stand in the way of another."""
    within = None if own.believed is Believed.UNKNOWN else own.believed in (Believed.PERHAPS_IN, Believed.IN)
    return OthersView(own.holds, within)


class GroundState(NamedTuple):
    """The register and the terminals with power, the latter by id."""

    register: Register | None
    terminals: Mapping[str, Terminal]


def pair_view(
    kind: ViewedKind,
    ground: GroundState,
    section_id: str,
    units: tuple[str, str],
    views: tuple[OwnView, OwnView],
    needed: tuple[PointsNeeded, ...],
) -> PairView | None:
    """A section by a unit and another; None: a third holds it. `needed`: its points as the unit needs them."""
    (unit, other), (own, others) = units, views
    theirs, register = others_view(others), ground.register
    locked = own.proven and all(_shows(ground.terminals.get(n.terminal_id), unit, n) for n in needed)
    seen = GroundView(locked=locked)
    if register is not None:
        holder = register.holders.get(section_id)
        if holder is not None and holder not in units:
            return None
        concerned = theirs.holds or theirs.within or holder == other
        standing = register.unit(other).standing if concerned else None
        seen = GroundView(
            register.defined,
            register.unit(unit).standing,
            standing,
            holder == unit,
            holder == other,
            locked,
        )
    view = PairView(kind, own, theirs, seen)
    return view if kind is ViewedKind.POINTS else without_points(view)._replace(kind=kind)


def _shows(terminal: Terminal | None, unit: str, needed: PointsNeeded) -> bool:
    if terminal is None or terminal.views[needed.points_id].state is not PointsState.PROVEN:
        return False
    locked = terminal.memory.commitments[needed.points_id]
    return (locked.unit_id, locked.position) == (unit, needed.position)


def without_points(view: PairView) -> PairView:
    """The same section less its points."""
    ground = view.ground._replace(locked=False)
    return PairView(ViewedKind.PLAIN, view.own._replace(proven=False), view.other, ground)
