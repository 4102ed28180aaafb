"""Invariant: points are thrown only for a unit that the block manager granted their section, under the
highest token seen for that section, and then stay locked for that token; a proof is sent only while
position and lock are detected.

The point terminal (制御端末装置) of Sugiyama et al. 2017, sections 2.1 (3) and 4.4 (1), as a pure machine:
`step(terminal, event) -> (terminal, actions)`. The terminal never talks to the manager (table 2): the grant
is checked offline by the capability's code. Highest tokens and what the points are locked for are its
durable memory; after a restart it knows them, but proves nothing until the detection shows it. Where they were
lost, whoever may rely on the points is told how they lie until they are commanded. Repeated
commands change nothing; points that a crew has locked by hand are commanded by nobody (4.4 (3)).
`TABLE` is the state of the points and the kind of event.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Final

import msgspec
from msgspec.structs import replace

from network.model import Position
from radio.keys import capability_mac, mac_equal
from radio.messages import AnyMessage, PointsCommand, PointsProof, PointsRefusalReason, PointsRefused
from wayside import barring
from wayside.actions import Action, Drive, Send, Show
from wayside.barring import NO_BARS, Bars
from wayside.config import PointsEntry, TerminalConfig
from wayside.said import (
    Barred,
    BarUnit,
    PointsCommanded,
    PointsDetected,
    PointsProven,
    PointsUnproven,
    StartThrow,
    StopThrow,
    ThrowRefused,
    Unbarred,
    UnbarUnit,
)

_TIME_TOLERANCE_S: Final = 1e-9
WITHDRAWN_AGAIN_S: Final = 5.0  # assumed: as often as the block manager asks; the telegram may have been lost


class PointsState(Enum):
    """What the terminal knows of one set of points."""

    FREE = "free"  # never commanded
    THROWING = "throwing"
    PROVEN = "proven"  # in the position commanded and locked, as detected
    UNPROVEN = "unproven"  # commanded, but not (or no longer) detected
    REMEMBERED = "remembered"  # commanded before a restart, and not looked at since


class Commitment(msgspec.Struct, frozen=True, array_like=True):
    """What the points are locked for. `position` None: the memory was lost, and people know who had their section, but
    not which way they were proven to it.
    """

    unit_id: str
    position: Position | None
    token: int


class TerminalMemory(msgspec.Struct, frozen=True):
    """Durable state: highest token by section, commitment by points, barred units. Kept before anything is thrown."""

    tokens: dict[str, int] = {}
    commitments: dict[str, Commitment] = {}
    bars: Bars = NO_BARS


class PointsView(msgspec.Struct, frozen=True):
    """One set of points as the terminal sees it; `correlation` is that of the command being carried out. `deadline_s`:
    when a throw has failed, or a proof that was withdrawn is withdrawn again.
    """

    entry: PointsEntry
    state: PointsState
    detected: PointsDetected
    deadline_s: float | None = None
    correlation: int = 0


class Terminal(msgspec.Struct, frozen=True):
    """State of a terminal. `key` is shared with the block manager only."""

    terminal_id: str
    key: bytes
    memory: TerminalMemory
    views: Mapping[str, PointsView] = msgspec.field(default_factory=dict[str, PointsView])


@dataclass(frozen=True, slots=True)
class Commanded:
    """Event: a command passed the envelope's checks."""

    unit_id: str
    correlation: int
    message: PointsCommand


@dataclass(frozen=True, slots=True)
class Expired:
    """Event: look at the time limits of throws, and at what was withdrawn."""


TerminalEvent = Commanded | PointsDetected | BarUnit | UnbarUnit | Expired
TerminalStep = tuple[Terminal, tuple[Action, ...]]


def start(config: TerminalConfig, key: bytes, memory: TerminalMemory) -> Terminal:
    """A terminal after a (re)start: it remembers for whom the points are locked and has detected nothing
    yet.
    """
    views = {
        entry.points_id: PointsView(
            entry,
            PointsState.REMEMBERED if entry.points_id in memory.commitments else PointsState.FREE,
            PointsDetected(entry.points_id, None, False),
        )
        for entry in config.points
    }
    return Terminal(config.device_id, key, memory, views)


def step(terminal: Terminal, event: TerminalEvent, now_s: float) -> TerminalStep:
    """The next state and what to do. Never raises for what a unit sends."""
    if isinstance(event, Expired):
        return _expire(terminal, now_s)
    if isinstance(event, BarUnit | UnbarUnit):
        return _bar(terminal, event)
    if isinstance(event, PointsDetected):
        if event.points_id not in terminal.views:
            return terminal, ()
        return _dispatch(terminal, event.points_id, event, now_s)
    if (reason := refusal(terminal, event.unit_id, event.message)) is not None:
        return terminal, _refuse(event, reason)
    return _dispatch(terminal, event.message.points_id, event, now_s)


