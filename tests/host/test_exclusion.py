"""On-board units, block manager and air together, on the bytes: whatever is lost, late, repeated or restarted, in
any order, no two trains believe to hold the same section, and no two stand in one.

The units are the very machine that runs (`onboard.unit`), the manager its very host; made up are a line without
points, the places of the trains in joints and what their crews do. Of the persons, Mori stands beside the trains and
is truthful: enters by hand all that a train believes to hold, and confirms as outside only trains that hold nothing.
Sato, the controller, enters anything about anything, and accepts any picture.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable, Sequence
from enum import Enum
from itertools import pairwise
from types import MappingProxyType
from typing import Final

import msgspec
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from host.device import DeviceHost
from host.store import MemoryStore
from host.units import UnitConfig, unit_of
from network.model import SectionKind, TagPurpose
from onboard.authority.letters import _READERS, Letters
from onboard.authority.records import Ask, Authority, Event
from onboard.authority.stop_limit import cleared_sections
from onboard.duty import machine as duty_machine
from onboard.duty.plan import Leg, Plan, Span, Stop, Tag
from onboard.duty.records import (
    Accepted as MayEnter,
)
from onboard.duty.records import (
    AtMark,
    Begin,
    ChangeEnds,
    Command,
    Finished,
    How,
    Leave,
    LeftLine,
    Looked,
    Order,
    Person,
    Phase,
    Place,
    PositionLost,
    Sensed,
    SetBack,
    Stopped,
    SwitchedOn,
    TagPassed,
)
from onboard.duty.turn import DutyParameters
from onboard.notes import GaveBack, Resumed, RouteHeld, UnitRestarted
from onboard.notes import Note as UnitNote
from onboard.notes import SignedOff as UnitSignedOff
from onboard.unit import Report, Unit
from radio.envelope import AGE_MAX_S, Received
from radio.keys import key_ring
from radio.messages import SignOnAccepted
from radio.noted import Noted, TelegramDropped
from wayside.config import (
    MANAGER_ID,
    DeviceConfig,
    ManagerConfig,
    ReentryMode,
    RouteEntry,
    SectionEntry,
    TerminalConfig,
)
from wayside.register import Register, Stage
from wayside.said import (
    Accepted,
    AcceptPicture,
    ConfirmedByHand,
    ConfirmHolding,
    ConfirmOutside,
    Contradicted,
    EnterSection,
    Freed,
    Granted,
    Input,
    Note,
    Outside,
    PictureChanged,
    Started,
    WordTaken,
)

MASTER: Final = b"m" * 32
UNITS: Final = ("u1", "u2", "u3")
TIMES: Final = DutyParameters(dwell_min_s=1.0, request_lead_s=1.0, emergency_release_s=1.0)
SEEDS: Final = 16
HOLD_S: Final = 5.0  # a route set back is not asked for again before
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
        SectionEntry("C"),
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


def plan(number: str, section_ids: tuple[str, ...], routes: tuple[str, ...]) -> Plan:
    """A way over the made-up line: it stops in its first section, at the end of each route, and has a tag in each."""
    legs = tuple(Leg(r, ROUTES[r].from_section, ROUTES[r].section_ids) for r in routes)
    stops = [0, *(section_ids.index(leg.section_ids[-1]) for leg in legs)]
    return Plan(
        number=number,
        direction="down" if section_ids[0] == "P0" else "up",
        spans=tuple(Span(s, KINDS.get(s, SectionKind.TRACK), (), s, 0.0) for s in section_ids),
        legs=legs,
        stops=tuple(Stop(section_ids[i], True, i, i, None, None) for i in stops),
        tags=tuple(Tag(i, TagPurpose.POSITION, i + 1) for i in range(len(section_ids))),
        end_piece=section_ids[-1],
        end_kilometrage_m=100.0,
        enters=section_ids[0] == "P0",
    )


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
    LEAVING = "leaving"  # over the portal's far joint, and signing off


class Train:
    """One train as the world has it: `rear` to `front` are the spans of its plan under it; and its unit."""

    def __init__(self, unit_id: str) -> None:
        self.unit_id = unit_id
        self.epoch = 0
        self.where = Where.OUTSIDE
        self.plan = PLANS["E"]
        self.front = self.rear = 0
        self.known = False  # its unit knows where it is
        self.emergency = False
        self.finished = False
        self.command = Command()
        self.wake_at_s: float | None = None
        self.notes: list[UnitNote] = []
        self.boot()

    def boot(self) -> None:
        self.epoch += 1
        config = UnitConfig("line", self.unit_id, MANAGER_ID, TIMES)
        self.unit: Unit = unit_of(config, key_ring(MASTER, self.unit_id, [MANAGER_ID]), self.epoch)
        self.command, self.wake_at_s = Command(), None

    @property
    def physical(self) -> frozenset[str]:
        """What it truly stands in; a train that leaves is over the joint of the other line."""
        if self.where is not Where.ON_LINE:
            return frozenset()
        return frozenset(span.section_id for span in self.plan.spans[self.rear : self.front + 1])

    @property
    def knows(self) -> bool:
        """Whether it knows what it holds: a unit that was switched on again does not before it is told."""
        authority = self.unit.state.authority
        sign_on = authority.open(Ask.SIGN_ON)
        return authority.on_line or (sign_on is not None and sign_on.section_ids is not None)

    @property
    def believed(self) -> frozenset[str]:
        if self.where is Where.LEAVING:
            return frozenset()
        if self.where is Where.ON_LINE and not self.knows:
            return self.physical
        return frozenset(self.unit.state.authority.held)

    def place(self, *, stands: bool = True) -> Place:
        """By its localisation, which is exact where it knows anything."""
        if not self.known:
            return Place(stands=stands, emergency=self.emergency)
        within = self.rear == self.front
        stops = [stop.span for stop in self.plan.stops]
        passed = [i for i, at in enumerate(stops) if at < self.front + within]
        return Place(
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


class World:
    """Telegrams live in `flying` until the age limit and are delivered any number of times, in any order."""

    def __init__(self, mode: ReentryMode = ReentryMode.ASSISTED) -> None:
        """A day under way: u1 stands in B, u2 in E, u3 is off the line."""
        self.mode = mode
        self.now_s = 0.0
        self.store = MemoryStore()
        self.units = {unit_id: Train(unit_id) for unit_id in UNITS}
        self.flying: list[tuple[str, bytes, float]] = []
        self.silent: set[str] = set()  # no telegram comes from or to these
        self.notes: list[Note] = []
        self.host: DeviceHost
        self.boot_manager()
        self.manage(inputs=[ConfirmOutside(unit_id, "Sato") for unit_id in ("u1", "u3")])
        u2 = self.units["u2"]
        u2.where, u2.plan, u2.known = Where.ON_LINE, PLANS["from E"], True
        self.tell(u2, Begin(u2.plan, signs_on=True))
        self.flush()
        self.next_train("u1", "E2")
        self.run_to("u1", "B")
        assert [self.units[u].physical for u in UNITS] == [{"B"}, {"E"}, frozenset()]

    # the manager ------------------------------------------------------------------------------------------------

    def boot_manager(self) -> None:
        config: DeviceConfig = msgspec.structs.replace(CONFIG, reentry=self.mode)
        assert not isinstance(config, TerminalConfig)
        ring = key_ring(MASTER, MANAGER_ID, UNITS, ["tA", "tD"])
        self.host = DeviceHost(config, ring, self.store)
        self.manage()

    def manage(self, telegrams: Sequence[bytes] = (), inputs: Sequence[Input] = ()) -> None:
        advance = self.host.advance(self.now_s, telegrams, inputs)
        self.flying += [
            (destination, data, self.now_s)
            for destination, data in advance.telegrams
            if destination not in self.silent
        ]
        self.judge(advance.notes)

    def judge(self, notes: tuple[Note, ...]) -> None:
        """Judged by the journal alone: nothing granted while undefined, tokens grow."""
        for note in notes:
            if isinstance(note, Started):
                self.known: set[str] = set()
                self.restoring = note.epoch > 1
            if isinstance(note, PictureChanged):
                self.restoring = note.stage != Stage.DEFINED.value
            if isinstance(note, Accepted | Outside | ConfirmedByHand):
                self.known.add(note.unit_id)
            if isinstance(note, Granted):
                assert self.known == set(UNITS)
                assert not self.restoring
        self.notes += notes

    # the trains -------------------------------------------------------------------------------------------------

    def tell(
        self, train: Train, *happened: Person | Sensed, telegrams: Sequence[bytes] = (), stands: bool = True
    ) -> None:
        """Put what happened to a unit and do what it says."""
        answer = train.unit.advance(self.now_s, telegrams, Report(train.place(stands=stands), happened))
        train.command, train.wake_at_s = answer.command, answer.wake_at_s
        train.notes += answer.notes
        if Order.RELEASE in answer.command.orders:
            train.emergency = False
        if train.unit_id not in self.silent:
            self.flying += [(t.destination, t.data, self.now_s) for t in answer.telegrams]
        for told in answer.told:
            match told:
                case MayEnter():
                    self.enter(train)
                case Finished():
                    train.finished = True
                case LeftLine():
                    train.where, train.finished = Where.OUTSIDE, False

    def enter(self, train: Train) -> None:
        """Through the portal, if the unit was accepted and nothing truly stands there."""
        occupied = frozenset[str]().union(*(other.physical for other in self.units.values()))
        if train.where is Where.WAITING and train.unit.state.authority.on_line and "P0" not in occupied:
            train.where = Where.ON_LINE

    def next_train(self, unit_id: str, to: str) -> None:
        """The crew enters the next train number: outside the portal, after changing ends, or leaves the line."""
        train = self.units[unit_id]
        if train.where is Where.OUTSIDE:
            train.where, train.plan, train.front, train.rear = Where.WAITING, PLANS[to], 0, 0
            train.known, train.finished, train.emergency = True, False, False
            self.tell(train, Begin(train.plan, signs_on=True))
        elif train.finished and train.where is Where.ON_LINE and train.unit.state.phase is Phase.FINISHED:
            train.finished = False
            if train.plan.spans[-1].section_id == "P9":
                train.where = Where.LEAVING
                self.tell(train, Leave())
                return
            train.plan = PLANS[f"from {train.plan.spans[-1].section_id}"]
            train.front = train.rear = 0
            self.tell(train, ChangeEnds(), Begin(train.plan, signs_on=False))
        elif train.finished and train.where is Where.LEAVING:  # started again as it left
            train.finished = False
            self.tell(train, Leave())

    def go(self, unit_id: str) -> None:
        """By a joint, as far as the unit and, on sight, the crew let it."""
        train = self.units[unit_id]
        self.enter(train)
        if train.where is not Where.ON_LINE or not train.command.drive:
            return
        if train.command.on_sight and not train.known:
            self.go_on_sight(train)
        elif train.rear < train.front:
            train.rear += 1
            target = train.command.target
            arrived = target is not None and train.plan.stops[target].span == train.front
            self.tell(train, *([Stopped(How.AT, 0.0)] if arrived else [Looked()]), stands=arrived)
        elif not train.command.on_sight and train.front + 1 < train.command.limit.joint:
            train.front += 1
            self.tell(train, Looked(), stands=False)
        elif not train.command.on_sight:  # at the end of what it holds, its mark yet to come
            self.tell(train, Stopped(How.SHORT, -10.0))

    def go_on_sight(self, train: Train) -> None:
        """The crew drives within what the unit shows as held, and tells it of the marks that it reaches."""
        shown, stops = train.command, [stop.span for stop in train.plan.stops]
        at = stops.index(train.front) if train.rear == train.front and train.front in stops else -1
        if at > shown.at and shown.stands_at != at:
            self.tell(train, AtMark(at))
        elif train.rear < train.front:
            train.rear += 1
        elif train.front + 1 < len(train.plan.spans):
            train.front += train.plan.spans[train.front + 1].section_id in shown.held

    def locate(self, unit_id: str) -> None:
        """A train that does not know where it is reads a tag."""
        train = self.units[unit_id]
        if train.where is Where.ON_LINE and not train.known and train.unit.state.phase is not Phase.OFF:
            train.known = True
            self.tell(train, TagPassed(train.front, found=True))

    def lose_position(self, unit_id: str) -> None:
        """A position fault: the emergency brake brings the train to a stand."""
        train = self.units[unit_id]
        if train.where is Where.ON_LINE and train.known:
            train.known, train.emergency = False, True
            moves = train.command.drive
            self.tell(train, PositionLost(), stands=not moves)
            if moves:
                self.tell(train, Stopped(How.AT, 0.0))

    def set_back(self, unit_id: str) -> None:
        """The crew sets back the route ahead."""
        train = self.units[unit_id]
        if train.where is Where.ON_LINE:
            self.tell(train, SetBack(HOLD_S))

    def restart_train(self, unit_id: str) -> None:
        """Power cut and power back; the crew enters the train number and, if it stands at one, the stop."""
        train = self.units[unit_id]
        train.boot()
        train.finished = False
        if train.where is Where.WAITING:
            self.tell(train, Begin(train.plan, signs_on=True))
        elif train.where is not Where.OUTSIDE:
            train.known, train.emergency = False, True
            stops = [stop.span for stop in train.plan.stops]
            stands_at = (
                stops.index(train.front) if train.rear == train.front and train.front in stops else None
            )
            self.tell(train, SwitchedOn(train.plan, stands_at))

    def run_to(self, unit_id: str, section_id: str) -> None:
        """Nothing is lost until this train stands in a section."""
        for _ in range(40):
            self.flush()
            self.go(unit_id)
            if self.units[unit_id].physical == {section_id}:
                return
            self.wait(1.0)
        raise AssertionError(
            f"{unit_id} does not come to {section_id}: {self.units[unit_id].command.waits_for}"
        )

    def normal_run(self, unit_id: str) -> None:
        """A while in which nothing is lost and this train goes as far as it may."""
        for _ in range(3):
            self.flush()
            for _ in range(6):
                self.go(unit_id)
            self.flush()
            self.wait(1.0)

    # the air and time -------------------------------------------------------------------------------------------

    def flush(self) -> None:
        """The air at its best: everything arrives, answers too."""
        while self.flying:
            self.deliver_one(0, keep=False)

    def deliver_in_order(self, count: int) -> None:
        for _ in range(min(count, len(self.flying))):
            self.deliver_one(0, keep=False)

    def deliver_one(self, index: int, *, keep: bool) -> None:
        destination, data, _ = self.flying[index] if keep else self.flying.pop(index)
        if destination == MANAGER_ID:
            self.manage([data])
        else:
            self.tell(self.units[destination], telegrams=[data])

    def wait(self, pause_s: float) -> None:
        """Time passes; every timer that runs out on the way runs out in its turn."""
        end_s = round(self.now_s + pause_s, 1)
        while (next_s := self.next_timer_s()) < end_s:
            self.now_s = max(self.now_s, next_s)
            for train in self.units.values():
                if train.wake_at_s is not None and train.wake_at_s <= self.now_s:
                    self.tell(train)
        self.now_s = end_s
        self.flying = [flight for flight in self.flying if self.now_s - flight[2] <= AGE_MAX_S + 1.0]
        self.manage()

    def next_timer_s(self) -> float:
        return min((t.wake_at_s for t in self.units.values() if t.wake_at_s is not None), default=math.inf)

    def lose_everything_in_the_air(self, unit_id: str) -> None:
        self.flying = [flight for flight in self.flying if flight[0] != unit_id]

    def hush(self, unit_id: str) -> None:
        """The radio of a train fails, or works again."""
        self.silent ^= {unit_id}

    # the persons ------------------------------------------------------------------------------------------------

    def confirm_by_hand(self, unit_id: str, person: str = "Mori") -> None:
        """A true word about one train."""
        believed = tuple(sorted(self.units[unit_id].believed))
        entry: Input = (
            ConfirmHolding(unit_id, believed, person) if believed else ConfirmOutside(unit_id, person)
        )
        self.manage(inputs=[entry])

    def enter_every_section(self) -> None:
        """Sato corrects everything that was entered wrongly: a true word about every section."""
        holder = {section: train.unit_id for train in self.units.values() for section in train.believed}
        self.manage(inputs=[EnterSection(section, holder.get(section), "Sato") for section in SECTIONS])

    def restore(self) -> None:
        """What a careful controller and the staff do together."""
        self.enter_every_section()
        for unit_id, train in self.units.items():
            if not train.knows or unit_id in self.silent:
                self.confirm_by_hand(unit_id)
                self.confirm_by_hand(unit_id, "Sato")
        self.manage(inputs=[AcceptPicture("Sato")])

    def heal(self) -> None:
        """Faults end, telegrams arrive, and the persons enter what the trains cannot say."""
        self.silent.clear()
        for _ in range(3):
            self.wait(6.0)
            self.flush()
            self.restore()
            for unit_id in UNITS:
                self.confirm_by_hand(unit_id)
                self.confirm_by_hand(unit_id, "Sato")
                self.locate(unit_id)
                self.normal_run(unit_id)
                self.check()

    # what must hold ---------------------------------------------------------------------------------------------

    def check(self) -> None:
        trains = self.units.values()
        held = [section for train in trains for section in train.believed]
        assert len(held) == len(set(held)), "two trains believe to hold the same section"
        under = [section for train in trains for section in train.physical]
        assert len(under) == len(set(under)), "two trains stand in the same section"
        assert all(train.physical <= train.believed for train in trains), (
            "a train stands where it holds nothing"
        )
        tokens = [note.token for note in self.notes if isinstance(note, Granted)]
        assert all(one < other for one, other in pairwise(tokens)), "tokens must grow"

    def check_that_all_goes_on(self) -> None:
        """After everything has healed a train runs, is done, or waits for a section that another truly holds."""
        for _ in range(4):
            for unit_id in UNITS:
                self.next_train(unit_id, "E")
                self.locate(unit_id)
                self.normal_run(unit_id)
                self.check()
        for _ in range(3):  # nobody moves: every request is answered as things stand now
            self.wait(6.0)
            self.flush()
        for unit_id, train in self.units.items():
            waits_for = train.command.waits_for
            request = train.unit.state.authority.open(Ask.ROUTE) or train.unit.state.authority.open(
                Ask.SIGN_ON
            )
            if request is None:
                continue
            holders = {
                f"held: section {s} of {o.unit_id}"
                for o in self.units.values()
                for s in o.unit.state.authority.held
            }
            assert request.refusal in holders, (unit_id, waits_for)


units = st.sampled_from(UNITS)
goals = st.sampled_from(["E", "E2"])
sections = st.sampled_from(SECTIONS)
wrong_entries = st.one_of(
    st.builds(EnterSection, sections, st.none() | units, st.just("Sato")),
    st.builds(ConfirmHolding, units, st.lists(sections, min_size=1, unique=True).map(tuple), st.just("Sato")),
    st.builds(ConfirmOutside, units, st.just("Sato")),
    st.just(AcceptPicture("Sato")),
)
seldom = st.sampled_from([False, False, True])


class Exclusion(RuleBasedStateMachine):
    """Hypothesis chooses what happens, and shrinks what it finds."""

    def __init__(self) -> None:
        super().__init__()
        self.world = World()

    @initialize(mode=st.sampled_from(ReentryMode))
    def begin(self, mode: ReentryMode) -> None:
        self.world = World(mode)

    @rule(unit_id=units)
    def normal_run(self, unit_id: str) -> None:
        self.world.normal_run(unit_id)

    @rule(unit_id=units)
    def go(self, unit_id: str) -> None:
        self.world.go(unit_id)

    @rule(unit_id=units, to=goals)
    def next_train(self, unit_id: str, to: str) -> None:
        self.world.next_train(unit_id, to)

    @rule(unit_id=units)
    def set_back(self, unit_id: str) -> None:
        self.world.set_back(unit_id)

    @rule(unit_id=units, really=seldom)
    def lose_position(self, unit_id: str, really: bool) -> None:
        if really:
            self.world.lose_position(unit_id)

    @rule(data=st.data(), keep=st.booleans())
    def deliver(self, data: st.DataObject, keep: bool) -> None:
        if self.world.flying:
            self.world.deliver_one(data.draw(st.integers(0, len(self.world.flying) - 1)), keep=keep)

    @rule()
    def deliver_everything(self) -> None:
        self.world.flush()

    @rule(unit_id=units)
    def lose(self, unit_id: str) -> None:
        self.world.lose_everything_in_the_air(unit_id)

    @rule(pause_s=st.sampled_from([0.1, 1.0, 5.5]))
    def wait(self, pause_s: float) -> None:
        self.world.wait(pause_s)

    @rule(really=seldom)
    def restart_manager(self, really: bool) -> None:
        if really:
            self.world.boot_manager()

    @rule(unit_id=units, really=seldom)
    def restart_train(self, unit_id: str, really: bool) -> None:
        if really:
            self.world.restart_train(unit_id)

    @rule(unit_id=units)
    def confirm_by_hand(self, unit_id: str) -> None:
        self.world.confirm_by_hand(unit_id)

    @rule(entry=wrong_entries)
    def enter_anything(self, entry: Input) -> None:
        self.world.manage(inputs=[entry])

    @rule(unit_id=units)
    def locate(self, unit_id: str) -> None:
        self.world.locate(unit_id)

    @rule()
    def restore(self) -> None:
        self.world.restore()

    @rule(unit_id=units, really=seldom)
    def hush(self, unit_id: str, really: bool) -> None:
        if really:
            self.world.hush(unit_id)

    @invariant()
    def check(self) -> None:
        self.world.check()


TestExclusion = Exclusion.TestCase
TestExclusion.settings = settings(max_examples=60, stateful_step_count=60, deadline=None)


class Walker:
    """A long day at random, busier than hypothesis' examples: what happens often happens often."""

    def __init__(self, seed: int, mode: ReentryMode) -> None:
        self.chance = random.Random(seed)
        self.world = World(mode)

    def step(self) -> None:
        world, chance = self.world, self.chance
        unit_id = chance.choice(UNITS)
        self.do(
            [
                (8.0, lambda: world.go(unit_id)),
                (8.0, lambda: world.deliver_in_order(chance.randint(1, 4))),
                (4.0, self.deliver_any),
                (6.0, lambda: world.wait(chance.choice([0.1, 1.0, 1.0, 5.5]))),
                (2.0, lambda: world.normal_run(unit_id)),
                (3.0, lambda: world.next_train(unit_id, chance.choice(["E", "E2"]))),
                (0.5, lambda: world.set_back(unit_id)),
                (0.5, lambda: world.confirm_by_hand(unit_id)),
                (0.5, lambda: world.manage(inputs=[self.anything()])),
                (0.2, lambda: world.manage(inputs=[AcceptPicture("Sato")])),
                (0.4, world.restore),
                (0.6, lambda: world.locate(unit_id)),
                (0.2, lambda: world.lose_position(unit_id)),
                (0.3, lambda: world.lose_everything_in_the_air(unit_id)),
                (0.25, world.boot_manager),
                (0.25, lambda: world.restart_train(unit_id)),
            ]
        )

    def step_of_recovery(self) -> None:
        """Mostly after a restart, with trains out of reach or without memory, and Sato hard at work."""
        world, chance = self.world, self.chance
        unit_id = chance.choice(UNITS)
        self.do(
            [
                (4.0, lambda: world.normal_run(unit_id)),
                (3.0, lambda: world.go(unit_id)),
                (2.0, lambda: world.wait(chance.choice([0.1, 5.5]))),
                (2.0, lambda: world.next_train(unit_id, chance.choice(["E", "E2"]))),
                (0.3, lambda: world.set_back(unit_id)),
                (1.0, lambda: world.confirm_by_hand(unit_id)),
                (3.0, lambda: world.manage(inputs=[self.anything()])),
                (2.0, lambda: world.manage(inputs=[AcceptPicture("Sato")])),
                (0.7, world.restore),
                (0.3, world.enter_every_section),
                (0.7, world.flush),
                (0.7, lambda: world.locate(unit_id)),
                (0.7, lambda: world.hush(unit_id)),
                (0.7, world.boot_manager),
                (0.3, lambda: world.restart_train(unit_id)),
            ]
        )

    def do(self, deeds: list[tuple[float, Callable[[], None]]]) -> None:
        (deed,) = self.chance.choices([deed for _, deed in deeds], [weight for weight, _ in deeds])
        deed()
        self.world.check()

    def anything(self) -> Input:
        """What Sato enters: mostly wrong."""
        chance = self.chance
        unit_id = chance.choice(UNITS)
        some = tuple(chance.sample(SECTIONS, chance.randint(1, 3)))
        wrong: list[Input] = [
            EnterSection(some[0], chance.choice([None, unit_id]), "Sato"),
            ConfirmHolding(unit_id, some, "Sato"),
            ConfirmOutside(unit_id, "Sato"),
        ]
        return chance.choice(wrong)

    def deliver_any(self) -> None:
        if self.world.flying:
            index = self.chance.randrange(len(self.world.flying))
            self.world.deliver_one(index, keep=self.chance.random() < 0.5)


