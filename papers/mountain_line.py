"""A mountain line of 88.5 km, generated: for experiments that need more curves and stretches than a shipped line has.

It is drawn from a seed within figures that are each stated with their reason (`ASSUMED`), laid out as `branchline new
line` lays a line out, and read by the project's own file reader. Every station has a main track and a loop; 200 check
points lie where the beacons of a train stop lie.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from network.files.line_file import line_of
from network.files.line_schema import LineFile
from network.files.toml_input import validate
from network.making.layout import LayoutRule, LineLayout, lay_out
from network.making.line_text import LineHeader, line_toml
from network.making.station_list import StationRow, listed_stations
from network.model import Alignment, Curve, Direction, Gradient, Line, SpeedLimit
from network.path import Path
from network.timetable import Timetable, parse_timetable
from papers.reproduction import Parameter
from radio.chance import generator

FILE: Final = "mountain line"  # in errors
LENGTH_M: Final = 88_500.0
STATIONS: Final = 12
STATION_SPREAD_M: Final = 900.0
CHECK_POINTS: Final = 200
MAX_SPEED_KMH: Final = 95.0
TRAIN_LENGTH_M: Final = 42.0
RADII_M: Final = (250.0, 300.0, 350.0, 400.0, 500.0, 600.0, 800.0)
RADIUS_SHARES: Final = (0.12, 0.26, 0.12, 0.22, 0.12, 0.10, 0.06)
CANT_MAX_MM: Final = 105.0
TRANSITION_M: Final = (40.0, 100.0)
CIRCLE_M: Final = (40.0, 250.0)
STRAIGHT_LEAST_M: Final = 25.0
STRAIGHT_MEAN_M: Final = 130.0
LONG_SHARE: Final = 0.07
LONG_M: Final = (600.0, 1600.0)
AROUND_STATION_M: Final = 260.0
FIRST_STRAIGHT_M: Final = 900.0  # out of the first station: a train gathers speed past figure 1's beacons
GRADIENT_PERMILLE: Final = 25.0
TUNNEL_SHARE: Final = 0.2
TUNNEL_M: Final = (120.0, 1400.0)
LEAST_APART_M: Final = 12.0
WINDOW_LEAST_M: Final = 10.0  # 3.2
WINDOW_MOST_M: Final = 60.0  # table 1
# Beacons about a station, m from its place: of starting, home and distant signals, for both directions.
ABOUT_STATION_M: Final = (
    -1075.0, -1055.0, -860.0, -275.0, -255.0, -120.0, 90.0, 110.0, 255.0, 275.0, 860.0, 1055.0, 1075.0,
)  # fmt: skip
# After the first station those of figure 1: A, X (which nobody goes by), B, C, and one more; m from its place.
FIRST_M: Final = 90.0
X_BEFORE_B_M: Final = 70.0
FIGURE_1_M: Final = {"A": 255.0, "X": 695.0 - X_BEFORE_B_M, "B": 695.0, "C": 1295.0, "D": 1815.0}

ASSUMED: Final = (
    Parameter("length", LENGTH_M / 1000.0, "km", "section 4: from the first mark to the last"),
    Parameter("check points", CHECK_POINTS, "", "section 4: ATS beacons passed"),
    Parameter("stations", STATIONS, "", "assumed: a passing loop every 8 km, as on single-track trunk lines"),
    Parameter(
        "radii",
        "250 to 800",
        "m",
        "assumed: a narrow-gauge line in the mountains; 300 and 400 are most usual",
    ),
    Parameter(
        "cant", "up to 105", "mm", "customary greatest of 1067 mm gauge; 8.4 V^2 / R at the curve's limit"
    ),
    Parameter(
        "transitions",
        "40 to 100",
        "m",
        "the longer of 0.4 m and 0.009 m per km/h for each mm of cant, as is customary; cut to the range",
    ),
    Parameter(
        "straights",
        f"{STRAIGHT_LEAST_M:g} and on average {STRAIGHT_MEAN_M:g} more",
        "m",
        f"assumed; {LONG_SHARE:.0%} are {LONG_M[0]:g} to {LONG_M[1]:g}: valley floors",
    ),
    Parameter("limits of curves", "3.7 sqrt(R)", "km/h", "customary basic speeds, to the nearest 5 km/h"),
    Parameter("gradients", "up to 25", "permille", "customary greatest of such lines; level at stations"),
    Parameter("tunnels", TUNNEL_SHARE, "share", "assumed: the paper's are many (1)"),
    Parameter(
        "loops",
        "4 m beside the main track, legs of 60 m",
        "",
        "assumed: as those of the project's other lines",
    ),
)


@dataclass(frozen=True, slots=True)
class MountainLine:
    """The line as it was read, its tables, and the path along its main tracks (DOWN)."""

    line: Line
    tables: dict[str, Any]
    station_ids: tuple[str, ...]
    places_m: tuple[float, ...]

    @property
    def alignment(self) -> Alignment:
        """Its one axis."""
        return next(iter(self.line.alignments.values()))

    def timetable(self, over_loops: Sequence[str] = (), average_kmh: float = 90.0) -> Timetable:
        """One train that passes all stations but the ends, over the loops of those named."""
        return timetable_of_one(self.line, self.station_ids, over_loops, average_kmh)

    def with_tables(self, **changed: Any) -> MountainLine:  # noqa: ANN401 - tables of a line file
        """The same line with some of its tables replaced."""
        tables = self.tables | changed
        return MountainLine(read(tables), tables, self.station_ids, self.places_m)


def mountain_line(seed: int = 1, stations: int = STATIONS) -> MountainLine:
    """The line of a seed. With fewer stations it is its beginning, with as much fewer check points: for slices."""
    places_m = _places_m(generator(seed, "mountain line", "stations"))[:stations]
    check_points = CHECK_POINTS * (stations - 1) // (STATIONS - 1)
    rng = generator(seed, "mountain line")
    ids = tuple(f"M{number:02d}" for number in range(1, stations + 1))
    rule = LayoutRule(TRAIN_LENGTH_M, MAX_SPEED_KMH / 3.6)
    layout = lay_out(FILE, [*listed_stations(FILE, [_row(name) for name in ids])], places_m, rule)
    words = LineHeader(
        "mountain", "A mountain line", "", MAX_SPEED_KMH, (), ("everything: it is generated",), ()
    )
    tables = tomllib.loads(line_toml(words, _alignment(rng, layout, places_m), layout, rule))
    tables["tags"] = []
    tables["alignments"][0]["tunnels"] = list(_tunnels(seed, places_m))
    bare = MountainLine(read(tables), tables, ids, tuple(places_m))
    path = main_path(bare.line, bare.timetable())
    at_m = _check_points_m(generator(seed, "mountain line", "beacons"), places_m, check_points)
    windows_m = windows_of(at_m)
    on_track = [_on_track(path, bare.line, place_m) for place_m in at_m]
    return bare.with_tables(
        tags=[
            where | {"id": 1000 + i, "purpose": "position", "directions": ["down"]}
            for i, where in enumerate(on_track)
        ],
        beacons=[
            where | {"id": 5000 + i, "directions": ["down"]} | _database(windows_m.get(i))
            for i, where in enumerate(on_track)
        ],
    )


def read(tables: dict[str, Any]) -> Line:
    """The line of a file's tables, by the reader of line files."""
    return line_of(validate(tables, FILE, LineFile), FILE)


