"""What a wayside device must know: its fixed data (固定データ, section 4.1.3 (3)), which a power cut does
not lose.

Built by the simulator from the line, kept as JSON beside the device's durable state, read at its start.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import Enum
from typing import Final

import msgspec

from network.errors import InputError
from network.model import CrossingClass, CrossingControl, Line, Route, SectionKind
from network.virtual_blocks import radio_reaches
from radio.envelope import AGE_MAX_S

MANAGER_ID: Final = "block-manager"
ASK_INTERVAL_S: Final = 5.0


class ReentryMode(Enum):
    """How the block state comes back after the manager lost it."""

    ASSISTED = "assisted"  # units are asked, a person accepts the picture or corrects it for silent units
    BY_HAND = (
        "by_hand"  # a person enters every section (手動入力), then accepts; units are asked all the same
    )


class SectionEntry(msgspec.Struct, frozen=True):
    """A section of the register; `terminal_ids` drive points in it; a train may leave the line from a
    portal, and be stabled on a track of a station; where the radio reaches all of open line, it may wait there
    (`hears`) for the rest of its way.
    """

    section_id: str
    portal: bool = False
    terminal_ids: tuple[str, ...] = ()
    open_line: bool = False
    hears: bool = False


class RouteEntry(msgspec.Struct, frozen=True):
    """A route that may be granted, whole or what lies ahead of a train that is on it.

    The unit must hold `from_section` or a part of the route; of what lies ahead, the section in which it begins.
    `entry` and `overlap` are those of `network.model.Route`.
    """

    route_id: str
    from_section: str
    section_ids: tuple[str, ...]
    entry: tuple[str, ...] = ()
    overlap: tuple[str, ...] = ()

    def has_part(self, section_ids: tuple[str, ...]) -> bool:
        """Whether these are the route, or its end from some section on."""
        return bool(section_ids) and self.section_ids[-len(section_ids) :] == section_ids

    def leads_to(self, section_ids: tuple[str, ...]) -> frozenset[str]:
        """Sections of which a unit must hold one to be let into this end of the route."""
        if section_ids == self.section_ids:
            return frozenset((self.from_section, *section_ids))
        first = len(self.section_ids) - len(section_ids)
        return frozenset(self.section_ids[first - 1 : first + 1])


class OrderRule(Enum):
    """Who goes first over a section that several trains want."""

    FIRST_COME = "first_come"  # who asks first
    PLANNED = "planned"  # as planned, until the train that is first is late
    LEAST_DELAY = "least_delay"  # as planned; beyond that, which of the two first delays all trains less
    OPTIMAL = "optimal"  # as planned; where a train is late beyond that, what delays all least in the mean


class JourneyMove(msgspec.Struct, frozen=True, array_like=True):
    """A move of a stock's day: by a route, or onto the line by a portal (then `route_id` is empty).

    `section_id`: where it ends; `leaves`: by that portal, off the line. Planned times s since midnight; `stays_s`: from
    its end to the next move at least. `others`: tracks of the same station where it may end instead. `begins_at`: the
    station where the train stands before it; empty where it does not.
    """

    train: str
    route_id: str
    section_id: str
    leaves: bool
    departs_s: float
    arrives_s: float
    stays_s: float
    others: tuple[str, ...] = ()
    begins_at: str = ""


class StockMoves(msgspec.Struct, frozen=True):
    """All moves of one stock's day, in order, from where it stands at first."""

    unit_id: str
    moves: tuple[JourneyMove, ...]


class DispatcherMeans(Enum):
    """What the dispatcher may do besides letting trains wait for their routes."""

    CHANGE_TRACK = "change_track"  # another track of the next station (着発線変更)
    TAKE_BACK = "take_back"  # a route granted to a train that does not leave, so that others go first


class CutRules(msgspec.Struct, frozen=True):
    """At which stations a train may be ended early, so that its set goes on as a later one, and which trains may be
    left out whole. Each train that is cut counts as `late_s` late; it must save `gain_s` beyond that.
    """

    turn_back_at: tuple[str, ...] = ()
    trains: tuple[str, ...] = ()
    late_s: float = 3600.0
    gain_s: float = 600.0

    @property
    def any(self) -> bool:
        """Whether any train may be cut."""
        return bool(self.turn_back_at or self.trains)


NO_CUTS: Final = CutRules()


class DispatchEntry(msgspec.Struct, frozen=True):
    """How routes are given to trains that could all have them; see `wayside.dispatch`.

    `given`: the order of the day, a unit for each of all moves in turn; empty: none is given. `may`: see there.
    """

    certificate: bool = False
    order: OrderRule = OrderRule.FIRST_COME
    late_s: float = 240.0
    hold_s_max: float = 900.0
    overtaken_max: int = 2
    journeys: tuple[StockMoves, ...] = ()
    given: tuple[str, ...] = ()
    parts: bool = False  # of a way in virtual blocks, as far as it is free; with the certificate alone
    may: tuple[DispatcherMeans, ...] = ()
    cuts: CutRules = NO_CUTS

    @property
    def weighs(self) -> bool:
        """Whether anything but the register decides."""
        return (
            self.certificate
            or self.order is not OrderRule.FIRST_COME
            or bool(self.given or self.may or self.cuts.any)
        )


