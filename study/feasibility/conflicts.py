"""What two trains want of one section at a time, as one finding a pair: by what they do there and where they meet."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

from network.clock import clock
from network.model import Line, SectionKind
from study.feasibility.finding import (
    Finding,
    FindingKind,
    PlannedMeet,
    Severity,
    length_of_time,
    minute,
    severity_of,
)
from study.feasibility.holdings import Hold, HoldingConflict
from study.feasibility.places import (
    free_track,
    has_two_tracks,
    is_end,
    station_of,
    track_place,
    where_to_pass,
)
from study.feasibility.planned import PlannedTrain

Pair = frozenset[str]
# What follows from how a run gives sections, not from the plan's own times: the trains may still make it.
BY_BLOCKS: Final = (
    FindingKind.FOLLOWING,
    FindingKind.CROSSING,
    FindingKind.COMING_IN,
    FindingKind.PORTAL,
    FindingKind.TRACK,
    FindingKind.TERMINAL,
)


def pairs_of(clashes: Sequence[HoldingConflict]) -> dict[Pair, list[HoldingConflict]]:
    """Clashes by the numbers of the two trains, the longest wait first."""
    pairs: dict[Pair, list[HoldingConflict]] = {}
    for clash in clashes:
        pairs.setdefault(frozenset(train.number for train in clash.trains), []).append(clash)
    for found in pairs.values():
        found.sort(key=lambda clash: -clash.wait_s)
    return pairs


def severity(clash: HoldingConflict) -> Severity:
    """Whether the second train could wait that long."""
    times_s = [time_s for train in clash.trains for time_s in _given_s(train)]
    first, second = clash.trains
    whole = all(t % 60 == 0 for t in _given_s(first)) or all(t % 60 == 0 for t in _given_s(second))
    return severity_of(clash.wait_s, *([] if whole else times_s))


def on_paper(found: Sequence[HoldingConflict]) -> bool:
    """Whether two trains would stand on one track at once by the plan's own times, whatever a run makes of them."""
    return any(c.together_s > 0.0 and severity_of(c.together_s) is not Severity.TIGHT for c in found)


def _given_s(train: PlannedTrain) -> list[int]:
    """All times that the plan gives for a train."""
    calls = train.duty.train.calls
    return [time_s for call in calls for time_s in (call.arrival_s, call.departure_s) if time_s is not None]


def conflicts_of(
    line: Line,
    pairs: Mapping[Pair, list[HoldingConflict]],
    meets: Mapping[Pair, PlannedMeet],
    by_section: Mapping[str, list[Hold]],
) -> list[Finding]:
    """One finding a pair of trains."""
    return [_finding(line, found, meets.get(pair), by_section) for pair, found in pairs.items()]


def _finding(
    line: Line,
    found: Sequence[HoldingConflict],
    meet: PlannedMeet | None,
    by_section: Mapping[str, list[Hold]],
) -> Finding:
    portal = next((c for c in found if _kind_of(line, c) is SectionKind.PORTAL), None)
    between = next((c for c in found if _kind_of(line, c) is SectionKind.BETWEEN), None)
    worst = found[0]
    if portal is not None:
        return _one_after_another(FindingKind.PORTAL, portal)
    first, second = worst.trains
    opposing = first.direction is not second.direction
    if meet is not None and opposing:
        station = line.stations.get(meet.station or "")
        if station is None or not has_two_tracks(station):
            return _meeting(line, worst, meet)
        return _on_track(line, _on_a_track(line, found, station.id) or worst, by_section)
    if between is not None and (severity(between) is not Severity.TIGHT or between is worst):
        return _one_after_another(FindingKind.OPPOSING if opposing else FindingKind.FOLLOWING, between)
    if _kind_of(line, worst) is SectionKind.TRACK:
        return _on_track(line, worst, by_section)
    return _one_after_another(FindingKind.CROSSING, worst)


def _kind_of(line: Line, clash: HoldingConflict) -> SectionKind:
    return line.sections[clash.section_id].kind


def _on_a_track(line: Line, found: Sequence[HoldingConflict], station_id: str) -> HoldingConflict | None:
    """The clash on a track of that station, if there is one."""
    for clash in found:
        station = station_of(line, clash.section_id)
        if _kind_of(line, clash) is SectionKind.TRACK and station is not None and station.id == station_id:
            return clash
    return None


