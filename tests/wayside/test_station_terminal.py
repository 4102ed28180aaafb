"""One terminal with three machines, as a station of three tracks has: what happens to one does not touch the others.

West end: p1 and p2 in section W, east end: q in section X.
"""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from network.model import Position
from radio.keys import capability_key, capability_mac
from radio.messages import AnyMessage, PointsCommand, PointsProof, PointsRefusalReason, PointsRefused
from simulation.world import point_machine
from simulation.world.point_machine import PointMachine, Repaired
from wayside.actions import Action, Drive, Send
from wayside.config import PointsEntry, TerminalConfig
from wayside.point_terminal import (
    Commanded,
    Expired,
    PointsState,
    Terminal,
    TerminalEvent,
    TerminalMemory,
    start,
    step,
    wake_at_s,
)

N, R = Position.NORMAL, Position.REVERSE
KEY = capability_key(b"m" * 32, "t")
SECTION = {"p1": "W", "p2": "W", "q": "X"}
THROW_S = 6.0
CONFIG = TerminalConfig(
    "line", "t", tuple(PointsEntry(points, section, 10.0) for points, section in SECTION.items())
)


class Station:
    """The terminal wired to its machines: contacts show every motion at once."""

    def __init__(self) -> None:
        self.terminal: Terminal = start(CONFIG, KEY, TerminalMemory())
        self.machines = {points: PointMachine(points, THROW_S, N) for points in SECTION}
        self.said: list[AnyMessage] = []
        self.now_s = 0.0
        self.show_all()

    def do(self, event: TerminalEvent) -> None:
        self.terminal, actions = step(self.terminal, event, self.now_s)
        self.carry_out(actions)

    def carry_out(self, actions: Sequence[Action]) -> None:
        self.said += [action.message for action in actions if isinstance(action, Send)]
        for action in actions:
            if isinstance(action, Drive):
                points = action.output.points_id
                self.set(point_machine.step(self.machines[points], action.output, self.now_s))

    def set(self, machine: PointMachine) -> None:
        self.machines[machine.points_id] = machine
        self.do(point_machine.detection(machine))

    def show_all(self) -> None:
        for machine in self.machines.values():
            self.do(point_machine.detection(machine))

    def wait(self, pause_s: float) -> None:
        self.now_s += pause_s
        for points in SECTION:
            self.set(point_machine.advance(self.machines[points], self.now_s))
        self.do(Expired())

    def command(
        self,
        points: str,
        position: Position,
        token: int,
        unit: str = "u1",
        section: str | None = None,
        anew: int = 0,
    ) -> list[AnyMessage]:
        """What is said to a command; `anew`: how often it has been given anew, since a proof was withdrawn."""
        granted = section or SECTION[points]
        code = capability_mac(KEY, "t", granted, unit, token)
        self.said = []
        self.do(Commanded(unit, 10 * token + anew, PointsCommand(points, position, granted, token, code)))
        return self.said

    def states(self) -> dict[str, PointsState]:
        return {points: view.state for points, view in self.terminal.views.items()}

    def lies(self) -> dict[str, tuple[Position | None, bool]]:
        return {points: (machine.position, machine.locked) for points, machine in self.machines.items()}


def proof(points: str, position: Position | None, token: int) -> PointsProof:
    found = position is not None
    return PointsProof(points, position, found, found, token)


def three_thrown() -> Station:
    """Two trains have their ends of the station thrown at the same time."""
    station = Station()
    station.command("p1", R, 1)
    station.command("p2", R, 1)
    station.command("q", R, 2, "u2")
    return station


def test_three_machines_throw_at_the_same_time_and_each_is_proven_by_itself() -> None:
    station = three_thrown()
    assert set(station.states().values()) == {PointsState.THROWING}
    assert set(station.lies().values()) == {(None, False)}
    station.said = []
    station.wait(THROW_S)
    assert station.said == [proof("p1", R, 1), proof("p2", R, 1), proof("q", R, 2)]
    assert set(station.lies().values()) == {(R, True)}
    assert wake_at_s(station.terminal) is None


@pytest.mark.parametrize("stuck", SECTION)
def test_one_is_stuck_the_others_are_proven(stuck: str) -> None:
    station = Station()
    station.machines[stuck] = replace(station.machines[stuck], stuck=True)
    for points in SECTION:
        station.command(points, R, 1)
    station.wait(THROW_S)
    expected = dict.fromkeys(SECTION, PointsState.PROVEN) | {stuck: PointsState.THROWING}
    assert station.states() == expected
    station.said = []
    station.wait(10.0 - THROW_S)
    assert station.said == [PointsRefused(stuck, PointsRefusalReason.NOT_DETECTED, 1)]
    assert station.states() == expected | {stuck: PointsState.UNPROVEN}
    assert station.lies()[stuck] == (N, True)