def _bar(terminal: Terminal, event: BarUnit | UnbarUnit) -> TerminalStep:
    """Its commands are refused, or taken again, once a second person says the same; what is locked stays locked."""
    before, bar = terminal.memory.bars, isinstance(event, BarUnit)
    bars = barring.bars_after_word(before, event.unit_id, event.person, bar=bar)
    terminal = replace(terminal, memory=replace(terminal.memory, bars=bars))
    if bars.barred == before.barred:
        return terminal, ()
    note = Barred if bar else Unbarred
    return terminal, (Show(note(unit_id=event.unit_id, by=event.person)),)


def wake_at_s(terminal: Terminal) -> float | None:
    """When the first running throw reaches its limit, or a proof is withdrawn again."""
    return min(
        (view.deadline_s for view in terminal.views.values() if view.deadline_s is not None), default=None
    )


def refusal(terminal: Terminal, unit_id: str, command: PointsCommand) -> PointsRefusalReason | None:
    """Why a command must not be carried out, or None."""
    if unit_id in terminal.memory.bars.barred:
        return PointsRefusalReason.BARRED
    view = terminal.views.get(command.points_id)
    if view is None:
        return PointsRefusalReason.UNKNOWN_POINTS
    section_id = view.entry.section_id
    if command.section_id != section_id:
        return PointsRefusalReason.WRONG_SECTION
    expected = capability_mac(terminal.key, terminal.terminal_id, section_id, unit_id, command.token)
    if not mac_equal(expected, command.mac):
        return PointsRefusalReason.BAD_CAPABILITY
    if command.token < terminal.memory.tokens.get(section_id, 0):
        return PointsRefusalReason.OLD_TOKEN
    return _locked_against(terminal, view, command)


def _locked_against(
    terminal: Terminal, view: PointsView, command: PointsCommand
) -> PointsRefusalReason | None:
    """Why the lock of the points stands against a command: a crew has their key, or the same token did."""
    if view.detected.by_hand:
        return PointsRefusalReason.LOCKED_BY_HAND
    held = terminal.memory.commitments.get(command.points_id)
    if held is not None and held.token == command.token and held.position not in (None, command.position):
        return PointsRefusalReason.LOCKED
    return None


def _dispatch(
    terminal: Terminal, points_id: str, event: Commanded | PointsDetected, now_s: float
) -> TerminalStep:
    return TABLE[terminal.views[points_id].state, type(event)](terminal, event, now_s)


def _command(terminal: Terminal, event: Commanded, now_s: float) -> TerminalStep:
    """A command that is new, or repeated while the points are not proven: commit, then throw if needed."""
    command = event.message
    view = terminal.views[command.points_id]
    commitment = Commitment(event.unit_id, command.position, command.token)
    memory = terminal.memory
    if memory.commitments.get(command.points_id) != commitment:
        memory = TerminalMemory(
            {**memory.tokens, view.entry.section_id: command.token},
            {**memory.commitments, command.points_id: commitment},
            memory.bars,
        )
    note = PointsCommanded(
        unit_id=event.unit_id,
        section_id=command.section_id,
        token=command.token,
        points_id=command.points_id,
        position=command.position,
    )
    terminal = replace(terminal, memory=memory)
    proven = _proven(terminal, replace(view, correlation=event.correlation))
    if proven is not None:
        return proven[0], (Show(note), *proven[1])
    deadline_s = now_s + view.entry.throw_limit_s
    throwing = replace(view, state=PointsState.THROWING, deadline_s=deadline_s, correlation=event.correlation)
    drive = Drive(StartThrow(command.points_id, command.position))
    return _with(terminal, throwing), (Show(note), drive)


def _command_while_throwing(terminal: Terminal, event: Commanded, now_s: float) -> TerminalStep:
    """The same command again: no proof yet, the throw runs on. One with a higher token: throw for that."""
    points_id = event.message.points_id
    if terminal.memory.commitments[points_id].token < event.message.token:
        return _command(terminal, event, now_s)
    return _with(terminal, replace(terminal.views[points_id], correlation=event.correlation)), ()


def _command_while_proven(terminal: Terminal, event: Commanded, now_s: float) -> TerminalStep:
    """The same command again: the same proof. One with a higher token: lock for that, throw if needed."""
    points_id = event.message.points_id
    commitment = terminal.memory.commitments[points_id]
    if commitment.token < event.message.token:
        return _command(terminal, event, now_s)
    view = replace(terminal.views[points_id], correlation=event.correlation)
    return _with(terminal, view), (_proof(view, commitment),)


def _command_while_unproven(terminal: Terminal, event: Commanded, now_s: float) -> TerminalStep:
    """Repeated as it was when it was proven, it may have been sent before the withdrawal was heard, and the proof be
    believed yet: withdrawn again, and nothing is thrown. Else throw.
    """
    command = event.message
    view, commitment = terminal.views[command.points_id], terminal.memory.commitments[command.points_id]
    repeated = (command.token, event.correlation) == (commitment.token, view.correlation)
    if view.deadline_s is not None and repeated:
        return terminal, (_proof(view, commitment),)
    return _command(terminal, event, now_s)


def _detect(terminal: Terminal, event: PointsDetected, _now_s: float) -> TerminalStep:
    """Remembered; no telegram is sent."""
    return _with(terminal, replace(terminal.views[event.points_id], detected=event)), ()


