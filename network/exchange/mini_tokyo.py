"""Import of a day's timetable from nagix/mini-tokyo-3d (data from ODPT), for a line with one junction.

Numbers, times and what lies beyond the junction are facts of the source. How train sets go round is not in it
and is assembled here: at a station where trains turn back, the set that has stood longest leaves first; sets
that leave over a portal come back first in, first out after `outside_min_s` at least. Workings that the
source lacks but the day needs (回送, empty) are part of the plan and marked as assumed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import msgspec

from network.errors import InputError
from network.files.json_input import read_json, write_aside
from network.files.names import IDENTIFIER_HELP, is_identifier

SOURCE: Final = "numbers and times: nagix/mini-tokyo-3d, data from ODPT"
DAY_BEGINS_S: Final = 3 * 3600  # a time before it belongs to the end of the operating day
_DIRECTIONS: Final = {"Outbound": "down", "Inbound": "up"}
_TIME: Final = re.compile(r"([01]\d|2[0-3]):([0-5]\d)")


class _CallRow(msgspec.Struct):
    s: str
    a: str | None = None
    d: str | None = None


class _TrainRow(msgspec.Struct):
    id: str
    n: str
    d: str
    tt: list[_CallRow]
    os: list[str] = []
    ds: list[str] = []
    pt: list[str] = []


@dataclass(frozen=True, slots=True)
class ImportedCall:
    """A call with its times as written, HH:MM."""

    station_id: str
    arrival: str | None = None
    departure: str | None = None

    def time_s(self) -> int:
        """Departure, or arrival where there is none, seconds after the midnight before the operating day."""
        hours, minutes = (self.departure or self.arrival or "00:00").split(":")
        seconds = int(hours) * 3600 + int(minutes) * 60
        return seconds + 86_400 if seconds < DAY_BEGINS_S else seconds


@dataclass(frozen=True, slots=True)
class ImportedTrain:
    """A train; `begins` and `ends` as the timetable file writes them, empty until the sets are assembled."""

    number: str
    direction: str
    calls: tuple[ImportedCall, ...]
    begins: str = ""
    ends: str = ""
    revenue: bool = True

    def begins_s(self) -> int:
        """Time of the first call, s."""
        return self.calls[0].time_s()

    def ends_s(self) -> int:
        """Time of the last call, s."""
        return self.calls[-1].time_s()


@dataclass(frozen=True, slots=True)
class ImportPlan:
    """What the source does not say about a line: names, portals, sets, and the workings that are missing."""

    line_id: str
    source_prefix: str  # of the ids of stations on the line
    stations: Mapping[str, str]  # name in the source, without prefix: id on the line
    enter_portal: str
    leave_portal: str
    stock: tuple[str, ...]
    extra: tuple[ImportedTrain, ...] = ()
    assumed: tuple[str, ...] = ()
    dwell_min_s: int = 20
    outside_min_s: int = 1800


KARASUYAMA: Final = ImportPlan(
    line_id="karasuyama",
    source_prefix="JR-East.Karasuyama.",
    stations={
        "Hoshakuji": "HSK",
        "ShimotsukeHanaoka": "SHN",
        "Niita": "NIT",
        "Konoyama": "KNY",
        "Ogane": "OGN",
        "Kobana": "KBN",
        "Taki": "TAK",
        "Karasuyama": "KRS",
    },
    enter_portal="HSK.MD",
    leave_portal="HSK.MU",
    stock=("V1", "V2", "V3", "V4"),
    extra=(
        ImportedTrain(
            number="E346M",
            direction="up",
            calls=(
                ImportedCall("KRS", departure="22:15"),
                ImportedCall("OGN", "22:26", "22:27"),
                ImportedCall("HSK", "22:48", "22:49"),
            ),
            ends="portal:HSK.MU",
            revenue=False,
        ),
    ),
    assumed=(
        "train E346M (回346M, empty): 345M and 347M both end at Karasuyama, whose one track holds one train, "
        "and no later train leaves it; one set stands there in the morning, so 345M's must go back empty",
        "dwell: 20 s at least, because the source gives whole minutes",
    ),
)


def import_timetable(
    source_file: Path, out_file: Path, calendar: str, plan: ImportPlan = KARASUYAMA
) -> tuple[ImportedTrain, ...]:
    """`branchline import timetable`: write the timetable file of a day (`Weekday`, `SaturdayHoliday`).

    Returns its trains in order of time. Raises InputError for input that does not fit the plan.
    """
    trains = turn_round(read_trains(source_file, calendar, plan))
    diagrams = assemble(str(source_file), trains, plan)
    write_aside(out_file, timetable_toml(calendar, trains, diagrams, plan))
    return trains


def read_trains(source_file: Path, calendar: str, plan: ImportPlan) -> tuple[ImportedTrain, ...]:
    """Trains of one calendar with the plan's extra ones, in order of time; sets not yet assembled."""
    rows = read_json(source_file, list[_TrainRow])
    trains = [
        _train(str(source_file), f"[{index}]", row, plan)
        for index, row in enumerate(rows)
        if row.id.rpartition(".")[2] == calendar
    ]
    if not trains:
        known = sorted({row.id.rpartition(".")[2] for row in rows})
        raise InputError(str(source_file), "id", calendar, f"a calendar that is in it: {', '.join(known)}")
    return tuple(sorted((*trains, *plan.extra), key=lambda train: (train.begins_s(), train.number)))


