"""Minimum running times (基準運転時分) of a line for each kind of train, and what a timetable leaves over them.

From station to next station, in both directions, for a train that stops or passes at either end: full power up to the
limits, the planned braking, the scenario's mean load. A train that passes does so in a run from the last stop at full
power, or over the whole line where it passes at both ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

from exchange.running import Running, StationRun
from network.model import Direction, Line, Station
from network.timetable import Call, CallKind, Stabled, TimetableTrain, no_trains
from onboard.mission import Mission, NoWay, plan_mission
from simulation.setup import Setup
from simulation.world.roster import first_section
from study.measures.running_times import RunWay, TrainHop, least_times_s, planned_hops
from study.record.columns import tenth
from vehicle.running_time import laid_down_s
from vehicle.train_file import TrainType

HOW: Final = ("stop_stop_s", "stop_pass_s", "pass_stop_s", "pass_pass_s")
_HOW_OF: Final = dict(zip(((True, True), (True, False), (False, True), (False, False)), HOW, strict=True))


@dataclass(frozen=True, slots=True)
class StandardTime:
    """One leg of the line for one kind of train, s: how the train is at its ends is in the names.

    None: no such run, for trains do not pass where the line ends.
    """

    train: str
    direction: Direction
    from_id: str
    to_id: str
    distance_m: float
    stop_stop_s: float
    stop_pass_s: float | None
    pass_stop_s: float | None
    pass_pass_s: float | None

    def rounded_s(self) -> int | None:
        """The time from stand to stand as it is laid down: the next 5 s up; None where the train cannot climb."""
        return laid_down_s(self.stop_stop_s) if math.isfinite(self.stop_stop_s) else None

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV: times to 0.1 s."""
        times = {name: tenth(getattr(self, name)) for name in HOW}
        return {
            "train": self.train,
            "direction": self.direction.name.lower(),
            "from": self.from_id,
            "to": self.to_id,
            "distance_m": round(self.distance_m, 1),
            **times,
            "rounded_s": self.rounded_s(),
        }


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """One train between two of its times, each at a stop or in passing: what is planned and what it needs, s.

    A stop's time is that of departure, and that of the latest arrival which keeps the next departure.
    """

    number: str
    stock_id: str
    train: str
    direction: Direction
    from_id: str
    to_id: str
    from_kind: CallKind
    to_kind: CallKind
    leaves_s: float
    due_s: float
    least_s: float

    @property
    def planned_s(self) -> float:
        """From one time to the other."""
        return self.due_s - self.leaves_s

    @property
    def margin_s(self) -> float:
        """What the plan leaves (余裕時分); negative where it cannot be kept."""
        return self.planned_s - self.least_s

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV."""
        return {
            "number": self.number,
            "unit": self.stock_id,
            "train": self.train,
            "direction": self.direction.name.lower(),
            "from": self.from_id,
            "to": self.to_id,
            "from_kind": self.from_kind.value,
            "to_kind": self.to_kind.value,
            "leaves_s": self.leaves_s,
            "due_s": self.due_s,
            "planned_s": round(self.planned_s, 1),
            "least_s": tenth(self.least_s),
            "margin_s": tenth(self.margin_s),
            "margin_percent": tenth(100.0 * self.margin_s / self.least_s) if self.least_s > 0.0 else None,
        }


def standard_times(setup: Setup) -> tuple[StandardTime, ...]:
    """Every leg of the line in both directions for every kind of train that runs, in order of travel.

    On the usual tracks of the direction. Nothing for a direction in which the line has no way from end to end.
    """
    kinds = {kind.id: kind for kind in setup.trains.values()}
    return tuple(
        time
        for _, kind in sorted(kinds.items())
        for direction in Direction
        for time in _along(setup, kind, direction)
    )


def least_by_leg(line: Line, kind: TrainType) -> Running:
    """Least running time, s, of a kind of train for any leg of a line, over several stations too; None where no way is.

    With the load and the braking that scenarios have where they say nothing.
    """
    times = standard_times(Setup("", line, no_trains(line, 0.0), {"": kind}))
    onward = {(time.from_id, time.direction): time for time in times}

    def least(leg: StationRun) -> float | None:
        here, total_s = leg.from_id, 0.0
        step_m = line.stations[leg.to_id].position_m - line.stations[leg.from_id].position_m
        direction = Direction.DOWN if step_m > 0 else Direction.UP
        while here != leg.to_id:
            time = onward.get((here, direction))
            if time is None:
                return None
            stands = (leg.from_stand and here == leg.from_id, leg.to_stand and time.to_id == leg.to_id)
            time_s = getattr(time, _HOW_OF[stands])
            if time_s is None or not math.isfinite(time_s):
                return None
            here, total_s = time.to_id, total_s + time_s
        return total_s

    return least


def _along(setup: Setup, kind: TrainType, direction: Direction) -> Iterator[StandardTime]:
    mission = whole_line(setup.line, direction)
    if mission is None:
        return
    places = _places(mission)
    marks_m = [mark_m for _, mark_m in places]
    path, last = mission.path, len(places) - 1

    def times_s(start: int, end: int, passed: Iterable[int] = ()) -> tuple[float, ...]:
        """From a stand at one place to those passed that are asked for, and to a stand at another."""
        way = RunWay(setup.line, path, marks_m[start], marks_m[end])
        driving = setup.driving
        return least_times_s(
            kind,
            way,
            [marks_m[at] for at in passed],
            setup.load.load_share_mean,
            driving.stop_deceleration_mps2,
        )

    through_s = (0.0, *times_s(0, last, range(1, last)))
    for at, ((from_id, from_m), (to_id, to_m)) in enumerate(pairwise(places)):
        passed_s, stands_s = times_s(0, at + 1, (at,)) if at else (0.0, 0.0)
        yield StandardTime(
            kind.id,
            direction,
            from_id,
            to_id,
            to_m - from_m,
            times_s(at, at + 1)[0],
            times_s(at, last, (at + 1,))[0] if at + 1 < last else None,
            stands_s - passed_s if at else None,
            through_s[at + 1] - through_s[at] if at and at + 1 < last else None,
        )


def stations_along(line: Line, direction: Direction) -> list[Station]:
    """Those with a mark for the direction in order of travel, from the first with tracks of its own to the last."""
    found = [
        station
        for station in sorted(line.stations.values(), key=lambda s: s.position_m * direction)
        if any(direction in track.marks_m for track in station.tracks)
    ]
    ends = [i for i, station in enumerate(found) if not station.is_halt]
    return found[ends[0] : ends[-1] + 1] if len(ends) > 1 else []


def whole_line(line: Line, direction: Direction) -> Mission | None:
    """The way of a train over the whole line on its usual tracks, passing everything between its ends.

    None where there is none, or fewer than two stations have a mark for the direction.
    """
    stations = stations_along(line, direction)
    if not stations:
        return None
    kinds = [CallKind.OPERATIONAL, *(CallKind.PASS for _ in stations[1:-1]), CallKind.OPERATIONAL]
    calls = tuple(
        Call(station.id, None, i if kind is not CallKind.PASS else None, i, kind)
        for i, (station, kind) in enumerate(zip(stations, kinds, strict=True))
    )
    train = TimetableTrain("", direction, False, calls, Stabled(), Stabled())
    try:
        return plan_mission(line, train, first_section(line, train), None, None)
    except NoWay:
        return None


def _places(mission: Mission) -> list[tuple[str, float]]:
    first, last = mission.targets[0], mission.targets[-1]
    between = [(passing.station_id, passing.position_m) for passing in last.passings]
    return [(first.station_id or "", first.mark_m), *between, (last.station_id or "", last.mark_m)]


def planned_runs(setup: Setup) -> tuple[PlannedRun, ...]:
    """Every run of the timetable between two times of one train, those of passing too, in order of travel."""
    known: dict[tuple[object, ...], tuple[float, ...]] = {}
    return tuple(run for hop in planned_hops(setup) for run in _runs_of(setup, hop, known))


def _runs_of(
    setup: Setup, hop: TrainHop, known: dict[tuple[object, ...], tuple[float, ...]]
) -> Iterator[PlannedRun]:
    """The parts of a hop, from each of its times to the next."""
    kind, way, passings = setup.trains[hop.stock_id], hop.way(setup.line), hop.there.passings
    passing_m = tuple(passing.position_m for passing in passings)
    key = (kind.id, way.path.piece_ids, way.from_m, way.to_m, passing_m)
    if key not in known:
        load, driving = setup.load.load_share_mean, setup.driving
        known[key] = least_times_s(kind, way, passing_m, load, driving.stop_deceleration_mps2)
    places = [
        (hop.here.station_id or "", hop.here.kind, hop.leaves_s, 0.0),
        *(
            (passing.station_id, CallKind.PASS, passing.time_s, least_s)
            for passing, least_s in zip(passings, known[key], strict=False)
        ),
        (hop.there.station_id or "", hop.there.kind, hop.due_s, known[key][-1]),
    ]
    for (from_id, from_kind, leaves_s, before_s), (to_id, to_kind, at_s, after_s) in pairwise(places):
        yield PlannedRun(
            hop.mission.number,
            hop.stock_id,
            kind.id,
            hop.mission.direction,
            from_id,
            to_id,
            from_kind,
            to_kind,
            leaves_s,
            at_s,
            after_s - before_s,
        )


def smallest_margins(runs: tuple[PlannedRun, ...]) -> dict[tuple[str, Direction, str, str], PlannedRun]:
    """The run with the smallest margin by kind of train, direction and ends."""
    found: dict[tuple[str, Direction, str, str], PlannedRun] = {}
    for run in runs:
        key = (run.train, run.direction, run.from_id, run.to_id)
        if key not in found or run.margin_s < found[key].margin_s:
            found[key] = run
    return found
