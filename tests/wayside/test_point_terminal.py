"""The point terminal's rules, its refusals and its table; with the physical machine, what a proof is worth."""

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Position
from radio.keys import capability_key, capability_mac
from radio.messages import AnyMessage, PointsCommand, PointsProof, PointsRefusalReason, PointsRefused
from simulation.world import point_machine
from simulation.world.point_machine import PointMachine
from wayside.actions import Drive, Send
from wayside.config import PointsEntry, TerminalConfig
from wayside.point_terminal import (
    TABLE,
    Commanded,
    Commitment,
    Expired,
    PointsState,
    Terminal,
    TerminalEvent,
    TerminalMemory,
    start,
    step,
    wake_at_s,
)
from wayside.said import PointsDetected, StartThrow, StopThrow

N, R = Position.NORMAL, Position.REVERSE
KEY = capability_key(b"m" * 32, "t")
CONFIG = TerminalConfig(
    "line", "t", (PointsEntry("p1", "S", 8.0), PointsEntry("p2", "S", 8.0), PointsEntry("q", "Q", 8.0))
)


def command(
    token: int, position: Position = R, unit: str = "u1", points: str = "p1", section: str = "S"
) -> Commanded:
    code = capability_mac(KEY, "t", section, unit, token)
    return Commanded(unit, token, PointsCommand(points, position, section, token, code))


class Box:
    """A terminal and what it did last."""

    def __init__(self, memory: TerminalMemory | None = None, *, lying: Position | None = N) -> None:
        self.terminal: Terminal = start(CONFIG, KEY, memory or TerminalMemory())
        self.drives: list[StartThrow | StopThrow] = []
        self.now_s = 0.0
        if lying is not None:
            for entry in CONFIG.points:
                self.do(PointsDetected(entry.points_id, lying, True))

    def do(self, event: TerminalEvent) -> list[tuple[str, AnyMessage]]:
        self.terminal, actions = step(self.terminal, event, self.now_s)
        self.drives = [action.output for action in actions if isinstance(action, Drive)]
        return [(action.destination, action.message) for action in actions if isinstance(action, Send)]

    def state(self, points: str = "p1") -> PointsState:
        return self.terminal.views[points].state


def proof(token: int, position: Position | None = R, points: str = "p1") -> PointsProof:
    found = position is not None
    return PointsProof(points, position, found, found, token)


def refused(token: int, reason: PointsRefusalReason, points: str = "p1") -> PointsRefused:
    return PointsRefused(points, reason, token)


def test_throw_then_proof() -> None:
    box = Box()
    assert box.do(command(1)) == []
    assert box.drives == [StartThrow("p1", R)]
    assert box.do(PointsDetected("p1", None, False)) == []
    assert box.do(PointsDetected("p1", R, True)) == [("u1", proof(1))]
    assert wake_at_s(box.terminal) is None


def test_already_there_and_locked_is_proven_at_once() -> None:
    box = Box()
    assert box.do(command(1, N)) == [("u1", proof(1, N))]
    assert box.drives == []


def test_in_position_but_not_locked_is_thrown() -> None:
    box = Box()
    box.do(PointsDetected("p1", N, False))
    assert box.do(command(1, N)) == []
    assert box.drives == [StartThrow("p1", N)]
    assert box.do(PointsDetected("p1", N, False)) == []


def test_a_command_repeated_changes_nothing() -> None:
    box = Box()
    box.do(command(1))
    memory, deadline_s = box.terminal.memory, wake_at_s(box.terminal)
    box.now_s = 3.0
    assert box.do(command(1)) == []
    assert box.drives == []
    assert (box.terminal.memory, wake_at_s(box.terminal)) == (memory, deadline_s)
    box.do(PointsDetected("p1", R, True))
    assert box.do(command(1)) == [("u1", proof(1))]
    assert box.terminal.memory == memory


def test_locked_for_the_token_until_a_higher_one_commands() -> None:
    box = Box()
    box.do(command(1, N))
    assert box.do(command(1, R)) == [("u1", refused(1, PointsRefusalReason.LOCKED))]
    assert box.drives == []
    box.do(command(2, R, "u2"))
    assert box.drives == [StartThrow("p1", R)]


