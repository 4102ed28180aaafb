"""Where every stock truly was: the piece and kilometrage of its front at any moment, from the trace of a run."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import defaultdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from simulation.world.records import TRACE
from study.record.spans import rows_by_span

HALF_STEP_S: Final = 0.5 / STEPS_PER_S


class Whereabouts:
    """Samples of each stock in order of time; between two of them it is where the earlier one has it."""

    def __init__(self, result: RunResult) -> None:
        self._times_s: dict[str, list[float]] = defaultdict(list)
        self._at: dict[str, list[tuple[str, float]]] = defaultdict(list)
        rows_of: dict[str, list[NDArray[np.void]]] = defaultdict(list)
        for span, rows in rows_by_span(result):
            unit = result.stock_ids[span.slot]
            starts_m = np.asarray(span.starts_m)
            index = np.clip(np.searchsorted(starts_m, rows["position_m"], side="right") - 1, 0, None)
            along_m = span.direction * (rows["position_m"] - starts_m[index])
            at_m: list[float] = (np.asarray(span.entries_m)[index] + along_m).tolist()
            self._times_s[unit] += (rows["step"] / STEPS_PER_S).tolist()
            pieces = [span.piece_ids[int(i)] for i in index]
            self._at[unit] += zip(pieces, at_m, strict=True)
            rows_of[unit].append(rows)
        self._rows = {unit: np.concatenate(parts) for unit, parts in rows_of.items()}

    def piece(self, unit: str, t_s: float) -> tuple[str, float] | None:
        """Piece and kilometrage (m) of the front; before the first sample that of the first; None: no sample."""
        times_s = self._times_s.get(unit)
        if not times_s:
            return None
        return self._at[unit][max(bisect_right(times_s, t_s + HALF_STEP_S) - 1, 0)]

    def samples(self, unit: str, from_s: float, to_s: float) -> NDArray[np.void]:
        """Rows of the trace (simulation.world.records.TRACE) of a stock from one moment to another, shape (n,)."""
        times_s = self._times_s.get(unit, [])
        low, high = bisect_left(times_s, from_s - HALF_STEP_S), bisect_right(times_s, to_s + HALF_STEP_S)
        return self._rows[unit][low:high] if times_s else np.zeros(0, dtype=TRACE)
