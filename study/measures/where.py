"""Where every stock truly was: the piece and kilometrage of its front at any moment, from the trace of a run."""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from simulation.result import RunResult
from simulation.setup import STEPS_PER_S

Floats = NDArray[np.float64]


class Whereabouts:
    """Samples of each stock in order of time; between two of them it is where the earlier one has it."""

    tolerance_m: Final = 1.0

    def __init__(self, result: RunResult) -> None:
        from study.run.spans import rows_by_span

        self._times_s: dict[str, list[float]] = defaultdict(list)
        self._at: dict[str, list[tuple[str, float]]] = defaultdict(list)
        for span, rows in rows_by_span(result):
            unit = result.stock_ids[span.slot]
            starts_m = np.asarray(span.starts_m)
            index = np.clip(np.searchsorted(starts_m, rows["position_m"], side="right") - 1, 0, None)
            at_m = np.asarray(span.entries_m)[index] + span.direction * (
                rows["position_m"] - starts_m[index]
            )
            self._times_s[unit] += (rows["step"] / STEPS_PER_S).tolist()
            self._at[unit] += list(zip((span.piece_ids[i] for i in index), at_m.tolist(), strict=True))

    def piece(self, unit: str, t_s: float) -> tuple[str, float] | None:
        """Piece and kilometrage (m) of the front; before its first movement that of the first sample; None: no sample."""
        times_s = self._times_s.get(unit)
        if not times_s:
            return None
        index = bisect_right(times_s, t_s + 0.05) - 1
        return self._at[unit][max(index, 0)]

    def kilometrage_m(self, unit: str, t_s: float) -> float | None:
        """Kilometrage (m) of the front; None: no sample."""
        at = self.piece(unit, t_s)
        return None if at is None else at[1]