def _numbers(*trains: PlannedTrain) -> tuple[str, ...]:
    return tuple(train.number for train in trains)


def _short(clash: HoldingConflict) -> float | None:
    return clash.wait_s if math.isfinite(clash.wait_s) else None


def _until(time_s: float) -> str:
    if not math.isfinite(time_s):
        return "the end of the day"
    return clock(math.ceil(time_s)) if time_s % 60 else minute(time_s)


def _later(clash: HoldingConflict, what: str) -> str:
    """The remedy of waiting, where there is an end to it."""
    if not math.isfinite(clash.wait_s):
        return "one of them needs another track, or has to leave first"
    return f"{what} {length_of_time(clash.wait_s)} later, at {_until(clash.first.to_s)}"


def _meeting(line: Line, clash: HoldingConflict, meet: PlannedMeet) -> Finding:
    """They meet where there are no two tracks for them."""
    at = line.stations.get(meet.station or "")
    low, high = (line.stations.get(name or "") for name in (meet.low, meet.high))
    if at is not None:
        where, place = f"at {at.name}", at.id
        why = "a halt has no second track" if at.is_halt else "it has one track"
    elif low is None or high is None:
        end = low or high
        where = f"beyond {end.name}" if end is not None else "on the line"
        place, why = clash.section_id, "the line is single there"
    else:
        where, place = f"between {low.name} and {high.name}", f"{low.id}-{high.id}"
        why = "the line is single there"
    trains = (meet.down_train, meet.up_train)
    text = f"{trains[0]} and {trains[1]} would meet {where} at {minute(meet.time_s)}: {why}"
    remedy = where_to_pass(line, meet.position_m, None if at is None else at.id)
    return Finding(
        FindingKind.OPPOSING, severity(clash), trains, place, meet.time_s, text, remedy, _short(clash)
    )


def _on_track(line: Line, clash: HoldingConflict, by_section: Mapping[str, list[Hold]]) -> Finding:
    """A train is to come to a track, or to leave for it, that another still has."""
    first, second = clash.trains
    place, track = track_place(line, clash.section_id)
    kind = FindingKind.TERMINAL if is_end(line, place) else FindingKind.TRACK
    time_s = max(clash.second.arrives_s, clash.first.from_s)
    if not math.isfinite(time_s):
        time_s = clash.begins_s
    if not math.isfinite(clash.second.from_s):
        text = (
            f"the sets of {first.number} and {second.number} are both to stand on {track} before they begin"
        )
    elif math.isfinite(clash.first.to_s):
        text = (
            f"{second.number} is to come to {track} at {minute(time_s)}, and needs it from"
            f" {_until(clash.begins_s)}; {first.number} has it until {_until(clash.first.to_s)}"
        )
    else:
        text = f"{second.number} is to come to {track} at {minute(time_s)}, where the set of {first.number} stays"
    other = free_track(line, clash, by_section)
    remedy = f"track {other} is free then" if other else _later(clash, f"{second.number} leaves for it")
    trains = _numbers(first, second)
    return Finding(kind, severity(clash), trains, place, time_s, text, remedy, _short(clash))


# Of two trains that want a section at a time: how it is said, and what the second does later.
WAITS: Final = {
    FindingKind.OPPOSING: (  # they do not quite meet on paper
        "{second} is to leave at {begins} into {section}, where {first} comes the other way until {until}",
        "leaves",
    ),
    FindingKind.FOLLOWING: (
        "{second} is to follow {first} at {begins} into {section}, which is taken until {until}",
        "leaves",
    ),
    FindingKind.CROSSING: (
        "{second} is to go over the points of {section} from {begins}; {first} has them until {until}",
        "goes",
    ),
    FindingKind.PORTAL: (
        "{second} needs the portal {section} from {begins}, and {first} is in it until {until}",
        "goes",
    ),
}


def _one_after_another(kind: FindingKind, clash: HoldingConflict) -> Finding:
    (first, second), (text, does) = clash.trains, WAITS[kind]
    if kind is FindingKind.PORTAL and second.duty.enters:
        does = "comes"
    begins, until, section = _until(clash.begins_s), _until(clash.first.to_s), clash.section_id
    text = text.format(first=first.number, second=second.number, begins=begins, until=until, section=section)
    trains, remedy = _numbers(first, second), _later(clash, f"{second.number} {does}")
    return Finding(kind, severity(clash), trains, section, clash.begins_s, text, remedy, _short(clash))
