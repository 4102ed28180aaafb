"""The register of the block manager: who holds which section, and what is known of each unit.

`holders` maps a section to its one holder, so two holders cannot be written down. A registered unit that is
not in `units` is UNKNOWN: at a start `units` is empty, so "every section undefined after a restart"
(一旦、全区間を在線状態, section 4.4 (2)) cannot be forgotten. While `restoring`, `holders` has the units' own
words only; what persons enter stands apart in `reentry` until the line is defined.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final

import msgspec
from msgspec.structs import replace

from network.errors import InputError
from radio.keys import capability_mac
from radio.messages import Capability, RefusalReason
from wayside.barring import NO_BARS, Bars
from wayside.config import ManagerConfig, ReentryMode, RouteEntry
from wayside.journeys import NEW, UNKNOWN, DayProgress, Days, LastCertificate, LastSearch, days_of
from wayside.order_question import LastOrder, OrderSolver, without_solver

AT_ONCE_S: Final = -86_400.0  # no run begins so long before midnight

# Why a request is not granted, and the section and the unit in its way.
Against = tuple[RefusalReason, str | None, str | None]


class UnitStanding(Enum):
    """What the manager knows of a registered unit since its own restart."""

    UNKNOWN = "unknown"  # derived: not heard
    OUTSIDE = "outside"  # signed off, confirmed outside, or its claim was empty
    BY_HAND = "by hand"  # a person entered what it holds; it has not spoken
    REPORTED = "reported"  # it speaks for itself
    LEAVING = "leaving"  # signed off; it holds its portal until its train is known to have left
    DISPUTED = "disputed"  # it claims what another holds; nothing is granted to anyone meanwhile


class RegisteredUnit(msgspec.Struct, frozen=True):
    """A unit that has been heard or entered.

    `epoch`: the boot that signed on; `token`, `route_id`, `correlation`: of its last grant and its request; `claim`:
    what it says it holds, while that is disputed, `leaves`: as one that has signed off. `counted_out`: it leaves, and
    the boundary has counted it out before it said so (`wayside.leaving`). `by`: who said so, where
    persons did; `claim_needed`: of this boot only a fresh claim counts, since it spoke for itself before persons did;
    `silent`: it may be on the line, so it is asked all the same; `taken_back`: persons were wrong about it, or it was.
    `unproven`: by its own word it is outside, and it was on the line as far as was known when the block state was lost,
    or when it signed off in an earlier boot.
    `leave`: sections that it may run over, `without_leave`: and may not, as this boot has told it; of others it has not
    (`wayside.entering`).
    """

    standing: UnitStanding
    epoch: int = 0
    token: int = 0
    route_id: str | None = None
    correlation: int = 0
    claim: tuple[str, ...] | None = None
    leaves: bool = False
    counted_out: bool = False
    by: str = ""
    claim_needed: bool = False
    silent: bool = False
    taken_back: bool = False
    unproven: bool = False
    leave: frozenset[str] = frozenset()
    without_leave: frozenset[str] = frozenset()

    @property
    def has_spoken(self) -> bool:
        """Whether it spoke for itself, be it before persons spoke for it."""
        return self.claim_needed or self.standing in (UnitStanding.REPORTED, UnitStanding.LEAVING)


UNKNOWN_UNIT = RegisteredUnit(UnitStanding.UNKNOWN)


@dataclass(frozen=True, slots=True)
class RegisterPlan:
    """Fixed data, indexed."""

    unit_ids: tuple[str, ...]
    order: Mapping[str, int]
    portals: frozenset[str]
    open_line: frozenset[str]
    hears: frozenset[str]
    terminals: Mapping[str, tuple[str, ...]]
    routes: Mapping[str, RouteEntry]
    capability_keys: Mapping[str, bytes]
    ask_interval_s: float
    telegram_age_max_s: float
    reentry: ReentryMode
    days: Days | None = None  # None: nothing but the register decides
    has_overlaps: bool = False
    solver: OrderSolver = without_solver


class ReentryStage(Enum):
    """How far the re-entry has come."""

    INCOMPLETE = "incomplete"
    COMPLETE = "complete"  # a person may accept it
    ACCEPTED = "accepted"  # by hand: the units have yet to speak for themselves
    DEFINED = "defined"


class Reentry(msgspec.Struct, frozen=True):
    """What persons entered in this boot, and what the picture needs besides.

    `entries`: section -> person -> unit, None for free. `complete`: (person, unit) where the person has said
    all that the unit holds; `left_by`: for the same, the portal by which it left the line. `heard_s`: when an
    unknown unit was last heard. `inputs`: by person.
    """

    entries: Mapping[str, Mapping[str, str | None]] = msgspec.field(
        default_factory=dict[str, Mapping[str, str | None]]
    )
    complete: frozenset[tuple[str, str]] = frozenset()
    left_by: Mapping[tuple[str, str], str] = msgspec.field(default_factory=dict[tuple[str, str], str])
    accepted_by: str = ""
    inputs: Mapping[str, int] = msgspec.field(default_factory=dict[str, int])
    heard_s: Mapping[str, float] = msgspec.field(default_factory=dict[str, float])
    stage: ReentryStage = ReentryStage.INCOMPLETE
    defined_s: float | None = None


class BiddenUnit(msgspec.Struct, frozen=True):
    """What a unit is to do: no route before `until_s`, or until `behind` has had `section_id`; to go on as
    `next_train`, as it has been told so often.
    """

    until_s: float = 0.0
    behind: str = ""
    section_id: str = ""
    next_train: str = ""
    told: int = 0


class Register(msgspec.Struct, frozen=True):
    """State of the block manager. `epoch` is its boot, `counter` counts the tokens given in it.

    `started_s`: time of the first event of this boot. `restoring`: the block state was lost and no picture of the line
    has been accepted and completed yet. `ledger`: units that are on the line as far as is known, kept over power cuts;
    it blocks and never frees. `bars`: units that persons have barred, kept over power cuts; `barred_s`: when last, in
    this boot. `unswept`: sections that a silent unit may be in although persons say that it is elsewhere, kept over
    power cuts: to be passed on sight.
    `left_through`: how many trains have left by each portal in this boot. `doubted`: units that reported and of which a
    person now says something, each with how often it was asked in vain since. `trips`: how far each unit is in its day,
    kept over power cuts, `kept` the order in which all can finish, as last proven, `sought` the last search that found
    none, `solved` the order of least delay found last, and `now_s` when the last telegram came; all where `plan.days`
    are. `tracks`: for each unit the moves of its day, by place, that end on another track than planned; `cuts`: those
    from where it went on as another train, and as which; both kept over power cuts. `days` are the days with them.
    `bidden`: what a dispatcher has units do in this boot.
    """

    plan: RegisterPlan
    epoch: int
    counter: int = 0
    holders: Mapping[str, str] = msgspec.field(default_factory=dict[str, str])
    units: Mapping[str, RegisteredUnit] = msgspec.field(default_factory=dict[str, RegisteredUnit])
    started_s: float | None = None
    ask_at_s: float = AT_ONCE_S
    restoring: bool = False
    ledger: frozenset[str] = frozenset()
    bars: Bars = NO_BARS
    barred_s: float | None = None
    unswept: frozenset[str] = frozenset()
    left_through: Mapping[str, int] = msgspec.field(default_factory=dict[str, int])
    doubted: Mapping[str, int] = msgspec.field(default_factory=dict[str, int])
    reentry: Reentry = msgspec.field(default_factory=Reentry)
    trips: Mapping[str, DayProgress] = msgspec.field(default_factory=dict[str, DayProgress])
    trips_lost: bool = False
    kept: LastCertificate | None = None
    sought: LastSearch | None = None
    solved: Mapping[int, LastOrder] = msgspec.field(default_factory=dict[int, LastOrder])
    now_s: float = 0.0
    days: Days | None = None
    tracks: Mapping[str, Mapping[int, str]] = msgspec.field(default_factory=dict[str, Mapping[int, str]])
    cuts: Mapping[str, Mapping[int, str]] = msgspec.field(default_factory=dict[str, Mapping[int, str]])
    bidden: Mapping[str, BiddenUnit] = msgspec.field(default_factory=dict[str, BiddenUnit])

    @property
    def defined(self) -> bool:
        """Whether anything may be granted."""
        return not self.restoring and not self.undefined_because_of()

    @property
    def inputs(self) -> int:
        """Inputs that persons have made for the re-entry of this boot, refused ones too."""
        return sum(self.reentry.inputs.values())

    @property
    def token_max(self) -> int:
        """The greatest token that this boot or one before it can have given."""
        return (self.epoch << 32) + self.counter

    def unit(self, unit_id: str) -> RegisteredUnit:
        """What is known of a unit."""
        return self.units.get(unit_id, UNKNOWN_UNIT)

    def trip(self, unit_id: str) -> DayProgress:
        """How far a stock is in its day, as it was last known."""
        return self.trips.get(unit_id, UNKNOWN if self.trips_lost else NEW)

    def with_trip(self, unit_id: str, trip: DayProgress) -> Register:
        """The register with this known of a stock's day."""
        return replace(self, trips={**self.trips, unit_id: trip})

    def asking(self, unit_id: str) -> Register:
        """With a unit asking for its next move: since now, or still."""
        return self.with_trip(unit_id, self.trip(unit_id).asks(self.now_s))

    def with_track(self, unit_id: str, place: int, section_id: str) -> Register | None:
        """The register with a move of a unit's day ending on another track: what was proven of the day before is not
        known to be so any more. None: it cannot end there.
        """
        index = None if self.days is None else self.days.index.get(unit_id)
        if self.days is None or index is None or place >= len(self.days.hops[index]):
            return None
        days = self.days.with_track(index, place, section_id)
        if days is None:
            return None
        tracks = {**self.tracks, unit_id: {**self.tracks.get(unit_id, {}), place: section_id}}
        return replace(self, days=days, tracks=tracks, kept=None, sought=None)

    def with_cut(self, unit_id: str, place: int, next_train: str) -> Register | None:
        """The register with a unit that goes on as another train of its day from where it is: nothing proven is known
        to be so any more. None: it has no such train from there.
        """
        index = None if self.days is None else self.days.index.get(unit_id)
        days = None if self.days is None or index is None else self.days.with_cut(index, place, next_train)
        if days is None:
            return None
        kept = {at: end for at, end in self.tracks.get(unit_id, {}).items() if at < place}
        cuts = {**self.cuts, unit_id: {**self.cuts.get(unit_id, {}), place: next_train}}
        tracks = {**self.tracks, unit_id: kept}
        return replace(self, days=days, tracks=tracks, cuts=cuts, kept=None, sought=None, solved={})

    def held_by(self, unit_id: str) -> tuple[str, ...]:
        """Its sections, in the order of the line."""
        mine = [section for section, holder in self.holders.items() if holder == unit_id]
        return tuple(sorted(mine, key=self.plan.order.__getitem__))

    def asks_to_enter(self, unit_id: str, claimed: tuple[str, ...]) -> bool:
        """Whether what a unit says that it holds is a portal that it does not hold yet."""
        return self.plan.portals.issuperset(claimed) and not set(claimed) <= set(self.held_by(unit_id))

    def undefined_because_of(self) -> tuple[str, ...]:
        """Units for which nothing may be granted, and which are asked: unknown or disputed."""
        blocking = (UnitStanding.UNKNOWN, UnitStanding.DISPUTED)
        return tuple(unit_id for unit_id in self.plan.unit_ids if self.unit(unit_id).standing in blocking)

    def units_asked(self) -> tuple[str, ...]:
        """Units that are asked what they hold: those that block, that leave, or that count by persons' word alone.

        While one is looked for, those that hold what it may be in, too: with the answer they hear what to sweep.
        """
        units = self.units.items()
        others = (unit_id for unit_id, u in units if u.silent or u.standing is UnitStanding.LEAVING)
        near = (unit_id for unit_id in self.units if self.on_sight(self.contested(unit_id)))
        named = dict.fromkeys((*self.undefined_because_of(), *self.doubted, *others, *near))
        return tuple(unit_id for unit_id in named if unit_id not in self.bars.barred)

    @property
    def in_dispute(self) -> bool:
        """Whether any unit claims what another holds, or persons were wrong about one."""
        return any(unit.claim or unit.taken_back for unit in self.units.values())

    def contested(self, unit_id: str) -> tuple[str, ...]:
        """What it holds that another claims too, or that a unit may be in of which persons were wrong."""
        if not self.in_dispute:
            return ()
        units = self.units.items()
        claimed = {s for other, unit in units if other != unit_id for s in unit.claim or ()}
        if any(unit.taken_back for _, unit in units):
            claimed |= self.unswept
        return tuple(section for section in self.held_by(unit_id) if section in claimed)

    def without_doubt(self, unit_id: str) -> Register:
        """The register with nothing said any more of a unit that had reported."""
        return replace(self, doubted={other: n for other, n in self.doubted.items() if other != unit_id})

    def on_sight(self, section_ids: Iterable[str]) -> tuple[str, ...]:
        """Those of the sections that must be passed on sight."""
        return tuple(section for section in section_ids if section in self.unswept)

    def other_holder(self, unit_id: str, section_ids: Iterable[str]) -> tuple[str, str] | None:
        """The first of the sections that another unit holds, and that unit."""
        for section_id in section_ids:
            holder = self.holders.get(section_id, unit_id)
            if holder != unit_id:
                return section_id, holder
        return None

    def with_unit(self, unit_id: str, unit: RegisteredUnit) -> Register:
        """The register with this known of the unit."""
        return replace(self, units={**self.units, unit_id: unit})

    def with_held(self, unit_id: str, section_ids: Iterable[str]) -> Register:
        """The unit holds exactly these. Raises ValueError if another holds one of them: never two holders."""
        wanted = tuple(section_ids)
        if (conflict := self.other_holder(unit_id, wanted)) is not None:
            raise ValueError(f"section {conflict[0]} is held by {conflict[1]}, not free for {unit_id}")
        kept = {section: holder for section, holder in self.holders.items() if holder != unit_id}
        return replace(self, holders=kept | dict.fromkeys(wanted, unit_id))

    def next_token(self) -> tuple[Register, int]:
        """A token greater than any given before, in this boot or an earlier one."""
        register = replace(self, counter=self.counter + 1)
        return register, register.token_max

    def capabilities(self, unit_id: str, section_ids: Iterable[str], token: int) -> tuple[Capability, ...]:
        """For each terminal with points among the sections that it may run over, the proof that the unit holds them."""
        leave = self.unit(unit_id).leave
        return tuple(
            Capability(
                terminal_id,
                section_id,
                capability_mac(
                    self.plan.capability_keys[terminal_id], terminal_id, section_id, unit_id, token
                ),
            )
            for section_id in section_ids
            if section_id in leave or not self.plan.has_overlaps
            for terminal_id in self.plan.terminals.get(section_id, ())
        )


