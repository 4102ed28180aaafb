"""The level crossings on a train's path in metres and seconds of running, by its unit's own localisation.

The front may be as far ahead as its bound; how soon it can then be on a crossing is predicted with the unit's model of
its train: at the speed that it means to run, and at full power up to the limit, which no run is faster than. A run is
predicted where the answer depends on it; else the time counts that the way takes at the top speed of the path.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from network.files.crossings import least_closed_s
from network.model import LevelCrossing, Line
from onboard.crossings.machine import EARLY_S, HELD_FROM_S, CrossingPlace
from onboard.driving.pace import Pace
from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.driving.supervision import RESERVE_M
from onboard.mission import Mission
from onboard.records import BehaviourRow, UnitRow
from onboard.unit_records import UnitParameters
from vehicle.compiled import compiled
from vehicle.records import TrainRow
from vehicle.running_time import predicted_run

STOPS_SHORT_M: Final = 2.0  # the movement limit lies so far before the road
CLOSELY_S: Final = (
    20.0  # so long before it may have to be asked, at top speed all the way, its run is predicted
)
PREDICTION_STEP_S: Final = 0.5
AGES_S: Final = (
    5.0  # so long a prediction is good for, less the way run since at the speed that the train has
)
PATTERN_RESERVE_S: Final = 2.0  # assumed: dead time and lag of the brake, and a tick or two
STARTS_MPS2: Final = 1.0  # assumed: no train here gains more from a stand


class PredictedArrival(NamedTuple):
    """When the front would be on a crossing, s from when it was at `front_m`, m, at `speed_mps`."""

    arrives_s: float
    front_m: float
    speed_mps: float

    def at(self, front_m: float, speed_mps: float) -> float | None:
        """The time from a place a little further on, s; None: it is to be predicted anew."""
        run_m, mean_mps = front_m - self.front_m, 0.5 * (speed_mps + self.speed_mps)
        runs = 0.0 < run_m <= mean_mps * AGES_S and speed_mps > 0.0
        if runs or (run_m == 0.0 and speed_mps == self.speed_mps):
            return self.arrives_s - (run_m / mean_mps if runs else 0.0)
        return None


def begins_beyond_contact(crossing: LevelCrossing, mission: Mission) -> bool:
    """Whether a train has its first mark between a crossing's first contact and the road, on a path over it."""
    begins_m, road_m = mission.targets[0].mark_m, mission.path.to_road_m(crossing)
    before_m, _ = crossing.contacts_from_road_m(mission.path.direction)
    return road_m - before_m <= begins_m < road_m


def no_contact_passed(crossing: LevelCrossing, mission: Mission, before: Mission | None) -> bool:
    """Whether no contact has warned of a train: it begins beyond the first one, and has not come over that as the train
    before, which went the same way.
    """
    if (
        before is not None
        and before.path.direction is mission.path.direction
        and crossing.piece_id in before.path
    ):
        return begins_beyond_contact(crossing, mission) and begins_beyond_contact(crossing, before)
    return begins_beyond_contact(crossing, mission)


def _is_asked(crossing: LevelCrossing, mission: Mission, before: Mission | None) -> bool:
    """Whether a unit asks a crossing on its path, and does not pass it unheard."""
    return not crossing.warns_departures or no_contact_passed(crossing, mission, before)


@dataclass(frozen=True)
class CrossingOnPath:
    """A crossing between two path coordinates (m), in which span, and after which stop of the mission."""

    crossing: LevelCrossing
    start_m: float
    end_m: float
    span: int
    stop: int

    @cached_property
    def behind(self) -> CrossingPlace:
        """What a unit is told of it when its safe rear has left it."""
        crossing = self.crossing
        times_s = (crossing.warning_s, crossing.closing_s, least_closed_s(crossing))
        if crossing.has_protection:  # it closes by itself, and is asked once it ends the movement limit
            times_s = (HELD_FROM_S - EARLY_S, 0.0, 0.0)
        return CrossingPlace(
            crossing.id,
            self.span,
            self.stop,
            *times_s,
            entered=True,
            under=True,
            beyond=True,
            clear=True,
            departs=crossing.warns_departures,
        )


@compiled
def _arrives_s(
    train: NDArray[np.void],
    load_share: float,
    climb_m: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    from_m: float,
    stop_m: float,
    cruise_mps: float,
    deceleration_mps2: float,
    speed_mps: float,
    road_m: float,
) -> float:
    """The time of `predicted_run` to a road, s; the train as a row of one, as numpy hands records over slowly."""
    return predicted_run(
        train[0],
        load_share,
        climb_m,
        limit_mps,
        from_m,
        stop_m,
        cruise_mps,
        deceleration_mps2,
        PREDICTION_STEP_S,
        speed_mps,
        road_m,
        rolls=True,
    )[0]


