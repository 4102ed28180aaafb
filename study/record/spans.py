"""The trace of a run, cut into trains."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from network.model import Line
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


def section_stretches(span: TraceSpan, line: Line) -> list[tuple[str, float, float]]:
    """(section, start, end) along a train's path, m; pieces of one section joined, the last one open."""
    ends = (*span.starts_m[1:], np.inf)
    sections: list[tuple[str, float, float]] = []
    for piece, start_m, end_m in zip(span.piece_ids, span.starts_m, ends, strict=True):
        section = line.pieces[piece].section_id
        if sections and sections[-1][0] == section:
            sections[-1] = (section, sections[-1][1], end_m)
        else:
            sections.append((section, start_m, end_m))
    return sections
