"""What units need of the line to get a train through: tags that tell where it is, radio where something is said.

A unit's bounds grow with the distance from the last tags. It stops that far before where it may go, so without tags it
comes to stand short of its mark, and beyond `unit.doubt_bound_max_m` it gives its position up; by the wear of its
wheels it is off its mark even where it may go further. Points before a track are thrown at the approach tag (④);
without one the train stops before them. A route is asked for at a stand, what lies behind is given back there, and a
throw is commanded under way: each where the radio reaches.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from network.model import Line, SectionKind, TagPurpose
from network.tag_layout import OPEN_LINE_MAX_M
from onboard.authority.coverage import covered_at
from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.mission import Mission, SectionSpan, Target
from onboard.motion import ARRIVED_WITHIN_M
from onboard.plan import DutyPlan, plan_of
from simulation.settings import PositionSensor
from simulation.setup import Setup
from simulation.tolerance import CALLS_SHORT_M, OFF_MARK_M
from study.feasibility.finding import Finding, FindingKind, Severity, minute
from study.feasibility.fixes import PositionKnown, fixes_on, measured_growth
from study.feasibility.planned import PlannedDay, PlannedStop, PlannedTrain

RESERVE_M: Final = 1.0  # what supervision keeps beyond that
BEFORE_LIMIT_M: Final = LIMIT_MARGIN_M + RESERVE_M  # trains stop this far before a limit, and their bound
MEASURED_OVER_M: Final = 1000.0  # assumed: tags this far apart measure the wheels
MEASURED_SHARE: Final = 0.001  # assumed: what is left of their error then, 1 m in those 1000 m
NEAR_M: Final = 15.0  # where the last of the tags before a mark lies by the rule of `network.tag_layout`
LOOK_EVERY_M: Final = 20.0  # a covered stretch shorter than this is not looked for


@dataclass(frozen=True, slots=True)
class _TrainUnderWay:
    """One train on its way; `since_m` is how far its set ran since the last tag before this train began, and
    `measured` whether tags have measured its wheels by then.

    `mended_m`: where a tag is already said to be missing. What lies beyond is looked at as if it lay there.
    """

    setup: Setup
    line: Line
    train: PlannedTrain
    plan: DutyPlan
    since_m: float
    measured: bool
    fixes: tuple[PositionKnown, ...] = ()
    mended_m: list[float] = field(default_factory=list[float])

    @property
    def mission(self) -> Mission:
        return self.train.duty.mission

    @property
    def length_m(self) -> float:
        return float(self.setup.trains[self.train.stock_id].row[0]["length_m"])

    def bound_m(self, at_m: float) -> float:
        """How far ahead the front may be of where the unit believes it at `at_m`."""
        share = self.growth(at_m)
        return min(fix.within_m + share * max(at_m - fix.at_m, 0.0) for fix in self.known_m(at_m))

    def growth(self, at_m: float) -> float:
        """Of the bounds, m per m run, as the unit knows its wheels there."""
        unit = self.setup.unit
        known = self.reads_tags and self.measured_by(at_m)
        return measured_growth(unit) if known else unit.wheel_error_share

    def known_m(self, at_m: float) -> list[PositionKnown]:
        """From what the train knows where it is by then: at least where it last knew before this mission."""
        start_m, accuracy_m = self.mission.targets[0].mark_m, self.setup.unit.tag_accuracy_m
        fixes = [*self.fixes, *(PositionKnown(mended_m, accuracy_m) for mended_m in self.mended_m)]
        known = [fix for fix in fixes if start_m <= fix.at_m <= at_m]
        return known or [PositionKnown(start_m - self.since_m, accuracy_m)]

    @property
    def reads_tags(self) -> bool:
        return PositionSensor.TAGS in self.setup.sensors.carried_by(self.train.stock_id)

    def off_m(self, at_m: float) -> float:
        """How far the front may truly be from where the unit believes it at `at_m`, by its wheels' wear: two sigma.

        Tags that it has read measure the wheels: from then on far less.
        """
        share = MEASURED_SHARE if self.measured_by(at_m) else 2.0 * self.setup.sensors.wheel_factor_sigma
        return share * max(self.run_since_tag_m(at_m), 0.0)

    def measured_by(self, at_m: float) -> bool:
        """Whether tags have measured the wheels before the train is at a place."""
        start_m = self.mission.targets[0].mark_m
        read_m = [fix.at_m for fix in self.fixes if start_m <= fix.at_m <= at_m]
        return self.measured or (len(read_m) > 1 and read_m[-1] - read_m[0] >= MEASURED_OVER_M)

    def run_since_tag_m(self, at_m: float) -> float:
        """How far the train has run at a place since it last learnt where it is."""
        return at_m - max(fix.at_m for fix in self.known_m(at_m))

    def stops_before_m(self, limit_m: float) -> float:
        """Where the front stops before a limit: what would tell it more beyond that is not come to any more."""
        start_m, accuracy_m = self.mission.targets[0].mark_m, self.setup.unit.tag_accuracy_m
        mended = (PositionKnown(at_m, accuracy_m) for at_m in self.mended_m)
        ahead = sorted(fix for fix in {*self.fixes, *mended} if start_m <= fix.at_m < limit_m)
        share = self.growth(limit_m)
        stops_m = -math.inf
        for index, fix in enumerate([PositionKnown(start_m - self.since_m, accuracy_m), *ahead]):
            if index and fix.at_m > stops_m:
                break
            room_m = BEFORE_LIMIT_M + fix.within_m
            stops_m = max(stops_m, (limit_m - room_m + share * fix.at_m) / (1.0 + share))
        return max(stops_m, start_m)

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

    def stand_at(self, target: Target) -> PlannedStop:
        return next(stand for stand in self.train.stands if stand.target is target)

    def place(self, target: Target) -> tuple[str, str]:
        """Id and name."""
        if target.station_id is None:
            return target.section_id, f"portal {target.section_id}"
        return target.station_id, self.line.stations[target.station_id].name

    def next_stand(self, at_m: float) -> PlannedStop:
        """The first stop beyond a place."""
        return next((s for s in self.train.stands if s.target.mark_m >= at_m), self.train.stands[-1])

    def finding(
        self, kind: FindingKind, severity: Severity, stand: PlannedStop, texts: tuple[str, str]
    ) -> Finding:
        place, _ = self.place(stand.target)
        return Finding(kind, severity, (self.train.number,), place, stand.arrives_s, *texts)


def equipment_of(setup: Setup, day: PlannedDay) -> list[Finding]:
    """What is missing, one finding a place and a thing, with all trains that miss it."""
    found: list[Finding] = []
    for trains in day.trains.values():
        since_m: float = 0.0
        measured: bool = False
        for train in trains:
            length_m = float(setup.trains[train.stock_id].row[0]["length_m"])
            plan = plan_of(train.duty.mission, length_m)
            fixes = fixes_on(setup, train.stock_id, train.duty.mission)
            way = _TrainUnderWay(
                setup, day.line, train, plan, 0.0 if train.duty.enters else since_m, measured, fixes
            )
            found += _position(way)
            found += _radio(way)
            end_m = way.mission.targets[-1].mark_m
            since_m = way.run_since_tag_m(end_m)
            measured = way.measured_by(end_m)
    return _gathered(found)


def _gathered(found: Iterable[Finding]) -> list[Finding]:
    """One finding for what several trains lack at one place."""
    by_what: dict[tuple[FindingKind, Severity, str, str], list[Finding]] = {}
    for finding in found:
        by_what.setdefault((finding.kind, finding.severity, finding.place, finding.remedy), []).append(
            finding
        )
    gathered: list[Finding] = []
    for same in by_what.values():
        first = min(same, key=lambda finding: finding.time_s)
        numbers = tuple(dict.fromkeys(n for finding in sorted(same, key=_time) for n in finding.trains))
        gathered.append(replace(first, trains=numbers))
    return gathered


def _time(finding: Finding) -> float:
    return finding.time_s


# position ----------------------------------------------------------------------------------------------------


def _position(way: _TrainUnderWay) -> Iterator[Finding]:
    """Along the way: points that are to be thrown, and stops to be made."""
    spans = way.mission.spans
    places: list[tuple[float, int, int]] = [
        (span.start_m, 0, index) for index, span in enumerate(spans) if span.kind is SectionKind.POINTS
    ]
    places += [(target.mark_m, 1, index) for index, target in enumerate(way.mission.targets) if index > 0]
    for _, what, index in sorted(places):
        yield from _mark(way, way.mission.targets[index]) if what else _points(way, index)


def _mark(way: _TrainUnderWay, target: Target) -> Iterator[Finding]:
    """A stop that a unit could not make because no tag has told it where it is."""
    if target.station_id is None:
        return
    unit = way.setup.unit
    limit_m = _limit_m(way, target)
    stops_m = way.stops_before_m(limit_m)
    bound_m = way.bound_m(min(target.mark_m, stops_m))
    short_m = target.mark_m - stops_m
    off_m = way.off_m(target.mark_m)
    lost = bound_m > unit.doubt_bound_max_m and short_m > ARRIVED_WITHIN_M
    spare_m = CALLS_SHORT_M if _by_eye(way, target) else max(CALLS_SHORT_M, _spare_m(way, target))
    if not lost and short_m <= max(CALLS_SHORT_M, _spare_m(way, target)) and off_m <= spare_m:
        yield from _wide(way, target, short_m, off_m)
        return
    if not way.reads_tags:
        yield _to_be_brought(way, target, max(short_m, off_m), bound_m)
        return
    stand, (_, name) = way.stand_at(target), way.place(target)
    misses = f"{short_m:.0f} m short of" if short_m > off_m else f"perhaps {off_m:.0f} m off"
    text = (
        f"{way.train.number} would stop {misses} its mark at {name} at {minute(stand.arrives_s)}:"
        f" no position tag for the {way.run_since_tag_m(min(target.mark_m, stops_m)) / 1000.0:.1f} km before that"
    )
    room_m = (limit_m - target.mark_m - BEFORE_LIMIT_M - unit.tag_accuracy_m) / unit.wheel_error_share
    within_m = max(min(room_m, 300.0), 15.0)
    remedy = f"a position tag at most {within_m:.0f} m before the mark ({way.km(target.mark_m)})"
    if way.run_since_tag_m(target.mark_m) <= within_m:  # there is one, which the train does not come to
        remedy = f"tags on the way to it, at most {OPEN_LINE_MAX_M / 1000.0:.0f} km apart"
    way.mended_m.append(target.mark_m)
    yield way.finding(FindingKind.TAG, Severity.IMPOSSIBLE, stand, (text, remedy))


def _wide(way: _TrainUnderWay, target: Target, short_m: float, off_m: float) -> Iterator[Finding]:
    """A stop that is made, but farther off its mark than a run's summary calls at it; named once a place and cause."""
    misses_m = max(short_m, off_m)
    if misses_m <= OFF_MARK_M or not way.reads_tags:
        return
    stand, (_, name), mark = way.stand_at(target), way.place(target), way.km(target.mark_m)
    head = f"{way.train.number} would stop "
    at = f" its mark at {name} at {minute(stand.arrives_s)}"
    if short_m > off_m:
        limit_m = _limit_m(way, target)
        text = f"{head}{short_m:.1f} m short of{at}: it may go no more than {limit_m - target.mark_m:.1f} m beyond"
        room_m = BEFORE_LIMIT_M + way.setup.unit.tag_accuracy_m
        remedy = f"the mark ({mark}) {room_m:.0f} m or more before the end of what is held there, or a tag nearer to it"
    else:
        since_m = way.run_since_tag_m(target.mark_m)
        text = (
            f"{head}perhaps {off_m:.1f} m off{at}: nothing tells it where it is for {since_m:.0f} m before it"
        )
        remedy = f"a position tag at most {NEAR_M:.0f} m before the mark ({mark})"
    yield way.finding(FindingKind.STOP, Severity.TIGHT, stand, (text, remedy))