@pytest.mark.parametrize("mode", ReentryMode)
@pytest.mark.parametrize("recovering", [False, True], ids=["walk", "recovery"])
@pytest.mark.parametrize("seed", range(SEEDS))
def test_walks_and_after_them_all_goes_on(seed: int, recovering: bool, mode: ReentryMode) -> None:
    walker = Walker(seed, mode)
    for _ in range(300):
        walker.step_of_recovery() if recovering else walker.step()
    walker.world.heal()
    walker.world.check_that_all_goes_on()


@pytest.mark.parametrize("mode", ReentryMode)
def test_walks_grant_run_and_disturb_enough(mode: ReentryMode) -> None:
    kinds: Counter[type[Noted]] = Counter()
    granted_again = 0
    for seed in range(6):
        walker = Walker(seed, mode)
        for _ in range(250):
            walker.step()
            walker.step_of_recovery()
        notes = walker.world.notes
        kinds.update(type(note) for note in notes)
        kinds.update(type(note) for train in walker.world.units.values() for note in train.notes)
        granted_again += sum(isinstance(note, Granted) and note.token >> 32 > 1 for note in notes)
    enough = {
        **dict.fromkeys((Granted, Freed, TelegramDropped, Started, RouteHeld), 20),
        **dict.fromkeys((ConfirmedByHand, WordTaken, Contradicted), 20),
        **dict.fromkeys((UnitRestarted, GaveBack, Resumed, UnitSignedOff), 5),
    }
    assert granted_again > 10
    assert {kind: kinds[kind] for kind, count in enough.items() if kinds[kind] < count} == {}