def main_path(line: Line, timetable: Timetable) -> Path:
    """The path of the timetable's one train."""
    from simulation.world.roster import draw_up

    return next(iter(draw_up(line, timetable, {STOCK_ID: TRAIN_LENGTH_M}, 0.0).values()))[0].mission.path


STOCK_ID: Final = "M1"
TRAIN_NUMBER: Final = "1D"


def timetable_of_one(
    line: Line, station_ids: Sequence[str], over_loops: Sequence[str] = (), average_kmh: float = 90.0
) -> Timetable:
    """One train that passes all stations but the ends; so fast on average that it runs as fast as it may."""
    first_m = line.stations[station_ids[0]].position_m
    rows: list[str] = []
    for name in station_ids:
        after_s = (line.stations[name].position_m - first_m) / average_kmh * 3.6
        at_s = 36_000 + round(after_s)
        clock = f"{at_s // 3600:02d}:{at_s // 60 % 60:02d}:{at_s % 60:02d}"
        key = "departure" if name == station_ids[0] else "arrival" if name == station_ids[-1] else "pass"
        track = "2" if name in over_loops else "1"
        rows.append(f'  {{ station = "{name}", track = "{track}", {key} = "{clock}" }},')
    text = "\n".join(
        (
            f'[timetable]\nid = "one"\nname = "One train"\nline = "{line.id}"\ndwell_min_s = 20',
            'sources = ["made for the experiment"]',
            f'[[trains]]\nnumber = "{TRAIN_NUMBER}"\ndirection = "down"\nbegins = "stabled"\nends = "stabled"',
            "calls = [",
            *rows,
            "]",
            f'[[diagrams]]\nstock = "{STOCK_ID}"\ntrains = ["{TRAIN_NUMBER}"]',
        )
    )
    return parse_timetable(text, FILE, line)


