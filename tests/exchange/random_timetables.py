"""Timetables drawn at random on a line: sets that come in, turn, stand over and go out, with calls of every kind."""

import math
from dataclasses import dataclass
from itertools import pairwise

from hypothesis import strategies as st

from exchange.portals import PortalWay, portal_of
from network.files.quantities import SPEED
from network.files.timetable_schema import CallTable, DiagramTable, HeadTable, TimetableFile, TrainTable
from network.model import Direction, Line, Station
from network.timetable import Timetable, time_text, timetable_of

_LAST_BEGIN_S = 29 * 3600
_FASTEST_MPS = SPEED.spans[-1][1] / 3.6


@dataclass
class _Set:
    """A set as it goes through its day: where it stands, on which track, since when."""

    name: str
    place: str
    time_s: int
    fastest_mps: float
    track: str | None = None


_WAYS: dict[tuple[str, str, Direction, bool], PortalWay | None] = {}


def _portal(line: Line, station_id: str, direction: Direction, *, entering: bool) -> PortalWay | None:
    """As `portal_of`, looked for once: a timetable is drawn in no time then."""
    key = (line.id, station_id, direction, entering)
    if key not in _WAYS:
        _WAYS[key] = portal_of(line, station_id, direction, entering=entering)
    return _WAYS[key]


def _ends(line: Line, direction: Direction) -> list[Station]:
    """Stations with tracks of their own, along a direction."""
    places = [station for station in line.stations.values() if not station.is_halt]
    return sorted(places, key=lambda station: station.position_m * direction)


def _clock(draw: st.DrawFn, least_s: int) -> int:
    """A time not before another, mostly in whole minutes."""
    time_s = least_s + draw(st.integers(0, 1500))
    return time_s if draw(st.integers(0, 3)) == 0 else math.ceil(time_s / 60) * 60


@st.composite
def timetables(draw: st.DrawFn, line: Line, fastest_mps: float = _FASTEST_MPS) -> Timetable:
    """A valid timetable of a line; no train runs faster than `fastest_mps`."""
    trains: list[TrainTable] = []
    diagrams: list[DiagramTable] = []
    for i in range(draw(st.integers(1, 3))):
        own = _Set(f"S{i}", "", draw(st.integers(0, 26 * 3600)), fastest_mps)
        own.time_s = math.ceil(own.time_s / 60) * 60
        found = _day(draw, line, own, len(trains))
        if found:
            trains += found
            diagrams.append(DiagramTable(stock=own.name, trains=[train.number for train in found]))
    if not trains:
        found = _day(draw, line, _Set("S9", "", 5 * 3600, fastest_mps), 0)
        trains, diagrams = found, [DiagramTable(stock="S9", trains=[train.number for train in found])]
    head = HeadTable(
        id="drawn",
        name=draw(st.sampled_from(["", "Weekdays", "平日\\休日", 'as "run"', "as run"])),
        line=line.id,
        dwell_min_s=draw(st.sampled_from([0.0, 20.0, 12.5])),
        sources=draw(st.lists(st.sampled_from(["a\nb", "C:\\data", "十ソ表"]), max_size=2)),
        assumed=draw(st.lists(st.sampled_from(["x = 1", "[trains]", "#", "\\n"]), max_size=2)),
    )
    file = TimetableFile(timetable=head, trains=trains, diagrams=diagrams)
    return timetable_of(file, "drawn", line)


def _day(draw: st.DrawFn, line: Line, own: _Set, number: int) -> list[TrainTable]:
    """The trains of one set, each beginning as the one before it ended."""
    found: list[TrainTable] = []
    begins = ""
    for _ in range(draw(st.integers(1, 4))):
        if own.time_s > _LAST_BEGIN_S:
            break
        train = _train(draw, line, own, f"{number + len(found)}M", begins)
        found.append(train)
        begins = {"s": "stabled", "p": "portal", "b": f"from:{train.number}"}[train.ends[0]]
        if train.ends == "becomes":
            begins = f"from:{train.number}"
    if found and found[-1].ends == "becomes":
        found[-1] = found[-1].model_copy(update={"ends": "stabled"})
    ended = [
        train.model_copy(update={"ends": f"becomes:{after.number}"}) if train.ends == "becomes" else train
        for train, after in pairwise(found)
    ]
    return [*ended, *found[-1:]]