@pytest.mark.parametrize("lost", SECTION)
def test_one_loses_its_detection_only_its_proof_is_withdrawn(lost: str) -> None:
    station = three_thrown()
    station.wait(THROW_S)
    token = station.terminal.memory.tokens[SECTION[lost]]
    station.said = []
    station.set(replace(station.machines[lost], detection_fault=True))
    assert station.said == [proof(lost, None, token)]
    assert station.states() == dict.fromkeys(SECTION, PointsState.PROVEN) | {lost: PointsState.UNPROVEN}
    # The unit may believe the proof: its command of before throws nothing. Given anew it throws once more, and proves
    # nothing that is not seen.
    unit = station.terminal.memory.commitments[lost].unit_id
    assert station.command(lost, R, token, unit) == [proof(lost, None, token)]
    assert station.states()[lost] is PointsState.UNPROVEN
    assert station.command(lost, R, token, unit, anew=1) == []
    station.wait(10.0)
    assert station.said == [PointsRefused(lost, PointsRefusalReason.NOT_DETECTED, token)]


@pytest.mark.parametrize("cranked", SECTION)
def test_cranked_by_hand_into_place_it_is_proven_again_and_no_other_moves(cranked: str) -> None:
    station = Station()
    station.machines[cranked] = replace(station.machines[cranked], stuck=True)
    for points in SECTION:
        station.command(points, R, 1)
    station.wait(10.0)
    others = {points: lies for points, lies in station.lies().items() if points != cranked}
    station.said = []
    station.set(point_machine.step(station.machines[cranked], Repaired(R), station.now_s))
    assert station.said == [proof(cranked, R, 1)]
    assert set(station.states().values()) == {PointsState.PROVEN}
    assert others.items() <= station.lies().items()


def test_cranked_into_the_wrong_place_it_stays_unproven_until_thrown() -> None:
    station = Station()
    station.machines["q"] = replace(station.machines["q"], stuck=True)
    station.command("q", R, 1)
    station.wait(10.0)
    station.set(point_machine.step(station.machines["q"], Repaired(N), station.now_s))
    assert station.states()["q"] is PointsState.UNPROVEN
    station.command("q", R, 1)
    station.wait(THROW_S)
    assert station.said == [proof("q", R, 1)]


@pytest.mark.parametrize(("points", "other"), [("p1", "X"), ("p2", "X"), ("q", "W")])
def test_a_token_for_one_section_throws_no_points_of_another(points: str, other: str) -> None:
    station = Station()
    before = station.lies()
    # Named as it was granted the points are not in it; named as the points' own, its code does not fit.
    answer = station.command(points, R, 9, section=other)
    assert answer == [PointsRefused(points, PointsRefusalReason.WRONG_SECTION, 9)]
    code = capability_mac(KEY, "t", other, "u1", 9)
    station.said = []
    station.do(Commanded("u1", 9, PointsCommand(points, R, SECTION[points], 9, code)))
    assert station.said == [PointsRefused(points, PointsRefusalReason.BAD_CAPABILITY, 9)]
    assert station.lies() == before
    assert station.terminal.memory == TerminalMemory()


def test_a_newer_token_in_one_section_leaves_the_other_locked_for_its_own() -> None:
    station = three_thrown()
    station.wait(THROW_S)
    station.command("p1", N, 5, "u3")
    assert station.terminal.memory.tokens == {"W": 5, "X": 2}
    assert station.machines["q"].target is None
    # The old holder of W is refused at both of its points, the holder of X is not.
    old = [PointsRefused("p2", PointsRefusalReason.OLD_TOKEN, 1)]
    assert station.command("p2", N, 1) == old
    assert station.command("q", R, 2, "u2") == [proof("q", R, 2)]


def test_after_a_restart_each_is_proven_as_its_contacts_show() -> None:
    station = three_thrown()
    station.wait(THROW_S)
    station.machines["p2"] = replace(station.machines["p2"], detection_fault=True)
    station.terminal = start(CONFIG, KEY, station.terminal.memory)
    station.said = []
    station.show_all()
    withdrawn = PointsProof("p2", None, False, False, 1)
    assert station.said == [proof("p1", R, 1), withdrawn, proof("q", R, 2)]
    assert station.states()["p2"] is PointsState.UNPROVEN
