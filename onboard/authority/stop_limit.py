"""Where the train must stop (停止限界点): the end of what it holds, or the first points not proven.

Sugiyama et al. 2017, section 2.2: first before the departure points, then before the arrival points, then on the
arrival track, as grants and proofs come in.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from network.model import SectionKind
from onboard.authority.machine import Authority, PointsNeeded
from onboard.duty.mission import Mission, SectionSpan


@dataclass(frozen=True, slots=True)
class StopLimit:
    """Path coordinate of the stop limit, m, and the section that the train may not enter (None: path's end)."""

    limit_m: float
    before_section: str | None
    reason: str


def stop_limit(mission: Mission, authority: Authority, entered: Collection[str] = frozenset()) -> StopLimit:
    """The stop limit on the mission's path; the path's beginning when nothing on it is held.

    Points of sections that the train has `entered` on their proof no longer hold it back: they are locked under
    it, whatever has become of the proof since (4.4 (1), table 3).
    """
    held = set(authority.section_ids())
    proven = set(authority.proven)
    limit_m = 0.0
    begun = False
    for span in mission.spans:
        if span.section_id not in held:
            if begun:
                return StopLimit(limit_m, span.section_id, "not held")
            continue
        begun = True
        missing = any(needed not in proven for needed in points_of(span))
        if missing and span.section_id not in entered:
            return StopLimit(span.start_m, span.section_id, "points not proven")
        limit_m = span.end_m
    if not begun:
        return StopLimit(0.0, mission.spans[0].section_id, "not held")
    return StopLimit(limit_m, None, "end of the path")


def points_of(span: SectionSpan) -> tuple[PointsNeeded, ...]:
    """The points of a section as the path needs them."""
    return tuple(
        PointsNeeded(points_id, position, span.section_id, terminal_id)
        for points_id, position, terminal_id in span.points
    )


def departure_points(mission: Mission, from_section: str) -> tuple[PointsNeeded, ...]:
    """Points between a track and the open line beyond it: thrown as soon as the route is held."""
    found: list[PointsNeeded] = []
    for span in mission.spans[mission.span_index(from_section) + 1 :]:
        if span.kind is not SectionKind.POINTS:
            break
        found.extend(points_of(span))
    return tuple(found)


def arrival_points(mission: Mission, position_m: float) -> tuple[PointsNeeded, ...]:
    """Points ahead of a train on the open line up to the next track: thrown at the approach tag (④)."""
    found: list[PointsNeeded] = []
    for span in mission.spans:
        if span.start_m <= position_m:
            continue
        if span.kind is SectionKind.POINTS:
            found.extend(points_of(span))
        elif found or span.kind is not SectionKind.BETWEEN:
            break
    return tuple(found)


def cleared_sections(mission: Mission, authority: Authority, safe_rear_m: float) -> tuple[str, ...]:
    """Sections held on the path that the safe rear has left, in order of travel."""
    return tuple(
        span.section_id
        for span in mission.spans
        if span.end_m <= safe_rear_m and authority.holds(span.section_id)
    )


def next_rear_trigger_m(mission: Mission, authority: Authority) -> float:
    """Path coordinate that the safe rear passes next to free a section; infinite for the last one held."""
    ends = [span.end_m for span in mission.spans if authority.holds(span.section_id)]
    return ends[0] if len(ends) > 1 else float("inf")


def entered_on_proof(mission: Mission, authority: Authority, front_m: float) -> frozenset[str]:
    """Points sections that the front, surely beyond `front_m` (path coordinate), has entered with all points proven."""
    proven = set(authority.proven)
    return frozenset(
        span.section_id
        for span in mission.spans
        if span.points and span.start_m <= front_m and all(needed in proven for needed in points_of(span))
    )


def points_perhaps_under(mission: Mission, authority: Authority, front_m: float) -> frozenset[str]:
    """Sections with points still being thrown that the front, at most at `front_m`, may have come into."""
    under_way = {command.needed.section_id for command in authority.commands}
    return frozenset(
        s.section_id for s in mission.spans if s.start_m <= front_m and s.section_id in under_way
    )
