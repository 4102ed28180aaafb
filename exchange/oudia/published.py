"""One Dia of an OuDia file as a published timetable.

Which train a set runs next is found as OuDiaSecond finds it: at the same station and track the first train that begins
with a set that came as another, not before this one has ended.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

from exchange.oudia.carried import is_ours
from exchange.oudia.cells import AfterTrain, BeforeTrain, CallHandling, OudiaCell, StationOperation, index_of
from exchange.oudia.route import DOWN, OudiaDia, OudiaRoute, OudiaStation, OudiaTrain, left_of
from exchange.published import PublishedStation, PublishedTimetable, PublishedTrain
from network.files.names import title_of
from network.timetable import Call, CallKind

NOT_FOR_PASSENGERS: Final = re.compile(
    r"回送|試運転|配給|工臨|工事|貨物|単機|入換|廃車|not in service|empty|deadhead|freight|trial",
    re.IGNORECASE,
)


def published_of(route: OudiaRoute, dia: OudiaDia) -> PublishedTimetable:
    """One Dia as a published timetable."""
    stations = tuple(
        PublishedStation(str(i), station.name, tracks=station.tracks, usual=_usual(station))
        for i, station in enumerate(route.stations)
    )
    used = [train for train in dia.trains if train.runs and not train.cancelled]
    links = _links(route, used)
    numbers = Counter(train.number for train in used)
    lost = [i for i, after in links.items() if _shared(numbers, used[i]) or _shared(numbers, used[after])]
    links = {i: after for i, after in links.items() if i not in lost}
    trains = tuple(
        _published(route, train, becomes=used[links[i]].number if i in links else "")
        for i, train in enumerate(used)
    )
    title = title_of(" ".join(part for part in (route.name, dia.name) if part))
    left = left_of(dia)
    if lost:
        left = (*left, f"{len(lost)} links between trains that have no number of their own")
    return PublishedTimetable(title, stations, trains, route.file, left)


def _usual(station: OudiaStation) -> dict[str, str]:
    """Names of the main tracks by direction."""
    mains = (("down", station.down_main), ("up", station.up_main))
    return {direction: station.tracks[main] for direction, main in mains if main < len(station.tracks)}


def _shared(numbers: Mapping[str, int], train: OudiaTrain) -> bool:
    """Whether a train's number does not tell it from others."""
    return not train.number or numbers[train.number] > 1


def _links(route: OudiaRoute, trains: Sequence[OudiaTrain]) -> dict[int, int]:
    """Which train each set runs next, by index: first begun at the same station and track, not before it has ended."""
    waiting: dict[tuple[str, int], list[tuple[int, int]]] = {}
    for i, train in enumerate(trains):
        if train.before is not None and train.before.kind == BeforeTrain.JUNCTION.value:
            place, first = _place(route, train, train.first), train.cells[train.first]
            time_s = first.departure_s if first.departure_s is not None else first.arrival_s
            if time_s is not None:
                waiting.setdefault(place, []).append((time_s, i))
    for queue in waiting.values():
        queue.sort()
    ended: list[tuple[int, int, tuple[str, int]]] = []
    for i, train in enumerate(trains):
        if train.after is not None and train.after.kind == AfterTrain.JUNCTION.value:
            last = train.cells[train.last]
            time_s = last.arrival_s if last.arrival_s is not None else last.departure_s
            if time_s is not None:
                ended.append((time_s, i, _place(route, train, train.last)))
    found: dict[int, int] = {}
    for time_s, i, place in sorted(ended):
        queue = waiting.get(place, [])
        following = next((pair for pair in queue if pair[0] >= time_s and pair[1] != i), None)
        if following is None:
            continue
        queue.remove(following)
        found[i] = following[1]
    return found


def _place(route: OudiaRoute, train: OudiaTrain, index: int) -> tuple[str, int]:
    """Station and track of a cell; a station that the route lists twice is one place."""
    station = route.stations_along(train.direction)[index]
    track = train.cells[index].track
    return station.name, station.main(train.direction) if track is None else track


def _published(route: OudiaRoute, train: OudiaTrain, becomes: str) -> PublishedTrain:
    along = route.stations_along(train.direction)
    count = len(route.stations)
    calls: list[Call] = []
    for i, of in enumerate(train.cells):
        if of.how not in (CallHandling.STOP, CallHandling.PASS):
            continue
        index = i if train.direction == DOWN else count - 1 - i
        calls.append(_call(str(index), of, along[i], train.direction))
    beyond_before = train.before is not None and train.before.kind == BeforeTrain.OUTER.value
    beyond_after = train.after is not None and train.after.kind == AfterTrain.OUTER.value
    return PublishedTrain(
        number=train.number,
        direction="down" if train.direction == DOWN else "up",
        calls=tuple(calls),
        name=train.name,
        kind=train.kind,
        becomes=(becomes,) if becomes else (),
        revenue=NOT_FOR_PASSENGERS.search(train.kind) is None,
        comes_from=_outer(along[train.first], train.before) if beyond_before else "",
        goes_to=_outer(along[train.last], train.after) if beyond_after else "",
        said="" if is_ours(train.remark) else train.remark,
    )


def _outer(station: OudiaStation, of: StationOperation | None) -> str:
    """Name of the place beyond a station that an operation names."""
    index = index_of(of.part(0)) if of is not None else 0
    return station.outer[index] if index < len(station.outer) else f"beyond {station.name}"


def _call(key: str, of: OudiaCell, station: OudiaStation, direction: str) -> Call:
    """A call; a train that passes with two times apart stands there (運転停車), which OuDia has no word for."""
    kind = CallKind.STOP
    arrival_s, departure_s = of.arrival_s, of.departure_s
    if of.how is CallHandling.PASS:
        stands = arrival_s is not None and departure_s is not None and arrival_s < departure_s
        kind = CallKind.OPERATIONAL if stands else CallKind.PASS
        if not stands:
            arrival_s, departure_s = None, departure_s if departure_s is not None else arrival_s
    track = None
    if of.track is not None and of.track != station.main(direction):
        track = station.tracks[of.track] if of.track < len(station.tracks) else f"[{of.track}]"
    return Call(key, track, arrival_s, departure_s, kind)
