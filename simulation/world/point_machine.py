"""Invariant: `position` and `locked` are what the blades and the lock really do; only a motor that runs, a
train that forces them or a repair changes them, and a locked machine is in a position.

The electric point machine (電気転てつ機) of the simulated world: the truth, apart from the terminal's
opinion of it. The simulator owns it, gives it the terminal's outputs, returns `detection` as the terminal's
input at each change, and reads `position` to know where a train really goes. `TABLE` is state and event;
refused events change nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType
from typing import Any, Final

from network.model import Points, Position
from wayside.said import PointsDetected, StartThrow, StopThrow


class MachineState(Enum):
    """Derived state of the machine."""

    AT_REST = "at rest"  # in a position, motor off
    MOVING = "moving"  # between positions, motor on
    BETWEEN = "between"  # between positions, motor off: stopped in mid-throw or forced open


@dataclass(frozen=True, slots=True)
class PointMachine:
    """One machine. Faults: `stuck` does not move, `lock_fault` moves but does not lock, `detection_fault`
    shows nothing, `throw_factor` is how much longer a throw takes. `forced`: a train ran through it; broken.

    `target` and `done_at_s` are set while the motor runs. `key`: who has locked it by hand and has its key, so that
    the motor is cut out; empty: nobody.
    """

    points_id: str
    throw_time_s: float
    position: Position | None
    locked: bool = True
    target: Position | None = None
    done_at_s: float | None = None
    stuck: bool = False
    lock_fault: bool = False
    detection_fault: bool = False
    throw_factor: float = 1.0
    forced: bool = False
    key: str = ""

    @property
    def state(self) -> MachineState:
        """What the machine does now."""
        if self.done_at_s is not None:
            return MachineState.MOVING
        return MachineState.BETWEEN if self.position is None else MachineState.AT_REST


@dataclass(frozen=True, slots=True)
class ThrowTimeOver:
    """Event: the time has come to which the motor had to run."""

    now_s: float


@dataclass(frozen=True, slots=True)
class Forced:
    """Event: a train ran through the points from the leg they were not set for (割出し)."""


@dataclass(frozen=True, slots=True)
class Repaired:
    """Event: staff set the machine by hand into a position, locked it and removed its faults."""

    position: Position


@dataclass(frozen=True, slots=True)
class LockedByHand:
    """Event: a crew locks the machine on the spot for its passage, and takes the key (鎖錠)."""

    by: str


@dataclass(frozen=True, slots=True)
class KeyBack:
    """Event: who has the key gives it back."""

    by: str


MachineEvent = StartThrow | StopThrow | ThrowTimeOver | Forced | Repaired | LockedByHand | KeyBack


def machine_of(points: Points) -> PointMachine:
    """The machine of the line's points, in its initial position and locked."""
    return PointMachine(points.id, points.throw_time_s, points.initial)


def step(machine: PointMachine, event: MachineEvent, now_s: float) -> PointMachine:
    """The machine after the event at `now_s`."""
    return TABLE[machine.state, type(event)](machine, event, now_s)


def advance(machine: PointMachine, now_s: float) -> PointMachine:
    """The machine at `now_s`; call it at every step or at `done_at_s`."""
    return step(machine, ThrowTimeOver(now_s), now_s) if machine.done_at_s is not None else machine


def detection(machine: PointMachine) -> PointsDetected:
    """What the detection contacts show the terminal."""
    if machine.detection_fault or machine.state is not MachineState.AT_REST:
        return PointsDetected(machine.points_id, None, False, bool(machine.key))
    return PointsDetected(machine.points_id, machine.position, machine.locked, bool(machine.key))


def _start(machine: PointMachine, event: StartThrow, now_s: float) -> PointMachine:
    """The motor runs; nothing happens if it is there and locked, on its way, stuck, or locked by hand."""
    if machine.key:
        return machine
    settled = machine.position is event.position and machine.locked
    if settled or machine.stuck or machine.forced or machine.target is event.position:
        return machine
    # A motor already there has only the lock left to do, but its cycle takes the same time.
    done_at_s = now_s + machine.throw_time_s * machine.throw_factor
    return replace(machine, position=None, locked=False, target=event.position, done_at_s=done_at_s)


def _stop(machine: PointMachine, _event: StopThrow, _now_s: float) -> PointMachine:
    """The motor stops between positions."""
    return replace(machine, target=None, done_at_s=None)


def _arrive(machine: PointMachine, event: ThrowTimeOver, _now_s: float) -> PointMachine:
    """At its time it is in the position and locked, unless it is stuck or its lock has failed."""
    if machine.stuck or machine.done_at_s is None or event.now_s < machine.done_at_s - 1e-9:
        return machine
    locked = not machine.lock_fault
    return replace(machine, position=machine.target, locked=locked, target=None, done_at_s=None)


def _force(machine: PointMachine, _event: Forced, _now_s: float) -> PointMachine:
    """Broken: between positions and unlocked until it is repaired."""
    return replace(machine, position=None, locked=False, target=None, done_at_s=None, forced=True)


def _lock_by_hand(machine: PointMachine, event: LockedByHand, _now_s: float) -> PointMachine:
    """The motor is cut out and the key taken; not where another has it, nor while the machine is not locked."""
    return replace(machine, key=event.by) if machine.locked and not machine.key else machine


def _take_key_back(machine: PointMachine, event: KeyBack, _now_s: float) -> PointMachine:
    """The motor may run again; it stays in its position, locked."""
    return replace(machine, key="") if machine.key == event.by else machine


def _repair(machine: PointMachine, event: Repaired, _now_s: float) -> PointMachine:
    """In the position set by hand, locked, without faults; nobody has the key any more."""
    return PointMachine(machine.points_id, machine.throw_time_s, event.position)


def _ignore(machine: PointMachine, _event: MachineEvent, _now_s: float) -> PointMachine:
    """Nothing happens."""
    return machine


TABLE: Final[Mapping[tuple[MachineState, type], Callable[[PointMachine, Any, float], PointMachine]]] = (
    MappingProxyType(
        {
            (MachineState.AT_REST, StartThrow): _start,
            (MachineState.AT_REST, StopThrow): _ignore,
            (MachineState.AT_REST, ThrowTimeOver): _ignore,
            (MachineState.AT_REST, Forced): _force,
            (MachineState.AT_REST, Repaired): _repair,
            (MachineState.AT_REST, LockedByHand): _lock_by_hand,
            (MachineState.AT_REST, KeyBack): _take_key_back,
            (MachineState.MOVING, StartThrow): _start,
            (MachineState.MOVING, StopThrow): _stop,
            (MachineState.MOVING, ThrowTimeOver): _arrive,
            (MachineState.MOVING, Forced): _force,
            (MachineState.MOVING, Repaired): _repair,
            (MachineState.MOVING, LockedByHand): _ignore,
            (MachineState.MOVING, KeyBack): _ignore,
            (MachineState.BETWEEN, StartThrow): _start,
            (MachineState.BETWEEN, StopThrow): _ignore,
            (MachineState.BETWEEN, ThrowTimeOver): _ignore,
            (MachineState.BETWEEN, Forced): _force,
            (MachineState.BETWEEN, Repaired): _repair,
            (MachineState.BETWEEN, LockedByHand): _ignore,
            (MachineState.BETWEEN, KeyBack): _take_key_back,
        }
    )
)
