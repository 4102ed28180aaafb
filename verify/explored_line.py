"""The line that is explored whole, its trains, and how often each thing that is not wished for may happen.

A portal P, a section X with one set of points of each of two terminals, and beyond it a track for each train: A, B, and
C where there are three. Every train comes in by the portal, runs to its track, turns, and leaves by the portal: trains
meet, follow and wait for each other over X and P.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple

from network.model import Position, SectionKind, TagPurpose
from onboard.duty_parameters import DutyParameters, ReleaseRule
from onboard.plan import DutyPlan, PlanLeg, PlanStop, PlanTag, PointsNeeded, Span
from radio.keys import capability_key
from verify.thirds import PLACES_A_SPAN
from wayside.config import (
    MANAGER_ID,
    ManagerConfig,
    PointsEntry,
    RouteEntry,
    SectionEntry,
    TerminalConfig,
)

UNITS: Final = ("u1", "u2", "u3")
SECTIONS: Final = ("P", "X", "A", "B", "C")
BIT: Final = {section: 1 << index for index, section in enumerate(SECTIONS)}
PORTAL: Final = "P"
TERMINALS: Final = ("t1", "t2")
POINTS_OF: Final = {"t1": "PX", "t2": "PY"}
PERSONS: Final = ("Mori", "Sato")
_MASTER: Final = b"explored" * 4
_DEPARTURE_S: Final = 1000.0  # when a timer runs out is left open
_TRACK_OF: Final = {  # and how the points of t1 and t2 lie for it
    "u1": ("A", (Position.NORMAL, Position.NORMAL)),
    "u2": ("B", (Position.REVERSE, Position.REVERSE)),
    "u3": ("C", (Position.NORMAL, Position.REVERSE)),
}
_KINDS: Final = {"P": SectionKind.PORTAL, "X": SectionKind.POINTS}
CAPABILITY_KEYS: Final = {terminal: capability_key(_MASTER, terminal) for terminal in TERMINALS}


class UnwishedFor(IntEnum):
    """What is not wished for, each within a budget; `UnwishedFor.NONE` costs nothing."""

    NONE = 0
    LOSS = 1  # a telegram is lost, overtaken, or older than the age limit
    DELAY = 2  # a body moves, a person acts or a timer runs out at a party while a telegram from or to it is on the air
    POWER = 3  # of a unit, the manager or a terminal
    WORD = (
        4  # a person's word that is not true, says less than is shown, or is of a unit that speaks for itself
    )
    POINTS = 5  # a throw that is not proven in time; a position or lock that is detected no more
    SENSOR = 6  # a position lost
    SET_BACK = 7  # a crew sets its route back


ANY: Final = 99  # as often as it may be
BOOTS: Final = 4  # of the block manager, whose tokens are told apart: its power may fail once less


class Budgets(NamedTuple):
    """How often each may happen; `ANY`: it is not counted."""

    loss: int = 0
    delay: int = 0
    power: int = 0
    word: int = 0
    points: int = 0
    sensor: int = 0
    set_back: int = 0


class ExploredLine(NamedTuple):
    """What is explored: how many of the trains run, and the budgets. `timed`: each asks for its routes, and leaves,
    when its timer says so, at any time; otherwise at once. `tag_between`: there is a tag where a train is whole in X,
    besides that of the arrival, and what tags prove is given back by this rule. `bars`: two persons may bar a unit at
    the manager, which counts as a wrong word, and unbar it; who speaks for a unit there waits until nothing to it is on
    the air. `agree`: both persons say a wrong word together, which counts as one, and so may free what a silent unit
    holds.
    """

    trains: int = 2
    budgets: Budgets = Budgets()
    timed: bool = False
    tag_between: ReleaseRule | None = None
    bars: bool = False
    agree: bool = False

    @property
    def parameters(self) -> DutyParameters:
        """Times of the duty: no state knows them but by the timers that they start."""
        return DutyParameters(20.0, 45.0, 30.0, self.tag_between or ReleaseRule.ROUTE)


def manager_config(line: ExploredLine) -> ManagerConfig:
    """The manager's fixed data: only the trains that run are on its fleet list; two tracks, or three for three."""
    tracks = [track for track, _ in _TRACK_OF.values()][: max(line.trains, 2)]
    routes = [
        route
        for track in tracks
        for route in (
            RouteEntry(f"in {track}", "P", ("X", track)),
            RouteEntry(f"out {track}", track, ("X", "P")),
        )
    ]
    points = SectionEntry("X", terminal_ids=TERMINALS)
    sections = (SectionEntry("P", portal=True), points, *map(SectionEntry, tracks))
    return ManagerConfig("explored", MANAGER_ID, UNITS[: line.trains], sections, tuple(routes))


def places(line: ExploredLine) -> tuple[int, ...]:
    """Where a train may stand, as bits of sections, for what persons may say of it."""
    tracks = manager_config(line).sections[2:]
    through = [mask_of(("P",)), mask_of(("P", "X")), mask_of(("X",))]
    beside = [mask_of(sections) for t in tracks for sections in (("X", t.section_id), (t.section_id,))]
    return (*through, *beside, *(mask_of(("P", "X", t.section_id)) for t in tracks))


def terminal_config(terminal_id: str) -> TerminalConfig:
    """Fixed data of a terminal: its one set of points."""
    return TerminalConfig("explored", terminal_id, (PointsEntry(POINTS_OF[terminal_id], "X", 10.0),))


def _plan(line: ExploredLine, way: str, sections: tuple[str, ...], lie: tuple[Position, ...]) -> DutyPlan:
    needed = tuple(PointsNeeded(POINTS_OF[t], at, "X", t) for t, at in zip(TERMINALS, lie, strict=True))
    spans = tuple(
        Span(s, _KINDS.get(s, SectionKind.TRACK), needed if s == "X" else (), s, 0.0) for s in sections
    )
    first, last = sections[0], sections[-1]
    departure_s = _DEPARTURE_S if line.timed else None
    stops = (
        PlanStop(first, first != PORTAL, 0, 0, None, departure_s, passengers=False),
        PlanStop(last, last != PORTAL, 2, 2, None, None, passengers=False),
    )
    leg = PlanLeg(f"{way} {sections[0 if way == 'out' else -1]}", first, sections[1:])
    between = () if line.tag_between is None else (PlanTag(2, TagPurpose.POSITION, 2, 1),)
    tags = (*between, PlanTag(1, TagPurpose.ARRIVAL, 3, 2))
    return DutyPlan(way, way, spans, (leg,), stops, tags, last, 0.0, enters=first == PORTAL)


def plans_of(line: ExploredLine, unit_id: str) -> tuple[DutyPlan, DutyPlan]:
    """A train's way in, and out again."""
    track, lie = _TRACK_OF[unit_id]
    into, out = ("P", "X", track), (track, "X", "P")
    return _plan(line, "in", into, lie), _plan(line, "out", out, lie)


END: Final = 2 * PLACES_A_SPAN  # where a train of three spans stands at its last mark, whole in the last


def mask_of(section_ids: tuple[str, ...] | frozenset[str]) -> int:
    """Sections as bits."""
    return sum(BIT[section] for section in section_ids)


def sections_of(mask: int) -> tuple[str, ...]:
    """Bits as sections."""
    return tuple(section for section in SECTIONS if mask & BIT[section])