def _to_be_brought(way: _TrainUnderWay, target: Target, misses_m: float, bound_m: float) -> Finding:
    """A stop that a train without a reader of tags makes on sight: its driver says where it stands."""
    stand, (_, name) = way.stand_at(target), way.place(target)
    carried = ", ".join(sorted(way.setup.sensors.carried_by(way.train.stock_id)))
    text = (
        f"{way.train.number} knows where it is within {bound_m:.0f} m, by {carried}, as it comes to {name} at"
        f" {minute(stand.arrives_s)}: its driver would have to bring it to its mark on sight, from {misses_m:.0f} m off"
    )
    remedy = f"something that tells it where it is nearer to the mark ({way.km(target.mark_m)})"
    way.mended_m.append(target.mark_m)
    return way.finding(FindingKind.TAG, Severity.TIGHT, stand, (text, remedy))


def _by_eye(way: _TrainUnderWay, target: Target) -> bool:
    """Whether the driver has to confirm a stop there, which only one at its mark allows."""
    stops = zip(way.mission.targets, way.plan.stops, strict=True)
    return next(stop.by_eye for at, stop in stops if at is target)


def _limit_m(way: _TrainUnderWay, target: Target) -> float:
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


def _spare_m(way: _TrainUnderWay, target: Target) -> float:
    """How far before its mark the whole train still stands along the platform."""
    station = way.line.stations[target.station_id or ""]
    track = next(t for t in station.tracks if t.name == target.track)
    piece = way.line.pieces[track.piece_id]
    low_m, high_m = track.platform_m or (piece.from_m, piece.to_m)
    ends_m = [way.mission.path.to_path_m(track.piece_id, at_m) for at_m in (low_m, high_m)]
    return target.mark_m - way.length_m - min(ends_m)