def test_an_old_token_is_refused_for_every_points_of_the_section() -> None:
    box = Box()
    box.do(command(5, N))
    assert box.do(command(4, R, points="p2")) == [("u1", refused(4, PointsRefusalReason.OLD_TOKEN, "p2"))]
    assert box.do(command(5, R, points="p2")) == []
    assert box.drives == [StartThrow("p2", R)]
    # Another section counts its own tokens.
    assert box.do(command(4, N, points="q", section="Q")) == [("u1", proof(4, N, "q"))]


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (command(1, points="x"), PointsRefusalReason.UNKNOWN_POINTS),
        (command(1, section="Q"), PointsRefusalReason.WRONG_SECTION),
        (Commanded("u2", 1, command(1).message), PointsRefusalReason.BAD_CAPABILITY),
        (
            Commanded("u1", 1, PointsCommand("p1", R, "S", 2, command(1).message.mac)),
            PointsRefusalReason.BAD_CAPABILITY,
        ),
        (Commanded("u1", 1, PointsCommand("p1", R, "S", 1, b"")), PointsRefusalReason.BAD_CAPABILITY),
    ],
)
def test_refusals(bad: Commanded, reason: PointsRefusalReason) -> None:
    box = Box()
    before = box.terminal
    assert box.do(bad) == [(bad.unit_id, refused(bad.message.token, reason, bad.message.points_id))]
    assert box.drives == []
    assert box.terminal == before


def test_a_throw_that_is_not_proven_in_time_is_stopped_and_may_be_tried_again() -> None:
    box = Box()
    box.do(command(1))
    assert wake_at_s(box.terminal) == 8.0
    box.now_s = 7.9
    assert box.do(Expired()) == []
    box.now_s = 8.0
    assert box.do(Expired()) == [("u1", refused(1, PointsRefusalReason.NOT_DETECTED))]
    assert box.drives == [StopThrow("p1")]
    assert wake_at_s(box.terminal) is None
    assert box.do(command(1)) == []
    assert box.drives == [StartThrow("p1", R)]


def test_a_proof_that_no_longer_holds_is_withdrawn_unasked() -> None:
    box = Box()
    box.do(command(1, N))
    assert box.do(PointsDetected("p1", None, False)) == [("u1", proof(1, None))]
    assert box.do(PointsDetected("p1", N, True)) == [("u1", proof(1, N))]
    assert wake_at_s(box.terminal) is None


def test_it_is_withdrawn_again_until_the_points_are_commanded_or_in_place() -> None:
    """The telegram may have been lost, and its train would run over them."""
    for ends in (command(1, N), PointsDetected("p1", N, True)):
        box = Box()
        box.do(command(1, N))
        box.do(PointsDetected("p1", None, False))
        for _ in range(3):
            again_s = wake_at_s(box.terminal)
            assert again_s == box.now_s + 5.0
            assert box.do(Expired()) == []
            box.now_s = again_s
            assert box.do(Expired()) == [("u1", proof(1, None))]
        box.do(ends)
        box.do(PointsDetected("p1", N, True))
        assert wake_at_s(box.terminal) is None


def test_after_a_restart_it_remembers_but_proves_nothing_it_does_not_see() -> None:
    box = Box()
    box.do(command(5))
    box.do(PointsDetected("p1", R, True))
    again = Box(box.terminal.memory, lying=None)
    assert again.state() is PointsState.REMEMBERED
    assert again.do(command(4, N)) == [("u1", refused(4, PointsRefusalReason.OLD_TOKEN))]
    assert again.do(command(5, N)) == [("u1", refused(5, PointsRefusalReason.LOCKED))]
    assert again.do(PointsDetected("p1", R, True)) == [("u1", proof(5))]
    assert again.drives == []


@pytest.mark.parametrize(("lies", "locked"), [(N, True), (None, False), (R, False)])
def test_what_holds_no_longer_after_a_restart_is_withdrawn(lies: Position | None, locked: bool) -> None:
    """Set by hand, forced open or unlocked while it was off: the unit that had them proven would run over them."""
    box = Box()
    box.do(command(5))
    box.do(PointsDetected("p1", R, True))
    again = Box(box.terminal.memory, lying=None)
    withdrawn = PointsProof("p1", lies, locked, lies is not None, 5)
    assert again.do(PointsDetected("p1", lies, locked)) == [("u1", withdrawn)]
    assert again.state() is PointsState.UNPROVEN


def test_who_may_rely_on_points_hears_how_they_lie_where_the_memory_was_lost() -> None:
    """At once, with each change, and every 5 s; until they are commanded, in either position, by nobody before it."""
    told = {"p1": Commitment("u1", None, 5)}
    box = Box(TerminalMemory({"S": 5}, told), lying=None)
    for lies in (R, None, N):
        shown = PointsDetected("p1", lies, lies is not None)
        assert box.do(shown) == [("u1", proof(5, lies))]
        box.now_s += 5.0
        assert box.do(Expired()) == [("u1", proof(5, lies))]
    assert box.do(command(4, R, "u2")) == [("u2", refused(4, PointsRefusalReason.OLD_TOKEN))]
    assert box.terminal.memory.commitments == told
    for position in Position:
        commanded = Box(TerminalMemory({"S": 5}, told))
        assert commanded.do(command(5, position)) == ([("u1", proof(5, N))] if position is N else [])
        assert commanded.terminal.memory.commitments == {"p1": Commitment("u1", position, 5)}
        assert commanded.do(PointsDetected("p1", None, False)) == (
            [("u1", proof(5, None))] if position is N else []
        )