def turn_round(trains: Sequence[ImportedTrain]) -> tuple[ImportedTrain, ...]:
    """Fill in how trains begin and end where they turn back (折返し), the set that stood longest first.

    A train that finds no set begins stabled, a set that is not called for ends stabled. Trains that come from
    or go to another line have their portal already.
    """
    by_number = {train.number: train for train in trains}
    standing: dict[str, list[str]] = {}
    # a set that arrives in the minute in which another leaves was there in time
    events = [(train.ends_s(), 0, train.number) for train in trains if not train.ends]
    events += [(train.begins_s(), 1, train.number) for train in trains if not train.begins]
    for _, leaves, number in sorted(events):
        train = by_number[number]
        if not leaves:
            standing.setdefault(train.calls[-1].station_id, []).append(number)
            by_number[number] = replace(train, ends="stabled")
            continue
        waiting = standing.get(train.calls[0].station_id, [])
        if not waiting:
            by_number[number] = replace(train, begins="stabled")
            continue
        arrived = waiting.pop(0)
        by_number[arrived] = replace(by_number[arrived], ends=f"becomes:{number}")
        by_number[number] = replace(train, begins=f"from:{arrived}")
    return tuple(by_number[train.number] for train in trains)


def assemble(
    file: str, trains: Sequence[ImportedTrain], plan: ImportPlan
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Diagrams (運用): stock id and its trains in order. Raises InputError when the sets do not suffice.

    Sets that stand on the line in the morning come first in the plan's stock; the others wait outside.
    """
    by_number = {train.number: train for train in trains}
    diagrams: dict[str, list[str]] = {}
    free = list(plan.stock)
    for train in trains:
        if train.begins == "stabled":
            if not free:
                raise InputError(file, "", None, f"a day that {len(plan.stock)} sets can run")
            diagrams[free.pop(0)] = _chain(train, by_number)
    outside = [(-plan.outside_min_s, name) for name in free]
    outside += [(_back_s(numbers, by_number), name) for name, numbers in diagrams.items()]
    for train in trains:
        if not train.begins.startswith("portal:"):
            continue
        waiting = [item for item in outside if item[0] + plan.outside_min_s <= train.begins_s()]
        if not waiting:
            expected = f"a day that {len(plan.stock)} sets can run: none is free for {train.number}"
            raise InputError(file, "", None, expected)
        longest = min(waiting, key=lambda item: item[0])
        outside.remove(longest)
        numbers = _chain(train, by_number)
        diagrams.setdefault(longest[1], []).extend(numbers)
        outside.append((_back_s(numbers, by_number), longest[1]))
    return tuple((name, tuple(diagrams[name])) for name in plan.stock if name in diagrams)


def timetable_toml(
    calendar: str,
    trains: Iterable[ImportedTrain],
    diagrams: Iterable[tuple[str, tuple[str, ...]]],
    plan: ImportPlan,
) -> str:
    """The timetable file."""
    day, days = ("weekday", "weekdays") if calendar == "Weekday" else ("holiday", "weekends and holidays")
    assumed = (
        *plan.assumed,
        "diagrams: sets turn back and come back from the portal first in, first out, "
        f"at least {plan.outside_min_s // 60} min outside the line",
    )
    rows = [
        "[timetable]",
        f'id = "{plan.line_id}_{day}"',
        f'name = "{plan.line_id.capitalize()} Line, {days}"',
        f'line = "{plan.line_id}"',
        f"dwell_min_s = {plan.dwell_min_s}",
        f'sources = ["{SOURCE}"]',
        "assumed = [",
        *(f'  "{text}",' for text in assumed),
        "]",
    ]
    for train in trains:
        rows += ["", *_train_toml(train)]
    for stock, numbers in diagrams:
        names = ", ".join(f'"{number}"' for number in numbers)
        rows += ["", "[[diagrams]]", f'stock = "{stock}"', f"trains = [{names}]"]
    return "\n".join(rows) + "\n"


def _train_toml(train: ImportedTrain) -> list[str]:
    rows = ["[[trains]]", f'number = "{train.number}"', f'direction = "{train.direction}"']
    if not train.revenue:
        rows.append("revenue = false")
    rows += [f'begins = "{train.begins}"', f'ends = "{train.ends}"', "calls = ["]
    for call in train.calls:
        times = [("arrival", call.arrival), ("departure", call.departure)]
        written = "".join(f', {name} = "{time}"' for name, time in times if time)
        rows.append(f'  {{ station = "{call.station_id}"{written} }},')
    return [*rows, "]"]


def _train(file: str, key: str, row: _TrainRow, plan: ImportPlan) -> ImportedTrain:
    if not is_identifier(row.n):
        raise InputError(file, f"{key}.n", row.n, IDENTIFIER_HELP)
    if row.d not in _DIRECTIONS:
        raise InputError(file, f"{key}.d", row.d, f"one of {', '.join(_DIRECTIONS)}")
    if len(row.tt) < 2:
        raise InputError(file, f"{key}.tt", len(row.tt), "two or more calls")
    calls = tuple(_call(file, f"{key}.tt[{i}]", call, plan) for i, call in enumerate(row.tt))
    direction = _DIRECTIONS[row.d]
    beyond = any(not name.startswith(plan.source_prefix) for name in (*row.os, *row.pt))
    begins = f"portal:{plan.enter_portal}" if direction == "down" and beyond else ""
    away = any(not name.startswith(plan.source_prefix) for name in row.ds)
    ends = f"portal:{plan.leave_portal}" if direction == "up" and away else ""
    return ImportedTrain(row.n, direction, calls, begins, ends)


def _call(file: str, key: str, row: _CallRow, plan: ImportPlan) -> ImportedCall:
    name = row.s.removeprefix(plan.source_prefix)
    if name not in plan.stations:
        raise InputError(file, f"{key}.s", row.s, f"a station of {plan.line_id}: {', '.join(plan.stations)}")
    for what, time in (("a", row.a), ("d", row.d)):
        if time is not None and not _TIME.fullmatch(time):
            raise InputError(file, f"{key}.{what}", time, "a time HH:MM")
    if row.a is None and row.d is None:
        raise InputError(file, f"{key}.a", None, "an arrival or a departure")
    return ImportedCall(plan.stations[name], row.a, row.d)


def _chain(train: ImportedTrain, by_number: Mapping[str, ImportedTrain]) -> list[str]:
    """Numbers of a train and of those its set becomes without leaving the line."""
    numbers = [train.number]
    while by_number[numbers[-1]].ends.startswith("becomes:"):
        numbers.append(by_number[numbers[-1]].ends.removeprefix("becomes:"))
    return numbers


def _back_s(numbers: Sequence[str], by_number: Mapping[str, ImportedTrain]) -> int:
    """When a set is outside the line after these trains; never, where it ends the day on the line."""
    last = by_number[numbers[-1]]
    return last.ends_s() if last.ends.startswith("portal:") else 10**9
