"""Switches that take one behaviour away, by name, and the runs in which the tests of this folder use them.

A switch patches the function that carries the behaviour; pytest puts it back. `MISBEHAVIOUR` is not a defect of ours
but what somebody else does wrong, against whom a behaviour protects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from types import MappingProxyType
from typing import Final

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from host import device
from network.model import Position
from onboard import motion
from onboard.authority import letters, points
from onboard.authority import machine as authority
from onboard.authority import records as sym
from onboard.authority.letters import Letters
from onboard.authority.records import Authority
from onboard.authority.stop_limit import stop_limit
from onboard.authority.tables import Handler, Result
from onboard.duty import machine as duty_machine
from onboard.duty.mission import Mission
from onboard.duty.plan import Plan, PointsNeeded
from onboard.duty.records import Command, Limit, Person, Place, PointsSeen, PointsWrong
from onboard.localisation.fix import Fix, Refused, Taken, take
from onboard.motion import Motion, PathData
from onboard.notes import Claimed
from onboard.records import UnitRow
from onboard.unit import Answer, Report, Telegram, Unit
from radio import envelope as env
from radio.envelope import DropReason, Envelope, Peer, header_of, kind_of
from radio.keys import MAC_BYTES
from radio.messages import (
    HoldingReport,
    PointsCommand,
    PointsProof,
    PointsRefusalReason,
    RefusalReason,
)
from radio.noted import TookEffect
from simulation.setup import Setup, behaviour_rows
from simulation.world.crew import Crew
from simulation.world.roster import Duty
from simulation.world.trains import Trains
from study.run.drill import find_drill, shipped_drills
from study.run.run import Link, Run, execute
from study.run.verdict import judge
from study.scenario.scenario import load_scenario
from wayside import block_manager, point_terminal, reentry, register
from wayside.actions import Action, Send, Show
from wayside.config import ManagerConfig
from wayside.register import Register, Standing
from wayside.said import Freed

Switch = Callable[[pytest.MonkeyPatch], None]

FOLDER: Final = Path(__file__).parent / "defects"
TRAIN_M: Final = 40.0  # length of the train of every scenario here
K1_ON_P7_S: Final = 36_071.0  # two_trains: from here on K1 is on P7
K2_ON_P7_S: Final = 36_112.0  # and from here on K2
ON_THE_POINTS_AFTER_S: Final = 12.0  # a train that has started on sight from before them is on them

SWITCHES: Final[dict[str, Switch]] = {}


def switch(function: Switch) -> Switch:
    """Enter a switch under its name."""
    SWITCHES[function.__name__] = function
    return function


@pytest.fixture(scope="session")
def switch_names() -> frozenset[str]:
    return frozenset(SWITCHES)


@pytest.fixture
def run_with(monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[Run, set[str]]]:
    """Run a scenario or drill with switches thrown; the run, and who objects: checkers, unmet expectations."""

    def run(scenario: str, *switches: str | Switch) -> tuple[Run, set[str]]:
        for given in switches:
            if given:
                throw = SWITCHES[given] if isinstance(given, str) else given
                throw(monkeypatch)
        file = FOLDER / f"{scenario}.toml"
        name = str(file) if file.is_file() else scenario
        loaded = load_scenario(find_drill(name) if name in shipped_drills() else name)
        done = execute(loaded, Link.SIMULATED)
        verdicts = judge(loaded.setup.script.expectations, done.result, done.tables)
        return done, {v.checker for v in done.result.violations} | {v.text for v in verdicts if not v.passed}

    return run


def with_handlers(
    patch: pytest.MonkeyPatch, handlers: Mapping[type[sym.Event], Callable[[Handler], Handler]]
) -> None:
    """Unit's authority: each handler of these events, whatever the standing, as the given function makes it."""
    table = dict(authority.TABLE)
    for (standing, event), handler in authority.TABLE.items():
        if event in handlers:
            table[standing, event] = handlers[event](handler)
    patch.setattr(authority, "TABLE", MappingProxyType(table))


# block manager ----------------------------------------------------------------------------------------------


@switch
def grants_what_another_holds(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Register, "other_holder", lambda *_: None)


@switch
def grants_while_undefined(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Register, "defined", property(lambda _: True))


@switch
def starts_with_every_section_free(patch: pytest.MonkeyPatch) -> None:
    start = register.start

    def afresh(
        config: ManagerConfig, epoch: int, keys: Mapping[str, bytes], _ledger: Iterable[str] = ()
    ) -> Register:
        return replace(start(config, epoch, keys, ()), restoring=False)

    patch.setattr(device, "start_register", afresh)
    patch.setattr(register, "UNKNOWN_UNIT", register.Unit(Standing.OUTSIDE))


