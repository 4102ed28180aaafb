"""Where a paced run is to be: a step for every time of the clock on the wall, which is given, never read.

A run that cannot keep up falls back: it goes on from where it is, and does not hurry after what it has missed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from simulation.setup import STEPS_PER_S

FASTEST: Final = 60.0  # times real time
BEHIND_MAX_S: Final = 0.5  # of the clock on the wall
LOOKS_EVERY_S: Final = 3600.0  # where the next step is due later than that: no clock waits for ever


@dataclass(frozen=True, slots=True)
class Pacer:
    """From `step` at `since_s` on, `factor` times as fast as the clock; 0: it stands.

    With a `goal` it runs to that step as fast as it can, and then stands.
    """

    factor: float = 0.0
    step: int = 0
    since_s: float = 0.0
    goal: int | None = None

    def due(self, now_s: float) -> int:
        """The step at which the run is to be."""
        if self.goal is not None:
            return max(self.goal, self.step)
        return self.step + int((now_s - self.since_s) * self.factor * STEPS_PER_S + 1e-6)

    def at(self, step: int, now_s: float) -> Pacer:
        """As the run has come to a step: it stands at its goal, and falls back where it is too far behind."""
        if self.goal is not None:
            return self if step < self.goal else Pacer(0.0, step, now_s)
        behind_s = (self.due(now_s) - step) / (self.factor * STEPS_PER_S) if self.factor else 0.0
        return Pacer(self.factor, step, now_s) if behind_s > BEHIND_MAX_S else self

    def wait_s(self, step: int, now_s: float) -> float | None:
        """How long until the step after `step` is due, s; None: not by itself."""
        if self.goal is not None:
            return 0.0
        if self.factor == 0.0:
            return None
        next_s = self.since_s + (step + 1 - self.step) / (self.factor * STEPS_PER_S)
        return min(max(next_s - now_s, 0.0), LOOKS_EVERY_S)