NO_DISPATCH: Final = DispatchEntry()


class ManagerConfig(msgspec.Struct, frozen=True, tag="block-manager"):
    """Fixed data of the block manager. `unit_ids` is the fleet list; units not on it do not exist."""

    line_id: str
    device_id: str
    unit_ids: tuple[str, ...]
    sections: tuple[SectionEntry, ...]
    routes: tuple[RouteEntry, ...]
    ask_interval_s: float = ASK_INTERVAL_S
    telegram_age_max_s: float = AGE_MAX_S
    reentry: ReentryMode = ReentryMode.ASSISTED
    dispatch: DispatchEntry = NO_DISPATCH


class PointsEntry(msgspec.Struct, frozen=True):
    """Points of a terminal; a throw that is not proven within `throw_limit_s` has failed."""

    points_id: str
    section_id: str
    throw_limit_s: float


class TerminalConfig(msgspec.Struct, frozen=True, tag="point-terminal"):
    """Fixed data of a point terminal."""

    line_id: str
    device_id: str
    points: tuple[PointsEntry, ...]
    telegram_age_max_s: float = AGE_MAX_S


class CrossingConfig(msgspec.Struct, frozen=True, tag="level-crossing"):
    """Fixed data of the device of a level crossing: from the start of the warning to closed, and from there to the
    train, s; without `barriers` lamps alone close it. `contacts` control it; with `protection` units hear from it
    whether anything is on it, with `departures` trains that begin beyond the first contact ask it to close.
    """

    line_id: str
    device_id: str
    barriers: bool
    closing_s: float
    closed_s: float
    telegram_age_max_s: float = AGE_MAX_S
    protection: bool = False
    departures: bool = False
    contacts: bool = False


DeviceConfig = ManagerConfig | TerminalConfig | CrossingConfig


def encode_config(config: DeviceConfig) -> bytes:
    """The configuration as JSON."""
    return msgspec.json.encode(config)


def decode_config(data: bytes, file: str = "config.json") -> DeviceConfig:
    """The configuration in JSON. Raises InputError that names `file`."""
    try:
        return msgspec.json.decode(data, type=DeviceConfig)  # type: ignore[no-any-return, arg-type, unused-ignore]
    except msgspec.MsgspecError as error:
        raise InputError(file, "", None, f"the configuration of a wayside device ({error})") from None


def manager_config(
    line: Line,
    routes: Iterable[Route],
    unit_ids: Sequence[str],
    age_max_s: float = AGE_MAX_S,
    reentry: ReentryMode = ReentryMode.ASSISTED,
    dispatch: DispatchEntry = NO_DISPATCH,
) -> ManagerConfig:
    """Fixed data of the line's one block manager; sections in the order of the line file."""
    terminals: dict[str, set[str]] = {}
    for points in line.points.values():
        terminals.setdefault(points.section_id, set()).add(points.terminal_id)
    sections = tuple(
        SectionEntry(
            section.id,
            section.kind is SectionKind.PORTAL,
            tuple(sorted(terminals.get(section.id, ()))),
            section.kind is SectionKind.BETWEEN,
            section.kind is SectionKind.BETWEEN and radio_reaches(line, section),
        )
        for section in line.sections.values()
    )
    entries = tuple(
        RouteEntry(route.id, route.from_section, route.section_ids, route.entry, route.overlap)
        for route in routes
    )
    return ManagerConfig(
        line.id,
        MANAGER_ID,
        tuple(unit_ids),
        sections,
        entries,
        telegram_age_max_s=age_max_s,
        reentry=reentry,
        dispatch=dispatch,
    )


def terminal_configs(line: Line, age_max_s: float = AGE_MAX_S) -> tuple[TerminalConfig, ...]:
    """Fixed data of every point terminal. The limit of a throw is its time and a half, and a second."""
    entries: dict[str, list[PointsEntry]] = {}
    for points in line.points.values():
        entry = PointsEntry(points.id, points.section_id, 1.5 * points.throw_time_s + 1.0)
        entries.setdefault(points.terminal_id, []).append(entry)
    return tuple(
        TerminalConfig(line.id, terminal_id, tuple(entries[terminal_id]), age_max_s)
        for terminal_id in sorted(entries)
    )


def crossing_configs(line: Line, age_max_s: float = AGE_MAX_S) -> tuple[CrossingConfig, ...]:
    """Fixed data of the device of every level crossing that has one."""
    return tuple(
        CrossingConfig(
            line.id,
            crossing.id,
            crossing.kind is CrossingClass.BARRIERS,
            crossing.closing_s,
            crossing.closed_s,
            age_max_s,
            crossing.has_protection,
            crossing.warns_departures,
            crossing.control is CrossingControl.CONTACTS,
        )
        for crossing in line.crossings.values()
        if crossing.has_device
    )
