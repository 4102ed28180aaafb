"""The line of the bench of exclusion, made up and without points, and its trains: each with the very unit that runs."""

from enum import Enum
from types import MappingProxyType
from typing import Final

import msgspec

from host.unit import UnitConfig, unit_of
from network.model import SectionKind, TagPurpose
from onboard.authority.records import RequestKind
from onboard.duty.records import DrivingCommand, PlaceInJoints
from onboard.duty_parameters import DutyParameters, ReleaseRule
from onboard.notes import Note as UnitNote
from onboard.plan import DutyPlan, PlanLeg, PlanStop, PlanTag, Span
from onboard.unit import OnboardUnit
from radio.envelope import Endpoint
from radio.keys import key_ring
from wayside.config import MANAGER_ID, ManagerConfig, RouteEntry, SectionEntry

MASTER: Final = b"m" * 32
UNITS: Final = ("u1", "u2", "u3")
TIMES: Final = DutyParameters(dwell_min_s=1.0, request_lead_s=1.0, emergency_release_s=1.0)
ROUTES: Final = {
    "in": RouteEntry("in", "P0", ("A", "B")),
    "over": RouteEntry("over", "B", ("C", "D", "E")),
    "back": RouteEntry("back", "E", ("D", "C", "B2")),
    "out": RouteEntry("out", "B2", ("A", "P9")),
    "over 2": RouteEntry("over 2", "B", ("C", "D", "E2")),
    "back 2": RouteEntry("back 2", "E2", ("D", "C", "B2")),
}
CONFIG: Final = ManagerConfig(
    "line",
    MANAGER_ID,
    UNITS,
    (
        SectionEntry("P0", portal=True),
        SectionEntry("A", terminal_ids=("tA",)),
        SectionEntry("B"),
        SectionEntry("B2"),
        SectionEntry("C", open_line=True),
        SectionEntry("D", terminal_ids=("tD",)),
        SectionEntry("E"),
        SectionEntry("E2"),
        SectionEntry("P9", portal=True),
    ),
    tuple(ROUTES.values()),
)
SECTIONS: Final = tuple(section.section_id for section in CONFIG.sections)
KINDS: Final = {
    "P0": SectionKind.PORTAL,
    "P9": SectionKind.PORTAL,
    "C": SectionKind.BETWEEN,
    "A": SectionKind.POINTS,
    "D": SectionKind.POINTS,
}


def plan(number: str, section_ids: tuple[str, ...], routes: tuple[str, ...]) -> DutyPlan:
    """A way over the made-up line: it stops in its first section and at the end of each route.

    Each section has two tags: one is read when the front has come in, one when the whole train is in it.
    """
    legs = tuple(PlanLeg(r, ROUTES[r].from_section, ROUTES[r].section_ids) for r in routes)
    stops = [0, *(section_ids.index(leg.section_ids[-1]) for leg in legs)]
    return DutyPlan(
        number=number,
        direction="down" if section_ids[0] == "P0" else "up",
        spans=tuple(Span(s, KINDS.get(s, SectionKind.TRACK), (), s, 0.0) for s in section_ids),
        legs=legs,
        stops=tuple(PlanStop(section_ids[i], True, i, i, None, None) for i in stops),
        tags=tuple(tag for i, s in enumerate(section_ids) for tag in _tags_of(i, s)),
        end_piece=section_ids[-1],
        end_kilometrage_m=100.0,
        enters=section_ids[0] == "P0",
    )


def _tags_of(span: int, section_id: str) -> tuple[PlanTag, PlanTag]:
    arrives = KINDS.get(section_id, SectionKind.TRACK) in (SectionKind.TRACK, SectionKind.PORTAL)
    within = TagPurpose.ARRIVAL if arrives else TagPurpose.POSITION
    first = PlanTag(2 * span, TagPurpose.POSITION, span + 1, max(span - 1, 0))
    return first, PlanTag(2 * span + 1, within, span + 1, span)


PLANS: Final = MappingProxyType(
    {
        "E": plan("1", ("P0", "A", "B", "C", "D", "E"), ("in", "over")),
        "E2": plan("3", ("P0", "A", "B", "C", "D", "E2"), ("in", "over 2")),
        "from E": plan("2", ("E", "D", "C", "B2", "A", "P9"), ("back", "out")),
        "from E2": plan("4", ("E2", "D", "C", "B2", "A", "P9"), ("back 2", "out")),
    }
)


class Where(Enum):
    """Where the world has a train."""

    OUTSIDE = "outside"
    WAITING = "waiting"  # outside the portal, its unit switched on for its next train
    ON_LINE = "on the line"
    LEAVING = "leaving"  # in its portal, signing off or on its way out


class Train:
    """One train as the world has it: `rear` to `front` are the spans of its plan under it; and its unit."""

    def __init__(self, unit_id: str, release: ReleaseRule = ReleaseRule.ROUTE) -> None:
        self.unit_id = unit_id
        self.release = release
        self.epoch = 0
        self.where = Where.OUTSIDE
        self.plan = PLANS["E"]
        self.front = self.rear = 0
        self.known = False  # its unit knows where it is
        self.emergency = False
        self.finished = False
        self.may_leave = False
        self.command = DrivingCommand()
        self.wake_at_s: float | None = None
        self.notes: list[UnitNote] = []
        self.boot()

    def boot(self) -> None:
        self.epoch += 1
        times = msgspec.structs.replace(TIMES, release=self.release)
        config = UnitConfig("line", self.unit_id, MANAGER_ID, times)
        keys = key_ring(MASTER, self.unit_id, [MANAGER_ID])
        self.unit: OnboardUnit = unit_of(config, Endpoint(keys, self.epoch))
        self.command, self.wake_at_s = DrivingCommand(), None
        self.may_leave = False

    @property
    def physical(self) -> frozenset[str]:
        """What it truly stands in."""
        if self.where not in (Where.ON_LINE, Where.LEAVING):
            return frozenset()
        return frozenset(span.section_id for span in self.plan.spans[self.rear : self.front + 1])

    @property
    def tag(self) -> int:
        """The tag that it reads where it is."""
        return 2 * self.front + (self.rear == self.front)

    @property
    def knows(self) -> bool:
        """Whether it knows what it holds: a unit that was switched on again does not before it is told."""
        authority = self.unit.state.authority
        sign_on = authority.open(RequestKind.SIGN_ON)
        return (
            authority.on_line
            or authority.leaving
            or (sign_on is not None and sign_on.section_ids is not None)
        )

    @property
    def believed(self) -> frozenset[str]:
        if self.physical and not self.knows:
            return self.physical
        return frozenset(self.unit.state.authority.held)

    def place(self, *, stands: bool = True) -> PlaceInJoints:
        """By its localisation, which is exact where it knows anything."""
        if not self.known:
            return PlaceInJoints(stands=stands, emergency=self.emergency)
        within = self.rear == self.front
        stops = [stop.span for stop in self.plan.stops]
        passed = [i for i, at in enumerate(stops) if at < self.front + within]
        return PlaceInJoints(
            known=True,
            stands=stands,
            emergency=self.emergency,
            here=self.front,
            sure=self.front + 1,
            perhaps=self.front + 1,
            clear=self.rear,
            clear_at_mark=self.rear,
            reach=self.front + 1,
            near=stops.index(self.front) if within and self.front in stops else -1,
            passed=max(passed, default=0),
        )
