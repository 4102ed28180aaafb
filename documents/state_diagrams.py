"""State diagrams of the protocol machines, drawn by exploring them: `python -m documents.state_diagrams` says how fast.

Each machine's own `step` is taken breadth first from its first states with the events of its table, up to a bound, and
what leads from one state of the table to another is drawn (Mermaid). What changes nothing there is not drawn.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Final

from documents import crossing_diagrams
from network.model import Position
from onboard.authority import machine as authority
from onboard.authority import records as auth
from onboard.authority.records import Authority, RequestKind
from onboard.authority.tables import standing
from radio.keys import capability_key, capability_mac
from radio.messages import (
    AnyMessage,
    Claim,
    HoldingReport,
    PointsCommand,
    RouteRequest,
    SignOff,
    SignOn,
)
from simulation.world import point_machine
from simulation.world.point_machine import PointMachine
from verify.breadth import Explored, Keyed, explore
from verify.lone_unit import events_from, first, phase_name
from wayside import block_manager, point_terminal
from wayside.config import ManagerConfig, PointsEntry, RouteEntry, SectionEntry, TerminalConfig
from wayside.point_terminal import Terminal, TerminalMemory
from wayside.register import Register, start
from wayside.said import AcceptPicture, ConfirmHolding, ConfirmOutside, PointsDetected, StartThrow, StopThrow

DUTY_STATES_MAX: Final = 2000
STATES_MAX: Final = 900
_LATER_S: Final = 100.0


def duty() -> Explored[Any]:
    """Phases of the duty: a unit on a small line, all that can happen to it."""
    return explore(first(), events_from, phase_name, DUTY_STATES_MAX)


def authorities() -> Explored[Authority]:
    """Where the unit stands with the manager."""
    return explore([Authority()], _authority, lambda state: standing(state).value, STATES_MAX)


def _authority(state: Authority) -> Iterator[tuple[str, Authority]]:
    own, whole = ("A",), ("X", "B")
    events: tuple[auth.Event, ...] = (
        auth.BeginOnLine(own),
        auth.BeginOnLine(None),
        auth.EndOnLine(),
        auth.AskRoute("A>B", whole),
        auth.GrantHeard("A>B", whole, ("X",), answers=True, fresh=True, newer=True),
        auth.Cleared(("A", "X")),
        auth.GiveBack(whole),
        auth.TurnedBack(),
        auth.SignOnHeard(own, (), answers=True, newer=True),
        auth.SignOnHeard(own, (), answers=False, newer=True),
        *(auth.RefusalHeard(ask, "A>B", "held", lost_sight=True, answers=True) for ask in RequestKind),
        auth.ConfirmationHeard(state.held, answers=True, newer=False),
        auth.SignOffHeard(answers=True),
        auth.QueryHeard(),
        auth.PeerRestarted(),
    )
    for event in events:
        yield type(event).__name__, authority.step(state, event, covered=True)[0]


_LINE: Final = ManagerConfig(
    "line",
    "block-manager",
    ("u1", "u2"),
    (SectionEntry("P", portal=True), SectionEntry("T"), SectionEntry("U")),
    (RouteEntry("P>T", "P", ("T",)), RouteEntry("T>U", "T", ("U",))),
)


def standings() -> Explored[Keyed]:
    """What the block manager knows of one unit, another one about; at its first start and after a restart."""
    starts = [_register(start(_LINE, 1, {})), _register(start(_LINE, 2, {}, ledger=()))]
    return explore(starts, _manager, lambda keyed: keyed.state.unit("u1").standing.value, STATES_MAX)


def _register(register: Register) -> Keyed:
    reentry = register.reentry
    entries = sorted((section, *sorted(by.items(), key=str)) for section, by in reentry.entries.items())
    key = (
        register.restoring,
        register.counter,
        tuple(sorted(register.holders.items())),
        tuple(sorted(register.units.items(), key=lambda item: item[0])),
        tuple(sorted(register.ledger)),
        tuple(entries),
        tuple(sorted(reentry.complete)),
        reentry.accepted_by,
    )
    return Keyed(key, register)


def _manager(keyed: Keyed) -> Iterator[tuple[str, Keyed]]:
    register: Register = keyed.state
    for unit_id in ("u1", "u2"):
        token = register.unit(unit_id).token
        said: tuple[AnyMessage, ...] = (
            SignOn(unit_id, ("P",)),
            SignOn(unit_id, ("T",)),
            SignOn(unit_id, None),
            Claim(("T",), 0),
            Claim((), 0),
            Claim(None, 0),
            RouteRequest(unit_id, "P>T", ("T",)),
            HoldingReport(("T",), token),
            SignOff(unit_id, token),
        )
        for message in said:
            heard: block_manager.Heard[AnyMessage] = block_manager.Heard(unit_id, 1, True, 1, message)
            yield _named(message, unit_id), _register(block_manager.step(register, heard, 0.0)[0])
        for person in ("one", "another"):
            for act in (ConfirmOutside(unit_id, person), ConfirmHolding(unit_id, ("T",), person)):
                after, _ = block_manager.step(register, act, _LATER_S)
                yield _named(act, unit_id), _register(after)
    yield "AcceptPicture", _register(block_manager.step(register, AcceptPicture("one"), _LATER_S)[0])


def _named(event: object, unit_id: str) -> str:
    return type(event).__name__ + ("" if unit_id == "u1" else " (another unit)")


_KEY: Final = capability_key(b"m" * 32, "terminal")
_TERMINAL: Final = TerminalConfig("line", "terminal", (PointsEntry("P", "X", 10.0),))


def points() -> Explored[Keyed]:
    """What a point terminal knows of one set of points."""
    fresh = point_terminal.start(_TERMINAL, _KEY, TerminalMemory())
    return explore([_view(fresh)], _terminal, lambda keyed: keyed.state.views["P"].state.value, STATES_MAX)


def _view(terminal: Terminal) -> Keyed:
    view = terminal.views["P"]
    known = tuple(sorted(terminal.memory.tokens.items())), terminal.memory.commitments.get("P")
    return Keyed((known, view.state, view.detected, view.deadline_s), terminal)


def _terminal(keyed: Keyed) -> Iterator[tuple[str, Keyed]]:
    terminal: Terminal = keyed.state
    for position in Position:
        for token in (1, 2):
            mac = capability_mac(_KEY, "terminal", "X", "u1", token)
            command = PointsCommand("P", position, "X", token, mac)
            after, _ = point_terminal.step(terminal, point_terminal.Commanded("u1", 1, command), 0.0)
            yield "Commanded", _view(after)
    for detected in (*((position, True) for position in Position), (None, False)):
        after, _ = point_terminal.step(terminal, PointsDetected("P", *detected), 0.0)
        yield "PointsDetected", _view(after)
    yield "Expired", _view(point_terminal.step(terminal, point_terminal.Expired(), _LATER_S)[0])
    yield "restart", _view(point_terminal.start(_TERMINAL, _KEY, terminal.memory))


def machines() -> Explored[PointMachine]:
    """What a point machine does."""
    new = PointMachine("P", 6.0, Position.NORMAL)
    return explore([new], _machine, lambda machine: machine.state.value, STATES_MAX)


def _machine(machine: PointMachine) -> Iterator[tuple[str, PointMachine]]:
    events: Iterable[point_machine.MachineEvent] = (
        *(StartThrow("P", position) for position in Position),
        StopThrow("P"),
        point_machine.ThrowTimeOver(_LATER_S),
        point_machine.Forced(),
        *(point_machine.Repaired(position) for position in Position),
    )
    for event in events:
        yield type(event).__name__, point_machine.step(machine, event, 0.0)


def diagram(found: Explored[Any], begins: str) -> str:
    """The edges as a Mermaid state diagram; events that lead the same way stand on one arrow."""
    arrows: dict[tuple[str, str], list[str]] = {}
    for here, event, there in sorted(found.edges):
        arrows.setdefault((here, there), []).append(event)
    names = sorted({begins, *(name for arrow in arrows for name in arrow)})
    lines = ["```mermaid", "stateDiagram-v2"]
    lines += [f'    state "{name}" as {_id(name)}' for name in names]
    lines.append(f"    [*] --> {_id(begins)}")
    lines += [
        f"    {_id(here)} --> {_id(there)}: {', '.join(events)}" for (here, there), events in arrows.items()
    ]
    return "\n".join([*lines, "```"])


def _id(name: str) -> str:
    return name.replace(" ", "_")


DIAGRAMS: Final[dict[str, tuple[Callable[[], Explored[Any]], str]]] = {
    "Block manager": (standings, "unknown"),
    "Point terminal": (points, "free"),
    "Point machine": (machines, "at rest"),
    "Level crossing": (crossing_diagrams.devices, "open"),
    "Barriers of a level crossing": (crossing_diagrams.barriers, "raised"),
    "On-board unit: duty": (duty, "off"),
    "On-board unit: authority": (authorities, "off the line"),
    "On-board unit: level crossings": (crossing_diagrams.views, "ahead"),
}


def machine_diagram(machine: str) -> str:
    """The diagram of a machine, by the title of its part in docs/interlocking.md."""
    found, begins = DIAGRAMS[machine]
    return diagram(found(), begins)


def main() -> int:
    """Say how many states of each machine were looked at, and how fast."""
    for machine, (found, _) in DIAGRAMS.items():
        began_s = time.perf_counter()
        explored = found()
        took_s = time.perf_counter() - began_s
        states, whole = len(explored.states), "all" if explored.complete else "up to the bound"
        sys.stdout.write(
            f"{machine}: {states} states ({whole}), {explored.steps} steps; "
            f"{states / took_s:.0f} new states a second, {explored.steps / took_s:.0f} steps\n"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
