"""Branches: stations that trains of a source reach from inside a line, and that are not on it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import takewhile

from exchange.published import PublishedTimetable
from network.making.station_list import ONE_WAY
from network.model import Line


def branches(published: PublishedTimetable, line: Line, ids: Mapping[str, str]) -> Iterator[str]:
    """A sentence for each station where trains leave the line for a branch: which trains, and what can be done.

    `ids`: those of the line's stations by the source's keys.
    """
    by_position = sorted(line.stations.values(), key=lambda station: station.position_m)
    ends = {by_position[0].id, by_position[-1].id}
    names = {station.key: station.name_ja or station.name or station.key for station in published.stations}
    beyond: dict[str, dict[str, None]] = defaultdict(dict)
    trains: dict[str, dict[int, None]] = defaultdict(dict)
    for index, train in enumerate(published.trains):
        keys = [call.station_id for call in train.calls]
        for way in (keys, keys[::-1]):
            off = list(takewhile(lambda key: key not in ids, reversed(way)))
            if off and len(off) < len(way) and (at := ids[way[-len(off) - 1]]) not in ends:
                beyond[at] |= dict.fromkeys(names.get(key, key) for key in off)
                trains[at][index] = None
    for at, stations in beyond.items():
        name = line.stations[at].name or at
        yield (
            f"{name}: a branch leaves the line there, to {', '.join(stations)} ({len(trains[at])} trains). On"
            f" this line these trains begin and end at {name}, which needs a track for each that stands there at a"
            f" time; {ONE_WAY}"
        )