class CrossingsAhead:
    """The crossings of one unit's path that it hears by radio. `row` is its row of UNIT."""

    def __init__(
        self,
        line: Line,
        parameters: UnitParameters,
        row: UnitRow,
        train: TrainRow,
        behaviour: BehaviourRow,
        pace: Pace,
    ) -> None:
        self._by_radio: Final = [crossing for crossing in line.crossings.values() if crossing.tells_units]
        self._parameters: Final = parameters
        self._row: Final = row
        record: Any = train
        self._train: Final[NDArray[np.void]] = np.frombuffer(record, record.dtype)
        self._length_m: Final = float(train.length_m)
        self._predicted: dict[tuple[str, float, bool], PredictedArrival] = {}  # by crossing and how it runs
        self._deceleration_mps2: Final = float(behaviour.settings.stop_deceleration_mps2)
        self._pace: Final = pace
        self._on_path: tuple[CrossingOnPath, ...] = ()
        self._starts_m: dict[str, float] = {}
        self._mission: Mission | None = None
        self._front_m = 0.0
        self._behind: set[str] = set()  # of which the unit has been told so
        settings = behaviour.settings
        self._beyond_mps: Final = float(settings.driving_margin_mps + settings.service_margin_mps)
        self._top_mps = 1.0
        self._looks_s = 0.0  # of what is further ahead at top speed all the way the first alone is looked at
        self._fastest_mps: NDArray[np.float64] = np.zeros(1)

    def take_up(self, mission: Mission) -> None:
        """Another path; what of a crossing is under the train and not on this path stays under it."""
        before, was = self._on_path, self._mission
        self._mission = mission
        self._behind.clear()
        self._predicted.clear()
        if not self._by_radio:
            return
        self._fastest_mps = self._pace.driving_mps + self._beyond_mps
        self._top_mps = max(float(self._fastest_mps.max()), 1.0)
        brakes_s = self._room_s(self._top_mps)
        warns_s = (max(each.warning_s, each.closing_s + brakes_s) for each in self._by_radio)
        self._looks_s = max(HELD_FROM_S, max(warns_s) + EARLY_S)
        path, starts_m = mission.path, [span.start_m for span in mission.spans]
        marks_m = [target.mark_m for target in mission.targets]
        found: list[CrossingOnPath] = []
        for crossing in self._by_radio:
            if crossing.piece_id not in path or not _is_asked(crossing, mission, was):
                continue
            start_m = path.to_road_m(crossing)
            span, stop = bisect_right(starts_m, start_m) - 1, bisect_right(marks_m, start_m) - 1
            found.append(CrossingOnPath(crossing, start_m, start_m + crossing.width_m, span, stop))
        known = {one.crossing.id for one in found}
        if was is not None:
            turned = was.path.direction is not path.direction
            found += [self._under(one, turned=turned) for one in before if one.crossing.id not in known]
        kept = (one for one in found if one.crossing.id in known or one.end_m > self._rear_m())
        self._on_path = tuple(sorted(kept, key=lambda one: one.start_m))
        self._starts_m = {one.crossing.id: one.start_m for one in self._on_path}
        self._front_m = float(self._row.position_m)

    def asks(self, crossing_id: str) -> bool:
        """Whether the unit asks this crossing: not one whose contact its train passes."""
        return crossing_id in self._starts_m

    def _rear_m(self) -> float:
        """The safe rear, m."""
        row = self._row
        return float(row.position_m - row.bound_behind_m) - self._length_m

    def _under(self, one: CrossingOnPath, *, turned: bool) -> CrossingOnPath:
        """A crossing of the path before, by where it lies along the train, in metres of this path."""
        front_m, length_m = float(self._row.position_m), self._length_m
        if turned:
            old_rear_m = self._front_m - length_m
            ends_m = (front_m + old_rear_m - one.end_m, front_m + old_rear_m - one.start_m)
        else:
            ends_m = (one.start_m + front_m - self._front_m, one.end_m + front_m - self._front_m)
        within = ends_m[0] < front_m + float(self._row.bound_ahead_m)
        gone_m = -math.inf
        return CrossingOnPath(one.crossing, ends_m[0], ends_m[1] if within else gone_m, 0, 0)

    def start_m(self, crossing_id: str) -> float:
        """Where the road of a crossing begins on the path, m; infinite: it is none of this path."""
        return self._starts_m.get(crossing_id, math.inf)

    def nearer(self, limit_m: float, crossing_id: str) -> float:
        """The movement limit, m: as it is, or before this crossing if that comes first; empty: before none."""
        return min(limit_m, self.start_m(crossing_id) - STOPS_SHORT_M)

    def clears_at_m(self) -> float:
        """Where the safe rear leaves the first crossing that it has not left, m; infinite: there is none."""
        rear_m = self._rear_m() if self._on_path else math.inf
        for one in self._on_path:
            if one.end_m > rear_m:
                return one.end_m
        return math.inf

    def places(self, load_share: float) -> tuple[CrossingPlace, ...] | None:
        """How the train is to each of them now, up to the first that is far ahead, and once to each that has come to be
        behind it; None: its position is unknown.
        """
        row, mission = self._row, self._mission
        if mission is None or not row.position_known:
            return None
        self._front_m, rear_m = float(row.position_m), self._rear_m()
        found: list[CrossingPlace] = []
        for one in self._on_path:
            crossing_id = one.behind.crossing_id
            if one.end_m <= rear_m:
                if crossing_id not in self._behind:
                    self._behind.add(crossing_id)
                    found.append(one.behind)
                continue
            self._behind.discard(crossing_id)
            found.append(self._place(one, mission, load_share))
            if found[-1].fastest_s > self._looks_s:
                break
        return tuple(found)

    def _place(self, one: CrossingOnPath, mission: Mission, load_share: float) -> CrossingPlace:
        row, position_m = self._row, self._front_m
        ahead_m, behind_m = position_m + float(row.bound_ahead_m), position_m - float(row.bound_behind_m)
        entered, way_m = ahead_m >= one.start_m - STOPS_SHORT_M, one.start_m - ahead_m
        speed_mps, behind = float(row.speed_mps), one.behind
        arrives_s = fastest_s = proof_s = 0.0 if entered else way_m / self._top_mps
        if not entered:
            cruise_mps = min(float(row.cruise_mps), float(row.restricted_mps))
            brakes_s = self._brakes_s(one.start_m, way_m, cruise_mps)
            asked_s = max(behind.warning_s, behind.closing_s + brakes_s) + EARLY_S
            if arrives_s <= asked_s + CLOSELY_S:
                arrives_s = self._arrives_s(
                    one, mission, load_share, ahead_m, self._pace.driving_mps, cruise_mps
                )
            if fastest_s < behind.least_s:
                fastest_s = self._arrives_s(one, mission, load_share, ahead_m, self._fastest_mps, math.inf)
            proof_s = arrives_s - brakes_s
        return msgspec.structs.replace(
            behind,
            stands=speed_mps == 0.0,
            entered=entered,
            arrives_s=arrives_s,
            fastest_s=fastest_s,
            proof_s=proof_s,
            clear=False,
            under=behind_m >= one.start_m,
            beyond=behind_m >= one.end_m,
        )

    def _arrives_s(
        self,
        one: CrossingOnPath,
        mission: Mission,
        load_share: float,
        from_m: float,
        limit_mps: NDArray[np.float64],
        cruise_mps: float,
    ) -> float:
        """Until the front is on the crossing, s, on its run to the next stop behind it."""
        fastest = limit_mps is self._fastest_mps
        speed_mps, key = float(self._row.speed_mps), (one.crossing.id, cruise_mps, fastest)
        known = self._predicted.get(key)
        found_s = None if known is None else known.at(from_m, speed_mps)
        if found_s is not None:
            return found_s
        following = one.stop + 1
        stop_m = mission.targets[following].mark_m if following < len(mission.targets) else math.inf
        stop_m = max(min(stop_m, len(limit_mps) - 1.0), one.start_m)
        found_s = _arrives_s(
            self._train,
            load_share,
            self._pace.climb_m,
            limit_mps,
            max(from_m, 0.0),
            stop_m,
            cruise_mps,
            self._deceleration_mps2,
            speed_mps,
            one.start_m,
        )
        self._predicted[key] = PredictedArrival(found_s, from_m, speed_mps)
        return found_s

    def _brakes_s(self, start_m: float, way_m: float, cruise_mps: float) -> float:
        """How long before the crossing a train at its speed there would begin to brake for it, s."""
        row, pace = self._row, self._pace
        limit_mps = float(pace.driving_mps[min(int(start_m), len(pace.driving_mps) - 1)])
        gained_mps = math.sqrt(float(row.speed_mps) ** 2 + 2.0 * STARTS_MPS2 * max(way_m, 0.0))
        return self._room_s(max(min(limit_mps, cruise_mps, gained_mps), 1.0))

    def _room_s(self, speed_mps: float) -> float:
        """How long before the crossing a train at this speed would begin to brake for it, s."""
        room_m = STOPS_SHORT_M + self._parameters.standoff_m + LIMIT_MARGIN_M + RESERVE_M
        room_m += float(self._row.bound_ahead_m)
        return speed_mps / (2.0 * self._deceleration_mps2) + PATTERN_RESERVE_S + room_m / speed_mps
