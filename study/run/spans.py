"""The trace of a run, cut into trains."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from simulation.result import RunResult, TraceSpan


def rows_by_span(result: RunResult) -> Iterator[tuple[TraceSpan, NDArray[np.void]]]:
    """Trace rows of each train: those of its slot from its first step to the next train of the same slot."""
    last: dict[int, TraceSpan] = {}
    until: dict[int, int] = {}
    for index, span in enumerate(result.spans):
        before = last.get(span.slot)
        if before is not None:
            until[result.spans.index(before)] = span.from_step
        last[span.slot] = result.spans[index]
    for index, span in enumerate(result.spans):
        mine = (result.trace["slot"] == span.slot) & (result.trace["step"] > span.from_step)
        if index in until:
            mine &= result.trace["step"] <= until[index]
        yield span, result.trace[mine]
