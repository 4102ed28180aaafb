"""Timetables of nagix/mini-tokyo-3d (data from ODPT): one JSON file a railway, every train of every calendar in it.

A train has an id `<railway>.<number>.<calendar>`, a direction in words, calls `tt` with times in whole minutes, and
where it is known the stations where it really begins and ends (`os`, `ds`) and the trains that its set runs before and
after (`pt`, `nt`), on this railway or another. What lies beyond the railway is `comes_from` and `goes_to`.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final

import msgspec

from exchange.published import PublishedStation, PublishedTimetable, PublishedTrain, some_names
from exchange.station_order import ordered_stations, runs_down
from network.clock import clock
from network.errors import InputError
from network.files.json_input import read_json
from network.files.names import title_of
from network.files.text_input import JSON_BYTES_MAX, read_bytes
from network.files.toml_input import one_of
from network.timetable import Call

SOURCE: Final = "numbers and times: nagix/mini-tokyo-3d, data from ODPT"
DAY_BEGINS_S: Final = 3 * 3600  # a time before it belongs to the end of the operating day
CALLS_MAX: Final = 500  # of one train, assumed: ten times the longest published
_DAY_S: Final = 86_400
_DOWN: Final = "Outbound"
# Words of the source in either sense; what they mean on a line is found from the order of its stations.
_DIRECTIONS: Final = (
    *(_DOWN, "Inbound", "Northbound", "Southbound", "Eastbound", "Westbound"),
    *("InnerLoop", "OuterLoop", "Clockwise", "Counterclockwise"),
)
_TIME: Final = re.compile(r"([01]\d|2[0-3]):([0-5]\d)")
_DAYS: Final = {"Weekday": "weekdays", "SaturdayHoliday": "weekends and holidays"}
_WORD: Final = re.compile(r"(?<=[a-z])(?=[A-Z])")
_OUDIA: Final = b"FileType=OuDia"
_FORM: Final = "a file of mini-tokyo-3d's train-timetables: a JSON array of trains, each with id, n, d and tt"


class _CallRow(msgspec.Struct):
    s: str
    a: str | None = None
    d: str | None = None


class _TrainRow(msgspec.Struct):
    id: str
    n: str
    d: str
    tt: list[_CallRow]
    r: str = ""
    y: str = ""
    os: list[str] = []
    ds: list[str] = []
    pt: list[str] = []
    nt: list[str] = []

    @property
    def calendar(self) -> str:
        """Weekday, SaturdayHoliday, ..."""
        return self.id.rpartition(".")[2]

    @property
    def railway(self) -> str:
        """Of `r`, or of the station that it first calls at."""
        return self.r or (self.tt[0].s.rpartition(".")[0] if self.tt else "")


class _StationRow(msgspec.Struct):
    id: str
    title: dict[str, str] = {}


def read_mini_tokyo(
    source: Path, calendar: str, stations: Path | None = None, railway: str = ""
) -> PublishedTimetable:
    """The trains of one calendar (`Weekday`, `SaturdayHoliday`, ...), in the order of the file.

    `stations` is the source's file of stations, which has their names; without it they are made from the ids. `railway`
    is needed where the file holds several. Raises InputError.
    """
    file = str(source)
    _check_form(source)
    rows = list(enumerate(read_json(source, list[_TrainRow])))
    railways = sorted({row.railway for _, row in rows})
    if railway or len(railways) > 1:
        if railway not in railways:
            raise InputError(file, "r", railway or None, f"one railway, {one_of(railways, railway)}")
        rows = [(index, row) for index, row in rows if row.railway == railway]
    ours = [(index, row) for index, row in rows if row.calendar == calendar]
    if not ours:
        known = sorted({row.calendar for _, row in rows})
        raise InputError(file, "id", calendar, f"a calendar that is in it: {', '.join(known)}")
    for index, row in ours:
        _check(file, f"[{index}]", row)
    left = [f"{len(rows) - len(ours)} trains of other calendars"] if len(ours) < len(rows) else []
    twice = [row for _, row in ours if len({call.s for call in row.tt}) < len(row.tt)]
    if twice:
        left.append(f"trains that come twice to one station: {some_names([row.n for row in twice])}")
    kept = [(index, row) for index, row in ours if row not in twice]
    if not kept:
        raise InputError(file, "tt", None, "a train that comes to no station twice")
    order = ordered_stations(([call.s for call in row.tt], row.d == _DOWN) for _, row in kept)
    numbers = _numbers(file, kept)
    places = {station: i for i, station in enumerate(order)}
    trains = tuple(_train(file, f"[{index}]", row, places, numbers) for index, row in kept)
    name = (railway or railways[0]).rpartition(".")[2]
    title = f"{' '.join(_WORD.split(name))} Line, {_DAYS.get(calendar, calendar)}"
    return PublishedTimetable(title_of(title), _stations(order, stations), trains, file, tuple(left))


def _check_form(source: Path) -> None:
    """A file of another program is named as such, whatever its encoding. Raises InputError."""
    begins = read_bytes(source, JSON_BYTES_MAX).removeprefix(codecs.BOM_UTF8).lstrip()[: len(_OUDIA)]
    if begins == _OUDIA:
        raise InputError(str(source), "", None, f"{_FORM}; this is one of OuDia, for branchline import oudia")
    if begins.startswith(b"{"):
        raise InputError(str(source), "", None, f"{_FORM}; this is one JSON object")


def _check(file: str, key: str, row: _TrainRow) -> None:
    if not row.n.strip():
        raise InputError(file, f"{key}.n", row.n, "a train number")
    if row.d not in _DIRECTIONS:
        raise InputError(file, f"{key}.d", row.d, f"one of {', '.join(_DIRECTIONS)}")
    if not 2 <= len(row.tt) <= CALLS_MAX:
        raise InputError(file, f"{key}.tt", len(row.tt), f"2 to {CALLS_MAX} calls")


def _stations(order: Sequence[str], file: Path | None) -> tuple[PublishedStation, ...]:
    """Names from the source's file of stations, or from ids: `KazusaKameyama` is Kazusa-Kameyama."""
    titles: dict[str, Mapping[str, str]] = {}
    if file is not None:
        titles = {row.id: row.title for row in read_json(file, list[_StationRow])}
        if not any(key in titles for key in order):
            raise InputError(str(file), "id", None, f"stations of the timetable, such as {order[0]}")
    return tuple(
        PublishedStation(
            key,
            title_of(titles.get(key, {}).get("en") or "-".join(_WORD.split(key.rpartition(".")[2]))),
            title_of(titles.get(key, {}).get("ja", "")),
        )
        for key in order
    )


