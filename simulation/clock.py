"""The clock of a party: what it shows at a true time. The world keeps true time and asks parties by their clocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

SLOWEST: float = -0.9  # however many drifts add up, a clock goes on


@dataclass(frozen=True, slots=True)
class Clock:
    """What it shows is the true time and `ahead_s`, and `drift` for each second since midnight."""

    ahead_s: float = 0.0
    drift: float = 0.0

    def shows(self, true_s: float) -> float:
        """What the clock shows, s."""
        return true_s + (self.ahead_s + self.drift * true_s)

    def true_s(self, shown_s: float) -> float:
        """The true time at which it shows this, s."""
        return (shown_s - self.ahead_s) / (1.0 + self.drift) if self.ahead_s or self.drift else shown_s

    def wrong(self, offset_s: float, drift: float, since_s: float) -> Clock:
        """The same clock, further ahead by `offset_s` since a true time, and by `drift` for each second since then."""
        in_all = max(self.drift + drift, SLOWEST)
        return Clock(self.ahead_s + offset_s - (in_all - self.drift) * since_s, in_all)


RIGHT: Final = Clock()
