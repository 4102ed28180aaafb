"""Where opposing trains of a day meet (行違い), and on which tracks, by the missions that the run draws up."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from network.meets import Meet, Trajectory, meets_of
from network.model import Line
from study.feasibility.finding import PlannedMeet
from study.feasibility.planned import PlannedDay, PlannedTrain


def day_meets(day: PlannedDay) -> tuple[PlannedMeet, ...]:
    """All meets in order of time, each as possible: whether it is follows from what is found out about the two."""
    by_number = {train.number: train for train in day.all()}
    found = meets_of(day.line, [trajectory_of(day.line, train) for train in by_number.values()])
    return tuple(_meets(day.line, by_number, found))


def trajectory_of(line: Line, train: PlannedTrain) -> Trajectory:
    """The train on the train graph, by the kilometrages of the stations where it stops or has a time."""
    corners: list[tuple[float, float, float]] = []
    for stand in train.stands:
        for passing in stand.target.passings:
            corners.append((passing.time_s, passing.time_s, line.stations[passing.station_id].position_m))
        if stand.target.station_id is not None:
            at_m = line.stations[stand.target.station_id].position_m
            corners.append((stand.arrives_s, stand.departs_s, at_m))
    times_s = tuple(time_s for arrives_s, departs_s, _ in corners for time_s in (arrives_s, departs_s))
    positions_m = tuple(at_m for _, _, at_m in corners for _ in range(2))
    return Trajectory(train.number, train.direction, times_s, positions_m)


def _meets(
    line: Line, by_number: Mapping[str, PlannedTrain], found: tuple[Meet, ...]
) -> Iterator[PlannedMeet]:
    for meet in found:
        down, up = by_number[meet.down_train], by_number[meet.up_train]
        sections = _section_at(line, down, meet), _section_at(line, up, meet)
        if None in sections:  # one of them is on another branch at that kilometrage
            continue
        tracks = [_track_name(line, section_id) for section_id in sections]
        stations = {line.sections[section_id].station_id for section_id in sections if section_id is not None}
        station = meet.station
        if station is None and len(stations) == 1 and all(tracks):
            (station,) = stations
        yield PlannedMeet(
            meet.down_train,
            meet.up_train,
            meet.time_s,
            meet.position_m,
            station,
            meet.low_station,
            meet.high_station,
            tracks[0] if station else "",
            tracks[1] if station else "",
        )


def _section_at(line: Line, train: PlannedTrain, meet: Meet) -> str | None:
    """The section in which a train is when it meets; None where it does not come by."""
    if meet.station is not None:
        own = {track.section_id for track in line.stations[meet.station].tracks}
        at_station = next((node.section_id for node in train.nodes if node.section_id in own), None)
        if at_station is not None:
            return at_station
    for step in train.duty.mission.path.steps:
        low_m, high_m = sorted((step.entry_m, step.kilometrage_m(step.end_m)))
        if low_m <= meet.position_m <= high_m:
            return line.pieces[step.piece_id].section_id
    return None


def _track_name(line: Line, section_id: str | None) -> str:
    """The name of a station's track; empty where the section is none."""
    return "" if section_id is None else line.sections[section_id].track or ""
