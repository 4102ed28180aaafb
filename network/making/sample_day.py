"""A small day on a line that was just made: two sets that meet halfway, there and back, and a scenario to run it.

Times are generous, because they are only there so that something runs: by the limits of the line, a quarter more and
75 s for each leg.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from network.errors import COMMAND_LINE, InputError
from network.files.json_input import check_free, write_aside
from network.files.names import IDENTIFIER_HELP, is_identifier
from network.files.toml_text import text_toml
from network.model import Direction, Line, SectionKind, Station
from network.timetable import parse_timetable, time_text

STAND_IN_TRAIN: Final = "br642"
BEGIN_S: Final = 6 * 3600
DWELL_S: Final = 30
MEET_S: Final = 180
TURN_S: Final = 600
_SLACK: Final = 1.25
_START_STOP_S: Final = 75.0
_STEP_M: Final = 50.0
_ROUND_S: Final = 30


@dataclass(frozen=True, slots=True)
class _SampleTrip:
    """One run from end to end, with the time of its first departure."""

    number: str
    stations: Sequence[Station]
    legs_s: Sequence[int]
    waits_at: str
    departs_s: int
    begins: str
    ends: str

    def calls(self) -> Iterator[tuple[Station, int, int]]:
        """Stations with arrival and departure, s."""
        at_s = self.departs_s
        yield self.stations[0], at_s, at_s
        for station, leg_s in zip(self.stations[1:], self.legs_s, strict=True):
            arrives_s = at_s + leg_s
            at_s = arrives_s + (MEET_S if station.id == self.waits_at else DWELL_S)
            yield station, arrives_s, at_s

    @property
    def arrives_s(self) -> int:
        """When it is at the far end."""
        return list(self.calls())[-1][1]

    def at_s(self, station_id: str) -> int:
        """When it arrives at a station, counted from its departure."""
        return next(s for station, s, _ in self.calls() if station.id == station_id) - self.departs_s


def write_sample(line: Line, line_file: Path, scenario_file: Path) -> tuple[Path, Path]:
    """Write timetable and scenario; returns their paths. Raises InputError."""
    timetable_file = sample_timetable(line_file, scenario_file)
    where = Path(os.path.relpath(line_file.resolve(), scenario_file.parent.resolve())).as_posix()
    text = timetable_toml(line, timetable_file.stem)
    parse_timetable(text, str(timetable_file), line)
    write_aside(timetable_file, text)
    write_aside(scenario_file, scenario_toml(line, scenario_file.stem, where, timetable_file.name))
    return timetable_file, scenario_file


def sample_timetable(line_file: Path, scenario_file: Path) -> Path:
    """File of the timetable that goes with a scenario. Raises InputError where the two cannot be written."""
    if scenario_file.suffix != ".toml" or not is_identifier(scenario_file.stem):
        raise InputError(
            COMMAND_LINE, "--scenario", str(scenario_file), f"NAME.toml; NAME: {IDENTIFIER_HELP}"
        )
    timetable_file = scenario_file.with_name(f"{scenario_file.stem}_times.toml")
    if not scenario_file.parent.is_dir():
        raise InputError(str(scenario_file), "", None, "a writable path in an existing folder")
    if line_file.resolve() in (scenario_file.resolve(), timetable_file.resolve()):
        raise InputError(COMMAND_LINE, "--scenario", str(scenario_file), "another name than the line file's")
    for path in (scenario_file, timetable_file):
        check_free(path, "--scenario")
    return timetable_file


def timetable_toml(line: Line, timetable_id: str) -> str:
    """Two sets that meet at the loop nearest the middle; one set, where there is none."""
    trips = _trips(line)
    rows = [
        "[timetable]",
        f'id = "{timetable_id}"',
        f"name = {text_toml(f'A first try of {line.name}'[:200])}",
        f'line = "{line.id}"',
        f"dwell_min_s = {DWELL_S}",
        "assumed = [",
        '  "all times: by the limits of the line, a quarter more and 75 s a leg; made up so that something runs",',
        "]",
    ]
    for trip in trips:
        rows += ["", *_train_toml(trip)]
    for stock, numbers in (("V1", ("1D", "2U")), ("V2", ("4U", "3D"))):
        ours = [trip.number for trip in trips if trip.number in numbers]
        if ours:
            names = ", ".join(f'"{number}"' for number in sorted(ours, key=numbers.index))
            rows += ["", "[[diagrams]]", f'stock = "{stock}"', f"trains = [{names}]"]
    return "\n".join(rows) + "\n"


def scenario_toml(line: Line, scenario_id: str, line_name: str, timetable_name: str) -> str:
    """A scenario with a stand-in train and the shipped scenarios' air."""
    return f"""id = "{scenario_id}"
name = {text_toml(f"A first try of {line.name}"[:200])}
line = {text_toml(line_name)}
timetable = {text_toml(timetable_name)}
seed = 1
assumed = [
  "train: BR 642 as a stand-in, a two-part diesel railcar of 41.7 m",
  "air: telegrams take 0.1 s at least, 0.2 s on average, 1 % are lost; the paper gives no figures",
]

[trains]
default = "{STAND_IN_TRAIN}"

[air]
delay_min_s = 0.1
delay_mean_s = 0.2
loss_good_p = 0.01
"""