def _numbers(file: str, rows: Iterable[tuple[int, _TrainRow]]) -> dict[str, str]:
    """Numbers by id; of trains with the same one on a day the second is ...-2."""
    numbers: dict[str, str] = {}
    names: set[str] = set()
    for index, row in rows:
        if row.id in numbers:
            raise InputError(file, f"[{index}].id", row.id, "an id of its own")
        name, again = row.n, 1
        while name in names:
            again += 1
            name = f"{row.n}-{again}"
        names.add(name)
        numbers[row.id] = name
    return numbers


def _train(
    file: str, key: str, row: _TrainRow, places: Mapping[str, int], numbers: Mapping[str, str]
) -> PublishedTrain:
    down = runs_down([call.s for call in row.tt], places, says_down=row.d == _DOWN)
    return PublishedTrain(
        number=numbers[row.id],
        direction="down" if down else "up",
        calls=_calls(file, key, row.tt),
        kind=row.y.rpartition(".")[2],
        follows=tuple(numbers[train] for train in row.pt if train in numbers),
        becomes=tuple(numbers[train] for train in row.nt if train in numbers),
        comes_from=_beyond(row.os, row.pt, row, places, numbers),
        goes_to=_beyond(row.ds, row.nt, row, places, numbers),
    )


def _beyond(
    ends: Iterable[str],
    links: Iterable[str],
    row: _TrainRow,
    places: Mapping[str, int],
    numbers: Mapping[str, str],
) -> str:
    """A place beyond the railway where a train begins or ends, or that a train of another railway comes from."""
    away = [
        station for station in ends if station not in places and station.rpartition(".")[0] != row.railway
    ]
    trains = [train for train in links if train not in numbers and not train.startswith(f"{row.railway}.")]
    return next(iter((*away, *trains)), "")


def _calls(file: str, key: str, rows: Sequence[_CallRow]) -> tuple[Call, ...]:
    """Calls in order of time: what is over 12 h less than the time before it is of the next day."""
    calls: list[Call] = []
    last_s: int | None = None
    for i, row in enumerate(rows):
        if row.a is None and row.d is None:
            raise InputError(file, f"{key}.tt[{i}].a", None, "an arrival or a departure")
        times: dict[str, int | None] = {}
        for what, text in (("a", row.a), ("d", row.d)):
            times[what] = None
            if text is not None:
                times[what] = last_s = _seconds(file, f"{key}.tt[{i}].{what}", text, last_s)
        calls.append(Call(row.s, None, times["a"], times["d"]))
    return tuple(calls)


def _seconds(file: str, key: str, text: str, last_s: int | None) -> int:
    """Seconds after the midnight before the operating day."""
    match = _TIME.fullmatch(text)
    if match is None:
        raise InputError(file, key, text, "a time HH:MM")
    time_s = int(match[1]) * 3600 + int(match[2]) * 60
    if last_s is None:
        return time_s + _DAY_S if time_s < DAY_BEGINS_S else time_s
    while time_s < last_s - _DAY_S // 2:
        time_s += _DAY_S
    if time_s < last_s:
        raise InputError(file, key, text, f"a time not before {clock(last_s)[:-3]}")
    return time_s