def _train(draw: st.DrawFn, line: Line, own: _Set, number: str, begins: str) -> TrainTable:
    inside = bool(own.place) and begins != "portal"
    ways: list[tuple[Direction, int]] = []
    for direction in Direction:
        places = _ends(line, direction)
        for i, place in enumerate(places[:-1]):
            if inside and place.id != own.place:
                continue
            if begins == "portal" and _portal(line, place.id, direction, entering=True) is None:
                continue
            ways.append((direction, i))
    direction, first = draw(st.sampled_from(ways))
    places = _ends(line, direction)
    start = places[first]
    goal = draw(st.sampled_from(places[first + 1 :]))
    if not begins:
        way = _portal(line, start.id, direction, entering=True)
        begins = draw(st.sampled_from(["stabled", *([f"portal:{way.section_id}"] if way else [])]))
    elif begins == "portal":
        way = _portal(line, start.id, direction, entering=True)
        assert way is not None
        begins = f"portal:{way.section_id}"
    revenue = draw(st.booleans())
    calls = _calls(draw, line, own, direction, (start, goal), revenue=revenue, keep=inside)
    way = _portal(line, goal.id, direction, entering=False)
    ends = draw(st.sampled_from(["stabled", "becomes", *([f"portal:{way.section_id}"] if way else [])]))
    if ends == "becomes" and not _may_turn(line, goal, own.track):
        ends = "stabled"
    own.place = goal.id
    name: str = "down" if direction is Direction.DOWN else "up"
    return TrainTable.model_validate(
        {
            "number": number,
            "direction": name,
            "revenue": revenue,
            "begins": begins,
            "ends": ends,
            "calls": [call.model_dump(by_alias=True) for call in calls],
        }
    )


def _may_turn(line: Line, place: Station, track: str | None) -> bool:
    """Whether a set that stands at a place can leave again: some direction has a mark on its track."""
    tracks = [one for one in place.tracks if track in (None, one.name)]
    return bool(tracks) and all(len(one.marks_m) == 2 for one in tracks)


def _calls(
    draw: st.DrawFn,
    line: Line,
    own: _Set,
    direction: Direction,
    run: tuple[Station, Station],
    *,
    revenue: bool,
    keep: bool,
) -> list[CallTable]:
    start, goal = run
    between = [
        station
        for station in sorted(line.stations.values(), key=lambda station: station.position_m * direction)
        if start.position_m * direction <= station.position_m * direction <= goal.position_m * direction
        and any(direction in track.marks_m for track in station.tracks)
    ]
    calls: list[CallTable] = []
    at_m, time_s = start.position_m, own.time_s
    for station in between:
        end = station in run
        kind = "stop" if end else draw(st.sampled_from(["none", "stop", "pass", "operational"]))
        if kind == "none":
            continue
        usable = [track for track in station.tracks if direction in track.marks_m]
        track = draw(st.sampled_from([None, *(track.name for track in usable)]))
        if station is start and keep and own.track is not None and track is not None:
            track = own.track if any(one.name == own.track for one in usable) else None
        if kind == "stop" and (not revenue or any(one.platform_m is None for one in usable)):
            kind = draw(st.sampled_from(["stop", "operational"])) if not revenue else "operational"
        least_s = time_s + (math.ceil(abs(station.position_m - at_m) / own.fastest_mps) + 1 if calls else 0)
        arrives_s = _clock(draw, least_s)
        leaves_s = _clock(draw, arrives_s) if draw(st.booleans()) else arrives_s
        last = station is goal
        table: dict[str, object] = {
            "station": station.id,
            "track": track,
            "operational": kind == "operational",
            "inferred": draw(st.booleans()),
        }
        if kind == "pass":
            table["pass"], leaves_s = time_text(arrives_s), arrives_s
        else:
            if last or draw(st.booleans()):
                table["arrival"] = time_text(arrives_s)
            if not last or draw(st.booleans()):
                table["departure"] = time_text(leaves_s)
            elif "departure" not in table:
                leaves_s = arrives_s
        calls.append(CallTable.model_validate(table))
        at_m, time_s = station.position_m, leaves_s
        if last:
            own.track = track
    own.time_s = time_s + 60 * draw(st.integers(0, 200))
    return calls