def test_detection_of_points_it_does_not_have() -> None:
    box = Box()
    before = box.terminal
    assert box.do(PointsDetected("x", N, True)) == []
    assert box.terminal == before


def in_state(state: PointsState) -> Box:
    box = Box()
    if state is not PointsState.FREE:
        box.do(command(3, N if state is PointsState.PROVEN else R))
    if state is PointsState.UNPROVEN:
        box.now_s = 8.0
        box.do(Expired())
    if state is PointsState.REMEMBERED:
        box = Box(box.terminal.memory, lying=None)
    assert box.state() is state
    return box


@pytest.mark.parametrize(
    ("state", "token", "after", "throws"),
    [
        (PointsState.FREE, 3, PointsState.THROWING, True),
        (PointsState.THROWING, 3, PointsState.THROWING, False),
        (PointsState.THROWING, 4, PointsState.THROWING, True),
        (PointsState.PROVEN, 4, PointsState.THROWING, True),
        (PointsState.UNPROVEN, 3, PointsState.THROWING, True),
        (PointsState.UNPROVEN, 4, PointsState.THROWING, True),
        (PointsState.REMEMBERED, 3, PointsState.THROWING, True),
    ],
)
def test_commands_in_each_state(state: PointsState, token: int, after: PointsState, throws: bool) -> None:
    box = in_state(state)
    assert box.do(command(token)) == []
    assert box.state() is after
    assert box.drives == ([StartThrow("p1", R)] if throws else [])


@pytest.mark.parametrize(
    ("state", "shown", "after"),
    [
        (PointsState.FREE, R, PointsState.FREE),
        (PointsState.THROWING, N, PointsState.THROWING),
        (PointsState.THROWING, R, PointsState.PROVEN),
        (PointsState.PROVEN, N, PointsState.PROVEN),
        (PointsState.PROVEN, R, PointsState.UNPROVEN),
        (PointsState.UNPROVEN, N, PointsState.UNPROVEN),
        (PointsState.UNPROVEN, R, PointsState.PROVEN),
    ],
)
def test_detections_in_each_state(state: PointsState, shown: Position, after: PointsState) -> None:
    box = in_state(state)
    box.do(PointsDetected("p1", shown, True))
    assert box.state() is after
    assert box.drives == []


@pytest.mark.parametrize("state", PointsState)
@pytest.mark.parametrize("token", [3, 4])
def test_points_locked_by_hand_are_commanded_by_nobody(state: PointsState, token: int) -> None:
    box = in_state(state)
    lying = R if state is PointsState.THROWING else N
    box.do(PointsDetected("p1", lying, True, by_hand=True))
    memory = box.terminal.memory
    for position in Position:
        told = box.do(command(token, position))
        assert told == [("u1", refused(token, PointsRefusalReason.LOCKED_BY_HAND))]
        assert box.drives == []
    assert box.terminal.memory == memory
    box.do(PointsDetected("p1", lying, True))
    assert box.do(command(5, lying)) == [("u1", proof(5, lying))]


def test_the_table_is_complete() -> None:
    assert set(TABLE) == set(product(PointsState, (Commanded, PointsDetected)))


moves = st.tuples(
    st.integers(1, 4),
    st.sampled_from(Position),
    st.sampled_from(["u1", "u2"]),
    st.floats(0.0, 5.0),
    st.booleans(),
)


@given(st.lists(moves, max_size=30))
def test_a_proof_is_true_when_it_is_sent_and_tokens_never_go_back(
    given_moves: list[tuple[int, Position, str, float, bool]],
) -> None:
    box = Box()
    machine, thrown_for = PointMachine("p1", 6.0, N), 0
    for token, position, unit, pause_s, restart in given_moves:
        box.now_s += pause_s
        if restart:
            box.terminal = start(CONFIG, KEY, box.terminal.memory)
        machine = point_machine.advance(machine, box.now_s)
        for event in (point_machine.detection(machine), command(token, position, unit), Expired()):
            for _, message in box.do(event):
                if isinstance(message, PointsProof) and message.detected and message.locked:
                    assert (machine.position, machine.locked) == (message.position, True)
                    assert message.token == box.terminal.memory.tokens["S"]
            for output in box.drives:
                machine = point_machine.step(machine, output, box.now_s)
                if isinstance(output, StartThrow):
                    assert box.terminal.memory.tokens["S"] >= thrown_for
                    thrown_for = box.terminal.memory.tokens["S"]
                # The contacts show the motion at once, as wired ones do.
                box.terminal, _ = step(box.terminal, point_machine.detection(machine), box.now_s)
