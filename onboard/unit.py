"""The on-board unit (車上装置): joins telegrams, duty and authority behind one door.

`advance(now_s, telegrams, sensed) -> (telegrams, command, notes)`: whatever has come over the air, from the sensors
and the crew, and through time, is put to the duty machine one by one; what that does is turned into telegrams, timers
and the command for the driving part (`onboard.motion`). `now_s` is what the unit's own clock shows. The unit keeps no
metres and draws no chance: what it says is a function of what it was told.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import msgspec

from onboard import notes
from onboard.authority import records as auth
from onboard.authority.letters import Letters
from onboard.crossings.machine import CrossingPlace
from onboard.crossings.talk import CrossingTalk
from onboard.duty import records
from onboard.duty.duty_step import NEVER_S, Action
from onboard.duty.machine import TABLE, step
from onboard.duty.orders import leads_on
from onboard.duty.shown import command_of
from onboard.duty_parameters import DutyParameters
from onboard.plan import NO_PLAN, DutyPlan
from radio.elapsed import Elapsed
from radio.envelope import Dropped, Endpoint

TIMES_ALIKE_S: Final = 1e-6


class Report(msgspec.Struct, frozen=True):
    """What reaches the unit besides telegrams: where the train is now, and what happened, in order.

    `claims_besides`: for its host alone, what a fault has it claim that it does not hold. `crossings`: the level
    crossings of its path; None: it does not know where it is.
    """

    place: records.PlaceInJoints
    happened: tuple[records.Happening, ...] = ()
    claims_besides: tuple[str, ...] = ()
    crossings: tuple[CrossingPlace, ...] | None = ()


class Telegram(msgspec.Struct, frozen=True):
    """A sealed telegram for the air."""

    destination: str
    data: bytes


class UnitAnswer(msgspec.Struct, frozen=True):
    """What the unit did: telegrams, what it wants of its driving part, what it tells the driver, lines of the journal.

    `wake_at_s`: when a timer runs out next; None: none runs.
    """

    telegrams: tuple[Telegram, ...]
    command: records.DrivingCommand
    told: tuple[records.Told, ...]
    notes: tuple[notes.Note, ...]
    wake_at_s: float | None


class _RunsOut(NamedTuple):
    """When a timer runs out: so much has elapsed, and the clock shows this."""

    elapsed_s: float
    clock_s: float


class OnboardUnit:
    """One boot of one on-board unit. `perhaps_on_line`: whether the boot before ended there; None: nobody can tell."""

    def __init__(
        self,
        unit_id: str,
        manager_id: str,
        parameters: DutyParameters,
        endpoint: Endpoint,
        *,
        perhaps_on_line: bool | None = None,
    ) -> None:
        self.unit_id: Final = unit_id
        unsure = endpoint.epoch > 1 if perhaps_on_line is None else perhaps_on_line
        self.state = records.DutyState(authority=auth.Authority(unsure=unsure))
        self.plan: DutyPlan = NO_PLAN
        self._command: records.DrivingCommand | None = None
        self._command_of: tuple[DutyPlan, records.DutyState] = (self.plan, self.state)
        self._parameters: Final = parameters
        self._endpoint: Final = endpoint
        self._letters: Final = Letters(unit_id, manager_id)
        self._crossings: Final = CrossingTalk(forgot=unsure)
        self._elapsed: Final = Elapsed()
        self._timers: dict[auth.Timer, _RunsOut] = {}
        self._telegrams: list[Telegram] = []
        self._told: list[records.Told] = []
        self._notes: list[notes.Note] = []
        self._orders: list[records.DrivingOrder] = []

    def advance(self, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> UnitAnswer:
        """Act at `now_s` on what happened, on telegrams, on timers, in this order."""
        elapsed_s = self._elapsed.at(now_s)
        place = self._at_crossing(sensed.place, elapsed_s)
        for event in sensed.happened:
            if isinstance(event, records.CreepOver):
                self._crossings.creep(event.crossing_id, elapsed_s, guarded=event.guarded)
            else:
                self._take(event, place, now_s)
        for data in telegrams:
            self._open(data, place, now_s)
        while (timer := self._next_due(now_s)) is not None:
            del self._timers[timer]
            self._take(records.TimerDue(timer), place, now_s)
        self._look_at_crossings(sensed, now_s)
        crossings = self._crossings.command(elapsed_s)
        command = msgspec.structs.replace(
            self._commanded(),
            orders=tuple(self._orders),
            crossings=msgspec.structs.replace(crossings, look_s=self._elapsed.shown_at(crossings.look_s)),
        )
        wakes_s = [*map(self._shown_at, self._timers.values())]
        if (wake_s := self._crossings.wake_s(elapsed_s, crossings.unless_on)) < math.inf:
            wakes_s.append(self._elapsed.shown_at(wake_s))
        answer = UnitAnswer(
            tuple(self._telegrams),
            command,
            tuple(self._told),
            tuple(self._notes),
            min(wakes_s, default=None),
        )
        self._telegrams, self._told, self._notes, self._orders = [], [], [], []
        return answer

    def _commanded(self) -> records.DrivingCommand:
        """The command of the duty as it stands; many telegrams change nothing of it."""
        of = (self.plan, self.state)
        if self._command is None or self._command_of[0] is not of[0] or self._command_of[1] is not of[1]:
            self._command, self._command_of = command_of(*of), of
        return self._command

    def _at_crossing(self, place: records.PlaceInJoints, elapsed_s: float) -> records.PlaceInJoints:
        """The place with the level crossing that the train, if it stands, waits for."""
        waits_at = self._crossings.start_held_by(elapsed_s)
        return msgspec.structs.replace(place, crossing=waits_at) if waits_at else place

    def _look_at_crossings(self, sensed: Report, now_s: float) -> None:
        """How the train is to level crossings now; who waits at its stop for one that has proved closed leaves."""
        elapsed_s, leave = self._elapsed.at(now_s), self._timers.get(records.LEAVE)
        unset_s = 0.0 if self.state.may_leave else math.inf
        leaves_in_s = unset_s if leave is None else self._shown_at(leave) - now_s
        self._crossings.look(sensed.crossings, self.state, leaves_in_s, elapsed_s)
        place = self._at_crossing(sensed.place, elapsed_s)
        if place.crossing != self.state.place.crossing:
            self._take(records.Looked(), place, now_s)
        if place.crossing:  # it is this that it has stopped for, not the end of its way beyond
            why = f"level crossing {place.crossing} to be proved closed"
            for at, note in enumerate(self._notes):
                if isinstance(note, notes.StoppedShort):
                    self._notes[at] = msgspec.structs.replace(note, why=why)
        for letter in self._crossings.letters:
            data = self._endpoint.seal(letter.crossing_id, letter.message, now_s, letter.correlation)
            self._telegrams.append(Telegram(letter.crossing_id, data))
        self._notes += self._crossings.notes
        self._crossings.letters.clear()
        self._crossings.notes.clear()

    def _take(self, event: records.Event, place: records.PlaceInJoints, now_s: float) -> None:
        if records.DrivingOrder.LOSE in self._orders:  # its driving part has yet to obey
            place = msgspec.structs.replace(place, known=False, emergency=True)
        if isinstance(event, records.OffTheLine):
            self._crossings.off_the_line(self._elapsed.at(now_s))
        if isinstance(event, records.TakeUpWay) and not leads_on(self.plan, self.state, event.plan):
            event = records.NoSuchWay()
        if isinstance(event, records.Begin) and (self.state.phase, records.Begin) not in TABLE:
            return  # a number is entered before the first train, and when one is over
        if isinstance(event, records.Begin | records.SwitchedOn | records.TakeUpWay):
            self.plan = event.plan
        if isinstance(event, records.SwitchedOn):
            event = msgspec.structs.replace(event, epoch=self._endpoint.epoch)
        self.state, actions = step(self.plan, self._parameters, self.state, event, place, now_s)
        for action in actions:
            self._do(action, now_s)

    def _open(self, data: bytes, place: records.PlaceInJoints, now_s: float) -> None:
        """A telegram from the air: checked, written down, and put to the machine as it relates to what is open."""
        opened = self._endpoint.open(data, now_s)
        if isinstance(opened, Dropped):
            self._notes.append(opened.noted(self.unit_id))
            source = "" if opened.envelope is None else opened.envelope.source
            if (called := self._letters.read_dropped(opened.reason, source)) is not None:
                self._take(records.TelegramHeard(called), place, now_s)
            return
        self._notes.append(opened.noted(self.unit_id))
        if self._crossings.hear(opened, self._elapsed.at(now_s)):
            return
        event = self._letters.read(opened)
        if isinstance(event, auth.Ordered):
            self._take(event, place, now_s)
        elif event is not None:
            self._take(records.TelegramHeard(event), place, now_s)

    def _shown_at(self, runs_out: _RunsOut) -> float:
        """What the clock shows when a timer runs out."""
        return max(self._elapsed.shown_at(runs_out.elapsed_s), runs_out.clock_s)

    def _next_due(self, now_s: float) -> auth.Timer | None:
        at = [(self._shown_at(runs_out), timer) for timer, runs_out in self._timers.items()]
        return min(((s, timer) for s, timer in at if s <= now_s + TIMES_ALIKE_S), default=(0.0, None))[1]

    def _do(self, action: Action, now_s: float) -> None:
        match action:
            case auth.SendRequest() | auth.SendClaim() | auth.SendRefusal() | auth.SendCommand():
                letter = self._letters.write(action)
                data = self._endpoint.seal(letter.destination, letter.message, now_s, letter.correlation)
                self._telegrams.append(Telegram(letter.destination, data))
            case auth.Renew() | auth.Commit() | auth.Take():
                self._letters.keep(action)
            case auth.SetTimer(timer, after_s):
                self._timers[timer] = _RunsOut(self._elapsed.at(now_s) + after_s, NEVER_S)
            case records.SetTimerAt(timer, at_s, after_s):
                self._timers[timer] = _RunsOut(self._elapsed.at(now_s) + after_s, at_s)
            case auth.StopTimer(timer):
                self._timers.pop(timer, None)
            case auth.Write(note):
                self._notes.append(self._letters.with_token(note))
            case records.DrivingOrder():
                self._orders.append(action)
            case _:
                self._told.append(action)