# points ------------------------------------------------------------------------------------------------------


def _points(way: _TrainUnderWay, index: int) -> Iterator[Finding]:
    """Points that are to be thrown under way: their approach tag, and the radio to command them."""
    spans = way.mission.spans
    span = spans[index]
    needed = [one for group in _group(spans, index) for one in group.points]
    if index == 0 or spans[index - 1].kind is not SectionKind.BETWEEN or not needed:
        return
    tags = _approach_tags(way, span)
    stops_m = way.stops_before_m(span.start_m)
    stand = way.next_stand(span.start_m)
    head = f"{way.train.number} comes to points {needed[0][0]} before {minute(stand.arrives_s)}: "
    if not tags:
        yield from _without_approach_tag(way, stand, span, head)
    elif not way.covered(tags[0], max(stops_m, tags[0])):
        text = f"{head}no radio between their approach tag and them, so they cannot be thrown"
        remedy = _coverage_to(way, stops_m)
        yield way.finding(FindingKind.COVERAGE, Severity.IMPOSSIBLE, stand, (text, remedy))


def _without_approach_tag(
    way: _TrainUnderWay, stand: PlannedStop, span: SectionSpan, head: str
) -> Iterator[Finding]:
    """The train stops before the points: it can go on if it still knows where it is, and has radio there."""
    stops_m = way.stops_before_m(span.start_m)
    bound_m = way.bound_m(stops_m)
    remedy = f"an approach tag well before them ({way.km(span.start_m)})"
    if bound_m > way.setup.unit.doubt_bound_max_m:
        text = (
            f"{head}no approach tag has them thrown, and no position tag tells the train nearer than {bound_m:.0f} m"
            " where it is, so that it gives its position up"
        )
        way.mended_m.append(span.start_m)
        yield way.finding(FindingKind.TAG, Severity.IMPOSSIBLE, stand, (text, remedy))
    elif not way.covered(stops_m, stops_m):
        text = (
            f"{head}no approach tag has them thrown, and there is no radio where the train stops before them"
        )
        yield way.finding(
            FindingKind.TAG, Severity.IMPOSSIBLE, stand, (text, f"{remedy}, where the radio reaches")
        )
    else:
        text = f"{head}no approach tag has them thrown, so that the train stops before them"
        yield way.finding(FindingKind.TAG, Severity.TIGHT, stand, (text, remedy))


