"""Where trains truly were in a run: when the front of each came into a section and went out, and when its rear was out.

From the trace (samples of each second and at each event), which lies with its stock from train to train: a train that
turns back in a section is in it without a break, whichever of its ends is the front.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from network.model import Line, SectionKind
from simulation.events import Entered, Left
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from study.record.spans import rows_by_span, section_stretches

NOWHERE_M = -1e9  # a unit without a position is sure of none


@dataclass(slots=True)
class SectionVisit:
    """A stock in a section, s, by the truth; minus infinity: it was there, infinite: it stays.

    `begin_s` is when its front comes in, or when any of it is first seen in it; `number` the train that it then is.
    `safe_rear_s`: when its unit was sure that its rear was out, by its bounds.
    """

    section_id: str
    begin_s: float
    enters_s: float
    number: str = ""
    leaves_s: float = math.inf
    rear_s: float = math.inf
    safe_rear_s: float = math.inf


def visits_of(result: RunResult, line: Line, lengths_m: Mapping[str, float]) -> dict[str, list[SectionVisit]]:
    """The visits of each stock to sections, in the order in which they begin."""
    came_s, left_s = _times(result, Entered), _times(result, Left)
    found: dict[str, list[SectionVisit]] = defaultdict(list)
    # stock -> section -> a visit that has not ended
    within: dict[str, dict[str, SectionVisit]] = defaultdict(dict)
    for span, rows in rows_by_span(result):
        if not rows.size:
            continue
        unit = result.stock_ids[span.slot]
        from_s = float(rows["step"][0]) / STEPS_PER_S
        for gone_s in left_s[unit]:
            if gone_s <= from_s:
                _gone(within[unit], gone_s)
        seen = _SampledFronts(
            rows["step"] / STEPS_PER_S, np.maximum.accumulate(rows["position_m"]), lengths_m[unit]
        )
        sure_m = rows["position_m"] + rows["estimate_error_m"] - rows["bound_behind_m"]
        surely = replace(seen, front_m=np.maximum.accumulate(np.fmax(sure_m, NOWHERE_M)))
        on_line_s = [t for t in came_s[unit] if t <= from_s]
        for section_id, start_m, end_m in section_stretches(span, line):
            if not seen.touches(start_m, end_m):
                continue
            visit = within[unit].get(section_id)
            if visit is None:
                portal = line.sections[section_id].kind is SectionKind.PORTAL
                begin_s, enters_s = seen.begin(start_m, on_line_s[-1] if portal and on_line_s else -math.inf)
                visit = within[unit][section_id] = SectionVisit(section_id, begin_s, enters_s, span.number)
                found[unit].append(visit)
            elif seen.front_m[0] < end_m:
                visit.leaves_s = math.inf  # turned back: it is its front that is in it again
            visit.leaves_s = min(visit.leaves_s, seen.at_s(end_m))
            visit.rear_s = seen.at_s(end_m + seen.length_m)
            visit.safe_rear_s = surely.at_s(end_m + seen.length_m)
            if visit.rear_s < math.inf:
                del within[unit][section_id]
    for unit, open_visits in within.items():
        for gone_s in left_s[unit]:
            _gone(open_visits, gone_s)
    return found


def _gone(open_visits: dict[str, SectionVisit], gone_s: float) -> None:
    """Taken off the line."""
    for section_id, visit in list(open_visits.items()):
        if visit.begin_s <= gone_s:
            visit.leaves_s, visit.rear_s = min(visit.leaves_s, gone_s), gone_s
            del open_visits[section_id]


def _times(result: RunResult, kind: type[Entered | Left]) -> dict[str, list[float]]:
    found: dict[str, list[float]] = defaultdict(list)
    for entry in result.journal.entries:
        if isinstance(entry.event, kind):
            found[entry.event.unit_id].append(entry.t_s)
    return found


@dataclass(frozen=True, slots=True)
class _SampledFronts:
    """One train of a stock as sampled: times (s) and fronts (m of its path), neither of which goes back; shape (n,)."""

    times_s: NDArray[np.float64]
    front_m: NDArray[np.float64]
    length_m: float

    def touches(self, start_m: float, end_m: float) -> bool:
        """Whether any of it is in a stretch at any time."""
        return bool(self.front_m[-1] >= start_m and self.front_m[0] - self.length_m < end_m)

    def begin(self, start_m: float, on_line_s: float) -> tuple[float, float]:
        """When it is first known to be in a stretch, and when its front came in, s."""
        if self.front_m[0] >= start_m:  # there before it was first seen
            return float(self.times_s[0]), on_line_s
        at_s = self.at_s(start_m)
        return at_s, at_s

    def at_s(self, position_m: float) -> float:
        """When its front first is at a place, s; infinite: never; minus infinity: before it was first seen."""
        index = int(np.searchsorted(self.front_m, position_m, side="left"))
        if index == len(self.front_m):
            return math.inf
        if index == 0:
            return -math.inf if self.front_m[0] > position_m else float(self.times_s[0])
        before_m, after_m = float(self.front_m[index - 1]), float(self.front_m[index])
        share = (position_m - before_m) / (after_m - before_m)
        return float(self.times_s[index - 1] + share * (self.times_s[index] - self.times_s[index - 1]))
