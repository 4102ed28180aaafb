"""The bench of exclusion: the manager's very host, the trains, the air between them, and the persons.

Of the persons, Mori stands beside the trains and is truthful: enters by hand all that a train believes to hold, and
confirms as outside only trains that hold nothing. Sato, the controller, enters anything about anything, and accepts
any picture.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import msgspec

from host.device import DeviceHost
from host.store import MemoryStore
from onboard.authority.records import RequestKind
from onboard.duty.records import (
    AtMark,
    Begin,
    ChangeEnds,
    DrivingOrder,
    DutyPhase,
    EntryAllowed,
    Finished,
    Leave,
    LeftLine,
    Looked,
    MarkRelation,
    NotAtMark,
    OffTheLine,
    Person,
    PositionLost,
    Sensed,
    SetBack,
    Stopped,
    SwitchedOn,
    TagBelieved,
)
from onboard.duty_parameters import ReleaseRule
from onboard.unit import Report
from radio.envelope import AGE_MAX_S
from radio.keys import key_ring
from tests.host.exclusion_trains import CONFIG, MASTER, PLANS, SECTIONS, UNITS, Train, Where
from wayside import said
from wayside.config import MANAGER_ID, DeviceConfig, ReentryMode, TerminalConfig
from wayside.register import ReentryStage

HOLD_S: Final = 5.0  # a route set back is not asked for again before


class World:
    """Telegrams live in `flying` until the age limit and are delivered any number of times, in any order."""

    def __init__(
        self,
        mode: ReentryMode = ReentryMode.ASSISTED,
        release: ReleaseRule = ReleaseRule.ROUTE,
        *,
        contact: bool = True,
    ) -> None:
        """A day under way: u1 stands in B, u2 in E, u3 is off the line. `contact`: there is one at the boundary."""
        self.mode = mode
        self.contact = contact
        self.now_s = 0.0
        self.store = MemoryStore()
        self.units = {unit_id: Train(unit_id, release) for unit_id in UNITS}
        self.flying: list[tuple[str, bytes, float]] = []
        self.silent: set[str] = set()  # no telegram comes from or to these
        self.notes: list[said.Note] = []
        self.host: DeviceHost
        self.boot_manager()
        self.manage(inputs=[said.ConfirmOutside(unit_id, "Sato") for unit_id in ("u1", "u3")])
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

    def manage(self, telegrams: Sequence[bytes] = (), inputs: Sequence[said.Input] = ()) -> None:
        advance = self.host.advance(self.now_s, telegrams, inputs)
        self.flying += [
            (destination, data, self.now_s)
            for destination, data in advance.telegrams
            if destination not in self.silent
        ]
        self.judge(advance.notes)

    def judge(self, notes: tuple[said.Note, ...]) -> None:
        """Judged by the journal alone: nothing granted while undefined, tokens grow."""
        for note in notes:
            if isinstance(note, said.Started):
                self.known: set[str] = set()
                self.restoring = note.epoch > 1
            if isinstance(note, said.PictureChanged):
                self.restoring = note.stage != ReentryStage.DEFINED.value
            if isinstance(note, said.Accepted | said.Outside | said.ConfirmedByHand):
                self.known.add(note.unit_id)
            if isinstance(note, said.Granted):
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
        orders = answer.command.orders
        if DrivingOrder.RELEASE in orders:
            train.emergency = False
        if DrivingOrder.STOP in orders or DrivingOrder.LOSE in orders:
            train.emergency = True
        train.known = train.known and DrivingOrder.LOSE not in orders
        if train.unit_id not in self.silent:
            self.flying += [(t.destination, t.data, self.now_s) for t in answer.telegrams]
        for told in answer.told:
            match told:
                case EntryAllowed():
                    self.enter(train)
                case Finished():
                    train.finished = True
                case LeftLine():
                    train.may_leave = True
        if (DrivingOrder.STOP in orders or DrivingOrder.LOSE in orders) and not stands:
            self.tell(train, Stopped(MarkRelation.SHORT, -1.0))  # brought to a stand where it is

    def enter(self, train: Train) -> None:
        """Through the portal, if the unit was accepted and nothing truly stands there."""
        occupied = frozenset[str]().union(*(other.physical for other in self.units.values()))
        if train.where is Where.WAITING and train.unit.state.authority.on_line and "P0" not in occupied:
            train.where = Where.ON_LINE

    def leave(self, train: Train) -> None:
        """Out of its portal, if its unit was told that it may: the contact at the boundary counts it out."""
        if train.where is Where.LEAVING and train.may_leave:
            train.where, train.finished, train.may_leave = Where.OUTSIDE, False, False
            self.manage(inputs=[said.BoundaryPassed("P9")] if self.contact else [])
            self.tell(train, OffTheLine())

    def next_train(self, unit_id: str, to: str) -> None:
        """The crew enters the next train number: outside the portal, after changing ends, or leaves the line."""
        train = self.units[unit_id]
        if train.where is Where.OUTSIDE:
            train.where, train.plan, train.front, train.rear = Where.WAITING, PLANS[to], 0, 0
            train.known, train.finished, train.emergency = True, False, False
            self.tell(train, Begin(train.plan, signs_on=True))
        elif train.finished and train.where is Where.ON_LINE and train.unit.state.phase is DutyPhase.FINISHED:
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
        self.leave(train)
        self.look(train)
        if train.where is not Where.ON_LINE or not train.command.drive or train.emergency:
            return
        if train.command.on_sight and not train.known:
            self.go_on_sight(train)
        elif train.rear < train.front:
            train.rear += 1
            target = train.command.target
            arrived = target is not None and train.plan.stops[target].span == train.front
            then = Stopped(MarkRelation.AT, 0.0) if arrived else Looked()
            self.tell(train, TagBelieved(train.tag, found=False), then, stands=arrived)
        elif not train.command.on_sight and train.front + 1 < train.command.limit.joint:
            train.front += 1
            self.tell(train, Looked(), stands=False)
        elif not train.command.on_sight:  # at the end of what it holds, its mark yet to come
            self.tell(train, Stopped(MarkRelation.SHORT, -10.0))

    def look(self, train: Train) -> None:
        """Asked whether the whole train is at its mark, the driver says what is so."""
        if train.where is Where.ON_LINE and train.command.confirm:
            at = train.command.at
            there = train.rear == train.front == train.plan.stops[at].span
            self.tell(train, AtMark(at) if there else NotAtMark())

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
        if train.where is Where.ON_LINE and not train.known and train.unit.state.phase is not DutyPhase.OFF:
            train.known = True
            self.tell(train, TagBelieved(train.tag, found=True))

    def lose_position(self, unit_id: str) -> None:
        """A position fault: the emergency brake brings the train to a stand."""
        train = self.units[unit_id]
        if train.where is Where.ON_LINE and train.known:
            train.known, train.emergency = False, True
            moves = train.command.drive
            self.tell(train, PositionLost(), stands=not moves)
            if moves:
                self.tell(train, Stopped(MarkRelation.AT, 0.0))

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
        """A true word about one train: where it stands, or that it is off the line by P9, as all that left it."""
        believed = tuple(sorted(self.units[unit_id].believed))
        entry: said.Input = (
            said.ConfirmHolding(unit_id, believed, person)
            if believed
            else said.ConfirmOutside(unit_id, person, "P9")
        )
        self.manage(inputs=[entry])

    def enter_every_section(self) -> None:
        """Sato corrects everything that was entered wrongly: a true word about every section."""
        holder = {section: train.unit_id for train in self.units.values() for section in train.believed}
        self.manage(inputs=[said.EnterSection(section, holder.get(section), "Sato") for section in SECTIONS])

    def restore(self) -> None:
        """What a careful controller and the staff do together."""
        self.enter_every_section()
        for unit_id, train in self.units.items():
            if not train.knows or unit_id in self.silent:
                self.confirm_by_hand(unit_id)
                self.confirm_by_hand(unit_id, "Sato")
        self.manage(inputs=[said.AcceptPicture("Sato")])

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
        tokens = [note.token for note in self.notes if isinstance(note, said.Granted)]
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
            request = train.unit.state.authority.open(RequestKind.ROUTE) or train.unit.state.authority.open(
                RequestKind.SIGN_ON
            )
            if request is None:
                continue
            holders = {
                f"held: section {s} of {o.unit_id}"
                for o in self.units.values()
                for s in o.unit.state.authority.held
            }
            assert request.refusal in holders, (unit_id, waits_for)