def grants_what_another_holds(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Register, "other_holder", lambda *_: None)


def enters_on_any_acceptance(patch: pytest.MonkeyPatch) -> None:
    """Takes whatever is accepted for the portal that it wishes to enter."""
    sign_on = Letters._signed_on

    def any_sign_on(self: Letters, heard: Received, message: SignOnAccepted) -> Event:
        wished = msgspec.structs.replace(message, section_ids=(*message.section_ids, "P0"))
        return sign_on(self, heard, message if message.section_ids else wished)

    patch.setattr(Letters, "_signed_on", any_sign_on)
    patch.setitem(_READERS, SignOnAccepted, any_sign_on)


def releases_where_it_stands(patch: pytest.MonkeyPatch) -> None:
    """Gives back one section too many behind the rear."""

    def too_many(way: Plan, state: Authority, clear: int) -> tuple[str, ...]:
        return cleared_sections(way, state, clear + 1)

    patch.setattr(duty_machine, "cleared_sections", too_many)


@pytest.mark.parametrize(
    "off", [grants_what_another_holds, enters_on_any_acceptance, releases_where_it_stands]
)
def test_walks_see_what_is_switched_off(
    off: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    off(monkeypatch)
    with pytest.raises(AssertionError, match=r"two trains|holds nothing"):
        for seed in range(2 * SEEDS):
            walker = Walker(seed, ReentryMode.ASSISTED)
            for _ in range(300):
                walker.step()


def test_a_wish_to_enter_a_portal_where_a_silent_train_stands() -> None:
    """Found by a walk: u2 wishes to enter at P0, where u3 stands and has forgotten what it holds."""
    world = World()
    u2, u3 = world.units["u2"], world.units["u3"]
    world.run_to("u2", "P9")
    while u2.where is not Where.OUTSIDE:
        world.next_train("u2", "E")
        world.normal_run("u2")
    world.next_train("u3", "E")
    world.flush()
    assert u3.physical == {"P0"}
    world.hush("u3")
    world.restart_train("u3")
    world.boot_manager()
    world.next_train("u2", "E")
    for _ in range(4):
        world.flush()
        world.wait(5.0)
    assert u2.where is Where.WAITING
    assert u2.believed == frozenset()
    assert u3.physical == {"P0"}
    world.check()


def test_a_claim_of_nothing_accepted_opens_no_portal() -> None:
    """Found by a walk: asked on its sign-on, u3 claims nothing; the acceptance of that is no leave to enter."""
    world = World()
    u3 = world.units["u3"]
    world.boot_manager()
    world.next_train("u3", "E")
    world.flush()
    assert any(isinstance(note, Outside) and note.unit_id == "u3" for note in world.notes)
    assert u3.where is Where.WAITING
    for _ in range(3):
        world.restore()
        world.wait(6.0)
        world.flush()
    world.run_to("u3", "P0")
    world.check()
