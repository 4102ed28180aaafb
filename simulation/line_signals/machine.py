"""Invariant: of two signals that let trains into one section from its ends, at most one is clear.

The interlocking of a line with line signals, as a pure machine: levers that people and approaching trains pull, the
direction of each section, trains counted in and out at its ends (特殊自動閉そく: nothing sees them in between), detectors
of wrong departures, and the substitute aspect, which the machine does not check. What passes a signal at stop is not
counted in: that is the business of the detector, if there is one and it works.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Final

from network.model import Direction
from simulation.line_signals_settings import DirectionLever, LineSignal, LineSignals


class Aspect(StrEnum):
    """What a driver sees."""

    STOP = "stop"
    CLEAR = "clear"
    SUBSTITUTE = "substitute"


@dataclass(frozen=True, slots=True)
class Pulled:
    """A signal's lever is pulled, by people or by a train that comes near."""

    signal_id: str


@dataclass(frozen=True, slots=True)
class PutBack:
    """A signal's lever is put back."""

    signal_id: str


@dataclass(frozen=True, slots=True)
class LeverPulled:
    """A direction lever is pulled, or released."""

    lever_id: str
    released: bool = False


@dataclass(frozen=True, slots=True)
class SubstituteGiven:
    """Somebody gives the substitute aspect."""

    signal_id: str


@dataclass(frozen=True, slots=True)
class Passed:
    """A train's front passes a signal."""

    signal_id: str
    unit_id: str


@dataclass(frozen=True, slots=True)
class CountedOut:
    """A train's rear has left a section."""

    block: str
    unit_id: str


MachineInput = Pulled | PutBack | LeverPulled | SubstituteGiven | Passed | CountedOut


@dataclass(frozen=True, slots=True)
class SignalsState:
    """All that the machine knows. `wanted` in the order in which levers were pulled; `counted`: by signal, the trains that
    passed it last; `directions`: of sections that are in use.
    """

    wanted: tuple[str, ...] = ()
    levers: frozenset[str] = frozenset()
    directions: Mapping[str, Direction] = field(default_factory=dict[str, Direction])
    counted: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    held: frozenset[str] = frozenset()
    substitutes: frozenset[str] = frozenset()


class SignalMachine:
    """What the machine of a line does: pure functions of its state."""

    def __init__(self, settings: LineSignals) -> None:
        self.signals: Final[Mapping[str, LineSignal]] = {signal.id: signal for signal in settings.signal}
        self._levers: Final[Mapping[str, DirectionLever]] = {lever.id: lever for lever in settings.lever}
        self._detectors: Final = settings.detector

    def aspect(self, state: SignalsState, signal_id: str) -> Aspect:
        """What a signal shows."""
        signal = self.signals[signal_id]
        if signal_id in state.substitutes:
            return Aspect.SUBSTITUTE
        clear = (
            signal_id in state.wanted
            and state.directions.get(signal.block) is signal.direction
            and self._may(state, signal)
        )
        return Aspect.CLEAR if clear else Aspect.STOP

    def after(self, state: SignalsState, event: MachineInput) -> SignalsState:
        """The state after an event."""
        match event:
            case Pulled(signal_id) if signal_id not in state.wanted:
                state = replace(state, wanted=(*state.wanted, signal_id))
            case PutBack(signal_id):
                state = replace(state, wanted=tuple(s for s in state.wanted if s != signal_id))
            case LeverPulled(lever_id, released):
                levers = state.levers - {lever_id} if released else state.levers | {lever_id}
                state = replace(state, levers=levers)
            case SubstituteGiven(signal_id):
                state = replace(state, substitutes=state.substitutes | {signal_id})
            case Passed(signal_id, unit_id):
                state = self._passed(state, signal_id, unit_id)
            case CountedOut(block, unit_id):
                state = replace(state, counted=self._without(state, block, unit_id))
            case _:
                pass
        return replace(state, directions=self._directions(state))

    def holds_at(self, signal_id: str) -> tuple[tuple[str, ...], bool]:
        """What the detector of a signal puts to stop, and whether it works; nothing where there is none."""
        found = next((d for d in self._detectors if d.signal == signal_id), None)
        return ((), False) if found is None else (found.holds, found.works)

    def _passed(self, state: SignalsState, signal_id: str, unit_id: str) -> SignalsState:
        if self.aspect(state, signal_id) is Aspect.STOP:
            holds, works = self.holds_at(signal_id)
            return replace(state, held=state.held | frozenset(holds)) if works else state
        counted = self._without(state, self.signals[signal_id].block, unit_id)
        counted[signal_id] = (*counted.get(signal_id, ()), unit_id)
        return replace(
            state,
            counted=counted,
            wanted=tuple(s for s in state.wanted if s != signal_id),
            substitutes=state.substitutes - {signal_id},
        )

    def _without(self, state: SignalsState, block: str, unit_id: str) -> dict[str, tuple[str, ...]]:
        return {
            signal_id: tuple(u for u in units if u != unit_id or self.signals[signal_id].block != block)
            for signal_id, units in state.counted.items()
        }

    def _may(self, state: SignalsState, signal: LineSignal) -> bool:
        """Whether nothing but the section's direction keeps a signal at stop."""
        levers = [self._levers[lever_id] for lever_id in state.levers]
        against = any(signal.block in v.blocks and v.direction is not signal.direction for v in levers)
        return not (against or signal.id in state.held or state.counted.get(signal.id))

    def _directions(self, state: SignalsState) -> dict[str, Direction]:
        """Of each section: kept while a train is counted in or a lever of that direction is pulled, else of the first pulled."""
        found: dict[str, Direction] = {}
        for block in dict.fromkeys(signal.block for signal in self.signals.values()):
            mine = [signal for signal in self.signals.values() if signal.block == block]
            before = state.directions.get(block)
            used = [s.direction for s in mine if state.counted.get(s.id)]
            used += [s.direction for s in mine if s.id in state.wanted and s.direction is before]
            wanted = [self.signals[signal_id] for signal_id in state.wanted]
            first = next((s.direction for s in wanted if s.block == block and self._may(state, s)), None)
            direction = before if before in used else (used[0] if used else first)
            if direction is not None:
                found[block] = direction
        return found