# what is drawn ------------------------------------------------------------------------------------------------------


def _places_m(rng: np.random.Generator) -> list[float]:
    """Kilometrages of the stations, about evenly."""
    even = np.linspace(0.0, LENGTH_M, STATIONS)
    even[1:-1] += rng.uniform(-STATION_SPREAD_M, STATION_SPREAD_M, STATIONS - 2)
    return [round(float(place_m)) * 1.0 for place_m in even]


def _row(name: str) -> StationRow:
    """A main track on the axis that points lead to when normal, and a loop 4 m to its right."""
    return StationRow(id=name, name=f"Station {name}", tracks=2, normal="1", spacing_m=4.0)


def limit_kmh(radius_m: float) -> float:
    """Greatest speed in a curve."""
    return min(5.0 * round(3.7 * math.sqrt(radius_m) / 5.0), MAX_SPEED_KMH)


def transition_m(radius_m: float) -> tuple[float, float]:
    """Length of a curve's transitions (m), and its cant (mm)."""
    speed_kmh = limit_kmh(radius_m)
    cant_mm = min(8.4 * speed_kmh**2 / radius_m, CANT_MAX_MM)
    wanted_m = max(0.4 * cant_mm, 0.009 * cant_mm * speed_kmh)
    return round(min(max(wanted_m, TRANSITION_M[0]), TRANSITION_M[1])), round(cant_mm)


def _curves(rng: np.random.Generator, from_m: float, to_m: float) -> Iterator[Curve]:
    """Curves and straights in turn between two stations."""
    at_m, side = from_m, float(rng.choice((-1.0, 1.0)))
    while True:
        straight_m = STRAIGHT_LEAST_M + float(rng.exponential(STRAIGHT_MEAN_M))
        if rng.uniform() < LONG_SHARE:
            straight_m = float(rng.uniform(*LONG_M))
        radius_m = float(rng.choice(RADII_M, p=RADIUS_SHARES))
        along_m, cant_mm = transition_m(radius_m)
        length_m = 2.0 * along_m + float(rng.uniform(*CIRCLE_M))
        side = -side if rng.uniform() < 0.7 else side  # assumed: a valley winds to and fro
        begin_m = round(at_m + straight_m, 3)
        if begin_m + length_m > to_m:
            return
        at_m = round(begin_m + length_m, 3)
        yield Curve(begin_m, at_m, side * radius_m, along_m, cant_mm)


def _alignment(rng: np.random.Generator, layout: LineLayout, places_m: Sequence[float]) -> Alignment:
    """Axis, curves with their limits, gradients, tunnels."""
    curves: list[Curve] = []
    gradients: list[Gradient] = []
    level_m = AROUND_STATION_M
    gradients.append(Gradient(layout.from_m, places_m[0] + level_m, 0.0))
    for low_m, high_m in pairwise(places_m):
        from_m, to_m = low_m + level_m, high_m - level_m
        curves += _curves(rng, from_m if curves else low_m + FIRST_STRAIGHT_M, to_m)
        gradients += _gradients(rng, from_m, to_m)
        gradients.append(Gradient(to_m, min(high_m + level_m, layout.to_m), 0.0))
    limits = tuple(
        SpeedLimit(c.from_m, c.to_m, limit_kmh(abs(c.radius_m)) / 3.6, (Direction.DOWN, Direction.UP))
        for c in curves
        if limit_kmh(abs(c.radius_m)) < MAX_SPEED_KMH
    )
    return Alignment(
        "main", layout.from_m, layout.to_m, 0.0, 0.0, 30.0, 200.0, tuple(gradients), tuple(curves), limits, ()
    )


