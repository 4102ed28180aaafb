"""Switches that take one behaviour away, by name, and the runs in which the tests of this folder use them.

A switch patches the function that carries the behaviour; pytest puts it back. `MISBEHAVIOUR` is not a defect of ours
but what somebody else does wrong, against whom a behaviour protects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, cast

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from host import device
from network.model import Position
from onboard import unit as unit_module
from onboard.authority import machine as auth
from onboard.authority.records import Authority
from onboard.authority.stop_limit import StopLimit, cleared_sections, stop_limit
from onboard.duty.mission import Mission
from onboard.notes import Claimed
from onboard.unit import Transmit, Unit, UnitAction
from radio import envelope as env
from radio.envelope import DropReason, Envelope, Peer
from radio.keys import MAC_BYTES
from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    HoldingReport,
    PointsCommand,
    PointsProof,
    PointsRefusalReason,
    RefusalReason,
    RouteRefused,
    RouteRequest,
)
from simulation.setup import Setup, behaviour_rows
from simulation.world.crew import Crew, Seen
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
Handler = Callable[..., auth.Result]

FOLDER: Final = Path(__file__).parent / "defects"
TRAIN_M: Final = 40.0  # length of the train of every scenario here
K1_ON_P7_S: Final = 36_071.0  # two_trains: from here on K1 is on P7
K2_ON_P7_S: Final = 36_112.0  # and from here on K2

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


def heard_table() -> dict[type, Handler]:
    """What a unit does with each telegram."""
    return cast("dict[type, Handler]", auth._HEARD)


def event_table() -> dict[type, Handler]:
    """What a unit's authority does with each event."""
    return cast("dict[type, Handler]", auth._EVENTS)


def only_of(unit_id: str, mine: Handler, others: Handler) -> Handler:
    """One handler for one unit, the other for the rest."""

    def handler(state: Authority, event: auth.Event, now_s: float, covered: bool) -> auth.Result:
        chosen = mine if state.unit_id == unit_id else others
        return chosen(state, event, now_s, covered)

    return handler


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


# point terminal -----------------------------------------------------------------------------------------------


@switch
def commands_what_it_does_not_hold(patch: pytest.MonkeyPatch) -> None:
    """Given: K2, refused because K1 is on its way over P7, commands P7 with a capability that it made up."""
    refused = auth._HEARD[RouteRefused]

    def rogue(state: Authority, event: auth.Heard, now_s: float, covered: bool) -> auth.Result:
        state, actions = refused(state, event, now_s, covered)
        if now_s < K1_ON_P7_S:
            return state, actions
        order = PointsCommand("P7", Position.REVERSE, "7", state.token + 10, bytes(MAC_BYTES))
        return state, (*actions, auth.Send("B-W", order, 0))

    patch.setitem(heard_table(), RouteRefused, rogue)


@switch
def throws_for_anyone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(point_terminal, "refusal", lambda *_: None)


@switch
def repeats_an_old_command(patch: pytest.MonkeyPatch) -> None:
    """Given: K1 keeps its command of P7, and repeats it long after it gave the section back."""
    proof, cleared = auth._HEARD[PointsProof], auth._EVENTS[auth.Cleared]

    def kept(before: Authority, after: auth.Result) -> auth.Result:
        state, actions = after
        lost = [c for c in before.commands if c not in state.commands and c.needed.points_id == "P7"]
        again = tuple(replace(command, next_s=K2_ON_P7_S) for command in lost)
        return replace(state, commands=(*state.commands, *again)), actions

    def proven(state: Authority, event: auth.Heard, now_s: float, covered: bool) -> auth.Result:
        done = any(n.points_id == "P7" for n in state.proven)  # else it would prove the same points again
        return (state, ()) if done else kept(state, proof(state, event, now_s, covered))

    def given_back(state: Authority, event: auth.Cleared, now_s: float, covered: bool) -> auth.Result:
        return kept(state, cleared(state, event, now_s, covered))

    def not_withdrawn(state: Authority, _event: auth.Withdrawn, _now_s: float, _covered: bool) -> auth.Result:
        return state, ()

    patch.setitem(heard_table(), PointsProof, only_of("K1", proven, proof))
    patch.setitem(event_table(), auth.Cleared, only_of("K1", given_back, cleared))
    withdrawn = auth._EVENTS[auth.Withdrawn]
    patch.setitem(event_table(), auth.Withdrawn, only_of("K1", not_withdrawn, withdrawn))


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
    def at_front(mission: Mission, authority: Authority, safe_rear_m: float) -> tuple[str, ...]:
        return cleared_sections(mission, authority, safe_rear_m + TRAIN_M)

    patch.setattr(unit_module, "cleared_sections", at_front)