def _group(spans: Sequence[SectionSpan], first: int) -> list[SectionSpan]:
    """Points sections one behind the other."""
    group: list[SectionSpan] = []
    for span in spans[first:]:
        if span.kind is not SectionKind.POINTS:
            break
        group.append(span)
    return group


def _approach_tags(way: _TrainUnderWay, points: SectionSpan, before_m: float | None = None) -> list[float]:
    """Where approach tags of points lie on the open line before them, up to `before_m` if that is given."""
    index = way.mission.spans.index(points)
    start_m = points.start_m
    while index > 0 and way.mission.spans[index - 1].kind is SectionKind.BETWEEN:
        index -= 1
        start_m = way.mission.spans[index].start_m
    end_m = points.start_m if before_m is None else before_m
    tags = [tag for tag in way.mission.tags if tag.purpose is TagPurpose.APPROACH]
    return [tag.position_m for tag in tags if start_m <= tag.position_m < end_m]


# radio -------------------------------------------------------------------------------------------------------


def _radio(way: _TrainUnderWay) -> Iterator[Finding]:
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
        yield way.finding(FindingKind.COVERAGE, Severity.IMPOSSIBLE, stand, (text, remedy))
    yield from _passing(way)


def _passing(way: _TrainUnderWay) -> Iterator[Finding]:
    """Tracks that a train runs through: it asks for the way on from the approach tag on, or at the track's end."""
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
            f"{way.train.number} runs through section {span.section_id} before {minute(stand.arrives_s)}: no radio to"
            " ask for its route beyond"
        )
        remedy = _coverage_to(way, stops_m)
        yield way.finding(FindingKind.COVERAGE, Severity.IMPOSSIBLE, stand, (text, remedy))


def _coverage_to(way: _TrainUnderWay, at_m: float) -> str:
    """The nearest edge of what is covered."""
    step = way.mission.path.step_at(at_m)
    here_m = step.kilometrage_m(at_m)
    alignment = way.line.alignments[way.line.pieces[step.piece_id].alignment_id]
    edges_m = [edge_m for stretch in alignment.coverage for edge_m in (stretch.from_m, stretch.to_m)]
    nearest_m = min(edges_m, key=lambda edge_m: abs(edge_m - here_m), default=None)
    if nearest_m is None:
        return f"coverage of km {here_m / 1000.0:.3f}: the line has none"
    return f"coverage to km {here_m / 1000.0:.3f}: the nearest ends at km {nearest_m / 1000.0:.3f}"