def start(
    config: ManagerConfig,
    epoch: int,
    capability_keys: Mapping[str, bytes],
    ledger: Iterable[str] | None = None,
    unswept: Iterable[str] = (),
    moves_done: Mapping[str, int] | None = None,
    tracks: Mapping[str, Mapping[int, str]] | None = None,
    bars: Bars = NO_BARS,
    solver: OrderSolver = without_solver,
    on_part: Collection[str] = (),
    cuts: Mapping[str, Mapping[int, str]] | None = None,
) -> Register:
    """The register after a (re)start: nothing is known. `epoch` must be greater than that of any earlier boot.

    `ledger`: the units on the line when the boot before ended; None: lost, so every unit counts as on the
    line and all of it as not swept, except at the first start. `moves_done`: how far each unit was in its day,
    `on_part`: which had a part of their next move; `tracks`: on which other tracks its moves end,
    `cuts`: from where it went on as another train. `solver`: who finds
    the order of least delay. Raises InputError if
    the ledger names a unit that is not on the fleet list.
    """
    trips_lost = epoch > 1 and (ledger is None or moves_done is None)
    if ledger is None and epoch > 1:
        unswept = (section.section_id for section in config.sections if not section.portal)
    if ledger is None:
        ledger = config.unit_ids if epoch > 1 else ()
    on_line = frozenset(ledger)
    if strangers := sorted(on_line.difference(config.unit_ids)):
        expected = f"a fleet list with {', '.join(strangers)}, on the line when the manager stopped"
        raise InputError("config.json", "unit_ids", config.unit_ids, expected)
    plan = RegisterPlan(
        config.unit_ids,
        {section.section_id: index for index, section in enumerate(config.sections)},
        frozenset(section.section_id for section in config.sections if section.portal),
        frozenset(section.section_id for section in config.sections if section.open_line),
        frozenset(section.section_id for section in config.sections if section.hears),
        {section.section_id: section.terminal_ids for section in config.sections if section.terminal_ids},
        {route.route_id: route for route in config.routes},
        capability_keys,
        config.ask_interval_s,
        config.telegram_age_max_s,
        config.reentry,
        days_of(config),
        any(route.overlap for route in config.routes),
        solver,
    )
    register = Register(
        plan,
        epoch,
        restoring=epoch > 1,
        ledger=on_line,
        bars=bars,
        unswept=frozenset(unswept),
        trips={
            unit_id: DayProgress(done, part=unit_id in on_part)
            for unit_id, done in (moves_done or {}).items()
        },
        trips_lost=trips_lost,
        days=plan.days,
    )
    none: Mapping[int, str] = {}
    for unit_id in {**(tracks or {}), **(cuts or {})}:
        ends = none if tracks is None else tracks.get(unit_id, none)
        trains = none if cuts is None else cuts.get(unit_id, none)
        for place in sorted({*ends, *trains}):  # a track that was changed before a cut lies before it
            if place in trains:
                register = register.with_cut(unit_id, place, trains[place]) or register
            if place in ends:
                register = register.with_track(unit_id, place, ends[place]) or register
    return register
