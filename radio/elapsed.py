"""Time that passes for a party's timers, by a clock that may be set.

Invariant: it never goes back, so a clock that is set right leaves no timer waiting for a time that it only showed.
"""

from __future__ import annotations

import math


class Elapsed:
    """The party's clock without its steps backwards. A step forwards is time that passed: timers run out sooner."""

    def __init__(self) -> None:
        self._last_s = -math.inf
        self._elapsed_s = -math.inf
        self._set_back_s = 0.0

    def at(self, now_s: float) -> float:
        """Elapsed time, s, when the clock shows `now_s`; to be called whenever the party is asked."""
        if now_s < self._last_s:
            self._set_back_s = self._elapsed_s - now_s
        self._last_s = now_s
        self._elapsed_s = max(self._elapsed_s, now_s + self._set_back_s)
        return self._elapsed_s

    def shown_at(self, elapsed_s: float) -> float:
        """What the clock will show at an elapsed time, unless it is set before."""
        return elapsed_s - self._set_back_s
