"""A limit to waiting that counts only time in which this process ran: who sleeps may not blame another's silence."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

GAP_S_MAX: Final = 1.0


class Patience:
    """Looked at again and again while one waits. A gap of more than `gap_s_max` between two looks is not counted:
    this process was stopped (SIGSTOP, a machine put to sleep), or had no processor.
    """

    def __init__(
        self, limit_s: float, gap_s_max: float = GAP_S_MAX, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._limit_s: Final = limit_s
        self._gap_s_max: Final = gap_s_max
        self._clock: Final = clock
        self._waited_s = 0.0
        self._looked_s = clock()

    def is_over(self) -> bool:
        """A look: whether it has been waited for long enough."""
        now_s = self._clock()
        gap_s, self._looked_s = now_s - self._looked_s, now_s
        if gap_s <= self._gap_s_max:
            self._waited_s += gap_s
        return self._waited_s >= self._limit_s
