"""What units need of the line to get a train through: tags that tell where it is, radio where something is to be said.

A unit's bounds grow with the distance from the last tag. It stops that far before where it may go, so without tags it
comes to stand short of its mark, and beyond `unit.doubt_bound_max_m` it gives its position up. Points before a track are
thrown at the approach tag (④); without one the train stops before them. A route is asked for at a stand, what lies
behind is given back there, and a throw is commanded under way: each where the radio reaches (`onboard.authority.coverage`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from network.model import Line, SectionKind, TagPurpose
from onboard.authority.coverage import covered_at
from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.driving.supervision import RESERVE_M
from onboard.duty.mission import Mission, SectionSpan, Target
from onboard.motion import ARRIVED_WITHIN_M
from simulation.setup import Setup
from simulation.world.books import CALLS_SHORT_M
from study.feasibility.finding import Finding, Kind, Severity, minute
from study.feasibility.planned import PlannedDay, PlannedTrain, Stand

BEFORE_LIMIT_M: Final = LIMIT_MARGIN_M + RESERVE_M  # trains stop this far before a limit, and their bound
LOOK_EVERY_M: Final = 20.0  # a covered stretch shorter than this is not looked for


@dataclass(frozen=True, slots=True)
class _Way:
    """One train on its way; `since_m` is how far its set ran since the last tag before this train began."""

    setup: Setup
    line: Line
    train: PlannedTrain
    since_m: float

    @property
    def mission(self) -> Mission:
        return self.train.duty.mission

    @property
    def length_m(self) -> float:
        return float(self.setup.trains[self.train.stock_id].row[0]["length_m"])

    def bound_m(self, at_m: float) -> float:
        """How far ahead the front may be of where the unit believes it at `at_m`."""
        before = [tag.position_m for tag in self.mission.tags if tag.position_m <= at_m]
        start_m = self.mission.targets[0].mark_m
        run_m = at_m - before[-1] if before and before[-1] >= start_m else self.since_m + at_m - start_m
        unit = self.setup.unit
        return unit.tag_accuracy_m + unit.wheel_error_share * max(run_m, 0.0)

    def stops_before_m(self, limit_m: float) -> float:
        """Where the front stops before a limit, which it comes to with what tags have told it up to there."""
        return limit_m - self.bound_m(limit_m) - BEFORE_LIMIT_M

    def covered(self, from_m: float, to_m: float) -> bool:
        """Whether the radio reaches anywhere on a stretch of the way."""
        looked_m = from_m
        while looked_m < to_m:
            if covered_at(self.line, self.mission.path, looked_m):
                return True
            looked_m += LOOK_EVERY_M
        return covered_at(self.line, self.mission.path, to_m)

    def km(self, at_m: float) -> str:
        return f"km {self.mission.path.kilometrage_m(at_m) / 1000.0:.3f}"

    def stand_at(self, target: Target) -> Stand:
        return next(stand for stand in self.train.stands if stand.target is target)

    def place(self, target: Target) -> tuple[str, str]:
        """Id and name."""
        if target.station_id is None:
            return target.section_id, f"portal {target.section_id}"
        return target.station_id, self.line.stations[target.station_id].name

    def next_stand(self, at_m: float) -> Stand:
        """The first stop beyond a place."""
        return next((s for s in self.train.stands if s.target.mark_m >= at_m), self.train.stands[-1])

    def finding(self, kind: Kind, severity: Severity, stand: Stand, texts: tuple[str, str]) -> Finding:
        place, _ = self.place(stand.target)
        return Finding(kind, severity, (self.train.number,), place, stand.arrives_s, *texts)


def equipment_of(setup: Setup, day: PlannedDay) -> list[Finding]:
    """What is missing, one finding a place and a thing, with all trains that miss it."""
    found: list[Finding] = []
    for trains in day.trains.values():
        since_m = 0.0
        for train in trains:
            way = _Way(setup, day.line, train, 0.0 if train.duty.enters else since_m)
            found += _marks(way)
            found += _points(way)
            found += _radio(way)
            since_m = _run_since_tag_m(way)
    return _gathered(found)


def _run_since_tag_m(way: _Way) -> float:
    end_m = way.mission.targets[-1].mark_m
    start_m = way.mission.targets[0].mark_m
    read = [tag.position_m for tag in way.mission.tags if start_m <= tag.position_m <= end_m]
    return end_m - read[-1] if read else way.since_m + end_m - start_m


def _gathered(found: Iterable[Finding]) -> list[Finding]:
    """One finding for what several trains lack at one place."""
    by_what: dict[tuple[Kind, Severity, str, str], list[Finding]] = {}
    for finding in found:
        reason = finding.text.partition(": ")[2]
        by_what.setdefault((finding.kind, finding.severity, finding.place, reason), []).append(finding)
    gathered: list[Finding] = []
    for same in by_what.values():
        first = min(same, key=lambda finding: finding.time_s)
        numbers = tuple(dict.fromkeys(n for finding in sorted(same, key=_time) for n in finding.trains))
        gathered.append(replace(first, trains=numbers))
    return gathered


def _time(finding: Finding) -> float:
    return finding.time_s


# position ------------------------------------------------------------------------------------------------------------


def _marks(way: _Way) -> Iterator[Finding]:
    """Stops that a unit could not make because no tag has told it where it is."""
    for target in way.mission.targets[1:]:
        if target.station_id is None:
            continue
        limit_m = _limit_m(way, target)
        bound_m = way.bound_m(target.mark_m)
        short_m = target.mark_m - (limit_m - bound_m - BEFORE_LIMIT_M)
        lost = bound_m > way.setup.unit.doubt_bound_max_m and short_m > ARRIVED_WITHIN_M
        if not lost and short_m <= max(CALLS_SHORT_M, _spare_m(way, target)):
            continue
        stand, (_, name) = way.stand_at(target), way.place(target)
        text = (
            f"{way.train.number} would stop {short_m:.0f} m short of its mark at {name} at"
            f" {minute(stand.arrives_s)}: no position tag tells it nearer than {bound_m:.0f} m where it is"
        )
        unit = way.setup.unit
        room_m = (limit_m - target.mark_m - BEFORE_LIMIT_M - unit.tag_accuracy_m) / unit.wheel_error_share
        within_m = max(min(room_m, 300.0), 15.0)
        remedy = f"a position tag at most {within_m:.0f} m before the mark ({way.km(target.mark_m)})"
        yield way.finding(Kind.TAG, Severity.IMPOSSIBLE, stand, (text, remedy))


def _limit_m(way: _Way, target: Target) -> float:
    """How far a train may go when it comes to a stop: to the end of its track, at a halt to points not thrown yet."""
    spans = way.mission.spans
    at = way.mission.span_index(target.section_id)
    if spans[at].kind is not SectionKind.BETWEEN:
        return spans[at].end_m
    for span in spans[at:]:
        if span.kind is SectionKind.POINTS and span.points and not _approach_tags(way, span, target.mark_m):
            return span.start_m
        if span.kind is not SectionKind.BETWEEN and span.kind is not SectionKind.POINTS:
            return span.end_m
    return spans[-1].end_m


def _spare_m(way: _Way, target: Target) -> float:
    """How far before its mark the whole train still stands along the platform."""
    station = way.line.stations[target.station_id or ""]
    track = next(t for t in station.tracks if t.name == target.track)
    piece = way.line.pieces[track.piece_id]
    low_m, high_m = track.platform_m or (piece.from_m, piece.to_m)
    ends_m = [way.mission.path.to_path_m(track.piece_id, at_m) for at_m in (low_m, high_m)]
    return target.mark_m - way.length_m - min(ends_m)


# points ----------------------------------------------------------------------------------------------------------------


def _points(way: _Way) -> Iterator[Finding]:
    """Points that are to be thrown under way: their approach tag, and the radio to command them."""
    spans = way.mission.spans
    for index, span in enumerate(spans[1:], start=1):
        arrives = span.kind is SectionKind.POINTS and spans[index - 1].kind is SectionKind.BETWEEN
        needed = [one for group in _group(spans, index) for one in group.points]
        if not arrives or not needed:
            continue
        tags = _approach_tags(way, span)
        stops_m = way.stops_before_m(span.start_m)
        stand = way.next_stand(span.start_m)
        head = f"{way.train.number} comes to points {needed[0][0]} before {minute(stand.arrives_s)}: "
        if tags:
            if not way.covered(tags[0], max(stops_m, tags[0])):
                text = f"{head}no radio between their approach tag and them, so they cannot be thrown"
                yield way.finding(
                    Kind.COVERAGE, Severity.IMPOSSIBLE, stand, (text, _coverage_to(way, stops_m))
                )
            continue
        yield from _without_approach_tag(way, stand, stops_m, head)


def _without_approach_tag(way: _Way, stand: Stand, stops_m: float, head: str) -> Iterator[Finding]:
    """The train stops before the points: it can go on if it still knows where it is, and has radio there."""
    bound_m = way.bound_m(stops_m)
    remedy = f"an approach tag before {way.km(stops_m)}"
    if bound_m > way.setup.unit.doubt_bound_max_m:
        text = (
            f"{head}no approach tag has them thrown, and no position tag tells the train nearer than {bound_m:.0f} m"
            " where it is, so that it gives its position up"
        )
        yield way.finding(Kind.TAG, Severity.IMPOSSIBLE, stand, (text, remedy))
    elif not way.covered(stops_m, stops_m):
        text = (
            f"{head}no approach tag has them thrown, and there is no radio where the train stops before them"
        )
        yield way.finding(Kind.TAG, Severity.IMPOSSIBLE, stand, (text, f"{remedy}, where the radio reaches"))
    else:
        text = f"{head}no approach tag has them thrown, so that the train stops before them"
        yield way.finding(Kind.TAG, Severity.TIGHT, stand, (text, remedy))


def _group(spans: Sequence[SectionSpan], first: int) -> list[SectionSpan]:
    """Points sections one behind the other."""
    group: list[SectionSpan] = []
    for span in spans[first:]:
        if span.kind is not SectionKind.POINTS:
            break
        group.append(span)
    return group


def _approach_tags(way: _Way, points: SectionSpan, before_m: float | None = None) -> list[float]:
    """Where approach tags of points lie on the open line before them, up to `before_m` if that is given."""
    index = way.mission.spans.index(points)
    start_m = points.start_m
    while index > 0 and way.mission.spans[index - 1].kind is SectionKind.BETWEEN:
        index -= 1
        start_m = way.mission.spans[index].start_m
    end_m = points.start_m if before_m is None else before_m
    tags = [tag for tag in way.mission.tags if tag.purpose is TagPurpose.APPROACH]
    return [tag.position_m for tag in tags if start_m <= tag.position_m < end_m]


# radio -----------------------------------------------------------------------------------------------------------------


def _radio(way: _Way) -> Iterator[Finding]:
    """Stands where something must be said: signing on and off, asking for a route, giving back what lies behind."""
    spans = way.mission.spans
    last = len(way.mission.targets) - 1
    for index, target in enumerate(way.mission.targets):
        span = spans[way.mission.span_index(target.section_id)]
        comes = index == 0 and way.train.duty.train.begins.__class__.__name__ != "FromTrain"
        if span.kind is SectionKind.BETWEEN and not comes:
            continue
        if covered_at(way.line, way.mission.path, target.mark_m):
            continue
        what = (
            "sign on"
            if comes
            else "sign off"
            if index == last and way.train.duty.leaves
            else "give back what lies behind it"
            if index == last
            else "ask for its route"
        )
        stand, (_, name) = way.stand_at(target), way.place(target)
        text = (
            f"{way.train.number} stands at {name} at {minute(stand.arrives_s)}, {way.km(target.mark_m)}: no radio there"
            f" to {what}"
        )
        remedy = _coverage_to(way, target.mark_m)
        yield way.finding(Kind.COVERAGE, Severity.IMPOSSIBLE, stand, (text, remedy))
    yield from _passing(way)


def _passing(way: _Way) -> Iterator[Finding]:
    """Tracks that a train runs through: the route beyond is asked for from the approach tag on, or at the track's end."""
    for node in way.train.nodes[1:-1]:
        if node.target is not None:
            continue
        index = way.mission.span_index(node.section_id)
        span = way.mission.spans[index]
        before = way.mission.spans[:index]
        points = next((s for s in reversed(before) if s.kind is SectionKind.POINTS), None)
        tags = [] if points is None else _approach_tags(way, points)
        stops_m = way.stops_before_m(span.end_m)
        from_m = min(tags[0] if tags else stops_m, stops_m)
        if way.covered(from_m, stops_m):
            continue
        stand = way.next_stand(span.start_m)
        text = (
            f"{way.train.number} runs through section {span.section_id} before {minute(stand.arrives_s)}: no radio to ask"
            " for its route beyond"
        )
        remedy = _coverage_to(way, stops_m)
        yield way.finding(Kind.COVERAGE, Severity.IMPOSSIBLE, stand, (text, remedy))


def _coverage_to(way: _Way, at_m: float) -> str:
    """The nearest edge of what is covered."""
    step = way.mission.path.step_at(at_m)
    here_m = step.kilometrage_m(at_m)
    alignment = way.line.alignments[way.line.pieces[step.piece_id].alignment_id]
    edges_m = [edge_m for stretch in alignment.coverage for edge_m in (stretch.from_m, stretch.to_m)]
    nearest_m = min(edges_m, key=lambda edge_m: abs(edge_m - here_m), default=None)
    if nearest_m is None:
        return f"coverage of km {here_m / 1000.0:.3f}: the line has none"
    return f"coverage to km {here_m / 1000.0:.3f}: the nearest ends at km {nearest_m / 1000.0:.3f}"