def _trips(line: Line) -> tuple[_SampleTrip, ...]:
    stations = sorted(line.stations.values(), key=lambda station: station.position_m)
    legs_s = [_leg_s(line, a, b) for a, b in pairwise(stations)]
    meet = _meeting_place(line, stations, legs_s)

    def trip(number: str, departs_s: int, begins: str, ends: str) -> _SampleTrip:
        down = number.endswith("D")
        order = stations if down else stations[::-1]
        return _SampleTrip(number, order, legs_s if down else legs_s[::-1], meet, departs_s, begins, ends)

    if not meet:
        there = trip("1D", BEGIN_S, "stabled", "becomes:2U")
        return there, trip("2U", there.arrives_s + TURN_S, "from:1D", "stabled")
    down_s, up_s = trip("1D", 0, "", "").at_s(meet), trip("4U", 0, "", "").at_s(meet)
    at_s = BEGIN_S + max(down_s, up_s)
    first = trip("1D", at_s - down_s, "stabled", "becomes:2U")
    other = trip("4U", at_s - up_s, "stabled", "becomes:3D")
    again_s = max(first.arrives_s + up_s, other.arrives_s + down_s) + TURN_S
    back = trip("2U", again_s - up_s, "from:1D", "stabled")
    return first, other, back, trip("3D", again_s - down_s, "from:4U", "stabled")


def _meeting_place(line: Line, stations: Sequence[Station], legs_s: Sequence[int]) -> str:
    """The station inside the line where trains can pass, nearest the middle of the way in time; or none."""
    middle_s = sum(legs_s) / 2.0
    found: list[tuple[float, str]] = []
    for i, station in enumerate(stations[1:-1], start=1):
        tracks = [t for t in station.tracks if line.sections[t.section_id].kind is SectionKind.TRACK]
        usual = [{t.name for t in tracks if d in t.directions} for d in Direction]
        if not station.is_halt and all(usual) and not usual[0] & usual[1]:
            found.append((abs(sum(legs_s[:i]) - middle_s), station.id))
    return min(found, default=(0.0, ""))[1]


def _leg_s(line: Line, low: Station, high: Station) -> int:
    """A running time that any railcar keeps, s."""
    limits = next(iter(line.alignments.values())).limits
    seconds = _START_STOP_S
    at_m = low.position_m
    while at_m < high.position_m:
        step_m = min(_STEP_M, high.position_m - at_m)
        here = [x.speed_mps for x in limits if x.from_m < at_m + step_m and at_m < x.to_m]
        seconds += _SLACK * step_m / min([line.max_speed_mps, *here])
        at_m += step_m
    return _ROUND_S * math.ceil(seconds / _ROUND_S)


def _train_toml(trip: _SampleTrip) -> list[str]:
    direction = "down" if trip.number.endswith("D") else "up"
    rows = [
        "[[trains]]",
        f'number = "{trip.number}"',
        f'direction = "{direction}"',
        f'begins = "{trip.begins}"',
        f'ends = "{trip.ends}"',
        "calls = [",
    ]
    calls = list(trip.calls())
    before_s = trip.departs_s
    for i, (station, arrives_s, departs_s) in enumerate(calls):
        cells = [f'station = "{station.id}"']
        if i:
            cells.append(f'arrival = "{time_text(arrives_s, before_s)}"')
        if i < len(calls) - 1:
            cells.append(f'departure = "{time_text(departs_s)}"')
        before_s = departs_s
        if station.is_signal_station:
            cells.append("operational = true")
        rows.append(f"  {{ {', '.join(cells)} }},")
    return [*rows, "]"]