@switch
def does_not_wait_for_proof(patch: pytest.MonkeyPatch) -> None:
    def held_alone(mission: Mission, authority: Authority, _entered: object = ()) -> StopLimit:
        bare = replace(mission, spans=tuple(replace(span, points=()) for span in mission.spans))
        return stop_limit(bare, authority)

    patch.setattr(unit_module, "stop_limit", held_alone)


@switch
def runs_beyond_what_it_holds(patch: pytest.MonkeyPatch) -> None:
    def end_of_path(mission: Mission, _authority: Authority, _entered: object = ()) -> StopLimit:
        return StopLimit(mission.spans[-1].end_m, None, "end of the path")

    patch.setattr(unit_module, "stop_limit", end_of_path)


@switch
def ignores_a_withdrawn_proof(patch: pytest.MonkeyPatch) -> None:
    proof = auth._HEARD[PointsProof]

    def once_proven(state: Authority, event: auth.Heard, now_s: float, covered: bool) -> auth.Result:
        after, actions = proof(state, event, now_s, covered)
        return (state, ()) if len(after.proven) < len(state.proven) else (after, actions)

    patch.setitem(heard_table(), PointsProof, once_proven)


@switch
def claims_only_where_it_stands(patch: pytest.MonkeyPatch) -> None:
    def claim(state: Authority, event: auth.Heard, _now_s: float, _covered: bool) -> auth.Result:
        here = state.section_ids()[:1]
        return state, (
            auth.Send(state.manager_id, Claim(here, state.token), event.correlation),
            Claimed(section_ids=here, token=state.token),
        )

    patch.setitem(heard_table(), ClaimQuery, claim)


@switch
def believes_any_tag(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(unit_module, "within_window", lambda *_: True)


@switch
def expects_no_tag(patch: pytest.MonkeyPatch) -> None:
    def expect(self: Unit, _after_m: float | None = None) -> None:
        self.row.expected_tag_m = math.inf

    patch.setattr(Unit, "_expect_tag", expect)


@switch
def bounds_do_not_grow(patch: pytest.MonkeyPatch) -> None:
    place = Trains.place

    def placed(self: Trains, slot: int, duty: Duty) -> None:
        place(self, slot, duty)
        self.units[slot].bound_growth = 0.0

    patch.setattr(Trains, "place", placed)


@switch
def restarts_at_full_speed(patch: pytest.MonkeyPatch) -> None:
    restart, fault = Unit.restart, Unit._position_fault

    def at_once(self: Unit, *args: Any, **keywords: Any) -> list[UnitAction]:  # noqa: ANN401 - handed on
        actions = restart(self, *args, **keywords)
        self.row.restricted_mps = math.inf
        return actions

    def unrestricted(self: Unit, why: str, now_s: float) -> None:
        fault(self, why, now_s)
        self.row.restricted_mps = math.inf

    patch.setattr(Unit, "restart", at_once)
    patch.setattr(Unit, "_position_fault", unrestricted)


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

    def nod(self: Crew, slot: int, now_s: float) -> Seen:
        seen = stand(self, slot, now_s)
        return seen if seen.to_throw is None else Seen(passable=seen.to_throw)

    patch.setattr(Crew, "stand", nod)


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


@switch
def forges_a_report(patch: pytest.MonkeyPatch) -> None:
    """Given: with each request of K2 goes a report in the name of K1, code and all made up: 'I hold 3 alone'."""
    send, token = Unit._send, [0]

    def forging(self: Unit, destination: str, message: AnyMessage, correlation: int, now_s: float) -> None:
        if self.facts.unit_id == "K1":
            token[0] = self.authority.token
        elif isinstance(message, RouteRequest):
            report = msgspec.Raw(msgspec.msgpack.encode(HoldingReport(("3",), token[0])))
            false = Envelope("K1", destination, 1, 1, 1000 + correlation, now_s, None, 0, report)
            data = msgspec.msgpack.encode(false) + bytes(MAC_BYTES)
            self._actions.append(Transmit(destination, "HoldingReport", data))
        send(self, destination, message, correlation, now_s)

    patch.setattr(Unit, "_send", forging)


@switch
def believes_any_code(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(env, "mac_equal", lambda *_: True)