@switch
def accepts_a_picture_without_the_silent(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(reentry, "vouched", lambda *_: True)


@switch
def tokens_begin_anew(patch: pytest.MonkeyPatch) -> None:
    def next_token(self: Register) -> tuple[Register, int]:
        return replace(self, counter=self.counter + 1), self.counter + 1

    patch.setattr(Register, "next_token", next_token)


@switch
def silence_frees(patch: pytest.MonkeyPatch) -> None:
    """A lease: what a unit holds is free when it has been silent for 15 s."""
    step, heard_s = block_manager.step, dict[str, float]()

    def leased(state: Register, event: block_manager.Event, now_s: float) -> reentry.Step:
        if isinstance(event, block_manager.Heard):
            heard_s[event.unit_id] = now_s
        lapsed: list[Action] = []
        for unit_id, last_s in heard_s.items():
            if now_s - last_s > 15.0 and (held := state.held_by(unit_id)):
                state = state.with_held(unit_id, ())
                lapsed.append(Show(Freed(unit_id=unit_id, section_ids=held)))
        state, actions = step(state, event, now_s)
        return state, (*lapsed, *actions)

    patch.setattr(block_manager, "step", leased)


@switch
def refuses_everything(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(block_manager, "_against", lambda *_: (RefusalReason.HELD, None, None))


# duty and timers ----------------------------------------------------------------------------------------------


@switch
def never_asks_again(patch: pytest.MonkeyPatch) -> None:
    def once(handler: Handler) -> Handler:
        def heard(state: Authority, event: sym.Event) -> Result:
            state, actions = handler(state, event)
            return state, tuple(sym.StopTimer(a.timer) if isinstance(a, sym.SetTimer) else a for a in actions)

        return heard

    with_handlers(patch, {sym.Refused: once})


@switch
def drops_its_timers(patch: pytest.MonkeyPatch) -> None:
    advance = Unit.advance

    def forgetful(self: Unit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> Answer:
        answer = advance(self, now_s, telegrams, sensed)
        if self.state.authority.on_line:
            self._timers.clear()
            answer = msgspec.structs.replace(answer, wake_at_s=None)
        return answer

    patch.setattr(Unit, "advance", forgetful)


# point terminal -----------------------------------------------------------------------------------------------


@switch
def commands_what_it_does_not_hold(patch: pytest.MonkeyPatch) -> None:
    """Given: K2, refused because K1 is on its way over P7, commands P7 with a capability that it made up."""
    advance = Unit.advance

    def rogue(self: Unit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> Answer:
        answer = advance(self, now_s, telegrams, sensed)
        refused = any(isinstance(n, TookEffect) and n.kind == "RouteRefused" for n in answer.notes)
        if self.unit_id != "K2" or now_s < K1_ON_P7_S or not refused:
            return answer
        order = PointsCommand("P7", Position.REVERSE, "7", self._letters.token + 10, bytes(MAC_BYTES))
        data = self._endpoint.seal("B-W", order, now_s)
        made_up = Telegram("B-W", data)
        return msgspec.structs.replace(answer, telegrams=(*answer.telegrams, made_up))

    patch.setattr(Unit, "advance", rogue)


@switch
def throws_for_anyone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(point_terminal, "refusal", lambda *_: None)


@switch
def repeats_an_old_command(patch: pytest.MonkeyPatch) -> None:
    """Given: K1 keeps its command of P7, and repeats it long after it gave the section back."""
    advance, kept = Unit.advance, list[tuple[str, PointsCommand]]()
    write = Letters.write

    def writing(self: Letters, action: sym.Send | sym.SendClaim | sym.SendCommand) -> letters.Letter:
        letter = write(self, action)
        message = letter.message
        if self._unit_id == "K1" and isinstance(message, PointsCommand) and message.points_id == "P7":
            kept[:] = [(letter.destination, message)]
        return letter

    def repeating(self: Unit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> Answer:
        answer = advance(self, now_s, telegrams, sensed)
        if self.unit_id != "K1" or now_s < K2_ON_P7_S or not kept:
            return answer
        destination, order = kept.pop()
        again = Telegram(destination, self._endpoint.seal(destination, order, now_s))
        return msgspec.structs.replace(answer, telegrams=(*answer.telegrams, again))

    patch.setattr(Letters, "write", writing)
    patch.setattr(Unit, "advance", repeating)


@switch
def obeys_an_old_token(patch: pytest.MonkeyPatch) -> None:
    """The capability is authentic; that a newer holder has commanded since is not looked at."""
    real, tables = point_terminal.refusal, dict(point_terminal.TABLE)

    def forgetful(
        terminal: point_terminal.Terminal, unit_id: str, command: PointsCommand
    ) -> PointsRefusalReason | None:
        reason = real(terminal, unit_id, command)
        return None if reason is PointsRefusalReason.OLD_TOKEN else reason

    patch.setattr(point_terminal, "refusal", forgetful)
    for state in point_terminal.PointsState:
        tables[state, point_terminal.Commanded] = point_terminal._command
    patch.setattr(point_terminal, "TABLE", tables)


@switch
def proves_what_it_has_not_detected(patch: pytest.MonkeyPatch) -> None:
    def proof(view: point_terminal.PointsView, commitment: point_terminal.Commitment) -> Send:
        said = PointsProof(view.entry.points_id, commitment.position, True, True, commitment.token)
        return Send(commitment.unit_id, said, view.correlation)

    patch.setattr(point_terminal, "_shows", lambda *_: True)
    patch.setattr(point_terminal, "_proof", proof)


# on-board unit ------------------------------------------------------------------------------------------------


@switch
def releases_at_the_front(patch: pytest.MonkeyPatch) -> None:
    """What the front has surely passed counts as left by the rear, and the driving part reports that joint."""
    place = Motion.place

    def at_front(self: Motion) -> Place:
        here = place(self)
        passed = max(here.sure - 1, 0)
        return msgspec.structs.replace(here, clear=passed, clear_at_mark=passed)

    patch.setattr(Motion, "place", at_front)


@switch
def does_not_wait_for_proof(patch: pytest.MonkeyPatch) -> None:
    def held_alone(plan: Plan, state: Authority, _entered: Collection[str] = (), **how: bool) -> Limit:
        bare = tuple(msgspec.structs.replace(span, points=()) for span in plan.spans)
        return stop_limit(msgspec.structs.replace(plan, spans=bare), state, **how)

    patch.setattr(duty_machine, "stop_limit", held_alone)


@switch
def runs_beyond_what_it_holds(patch: pytest.MonkeyPatch) -> None:
    def end_of_path(plan: Plan, _state: Authority, _entered: Collection[str] = (), **_how: bool) -> Limit:
        return Limit(len(plan.spans), None, "end of the path")

    patch.setattr(duty_machine, "stop_limit", end_of_path)


@switch
def ignores_a_withdrawn_proof(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(points, "_lost", lambda state, _event: (state, ()))


@switch
def claims_only_where_it_stands(patch: pytest.MonkeyPatch) -> None:
    def claim(_queried: Handler) -> Handler:
        def first(state: Authority, _event: sym.Queried) -> Result:
            here = state.held[:1]
            return state, (sym.SendClaim(here), sym.Write(Claimed(section_ids=here, token=0)))

        return first

    with_handlers(patch, {sym.Queried: claim})


@switch
def believes_any_tag(patch: pytest.MonkeyPatch) -> None:
    def take_any(row: UnitRow, fix: Fix) -> Taken | Refused:
        row.position_known = 0  # so that nothing is compared
        return take(row, fix)

    patch.setattr(motion, "missed_by_m", lambda *_: 0.0)
    patch.setattr(motion, "take", take_any)


@switch
def expects_no_tag(patch: pytest.MonkeyPatch) -> None:
    def expect(self: Motion, _after_m: float | None = None) -> None:
        self.row.expected_tag_m = math.inf

    patch.setattr(Motion, "_expect_tag", expect)


@switch
def bounds_do_not_grow(patch: pytest.MonkeyPatch) -> None:
    take_up = Motion._take_up

    def certain(self: Motion, mission: Mission, path: PathData) -> None:
        take_up(self, mission, path)
        self.row.bound_growth = 0.0

    patch.setattr(Motion, "_take_up", certain)


@switch
def restarts_at_full_speed(patch: pytest.MonkeyPatch) -> None:
    obey = Motion.obey

    def at_once(self: Motion, command: Command, now_s: float) -> None:
        obey(self, command, now_s)
        self.row.restricted_mps = math.inf

    patch.setattr(Motion, "obey", at_once)


@switch
def service_brake_is_weak(patch: pytest.MonkeyPatch) -> None:
    """Given: the service brake gives a fifth of what automatic driving counts on; the emergency brake is sound."""
    place = Trains.place

    def worn(self: Trains, slot: int, duty: Duty) -> None:
        place(self, slot, duty)
        self.plants[slot].brake_factor = 0.2

    patch.setattr(Trains, "place", worn)


@switch
def supervision_trusts_any_brake(patch: pytest.MonkeyPatch) -> None:
    """Brakes taken for so strong that the curve before the stop limit leaves no room to stop."""

    def strong(setup: Setup, stocks: tuple[str, ...]) -> NDArray[np.void]:
        made = behaviour_rows(setup, stocks)
        made["service_guaranteed_mps2"] = made["emergency_guaranteed_mps2"] = 1e3
        made["service_reaction_s"] = made["emergency_reaction_s"] = 0.0
        return made

    patch.setattr("simulation.world.trains.behaviour_rows", strong)


@switch
def crew_does_not_look(patch: pytest.MonkeyPatch) -> None:
    stand = Crew.stand

    def nod(self: Crew, slot: int, now_s: float) -> list[Person]:
        return [PointsSeen(p.points) if isinstance(p, PointsWrong) else p for p in stand(self, slot, now_s)]

    patch.setattr(Crew, "stand", nod)


@switch
def crew_does_not_lock(patch: pytest.MonkeyPatch) -> None:
    """The crew only looks: what it has seen may change before its train has passed."""

    def looks(self: Crew, _slot: int, _mission: Mission, needed: PointsNeeded, _now_s: float) -> bool:
        machine = self._machine_of(needed.points_id)
        return machine.locked and machine.position is needed.position

    patch.setattr(Crew, "_locks", looks)


@switch
def commands_after_the_look(patch: pytest.MonkeyPatch) -> None:
    """Given: a unit commands P7 the other way, by its own token, when its train is on its way over it on sight."""
    advance, due_s = Unit.advance, list[float]()

    def rogue(self: Unit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> Answer:
        answer = advance(self, now_s, telegrams, sensed)
        if any(isinstance(event, PointsSeen) for event in sensed.happened):
            due_s.append(now_s + ON_THE_POINTS_AFTER_S)
        if not due_s:
            return answer
        if now_s < due_s[0]:
            return msgspec.structs.replace(answer, wake_at_s=min(due_s[0], answer.wake_at_s or math.inf))
        due_s.clear()
        own = self._letters
        order = PointsCommand("P7", Position.REVERSE, "7", own.token, own._macs["7", "B-W"])
        data = self._endpoint.seal("B-W", order, now_s)
        return msgspec.structs.replace(answer, telegrams=(*answer.telegrams, Telegram("B-W", data)))

    patch.setattr(Unit, "advance", rogue)


# envelope -----------------------------------------------------------------------------------------------------


def anywhere(_receiver: str) -> bool:
    return True


def on_board(receiver: str) -> bool:
    return receiver.startswith("K")


def at_the_ground(receiver: str) -> bool:
    return not on_board(receiver)


def lets_pass(patch: pytest.MonkeyPatch, *let: DropReason, where: Callable[[str], bool] = anywhere) -> None:
    check = env.check

    def lax(
        peer: Peer, envelope: Envelope, own_epoch: int, now_s: float, age_max_s: float
    ) -> tuple[Peer, DropReason | None]:
        heard, reason = check(peer, envelope, own_epoch, now_s, age_max_s)
        return (peer, None) if reason in let and where(envelope.destination) else (heard, reason)

    patch.setattr(env, "check", lax)


@switch
def accepts_telegrams_twice(patch: pytest.MonkeyPatch) -> None:
    lets_pass(patch, DropReason.REPEATED)


@switch
def ground_accepts_telegrams_twice(patch: pytest.MonkeyPatch) -> None:
    """Manager and terminals alone."""
    lets_pass(patch, DropReason.REPEATED, where=at_the_ground)


@switch
def units_accept_telegrams_twice(patch: pytest.MonkeyPatch) -> None:
    lets_pass(patch, DropReason.REPEATED, where=on_board)


@switch
def obeys_an_earlier_boot(patch: pytest.MonkeyPatch) -> None:
    lets_pass(patch, DropReason.OLD_EPOCH)


def kind_of_data(data: bytes) -> str | None:
    """Kind of the message in a telegram that is sound."""
    envelope = header_of(data)
    return None if envelope is None else kind_of(envelope)


@switch
def forges_a_report(patch: pytest.MonkeyPatch) -> None:
    """Given: with each request of K2 goes a report in the name of K1, code and all made up: 'I hold 3 alone'."""
    advance, token, sent = Unit.advance, [0], [1000]

    def forging(self: Unit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> Answer:
        answer = advance(self, now_s, telegrams, sensed)
        if self.unit_id == "K1":
            token[0] = self._letters.token
            return answer
        requests = [
            telegram for telegram in answer.telegrams if kind_of_data(telegram.data) == "RouteRequest"
        ]
        return msgspec.structs.replace(
            answer, telegrams=(*map(forged, requests, repeat(now_s)), *answer.telegrams)
        )

    def forged(request: Telegram, now_s: float) -> Telegram:
        sent[0] += 1
        report = msgspec.Raw(msgspec.msgpack.encode(HoldingReport(("3",), token[0])))
        false = Envelope("K1", request.destination, 1, 1, sent[0], now_s, None, 0, report)
        data = msgspec.msgpack.encode(false) + bytes(MAC_BYTES)
        return Telegram(request.destination, data)

    patch.setattr(Unit, "advance", forging)


@switch
def believes_any_code(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(env, "mac_equal", lambda *_: True)
