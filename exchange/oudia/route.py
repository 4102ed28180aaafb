"""What an OuDia file holds: its route (路線) with stations, their tracks, and each of its Dia with its trains.

Stations are listed from the route's beginning; trains of Kudari run along the list, those of Nobori against it, and the
cells of a train follow the way that it runs. Older files keep tracks and operations elsewhere; all come out the same.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from exchange.oudia.cells import (
    AfterTrain,
    BeforeTrain,
    CallHandling,
    OudiaCell,
    StationOperation,
    cell,
    index_of,
    operating_day,
    operation,
    seconds,
)
from exchange.oudia.nodes import OudiaNode, OudiaText
from network.clock import clock
from network.errors import InputError

DOWN: Final = "Kudari"
UP: Final = "Nobori"
# OuDiaSecond.1.01 to 1.05: tracks in a value of their own, counted from 1
_OLD_TRACKS_MINOR: Final = range(1, 6)
# 1.06 to 1.09: no code that links a set going in with one coming out
_OLD_OPERATIONS_MINOR: Final = range(6, 10)


@dataclass(frozen=True, slots=True)
class OudiaStation:
    """A station: its name, the names of its tracks, the indices of the main ones, and places beyond it."""

    name: str
    tracks: tuple[str, ...]
    down_main: int
    up_main: int
    outer: tuple[str, ...]

    def main(self, direction: str) -> int:
        """Index of the track that trains take of which nothing else is said."""
        return self.down_main if direction == DOWN else self.up_main


@dataclass(frozen=True, slots=True)
class OudiaTrain:
    """A train: `cells` by station in the order in which it runs, from the first of the route in its direction.

    Times are s after the midnight before the operating day. `before`, `after`: how its set begins and ends; `number`
    the one that the file has, empty if none.
    """

    direction: str
    kind: str
    number: str
    name: str
    remark: str
    cells: tuple[OudiaCell, ...]
    before: StationOperation | None
    after: StationOperation | None
    cancelled: bool
    others: int  # operations on the way, such as shunting or coupling

    @property
    def first(self) -> int:
        """Index of the cell at which it begins."""
        return next(i for i, of in enumerate(self.cells) if of.how in (CallHandling.STOP, CallHandling.PASS))

    @property
    def last(self) -> int:
        """Index of the cell at which it ends."""
        return max(i for i, of in enumerate(self.cells) if of.how in (CallHandling.STOP, CallHandling.PASS))

    @property
    def runs(self) -> bool:
        """Whether it is at any station."""
        return any(of.how in (CallHandling.STOP, CallHandling.PASS) for of in self.cells)


@dataclass(frozen=True, slots=True)
class OudiaDia:
    """One timetable of a file."""

    name: str
    trains: tuple[OudiaTrain, ...]


@dataclass(frozen=True, slots=True)
class OudiaRoute:
    """All that a file holds of its route (路線)."""

    file: str
    kind: str  # its FileType
    name: str
    comment: str
    stations: tuple[OudiaStation, ...]
    dias: tuple[OudiaDia, ...]

    def dia(self, name: str | None) -> OudiaDia:
        """The Dia of that name; without one, the only one. Raises InputError, which names all."""
        names = [dia.name for dia in self.dias]
        if name is None and len(names) == 1:
            return self.dias[0]
        found = [dia for dia in self.dias if dia.name == name]
        if len(found) != 1:
            raise InputError(
                self.file, "Dia", name, f"one of its names (--dia): {', '.join(map(repr, names))}"
            )
        return found[0]

    def stations_along(self, direction: str) -> tuple[OudiaStation, ...]:
        """Stations in the order in which trains of a direction run."""
        return self.stations if direction == DOWN else self.stations[::-1]


def route_of(text: OudiaText, file: str) -> OudiaRoute:
    """What a file holds. Raises InputError for a file without stations or Dia, and for times that are none."""
    rosen = text.root.node("Rosen")
    if rosen is None:
        raise InputError(file, "Rosen", None, "a route, which is missing")
    if text.root.node("DispProp") is None:
        raise InputError(file, "DispProp", None, "the display settings at its end: is the file cut off?")
    stations = tuple(_station(node) for node in rosen.nodes("Eki"))
    if not stations:
        raise InputError(file, "Rosen.Eki", None, "stations, of which there are none")
    kinds = [node.text("Syubetsumei") for node in rosen.nodes("Ressyasyubetsu")]
    nodes = rosen.nodes("Dia")
    if not nodes:
        raise InputError(file, "Rosen.Dia", None, "at least one timetable (Dia)")
    reader = _TrainReader(file, text, stations, kinds)
    names = [node.text("DiaName") or str(i) for i, node in enumerate(nodes, start=1)]
    dias = tuple(
        OudiaDia(name, tuple(reader.trains(node, name))) for name, node in zip(names, nodes, strict=True)
    )
    kind = text.root.text("FileType")
    return OudiaRoute(file, kind, rosen.text("Rosenmei"), rosen.text("Comment"), stations, dias)


def summary_of(dia: OudiaDia) -> dict[str, Any]:
    """For reports: trains by direction, when the first begins and the last ends, passings, and what is left out."""
    used = [train for train in dia.trains if train.runs and not train.cancelled]
    cells = [of for train in used for of in train.cells]
    times = [time_s for of in cells for time_s in (of.arrival_s, of.departure_s) if time_s is not None]
    return {
        "name": dia.name,
        "trains": len(dia.trains),
        "down": sum(train.direction == DOWN for train in dia.trains),
        "up": sum(train.direction == UP for train in dia.trains),
        "first": clock(min(times)) if times else "",
        "last": clock(max(times)) if times else "",
        "calls": sum(of.how is CallHandling.STOP for of in cells),
        "passings": sum(of.how is CallHandling.PASS for of in cells),
        "without_number": sum(not train.number for train in dia.trains),
        "left": list(left_of(dia)),
    }


def left_of(dia: OudiaDia) -> tuple[str, ...]:
    """What the file says of a Dia's trains that our timetables have no place for."""
    counts = (
        (sum(train.cancelled for train in dia.trains), "trains that are cancelled (運休)"),
        (sum(not train.runs for train in dia.trains), "trains that are at no station"),
        (sum(bool(train.name) for train in dia.trains), "names of trains (列車名)"),
        (
            sum(train.others for train in dia.trains),
            "operations on the way (shunting, coupling, change of number)",
        ),
    )
    return tuple(f"{what}: {count}" for count, what in counts if count)


