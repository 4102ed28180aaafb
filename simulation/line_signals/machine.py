"""Invariant: of two signals that let trains into one section from its ends, at most one is clear.

The interlocking of a line with line signals, as a pure machine: levers that people and approaching trains pull, the
direction of each section, trains counted in and out at its ends (特殊自動閉そく: nothing sees them in between),
detectors of wrong departures, and the substitute aspect, which the machine does not check. What passes a signal at stop
is not counted in: that is the business of the detector, if there is one and it works.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, StrEnum
from typing import Final

from network.model import Direction
from simulation.line_signals_settings import DepartureDetector, LineSignal, LineSignals, SignalDeed


class Aspect(StrEnum):
    """What a driver sees."""

    STOP = "stop"
    CLEAR = "clear"
    SUBSTITUTE = "substitute"


class Contact(Enum):
    """What the machine hears of trains."""

    PASSED = "passed"  # the front of a train passes a signal
    COUNTED_OUT = "counted out"  # the rear of a train has left a section


@dataclass(frozen=True, slots=True)
class SignalsState:
    """All that the machine knows. `wanted` in the order in which levers were pulled; `counted`: by signal, the trains
    that passed it last; `directions`: of sections that are in use.
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
        self._levers: Final = settings.lever
        self._detectors: Final = settings.detector

    def aspect(self, state: SignalsState, signal_id: str) -> Aspect:
        """What a signal shows."""
        signal = self.signals[signal_id]
        if signal_id in state.substitutes:
            return Aspect.SUBSTITUTE
        its_turn = state.directions.get(signal.block) is signal.direction
        clear = signal_id in state.wanted and its_turn and self._may(state, signal)
        return Aspect.CLEAR if clear else Aspect.STOP

    def after(
        self, state: SignalsState, event: SignalDeed | Contact, name: str, unit_id: str = ""
    ) -> SignalsState:
        """The state after somebody did something, or a train came by; `name`: of the signal, lever or section."""
        match event:
            case SignalDeed.SET if name not in state.wanted:
                state = replace(state, wanted=(*state.wanted, name))
            case SignalDeed.LEVER:
                state = replace(state, levers=state.levers | {name})
            case SignalDeed.RELEASE_LEVER:
                state = replace(state, levers=state.levers - {name})
            case SignalDeed.SUBSTITUTE:
                state = replace(state, substitutes=state.substitutes | {name})
            case Contact.PASSED:
                state = self._passed(state, name, unit_id)
            case Contact.COUNTED_OUT:
                state = replace(state, counted=self._without(state, name, unit_id))
            case _:
                pass
        return replace(state, directions=self._directions(state))

    def detector_at(self, signal_id: str) -> DepartureDetector | None:
        """What watches that no train leaves past a signal at stop."""
        return next((detector for detector in self._detectors if detector.signal == signal_id), None)

    def _passed(self, state: SignalsState, signal_id: str, unit_id: str) -> SignalsState:
        if self.aspect(state, signal_id) is Aspect.STOP:
            detector = self.detector_at(signal_id)
            holds = detector.holds if detector is not None and detector.works else ()
            return replace(state, held=state.held.union(holds))
        counted = self._without(state, self.signals[signal_id].block, unit_id)
        return replace(
            state,
            counted={**counted, signal_id: (*counted.get(signal_id, ()), unit_id)},
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
        pulled = [v for v in self._levers if v.id in state.levers and signal.block in v.blocks]
        against = any(lever.direction is not signal.direction for lever in pulled)
        return not (against or signal.id in state.held or state.counted.get(signal.id))

    def _directions(self, state: SignalsState) -> dict[str, Direction]:
        """Of each section: kept while a train is counted in or a lever for it pulled, else that of the first lever."""
        found: dict[str, Direction] = {}
        wanted = [self.signals[signal_id] for signal_id in state.wanted]
        for block in dict.fromkeys(signal.block for signal in self.signals.values()):
            before = state.directions.get(block)
            inside = [self.signals[signal_id] for signal_id, units in state.counted.items() if units]
            used = [s.direction for s in inside if s.block == block]
            asked = [s for s in wanted if s.block == block]
            used += [s.direction for s in asked if s.direction is before]
            first = next((s.direction for s in asked if self._may(state, s)), None)
            direction = before if before in used else next(iter(used), first)
            if direction is not None:
                found[block] = direction
        return found