def _detect_committed(terminal: Terminal, event: PointsDetected, _now_s: float) -> TerminalStep:
    """In place: the proof goes to the unit that commanded. Who may rely on either position is told how they lie."""
    view = replace(terminal.views[event.points_id], detected=event)
    commitment = terminal.memory.commitments[event.points_id]
    if (proven := _proven(terminal, view)) is not None:
        return proven
    return _with(terminal, view), (_proof(view, commitment),) if commitment.position is None else ()


def _proven(terminal: Terminal, view: PointsView) -> TerminalStep | None:
    """Proven to the unit that commanded, if they are as it did, and locked."""
    commitment = terminal.memory.commitments[view.entry.points_id]
    position = commitment.position
    if position is None or not _shows(view.detected, position):
        return None
    view = replace(view, state=PointsState.PROVEN, deadline_s=None)
    note = PointsProven(
        unit_id=commitment.unit_id,
        section_id=view.entry.section_id,
        token=commitment.token,
        points_id=view.entry.points_id,
        position=position,
    )
    return _with(terminal, view), (Show(note), _proof(view, commitment))


def _detect_proven(terminal: Terminal, event: PointsDetected, now_s: float) -> TerminalStep:
    """A proof that no longer holds is withdrawn at once, unasked, and again until they are commanded or lie so."""
    view = replace(terminal.views[event.points_id], detected=event)
    commitment = terminal.memory.commitments[event.points_id]
    if _shows(event, commitment.position):
        return _with(terminal, view), ()
    view = replace(view, state=PointsState.UNPROVEN, deadline_s=now_s + WITHDRAWN_AGAIN_S)
    return _with(terminal, view), (_unproven_note(commitment, view, "lost"), _proof(view, commitment))


def _detect_remembered(terminal: Terminal, event: PointsDetected, now_s: float) -> TerminalStep:
    """In place: the proof goes to the unit that commanded. Else what it may have been shown before the restart is
    withdrawn.
    """
    in_place = _shows(event, terminal.memory.commitments[event.points_id].position)
    return (_detect_committed if in_place else _detect_proven)(terminal, event, now_s)


def _expire(terminal: Terminal, now_s: float) -> TerminalStep:
    actions: list[Action] = []
    for points_id, view in terminal.views.items():
        if view.deadline_s is None or now_s < view.deadline_s - _TIME_TOLERANCE_S:
            continue
        commitment = terminal.memory.commitments[points_id]
        if view.state is PointsState.UNPROVEN:
            terminal = _with(terminal, replace(view, deadline_s=now_s + WITHDRAWN_AGAIN_S))
            actions.append(_proof(view, commitment))
            continue
        terminal = _with(terminal, replace(view, state=PointsState.UNPROVEN, deadline_s=None))
        refused = PointsRefused(points_id, PointsRefusalReason.NOT_DETECTED, commitment.token)
        actions += (
            Drive(StopThrow(points_id)),
            _unproven_note(commitment, view, "not detected in time"),
            Send(commitment.unit_id, refused, view.correlation),
        )
    return terminal, tuple(actions)


def _refuse(event: Commanded, reason: PointsRefusalReason) -> tuple[Action, ...]:
    command = event.message
    note = ThrowRefused(
        unit_id=event.unit_id,
        section_id=command.section_id,
        token=command.token,
        points_id=command.points_id,
        why=reason.name,
    )
    refused: AnyMessage = PointsRefused(command.points_id, reason, command.token)
    return Show(note), Send(event.unit_id, refused, event.correlation)


def _shows(detected: PointsDetected, position: Position | None) -> bool:
    return position is not None and detected.position is position and detected.locked


def _proof(view: PointsView, commitment: Commitment) -> Send:
    detected = view.detected
    proof = PointsProof(
        view.entry.points_id,
        detected.position,
        detected.locked,
        detected.position is not None,
        commitment.token,
    )
    return Send(commitment.unit_id, proof, view.correlation)


def _unproven_note(commitment: Commitment, view: PointsView, why: str) -> Show:
    return Show(
        PointsUnproven(
            unit_id=commitment.unit_id,
            section_id=view.entry.section_id,
            token=commitment.token,
            points_id=view.entry.points_id,
            why=why,
        )
    )


def _with(terminal: Terminal, view: PointsView) -> Terminal:
    return replace(terminal, views={**terminal.views, view.entry.points_id: view})


TABLE: Final[Mapping[tuple[PointsState, type], Callable[[Terminal, Any, float], TerminalStep]]] = (
    MappingProxyType(
        {
            (PointsState.FREE, Commanded): _command,
            (PointsState.FREE, PointsDetected): _detect,
            (PointsState.THROWING, Commanded): _command_while_throwing,
            (PointsState.THROWING, PointsDetected): _detect_committed,
            (PointsState.PROVEN, Commanded): _command_while_proven,
            (PointsState.PROVEN, PointsDetected): _detect_proven,
            (PointsState.UNPROVEN, Commanded): _command_while_unproven,
            (PointsState.UNPROVEN, PointsDetected): _detect_committed,
            (PointsState.REMEMBERED, Commanded): _command,
            (PointsState.REMEMBERED, PointsDetected): _detect_remembered,
        }
    )
)
