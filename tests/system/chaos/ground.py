"""Where cases happen: a scenario without any fault, as the files that make it, and how it runs undisturbed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tests.system.chaos.toml_text import Table


@dataclass(frozen=True, slots=True)
class Ground:
    """`head`: the scenario file's own tables; `files`: text by name of what it needs beside it."""

    id: str
    head: Table
    files: Mapping[str, str] = field(default_factory=dict[str, str])


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a train that is drawn: times in s after midnight, None where it has none."""

    station: str
    track: str
    arrival_s: int | None
    departure_s: int | None


@dataclass(frozen=True, slots=True)
class Planned:
    """A train that is drawn."""

    stock: str
    number: str
    direction: str
    begins: str
    ends: str
    calls: tuple[Call, ...]


def timetable_table(timetable_id: str, line_id: str, trains: list[Planned]) -> dict[str, Any]:
    """The tables of a timetable file."""
    stocks: dict[str, list[str]] = {}
    for train in trains:
        stocks.setdefault(train.stock, []).append(train.number)
    return {
        "timetable": {"id": timetable_id, "name": timetable_id, "line": line_id, "dwell_min_s": 20},
        "trains": [
            {
                "number": train.number,
                "direction": train.direction,
                "begins": train.begins,
                "ends": train.ends,
                "calls": [_call(call) for call in train.calls],
            }
            for train in trains
        ],
        "diagrams": [{"stock": stock, "trains": numbers} for stock, numbers in stocks.items()],
    }


def _call(call: Call) -> dict[str, str]:
    times = {"arrival": call.arrival_s, "departure": call.departure_s}
    return {
        "station": call.station,
        "track": call.track,
        **{name: _clock(time_s) for name, time_s in times.items() if time_s is not None},
    }


def _clock(time_s: int) -> str:
    return f"{time_s // 3600:02d}:{time_s // 60 % 60:02d}:{time_s % 60:02d}"
