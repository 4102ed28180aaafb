"""What a unit's bounds rest on: a tachometer that errs by no more than the bounds grow (decision 004), and a first tag,
or satellites, after a boot that do not lie, as there is nothing to compare them with (decision 035).

Invariant: bounds are judged unless one of these has made the position false and nothing has told it anew since.
A fault that errs by no more than `bound_growth` is what bounds are for. What is false stays so when the fault is
over, until a fix or the crew tells the position anew; the unit that lost its position has none to be false.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from onboard.records import UnitRow
from simulation.sensors.tachometer import TachometerRow

FIXES_MAX: Final = (
    2  # the first cuts what was false, and may leave a few centimetres of it; the second does not
)


@dataclass(slots=True)
class _Lie:
    """A faulty tachometer: whether it still is, whether the position is false by it, and fixes since it was."""

    in_force: bool
    false: bool = False
    fixes: int = 0


class FalsePositions:
    """Which trains' positions a faulty tachometer has made false, by slot."""

    def __init__(self, tachometers: Sequence[TachometerRow], units: Sequence[UnitRow]) -> None:
        self._tachometers = tachometers
        self._units = units
        self._lies: dict[int, _Lie] = {}
        self._booted: set[int] = set()  # whose unit has been told no position since its boot

    def fault(self, slot: int, *, in_force: bool) -> None:
        """The tachometer has become faulty in another way, or is in order again; its row says how it shows."""
        lie = self._lies.setdefault(slot, _Lie(in_force))
        lie.in_force = in_force
        if self._tachometers[slot].frozen_mps > 0.0:  # it runs on even while the train stands
            lie.false = True

    def runs_on(self, slot: int) -> bool:
        """Whether the tachometer shows that it runs, though the train may stand."""
        return bool(self._tachometers[slot].frozen_mps > 0.0)

    def is_false(self, slot: int) -> bool:
        """Whether the position is false now; asked after each stretch in which the train could move."""
        lie = self._lies.get(slot)
        if lie is None:
            return False
        if not self._covered(slot):
            lie.false, lie.fixes = True, 0
        elif not self._units[slot].position_known:
            lie.false = False
        if not lie.false and not lie.in_force:
            del self._lies[slot]
        return lie.false

    def booted(self, slot: int) -> None:
        """A unit knows nothing of its position."""
        self._booted.add(slot)

    def note_fix(self, slot: int, *, holds: bool, lies: bool = False) -> None:
        """A fix has told the position anew; whether the bounds that it left hold the true front, and whether it `lies`:
        a tag that read as another, or satellites that err by more than they state.
        """
        if lies and slot in self._booted:
            self._lies.setdefault(slot, _Lie(in_force=False)).false = True
        self._booted.discard(slot)
        lie = self._lies.get(slot)
        if lie is not None:
            lie.fixes += not lies
            lie.false = lie.false and not holds and lie.fixes < FIXES_MAX

    def position_told(self, slot: int) -> None:
        """The crew has told where the train stands, as it is put on the line."""
        self._booted.discard(slot)
        if slot in self._lies:
            self._lies[slot].false = False

    def _covered(self, slot: int) -> bool:
        """Whether bounds grow by as much as the position now errs, m per m."""
        tachometer, unit = self._tachometers[slot], self._units[slot]
        if tachometer.frozen_mps >= 0.0:
            return False
        counted = tachometer.gain / tachometer.wheel_factor
        return abs(1.0 - counted * unit.odometer_scale) <= counted * unit.bound_growth
