"""A point terminal and its one point machine as a party of the exploration: the real step, what the machine shows at
once as it changes, the terminal's power, and the crew's key.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from msgspec.structs import replace

from network.model import Position
from radio.envelope import DropReason
from radio.messages import PointsCommand, Restarted
from verify.explored_line import (
    CAPABILITY_KEYS,
    POINTS_OF,
    TERMINALS,
    UNITS,
    ExploredLine,
    UnwishedFor,
    terminal_config,
)
from verify.happening import Happening
from verify.on_air import InAir, opened, sealed
from wayside.actions import Drive
from wayside.point_terminal import (
    Commanded,
    Expired,
    Terminal,
    TerminalEvent,
    TerminalMemory,
    start,
    step,
    wake_at_s,
)
from wayside.said import PointsDetected, StartThrow, StopThrow

LATE_S: Final = 1000.0  # later than the limit of any throw
UNKNOWN_LIE: Final = 0
LIES: Final = {Position.NORMAL: 1, Position.REVERSE: 2}


@dataclass(frozen=True, slots=True)
class PlainTerminal:
    """A terminal, told from others by its key."""

    terminal: Terminal = field(compare=False)
    key: object


class TerminalState(NamedTuple):
    """`lies`: where the blades lie and are locked; `throws`: where the motor takes them; `by_hand`: a crew has the key;
    `detects`: the contacts show what is so.
    """

    power: bool
    epoch: int
    heard: tuple[int, ...]
    kept: PlainTerminal
    lies: Position | None = Position.NORMAL
    throws: Position | None = None
    by_hand: bool = False
    detects: bool = True


class TerminalStep(NamedTuple):
    """What comes of a step: telegrams by unit."""

    state: TerminalState
    sends: tuple[tuple[int, InAir], ...] = ()


TerminalHappening = Happening[TerminalState, InAir]


def plain(terminal: Terminal) -> PlainTerminal:
    """The terminal without times."""
    views = {
        points_id: replace(view, deadline_s=None if view.deadline_s is None else 0.0)
        for points_id, view in terminal.views.items()
    }
    terminal = replace(terminal, views=views)
    memory = terminal.memory
    key = (
        tuple(sorted(memory.tokens.items())),
        tuple(sorted(memory.commitments.items())),
        memory.bars,
        tuple((p, v.state, v.detected, v.deadline_s, v.correlation) for p, v in sorted(views.items())),
    )
    return PlainTerminal(terminal, key)


class TerminalModel:
    """Steps of one terminal."""

    def __init__(self, line: ExploredLine, terminal_id: str) -> None:
        self._config: Final = terminal_config(terminal_id)
        self._points_id: Final = POINTS_OF[terminal_id]
        self._key: Final = CAPABILITY_KEYS[terminal_id]
        self.terminal_id: Final = terminal_id
        self.units: Final = UNITS[: line.trains]

    def start(self) -> TerminalState:
        """It has never been commanded, and detects where its points lie."""
        terminal = start(self._config, self._key, TerminalMemory())
        state = TerminalState(True, 1, (0,) * len(self.units), plain(terminal))
        return self._shown(state).state

    def hear(self, state: TerminalState, unit: int, telegram: InAir) -> TerminalStep:
        """A telegram comes in; one for an earlier boot is answered with that."""
        if not state.power:
            return TerminalStep(state)
        heard = opened(self.units[unit], telegram, state.epoch, state.heard[unit])
        if heard is DropReason.EARLIER_BOOT:
            return TerminalStep(state, ((unit, InAir(state.epoch, state.heard[unit], 0, Restarted())),))
        if isinstance(heard, DropReason) or not isinstance(heard.message, PointsCommand):
            return TerminalStep(state)
        boots = (*state.heard[:unit], heard.epoch, *state.heard[unit + 1 :])
        return self._took(
            state._replace(heard=boots), Commanded(heard.source, heard.correlation, heard.message), 0.0
        )

    def events(self, state: TerminalState) -> tuple[TerminalHappening, ...]:
        """All that can happen besides telegrams."""
        found = (*self._machine(state), *self._power(state))
        return tuple(e for e in found if e.state != state or e.sends)

    def locked_by_hand(self, state: TerminalState, *, locked: bool) -> TerminalStep:
        """A crew locks the machine on the spot, or gives the key back; its motor is cut out meanwhile."""
        return self._shown(state._replace(by_hand=locked))

    def _machine(self, state: TerminalState) -> Iterator[TerminalHappening]:
        if state.throws is not None and not state.by_hand:
            there = state._replace(lies=state.throws, throws=None)
            yield TerminalHappening("points come to lie and are locked", *self._shown(there))
        if state.power and wake_at_s(state.kept.terminal) is not None:
            after, sends = self._took(state, Expired(), LATE_S)
            yield TerminalHappening("a throw takes too long", after, sends, UnwishedFor.POINTS)
        changed = self._shown(state._replace(detects=not state.detects))
        if state.detects:
            yield TerminalHappening("position or lock are detected no more", *changed, UnwishedFor.POINTS)
        else:
            yield TerminalHappening("position and lock are detected again", *changed)

    def _power(self, state: TerminalState) -> Iterator[TerminalHappening]:
        memory = state.kept.terminal.memory
        off = plain(start(self._config, self._key, memory))
        quiet = state._replace(heard=(0,) * len(self.units), kept=off, throws=None)
        if state.power:
            yield TerminalHappening("power fails", quiet._replace(power=False), (), UnwishedFor.POWER)
            return
        back = self._shown(quiet._replace(power=True, epoch=state.epoch + 1))
        yield TerminalHappening("power is back", *back)

    def _shown(self, state: TerminalState) -> TerminalStep:
        """The terminal sees at once what the machine shows."""
        lies = state.lies if state.detects else None
        detected = PointsDetected(self._points_id, lies, lies is not None, state.by_hand)
        return self._took(state, detected, 0.0) if state.power else TerminalStep(state)

    def _took(self, state: TerminalState, event: TerminalEvent, now_s: float) -> TerminalStep:
        terminal, actions = step(state.kept.terminal, event, now_s)
        state = state._replace(kept=plain(terminal))
        sends = sealed(self.units, state.epoch, state.heard, actions)
        for action in actions:
            if isinstance(action, Drive) and isinstance(action.output, StartThrow | StopThrow):
                moved = self._driven(state, action.output)
                state, sends = moved.state, (*sends, *moved.sends)
        return TerminalStep(state, sends)

    def _driven(self, state: TerminalState, output: StartThrow | StopThrow) -> TerminalStep:
        if isinstance(output, StopThrow):
            return TerminalStep(state._replace(throws=None))
        if state.by_hand:
            return TerminalStep(state)
        return self._shown(state._replace(lies=None, throws=output.position))


def lie_code(state: TerminalState) -> int:
    """Where the points lie and are locked at rest, as a number."""
    return UNKNOWN_LIE if state.lies is None or state.throws is not None else LIES[state.lies]


__all__ = ["TERMINALS", "TerminalModel", "lie_code"]
