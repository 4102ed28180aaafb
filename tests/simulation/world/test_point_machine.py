"""The physical points: throws take their time, faults do what they say, the table is complete."""

from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Position
from simulation.world.point_machine import (
    TABLE,
    Forced,
    KeyBack,
    LockedByHand,
    MachineEvent,
    MachineState,
    PointMachine,
    Repaired,
    ThrowTimeOver,
    advance,
    detection,
    step,
)
from wayside.said import PointsDetected, StartThrow, StopThrow

N, R = Position.NORMAL, Position.REVERSE
AT_NORMAL = PointMachine("p", 6.0, N)
TO_REVERSE = StartThrow("p", R)
EVENTS: tuple[MachineEvent, ...] = (
    *(TO_REVERSE, StartThrow("p", N), StopThrow("p"), Forced(), Repaired(N)),
    *(LockedByHand("K1"), LockedByHand("K2"), KeyBack("K1"), KeyBack("K2")),
)


def test_a_throw_takes_its_time_and_is_detected_only_then() -> None:
    moving = step(AT_NORMAL, TO_REVERSE, 10.0)
    assert detection(moving) == PointsDetected("p", None, False)
    assert advance(moving, 15.9) == moving
    there = advance(moving, 16.0)
    assert detection(there) == PointsDetected("p", R, True)
    assert there.state is MachineState.AT_REST


def test_to_where_it_lies_locked_nothing_moves() -> None:
    assert step(AT_NORMAL, StartThrow("p", N), 0.0) == AT_NORMAL


def test_the_same_order_again_does_not_prolong_the_throw() -> None:
    moving = step(AT_NORMAL, TO_REVERSE, 0.0)
    assert step(moving, TO_REVERSE, 3.0) == moving


def test_turned_back_in_mid_throw() -> None:
    back = step(step(AT_NORMAL, TO_REVERSE, 0.0), StartThrow("p", N), 3.0)
    assert advance(back, 8.9).position is None
    assert advance(back, 9.0).position is N


def test_stopped_in_mid_throw_it_lies_between() -> None:
    between = step(step(AT_NORMAL, TO_REVERSE, 0.0), StopThrow("p"), 3.0)
    assert between.state is MachineState.BETWEEN
    assert advance(between, 100.0) == between
    assert advance(step(between, TO_REVERSE, 100.0), 106.0).position is R


def test_faults() -> None:
    stuck = replace(AT_NORMAL, stuck=True)
    assert step(stuck, TO_REVERSE, 0.0) == stuck
    unlocked = advance(step(replace(AT_NORMAL, lock_fault=True), TO_REVERSE, 0.0), 6.0)
    assert detection(unlocked) == PointsDetected("p", R, False)
    blind = replace(AT_NORMAL, detection_fault=True)
    assert detection(blind) == PointsDetected("p", None, False)
    assert blind.position is N


def test_forced_open_until_repaired() -> None:
    forced = step(AT_NORMAL, Forced(), 0.0)
    assert (forced.position, forced.locked) == (None, False)
    assert advance(step(forced, TO_REVERSE, 0.0), 60.0).position is None
    assert step(forced, Repaired(R), 0.0) == PointMachine("p", 6.0, R)


def test_the_table_is_complete() -> None:
    kinds = (StartThrow, StopThrow, ThrowTimeOver, Forced, Repaired, LockedByHand, KeyBack)
    assert set(TABLE) == set(product(MachineState, kinds))


@given(st.lists(st.tuples(st.sampled_from(EVENTS), st.floats(0.0, 10.0)), max_size=20))
def test_locked_only_in_a_position_and_motor_only_between(events: list[tuple[MachineEvent, float]]) -> None:
    machine, now_s = AT_NORMAL, 0.0
    for event, pause_s in events:
        now_s += pause_s
        machine = step(advance(machine, now_s), event, now_s)
        assert not (machine.locked and machine.position is None)
        assert (machine.target is None) == (machine.done_at_s is None)
        assert not (machine.key and machine.target is not None)


@pytest.mark.parametrize("order", [TO_REVERSE, StopThrow("p"), ThrowTimeOver(60.0)])
def test_locked_by_hand_its_motor_is_cut_out_until_the_key_is_back(order: MachineEvent) -> None:
    locked = step(AT_NORMAL, LockedByHand("K1"), 0.0)
    assert detection(locked) == PointsDetected("p", N, True, by_hand=True)
    assert step(locked, order, 0.0) == locked
    assert step(locked, KeyBack("K2"), 0.0) == locked
    assert step(locked, LockedByHand("K2"), 0.0) == locked
    assert step(locked, KeyBack("K1"), 0.0) == AT_NORMAL


@pytest.mark.parametrize("machine", [step(AT_NORMAL, TO_REVERSE, 0.0), replace(AT_NORMAL, locked=False)])
def test_a_machine_that_is_not_locked_cannot_be_locked_by_hand(machine: PointMachine) -> None:
    assert step(machine, LockedByHand("K1"), 1.0) == machine


def test_staff_set_points_free_of_which_nobody_gives_the_key_back() -> None:
    locked = step(AT_NORMAL, LockedByHand("K1"), 0.0)
    for lying in (locked, step(locked, Forced(), 0.0)):
        assert step(lying, Repaired(N), 0.0) == AT_NORMAL


@pytest.mark.parametrize("state", MachineState)
def test_refused_events_change_nothing(state: MachineState) -> None:
    machines = {
        MachineState.AT_REST: AT_NORMAL,
        MachineState.MOVING: step(AT_NORMAL, TO_REVERSE, 0.0),
        MachineState.BETWEEN: step(AT_NORMAL, Forced(), 0.0),
    }
    machine = machines[state]
    assert machine.state is state
    assert step(machine, ThrowTimeOver(0.0), 0.0) == machine
    if state is not MachineState.MOVING:
        assert step(machine, StopThrow("p"), 0.0) == machine