def _station(node: OudiaNode) -> OudiaStation:
    cont = node.node("EkiTrack2Cont")
    tracks = tuple(track.text("TrackName") for track in cont.nodes("EkiTrack2")) if cont is not None else ()
    outer = tuple(
        item.text("OuterTerminalEkimei")
        for item in node.nodes("OuterTerminal")
        if item.text("OuterTerminalEkimei")
    )
    # A file without tracks has two of OuDiaSecond's own, the first for down trains.
    down, up = (
        index_of(node.text(key), default) for key, default in (("DownMain", 0), ("UpMain", 0 if cont else 1))
    )
    return OudiaStation(node.text("Ekimei"), tracks, down, up, outer)


@dataclass(frozen=True, slots=True)
class _TrainReader:
    """Reads trains of a file: its generation tells where tracks and operations stand."""

    file: str
    text: OudiaText
    stations: tuple[OudiaStation, ...]
    kinds: Sequence[str]

    def trains(self, dia: OudiaNode, name: str) -> Iterator[OudiaTrain]:
        """Trains of a Dia, down ones first; nodes without a direction are empty columns."""
        for direction in (DOWN, UP):
            container = dia.node(direction)
            if container is None:
                raise InputError(
                    self.file, f"Dia {name!r}", None, f"{direction}, its trains of that direction"
                )
            for node in container.nodes("Ressya"):
                if node.text("Houkou") in (DOWN, UP):
                    yield self._train(node, node.text("Houkou"), name)

    def _train(self, node: OudiaNode, direction: str, dia: str) -> OudiaTrain:
        number = node.text("Ressyabangou")
        key = f"Dia {dia!r}, train {number or '-'} (line {node.line})"
        cells = self._cells(node, key, direction)
        runs = [i for i, of in enumerate(cells) if of.how in (CallHandling.STOP, CallHandling.PASS)]
        before = after = None
        others = 0
        for entry in node.items:
            if isinstance(entry, OudiaNode) or not re.fullmatch(r"Operation\d+[AB]", entry.key):
                continue
            at, side = int(entry.key[9:-1]), entry.key[-1]
            found = [self._operation(key, entry.key, part) for part in entry.value.split(",") if part]
            if (
                found
                and runs
                and side == "B"
                and at == runs[0]
                and found[0].kind in {e.value for e in BeforeTrain}
            ):
                before = found.pop(0)
            elif (
                found
                and runs
                and side == "A"
                and at == runs[-1]
                and found[-1].kind in {e.value for e in AfterTrain}
            ):
                after = found.pop()
            others += len(found)
        index = index_of(node.text("Syubetsu"))
        kind = self.kinds[index] if index < len(self.kinds) else ""
        name = " ".join(part for part in (node.text("Ressyamei"), node.text("Gousuu")) if part)
        cancelled = node.text("Canceled") == "1"
        remark = node.text("Bikou")
        arrived = _arrival_beyond(before)
        if arrived is not None and cells[runs[0]].arrival_s is None:
            cells = _with_arrival(cells, runs[0], arrived)
        return OudiaTrain(direction, kind, number, name, remark, cells, before, after, cancelled, others)

    def _cells(self, node: OudiaNode, key: str, direction: str) -> tuple[OudiaCell, ...]:
        texts = node.text("EkiJikoku").split(",")
        along = self.stations if direction == DOWN else self.stations[::-1]
        if len(texts) > len(along):
            raise InputError(self.file, key, f"{len(texts)} in EkiJikoku", f"at most {len(along)} stations")
        cells: list[OudiaCell] = []
        for text, station in zip(texts, along, strict=False):
            try:
                cells.append(cell(text))
            except ValueError as error:
                expected = "how;arrival/departure$track with times HHMM or HHMMSS, such as 1;1005/1006$0"
                raise InputError(self.file, f"{key}, {station.name}", text, expected) from error
        if self.text.second and self.text.minor in _OLD_TRACKS_MINOR:
            cells = _with_old_tracks(cells, node.text("RessyaTrack"))
        times = operating_day([time_s for of in cells for time_s in (of.arrival_s, of.departure_s)])
        return tuple(
            replace(of, arrival_s=arrival_s, departure_s=departure_s)
            for of, arrival_s, departure_s in zip(cells, times[::2], times[1::2], strict=True)
        )

    def _operation(self, key: str, name: str, text: str) -> StationOperation:
        try:
            found = operation(text)
        except ValueError as error:
            raise InputError(
                self.file, f"{key}, {name}", text, "a kind of operation, 0 to 6, and its parts"
            ) from error
        if self.text.minor in _OLD_OPERATIONS_MINOR and found.kind in (3, 4, 5):
            return _of_today(found, before=name.endswith("B"))
        return found