def _gradients(rng: np.random.Generator, from_m: float, to_m: float) -> Iterator[Gradient]:
    """Stretches of 300 to 1500 m, each of a gradient of its own."""
    at_m = from_m
    while at_m < to_m:
        end_m = min(round(at_m + float(rng.uniform(300.0, 1500.0))) * 1.0, to_m)
        end_m = to_m if to_m - end_m < 300.0 else end_m
        yield Gradient(at_m, end_m, round(float(rng.uniform(-GRADIENT_PERMILLE, GRADIENT_PERMILLE))) * 1.0)
        at_m = end_m


def _tunnels(seed: int, places_m: Sequence[float]) -> Iterator[dict[str, float]]:
    """Where no sky is seen, drawn so that they take up their share of the line."""
    rng = generator(seed, "mountain line", "tunnels")
    at_m, end_m = places_m[0] + AROUND_STATION_M, places_m[-1] - AROUND_STATION_M
    while True:
        length_m = float(rng.uniform(*TUNNEL_M))
        at_m += float(rng.exponential(length_m * (1.0 - TUNNEL_SHARE) / TUNNEL_SHARE))
        if at_m + length_m > end_m:
            return
        yield {"from_km": round(at_m) / 1000.0, "to_km": round(at_m + length_m) / 1000.0}
        at_m += length_m


def _check_points_m(rng: np.random.Generator, places_m: Sequence[float], count: int) -> list[float]:
    """Kilometrages of check points: figure 1's, those of the stations, and others between until there are enough."""
    first_m, last_m = places_m[0], places_m[-1]
    free_from_m = first_m + max(FIGURE_1_M.values()) + 300.0
    found = [first_m + FIRST_M, *(first_m + away_m for away_m in FIGURE_1_M.values())]
    about = (place_m + away_m for place_m in places_m[1:] for away_m in ABOUT_STATION_M)
    found += [at_m for at_m in about if free_from_m < at_m < last_m]
    found = sorted(found)[:count]
    while len(found) < count:
        at_m = round(float(rng.uniform(free_from_m, last_m - 150.0)), 1)
        if min(abs(at_m - other_m) for other_m in found) >= LEAST_APART_M:
            found.append(at_m)
    return sorted(found)


def windows_of(at_m: Sequence[float]) -> dict[int, float]:
    """The beacons that a database goes by (使用地上子), by number, with how far either way they are looked for, m.

    As in table 1 a tenth of the interval, to 5 m, and no other beacon lies in it: beside others it is narrower, and a
    beacon that would have less than 10 m is none of them.
    """
    found: dict[int, float] = {}
    last_m = at_m[0] - FIRST_M + TRAIN_LENGTH_M / 2.0
    for i, here_m in enumerate(at_m):
        near_m = min(abs(other_m - here_m) for k, other_m in enumerate(at_m) if k != i)
        window_m = 5.0 * math.floor(min(0.1 * (here_m - last_m), WINDOW_MOST_M, near_m - 1.0) / 5.0)
        if window_m >= WINDOW_LEAST_M and here_m != at_m[0] - FIRST_M + FIGURE_1_M["X"]:
            found[i], last_m = window_m, here_m
    return found


def _database(window_m: float | None) -> dict[str, Any]:
    return {"used": False} if window_m is None else {"used": True, "window_m": window_m}


def _on_track(path: Path, line: Line, kilometrage_m: float) -> dict[str, Any]:
    """Where a kilometrage lies on the main tracks, as a line file says it."""
    piece_id = next(
        step.piece_id for step in path.steps if 0.0 <= kilometrage_m - step.entry_m < step.length_m
    )
    piece = line.pieces[piece_id]
    key = "section" if piece.id == piece.section_id else "piece"
    return {key: piece_id, "km": round(kilometrage_m / 1000.0, 6)}
