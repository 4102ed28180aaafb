"""When the ways of a journey are set: asked for, held, points thrown; as units do it, or as late as it can be.

As units do it: a route is asked for before the departure, or at a tag before the track that the train runs through; its
departure points are thrown once it is held, its arrival points at the approach tag (`onboard.duty.machine`). As late as
it can be: all that leads into a section is done when a standing train leaves, or when the front comes to where it would
have to brake for the section's begin, by its pattern to a stop or by supervision.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from network.model import Points, SectionKind, TagPurpose
from onboard.driving.room import Room
from onboard.plan import DutyPlan, PlanLeg, PlanTag
from study.capacity.clearing import Clearing
from study.capacity.journey import TrainJourney
from study.capacity.links import Links
from study.capacity.rules import Rules
from study.measures.register_holds import Throwing


@dataclass(frozen=True, slots=True)
class SetUp:
    """How one section is set for a train: by which route, its moments, s, and its points."""

    route_id: str
    wanted_s: float
    sent_s: float
    heard_s: float
    held_s: float
    throwing: tuple[Throwing, ...] = ()


@dataclass(frozen=True, slots=True)
class Setting:
    """The rules, the links, and the points of the line; `lie_right`: (train number, points) that need no throw.

    `parts`: units are let onto the part of a way that is free, section by section of open line.
    """

    rules: Rules
    links: Links
    points: Mapping[str, Points]
    clearing: Clearing
    room: Room
    lie_right: Collection[tuple[str, str]] = frozenset()
    parts: bool = False

    def set_ups(self, journey: TrainJourney) -> dict[int, SetUp]:
        """How each section of the journey is set, by its index on the path; all but the first."""
        found: dict[int, SetUp] = {}
        passing_s = {} if self.rules.late else asks_in_passing_s(journey)
        for leg in journey.plan.legs:
            spans = spans_of(journey.plan, leg)
            if self.rules.late:
                found |= self._late(journey, leg, spans)
            else:
                ask_s = journey.asks_s.get(leg.route_id, passing_s.get(leg.route_id, math.inf))
                if ask_s == math.inf:  # no tag has it ask in time: it would as it comes to brake
                    ask_s = self.touches_s(journey, spans[0])
                found |= self._as_asked(journey, leg, spans, ask_s)
        return found

    def set_s(self, number: str, points_id: str) -> float:
        """From the command to points until their proof, s."""
        return self.links.set_s(self.throw_s(number, points_id))

    def throw_s(self, number: str, points_id: str) -> float:
        """How long points take to throw for a train, s; 0: they lie right."""
        lies = (number, points_id) in self.lie_right and not self.rules.throws
        return 0.0 if lies else self.points[points_id].throw_time_s

    def way_free_s(self, plan: DutyPlan, leg: PlanLeg, ask_s: float) -> float:
        """When a train that asks for a route at a time may leave by it, s."""
        points = plan.departure_points(leg.from_section)
        set_s = max((self.set_s(plan.number, needed.points_id) for needed in points), default=0.0)
        return ask_s + self.links.ask_s + set_s

    def touches_s(self, journey: TrainJourney, span: int) -> float:
        """When a train that runs on would first have to brake for the begin of a section, s; when it leaves its last
        stop before that, if it is so near.
        """
        joint_m = journey.mission.spans[span].start_m
        leaves_s = journey.leaves_last_s(joint_m)
        rows = journey.course[(journey.course[:, 0] >= leaves_s) & (journey.course[:, 1] <= joint_m)]
        if not len(rows):
            return leaves_s
        bound_m = self.clearing.bound_m(journey, joint_m)
        room_m = joint_m - rows[:, 1] - self.room.needed_m(rows[:, 2], bound_m)
        under = np.flatnonzero(room_m <= 0.0)
        if not under.size:
            return float(rows[-1, 0])
        first = int(under[0])
        if first == 0:
            return float(rows[0, 0])
        share = room_m[first - 1] / (room_m[first - 1] - room_m[first])
        return float(rows[first - 1, 0] + share * (rows[first, 0] - rows[first - 1, 0]))

    def leave(self, journey: TrainJourney, leg: PlanLeg, set_ups: Mapping[int, SetUp]) -> SetUp:
        """When a train asks for leave to come in by a route, and has it: before its arrival points are thrown."""
        spans = [i for i in spans_of(journey.plan, leg) if journey.plan.spans[i].section_id in leg.entry]
        throws_s = min(t.sent_s for i in spans for t in set_ups[i].throwing)
        sent_s = throws_s - self.links.ask_s + self.links.request_s
        heard_s = sent_s + self.links.delay_s
        return SetUp(leg.route_id, throws_s - self.links.ask_s, sent_s, heard_s, heard_s + self.links.grant_s)

    # as units do it ---------------------------------------------------------------------------------------------------

    def _as_asked(
        self, journey: TrainJourney, leg: PlanLeg, spans: range, ask_s: float
    ) -> Iterator[tuple[int, SetUp]]:
        at_once = {needed.points_id for needed in journey.plan.departure_points(leg.from_section)}
        by_tag_s = wants_at_tags_s(journey)
        sent_s = ask_s + self.links.request_s
        heard_s = sent_s + self.links.delay_s
        held_s = heard_s + self.links.grant_s
        for span in spans:
            throwing: list[Throwing] = []
            for needed in journey.plan.spans[span].points:
                wants_s = by_tag_s.get(needed.points_id, math.inf)
                if needed.points_id in at_once:
                    wants_s = held_s
                elif wants_s == math.inf:
                    wants_s = self.touches_s(journey, span)
                if needed.section_id in leg.entry:  # first it asks for leave to come in
                    wants_s = max(wants_s, held_s) + self.links.ask_s
                throwing.append(self._thrown(journey.number, needed.points_id, max(wants_s, held_s)))
            yield span, SetUp(leg.route_id, ask_s, sent_s, heard_s, held_s, tuple(throwing))

    def _thrown(self, number: str, points_id: str, sent_s: float) -> Throwing:
        taken_s = sent_s + self.links.command_s
        locked_s = taken_s + self.throw_s(number, points_id)
        return Throwing(sent_s, taken_s, locked_s, locked_s + self.links.proof_s)

    # as late as it can be ---------------------------------------------------------------------------------------------

    def _late(self, journey: TrainJourney, leg: PlanLeg, spans: range) -> Iterator[tuple[int, SetUp]]:
        ready_s = {span: self._ready_s(journey, leg, spans, span) for span in spans}
        points_s = {
            span: max(
                (self.set_s(journey.number, needed.points_id) for needed in journey.plan.spans[span].points),
                default=0.0,
            )
            for span in spans
        }
        own_s = {span: ready_s[span] - points_s[span] - self.links.ask_s for span in spans}
        for span in spans:
            wanted_s = min(own_s[other] for other in self._had_with(journey, spans, span))
            sent_s = wanted_s + self.links.request_s
            heard_s = sent_s + self.links.delay_s
            throwing = tuple(
                self._thrown(
                    journey.number,
                    needed.points_id,
                    ready_s[span] - self.set_s(journey.number, needed.points_id),
                )
                for needed in journey.plan.spans[span].points
            )
            yield span, SetUp(leg.route_id, wanted_s, sent_s, heard_s, heard_s + self.links.grant_s, throwing)

    def _had_with(self, journey: TrainJourney, spans: range, span: int) -> Sequence[int]:
        """The sections that are had together with one: all of the route, or its part, or by theory itself alone."""
        if self.rules.by_section:
            return (span,)
        if not self.parts:
            return spans
        between = [i for i in spans if journey.plan.spans[i].kind is SectionKind.BETWEEN]
        ends = (*between, spans[-1])
        first = max((end + 1 for end in ends if end < span), default=spans[0])
        return range(first, min(end for end in ends if end >= span) + 1)

    def _ready_s(self, journey: TrainJourney, leg: PlanLeg, spans: range, span: int) -> float:
        """When all that leads into a section must be done: at the departure, or where the train would have to brake."""
        touches_s = self.touches_s(journey, span)
        departs_s = leaves_s(journey, leg)
        if departs_s is None:
            return touches_s
        at_once = {needed.section_id for needed in journey.plan.departure_points(leg.from_section)}
        first = span == spans[0] or journey.plan.spans[span].section_id in at_once
        return departs_s if first else max(touches_s, departs_s)


def spans_of(plan: DutyPlan, leg: PlanLeg) -> range:
    """Indices of a route's sections on the path."""
    first = next(i for i, span in enumerate(plan.spans) if span.section_id == leg.section_ids[0])
    return range(first, first + len(leg.section_ids))