def _of_today(old: StationOperation, *, before: bool) -> StationOperation:
    """An operation of FileType 1.06 to 1.09 in the parts that later files have: the set's number moved."""
    if not before:
        return old
    match old.kind:
        case 3:  # time $ number
            return StationOperation(3, (old.part(0), "", old.part(1)))
        case 4:  # place $ time / arrival $ number
            return StationOperation(4, (old.part(0), old.part(1), old.part(2), "", old.part(3)))
        case _:  # time $ hidden / number
            return StationOperation(5, (old.part(0), old.part(2)))


def _with_old_tracks(cells: Sequence[OudiaCell], text: str) -> list[OudiaCell]:
    """Tracks of FileType 1.01 to 1.05: 0 for the main one, then from 1."""
    found = list(cells)
    for i, part in enumerate(text.split(",")[: len(found)]):
        number = index_of(part.partition(";")[0])
        if number and found[i].how in (CallHandling.STOP, CallHandling.PASS):
            found[i] = replace(found[i], track=number - 1)
    return found


def _arrival_beyond(before: StationOperation | None) -> int | None:
    """When a set from beyond arrives at the first station, s after midnight; OuDiaSecond 2 keeps it there."""
    if before is None or before.kind != BeforeTrain.OUTER.value:
        return None
    try:
        return seconds(before.part(2))
    except ValueError:
        return None


def _with_arrival(cells: Sequence[OudiaCell], index: int, arrival_s: int) -> tuple[OudiaCell, ...]:
    """Cells with an arrival at one of them, on the day of its departure."""
    leaves_s = cells[index].departure_s
    if leaves_s is None:
        return tuple(cells)
    arrives_s = leaves_s - (leaves_s - arrival_s) % 86_400
    if leaves_s - arrives_s > 12 * 3600:
        return tuple(cells)
    return (*cells[:index], replace(cells[index], arrival_s=arrives_s), *cells[index + 1 :])
