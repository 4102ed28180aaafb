"""When a train gives back what lies behind it: at the arrival tag, or at each, by bounds that grow since the tags.

The rule is that of `onboard.duty.arrival`; the bounds are those of `onboard.localisation.tags` where nothing slides and
no tag lies: of `tags_wrong_together` n, they rest on the tag read n before the last one. Wheels count as known, as they
are after the first two stations (`onboard.localisation.wheel_scale`): bounds then grow by twice what wheels change on
the way.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from network.model import SectionKind, TagPurpose
from onboard.duty_parameters import ReleaseRule
from onboard.mission import Mission
from onboard.unit_records import UnitParameters
from simulation.world.crew import LOOKS_AGAIN_S
from study.capacity.journey import TrainJourney


@dataclass(frozen=True, slots=True)
class ReleaseMoment:
    """At this moment, s, with the front at `at_m`, so many spans may be given back; `stands`: at a mark on a track."""

    t_s: float
    at_m: float
    spans: int
    stands: bool


class ReleaseTimes(NamedTuple):
    """When the safe rear has left a section, and when the unit reports it as clear, s."""

    safe_rear_s: float
    reported_s: float


@dataclass(frozen=True, slots=True)
class Clearing:
    """How a unit gives back; `pulse_m` of its tachometer. `by_section`: whatever its safe rear has left, at once.

    `release`: at which tags a unit that runs gives back.
    """

    unit: UnitParameters
    pulse_m: float
    by_section: bool = False
    release: ReleaseRule = ReleaseRule.ROUTE

    @property
    def growth(self) -> float:
        """By how much bounds grow, m a metre."""
        return min(2.0 * self.unit.wheel_varies_share, self.unit.wheel_error_share)

    def bound_m(self, journey: TrainJourney, front_m: float) -> float:
        """By how much the front may be off at a path coordinate, m either way."""
        return float(self.bounds_m(journey.mission, np.array([front_m]))[0])

    def bounds_m(self, mission: Mission, fronts_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same on a mission, at many path coordinates."""
        known_m = np.array(_known_m(mission))
        counts = np.searchsorted(known_m, fronts_m, side="right") - 1 - self.unit.tags_wrong_together
        since_m = np.maximum(fronts_m - known_m[np.maximum(counts, 0)], 0.0)
        return np.asarray(self.unit.tag_accuracy_m + self.pulse_m + self.growth * since_m)

    def clear_at_m(self, journey: TrainJourney, end_m: float, from_m: float, doubt: float) -> float:
        """Where the front is when the safe rear first is beyond `end_m`, from `from_m` on, m; infinite: nowhere.

        `doubt`: share of the way since the last tag that the odometer may have shown too much, for a release on it.
        """
        known_m = _known_m(journey.mission)
        growth = self.growth
        least_m = self.unit.tag_accuracy_m + self.pulse_m
        # before it the front is not beyond either
        first = max(bisect_right(known_m, max(from_m, end_m)) - 1, 0)
        for at, last_m in enumerate(known_m[first:], first):
            begin_m = max(from_m, last_m)
            since_m = max(begin_m - known_m[max(at - self.unit.tags_wrong_together, 0)], 0.0)
            rear_m = begin_m - (least_m + growth * since_m) - journey.length_m - doubt * (begin_m - last_m)
            at_m = begin_m + max(end_m - rear_m, 0.0) / (1.0 - growth - doubt)
            if at + 1 == len(known_m) or at_m < known_m[at + 1]:
                return at_m
        return math.inf

    def released(self, journey: TrainJourney) -> Iterator[ReleaseTimes]:
        """The same, with when the safe rear has left the section, s; infinite: nowhere before it stands."""
        for span, reported_s in zip(journey.mission.spans, self.reported_s(journey), strict=True):
            yield ReleaseTimes(journey.at_s(self.clear_at_m(journey, span.end_m, 0.0, 0.0)), reported_s)

    def reported_s(self, journey: TrainJourney) -> tuple[float, ...]:
        """When each section of the journey is reported as clear, s; infinite for those that it ends in."""
        frees = () if self.by_section else tuple(self._frees(journey))
        return tuple(self._reported_s(journey, frees, i) for i in range(len(journey.mission.spans)))

    def _reported_s(self, journey: TrainJourney, frees: tuple[ReleaseMoment, ...], span: int) -> float:
        end_m = journey.mission.spans[span].end_m
        kept_s = _kept_until_s(journey, span)
        if self.by_section:
            return max(journey.at_s(self.clear_at_m(journey, end_m, 0.0, 0.0)), kept_s)
        found_s = math.inf
        for each in frees:
            if each.spans <= span or each.t_s < kept_s:
                continue
            if not each.stands:
                at_m = self.clear_at_m(journey, end_m, each.at_m, self.unit.doubt_error_share)
                found_s = min(found_s, journey.at_s(at_m))
            elif each.at_m - self.bound_m(journey, each.at_m) - journey.length_m >= end_m:
                found_s = min(found_s, each.t_s)
        return min(found_s, self._by_eye_s(journey, span))

    def _by_eye_s(self, journey: TrainJourney, span: int) -> float:
        """When the driver of a train at its mark would have confirmed what no tag proves, s."""
        found = (s.arrives_s for s in journey.stays if journey.plan.stops[s.target].clear > span)
        return next(found, math.inf) + LOOKS_AGAIN_S

    def _frees(self, journey: TrainJourney) -> Iterator[ReleaseMoment]:
        """What may be given back when, by the tags read and the stops made."""
        mission, plan = journey.mission, journey.plan
        proved = 0
        read = list(zip(mission.tags, plan.tags, strict=True))
        for stay in journey.stays:
            stop, mark_m = plan.stops[stay.target], mission.targets[stay.target].mark_m
            while read and read[0][0].position_m <= mark_m:
                laid, tag = read.pop(0)
                proved = max(proved, tag.clear)
                if tag.purpose is TagPurpose.ARRIVAL or self.release is ReleaseRule.SECTION:
                    yield ReleaseMoment(journey.at_s(laid.position_m), laid.position_m, proved, stands=False)
            if mission.spans[stop.span].kind is not SectionKind.BETWEEN:
                yield ReleaseMoment(stay.arrives_s, mark_m, min(proved, stop.clear), stands=True)


def _kept_until_s(journey: TrainJourney, span: int) -> float:
    """When a train stands behind arrival points that it keeps until then (`onboard.duty.entering`), s."""
    section_id, plan = journey.plan.spans[span].section_id, journey.plan
    leg = next((leg for leg in plan.legs if section_id in leg.entry), None)
    ends = {i for i, at in enumerate(plan.spans) if leg is not None and at.section_id == leg.section_ids[-1]}
    return next((s.arrives_s for s in journey.stays if plan.stops[s.target].span in ends), -math.inf)


def _known_m(mission: Mission) -> list[float]:
    """Where the position becomes known: where a mission begins, and at each tag, m."""
    start_m = mission.targets[0].mark_m
    return [start_m, *(tag.position_m for tag in mission.tags if tag.position_m > start_m)]