def leaves_s(journey: TrainJourney, leg: PlanLeg) -> float | None:
    """When a train leaves the track where a route begins, s; None: it runs through."""
    at = next(i for i, span in enumerate(journey.plan.spans) if span.section_id == leg.from_section)
    stays = [stay for stay in journey.stays if journey.plan.stops[stay.target].span == at]
    return stays[-1].departs_s if stays else None


def asks_in_passing_s(journey: TrainJourney) -> dict[str, float]:
    """When routes beyond tracks that the train runs through are asked for, by id, s (`look_ahead` of the duty)."""
    plan, found = journey.plan, dict[str, float]()
    for index, tag in enumerate(plan.tags):
        passed = plan.tags[: index + 1]
        track = None
        last = _approach(passed)
        if last is not None:
            track = plan.track_ahead(passed[last])
        elif tag.purpose is TagPurpose.POSITION:
            track = plan.track_behind_joint(tag)
        if track is None or plan.calls_at(track.section_id):
            continue
        leg = plan.leg_beyond(track.section_id)
        read_s = journey.at_s(journey.mission.tags[index].position_m)
        if leg is not None and not math.isinf(read_s):
            found.setdefault(leg.route_id, read_s)
    return found


def wants_at_tags_s(journey: TrainJourney) -> dict[str, float]:
    """When the approach tags have arrival points thrown, by id, s."""
    plan, found = journey.plan, dict[str, float]()
    for index in range(len(plan.tags)):
        last = _approach(plan.tags[: index + 1])
        read_s = journey.at_s(journey.mission.tags[index].position_m)
        if last is None or math.isinf(read_s):
            continue
        for needed in plan.arrival_points(plan.tags[last]):
            found.setdefault(needed.points_id, read_s)
    return found


def _approach(passed: tuple[PlanTag, ...]) -> int | None:
    """The last approach tag passed, unless an arrival tag has been passed since."""
    last = max((i for i, tag in enumerate(passed) if tag.purpose is TagPurpose.APPROACH), default=None)
    if last is None or any(tag.purpose is TagPurpose.ARRIVAL for tag in passed[last:]):
        return None
    return last
