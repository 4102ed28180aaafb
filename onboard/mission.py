"""What a train number asks of the unit: its path, the sections and tags on it, and where it is to stop when.

Drawn up from the unit's fixed data (線形データ) and the timetable before the train starts; positions are path
coordinates (m) of the train's front in the direction of travel.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from network.graph import fouled_sections, routes_from
from network.model import Direction, Line, Position, Route, SectionKind, TagPurpose
from network.path import Path, path_of
from network.timetable import CallKind, TimetableTrain

AT_MARK_M: Final = 1.0  # who stands on sight so near before a mark is there
KEEPS_ITS_MARK = True  # off: on sight a mark is forgotten in its last metre, with the train still moving


@dataclass(frozen=True, slots=True)
class SectionSpan:
    """One section on the path: where it begins and ends, and the points in it as this path needs them."""

    section_id: str
    kind: SectionKind
    start_m: float
    end_m: float
    points: tuple[tuple[str, Position, str], ...]  # points id, position, terminal id


@dataclass(frozen=True, slots=True)
class PathTag:
    """A tag that this path passes and that speaks to trains of this direction."""

    tag_id: int
    position_m: float
    purpose: TagPurpose


@dataclass(frozen=True, slots=True)
class Passing:
    """A station that the train runs through: its front is at `position_m` at `time_s`, as planned."""

    station_id: str
    track: str
    position_m: float
    time_s: float


@dataclass(frozen=True, slots=True)
class Target:
    """A place where the train stops; a place without a station is where it leaves the line.

    `passings` lie between the stop before and this one. `kind`: whether passengers get on and off, which takes its
    time. `crossing`: a station of several tracks, where another train may wait for this one.
    """

    station_id: str | None
    track: str
    section_id: str
    mark_m: float
    arrival_s: float | None
    departure_s: float | None
    passings: tuple[Passing, ...] = ()
    kind: CallKind = CallKind.STOP
    crossing: bool = False

    @property
    def passengers(self) -> bool:
        """Whether they get on and off here."""
        return self.kind is CallKind.STOP

    @property
    def place_id(self) -> str:
        """Id of the station, or of the section where it is no station."""
        return self.station_id or self.section_id

    def latest_arrival_s(self, dwell_min_s: float) -> float | None:
        """The latest arrival, s: by the plan, and the least dwell before the departure; None where neither is given."""
        if self.departure_s is None:
            return self.arrival_s
        ready_s = self.departure_s - (dwell_min_s if self.passengers else 0.0)
        return ready_s if self.arrival_s is None else min(self.arrival_s, ready_s)


@dataclass(frozen=True, slots=True)
class Mission:
    """Everything one train number needs, from where its stock stands to where it ends."""

    number: str
    direction: Direction
    revenue: bool
    path: Path
    routes: tuple[Route, ...]
    spans: tuple[SectionSpan, ...]
    tags: tuple[PathTag, ...]
    targets: tuple[Target, ...]  # the first one is where the train begins
    overlaps: bool = False  # on this line not all may come in at once (`wayside.entering`)

    def span_index(self, section_id: str) -> int:
        """Index of a section on the path; ValueError when it is not there."""
        for index, span in enumerate(self.spans):
            if span.section_id == section_id:
                return index
        raise ValueError(section_id)

    def mark_ahead_m(self, position_m: float, *, moves: bool) -> float:
        """The next mark of a train on sight, m; infinite where none follows. Who stands just short of one is there, who
        still moves comes to a stand at it.
        """
        there_m = 0.0 if moves and KEEPS_ITS_MARK else AT_MARK_M
        marks_m = (target.mark_m for target in self.targets if target.mark_m > position_m + there_m)
        return min(marks_m, default=math.inf)

    def span_at(self, position_m: float) -> SectionSpan:
        """The section at a path coordinate (m); at a joint the one being entered."""
        return next((s for s in self.spans if s.start_m <= position_m < s.end_m), self.spans[-1])

    @property
    def tracks(self) -> dict[str, str]:
        """The track at each station where it stops or that it passes."""
        passed = {p.station_id: p.track for target in self.targets for p in target.passings}
        return passed | {t.station_id: t.track for t in self.targets if t.station_id is not None}


def front_on(mission: Mission, before: Mission | None, at_m: float, length_m: float) -> float:
    """Where the front, at `at_m` of the path before, is on a mission's, m: what was the rear where it goes back.

    An estimate off that path, as of a train that does not know where it is, goes by its kilometrage.
    """
    if before is None or before is mission:
        return at_m
    turned = before.direction is not mission.direction
    piece_id, kilometrage_m = before.path.locate(at_m - length_m if turned else at_m)
    path = mission.path
    return (path.step_of(piece_id) if piece_id in path else path.steps[0]).to_path_m(kilometrage_m)


def on_tracks(train: TimetableTrain, tracks: Mapping[str, str]) -> TimetableTrain:
    """The train with its calls at these stations on these tracks, by name."""
    calls = tuple(replace(c, track=tracks.get(c.station_id, c.track)) for c in train.calls)
    return replace(train, calls=calls)


class NoWay(Exception):  # noqa: N818 - a planner's finding, not a program error
    """There is no route between two places of a mission."""


LEAVING_MARK_M = 15.0  # a train handed over to the other line stands this far before the portal's end


def plan_mission(
    line: Line, train: TimetableTrain, start_section: str, leave_by: str | None, enter_mark_m: float | None
) -> Mission:
    """Draw up the mission of `train` whose stock stands in `start_section`; NoWay where the line has no route.

    `leave_by` is the portal section by which it leaves, `enter_mark_m` the kilometrage (m) of the front where a
    train stands that has come in by a portal.
    """
    direction = train.direction
    stops = _stops(line, train, start_section, leave_by)
    routes: list[Route] = []
    at = start_section
    for section_ids in stops:
        if at in section_ids:
            continue
        leg = _shortest(line, at, section_ids, direction)
        routes.extend(leg)
        at = leg[-1].to_section
    pieces = _pieces(line, routes, start_section)
    path = path_of(line, pieces, direction)
    spans = _spans(line, path, routes)
    targets = _targets(line, train, path, spans, start_section, leave_by, enter_mark_m)
    tags = _tags(line, path, direction)
    overlaps = bool(fouled_sections(line))
    return Mission(
        train.number, direction, train.revenue, path, tuple(routes), spans, tags, targets, overlaps
    )


def _stops(line: Line, train: TimetableTrain, start_section: str, leave_by: str | None) -> list[set[str]]:
    """Sections of which one must be reached, in order: one set for each call at a track of its own."""
    wanted: list[set[str]] = []
    for call in train.calls:
        tracks = line.stations[call.station_id].tracks
        sections = [
            t
            for t in tracks
            if line.sections[t.section_id].kind is SectionKind.TRACK
            and train.direction in t.marks_m
            and (call.track is None or t.name == call.track)
        ]
        if not sections:
            continue
        usual = [t for t in sections if train.direction in t.directions] or sections
        ids = {
            t.section_id for t in (sections if start_section in {s.section_id for s in sections} else usual)
        }
        wanted.append(ids)
    if leave_by is not None:
        wanted.append({leave_by})
    return wanted


def _shortest(line: Line, start: str, goals: set[str], direction: Direction) -> list[Route]:
    """Fewest routes from `start` to any of `goals`, through the usual tracks of this direction first."""
    usual = {t.section_id for s in line.stations.values() for t in s.tracks if direction in t.directions}
    queue: deque[tuple[str, list[Route]]] = deque([(start, [])])
    seen = {start}
    while queue:
        at, legs = queue.popleft()
        if at in goals:
            return legs
        onward = sorted(routes_from(line, at, direction), key=lambda r: (r.to_section not in usual, r.id))
        for route in onward:
            if route.to_section not in seen:
                seen.add(route.to_section)
                queue.append((route.to_section, [*legs, route]))
    message = f"no route from section {start} to {' or '.join(sorted(goals))} going {direction.name.lower()}"
    raise NoWay(message)


def _pieces(line: Line, routes: list[Route], start_section: str) -> tuple[str, ...]:
    if not routes:
        return line.sections[start_section].piece_ids
    pieces = list(routes[0].piece_ids)
    for route in routes[1:]:
        pieces.extend(route.piece_ids[1:])
    return tuple(pieces)


def _spans(line: Line, path: Path, routes: list[Route]) -> tuple[SectionSpan, ...]:
    needed = {points_id: position for route in routes for points_id, position in route.points}
    spans: list[SectionSpan] = []
    for step in path.steps:
        section = line.sections[line.pieces[step.piece_id].section_id]
        end_m = step.start_m + step.length_m
        if spans and spans[-1].section_id == section.id:
            last = spans[-1]
            spans[-1] = SectionSpan(last.section_id, last.kind, last.start_m, end_m, last.points)
            continue
        points = tuple(
            (points.id, needed[points.id], points.terminal_id)
            for points in line.points.values()
            if points.section_id == section.id and points.id in needed
        )
        spans.append(SectionSpan(section.id, section.kind, step.start_m, end_m, points))
    return tuple(spans)


def _tags(line: Line, path: Path, direction: Direction) -> tuple[PathTag, ...]:
    on_path = {step.piece_id for step in path.steps}
    tags = [
        PathTag(tag.id, path.to_path_m(tag.piece_id, tag.position_m), tag.purpose)
        for tag in line.tags.values()
        if tag.piece_id in on_path and direction in tag.directions
    ]
    return tuple(sorted(tags, key=lambda tag: tag.position_m))


def _targets(
    line: Line,
    train: TimetableTrain,
    path: Path,
    spans: tuple[SectionSpan, ...],
    start_section: str,
    leave_by: str | None,
    enter_mark_m: float | None,
) -> tuple[Target, ...]:
    targets: list[Target] = []
    passings: list[Passing] = []
    on_path = {step.piece_id for step in path.steps}
    if enter_mark_m is not None:
        piece_id = line.sections[start_section].piece_ids[0]
        targets.append(Target(None, "", start_section, path.to_path_m(piece_id, enter_mark_m), None, None))
    for call in train.calls:
        tracks = [
            t
            for t in line.stations[call.station_id].tracks
            if t.piece_id in on_path and train.direction in t.marks_m and call.track in (None, t.name)
        ]
        if not tracks:
            message = (
                f"train {train.number} cannot call at {call.station_id} going {train.direction.name.lower()}"
            )
            raise NoWay(message)
        track = tracks[0]
        mark_m = path.to_path_m(track.piece_id, track.marks_m[train.direction])
        if not call.stops:
            passings.append(Passing(call.station_id, track.name, mark_m, call.last_s))
            continue
        targets.append(
            Target(
                call.station_id,
                track.name,
                track.section_id,
                mark_m,
                call.arrival_s,
                call.departure_s,
                tuple(passings),
                call.kind,
                len(line.stations[call.station_id].tracks) > 1,
            )
        )
        passings.clear()
    if leave_by is not None:
        targets.append(Target(None, "", leave_by, spans[-1].end_m - LEAVING_MARK_M, None, None))
    return tuple(targets)
