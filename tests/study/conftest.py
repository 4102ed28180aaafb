"""A made-up run of a real timetable: trapezoids between the stopping marks, blocks from the line's routes."""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from typing import Any

import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.graph import find_route
from network.model import Line
from network.timetable import Timetable, TimetableTrain, load_timetable, platform_of
from study.record.figure import schema_of
from study.record.tables import ROWS, RunTables, make_table
from study.report.data import ReportedRun

STEP_S = 1.0
POWER_MPS2, BRAKE_MPS2 = 0.6, 0.7
PERMITTED_MARGIN_MPS = 2.5


@dataclass
class Rows:
    """Rows under construction, a list of each table."""

    tables: dict[str, list[tuple[Any, ...]]] = field(default_factory=lambda: {name: [] for name in ROWS})

    def add(self, name: str, *row: object) -> None:
        assert len(row) == len(schema_of(ROWS[name]))
        self.tables[name].append(row)

    def finish(self) -> RunTables:
        frames = {}
        for name, rows in self.tables.items():
            columns = zip(*rows, strict=True) if rows else [()] * len(schema_of(ROWS[name]))
            frames[name] = make_table(name, dict(zip(schema_of(ROWS[name]), map(list, columns), strict=True)))
        return RunTables(**frames)


def _top_speed(distance_m: float, time_s: float) -> float:
    """Top speed of a trapezoid over distance_m in time_s: T = D / v + v / 2 (1 / a + 1 / b)."""
    k = (1 / POWER_MPS2 + 1 / BRAKE_MPS2) / 2
    shortest_s = 2 * math.sqrt(k * distance_m)
    time_s = max(time_s, shortest_s)
    return (time_s - math.sqrt(max(time_s**2 - 4 * k * distance_m, 0.0))) / (2 * k)


def _speed(at_m: float, distance_m: float, top_mps: float) -> tuple[float, float]:
    """Speed and notch of the trapezoid at at_m of distance_m."""
    up_mps = math.sqrt(2 * POWER_MPS2 * max(at_m, 0.02))
    down_mps = math.sqrt(2 * BRAKE_MPS2 * max(distance_m - at_m, 0.0))
    speed_mps = min(top_mps, up_mps, down_mps)
    return speed_mps, 4.0 if speed_mps == up_mps else -5.0 if speed_mps == down_mps else 1.0


def _hop(
    rows: Rows,
    line: Line,
    who: tuple[str, TimetableTrain],
    ends_m: tuple[float, float],
    ends_s: tuple[float, float],
    pieces: tuple[str, ...],
) -> float:
    """Samples from one mark to the next; the time of arrival."""
    unit, train = who
    distance_m = abs(ends_m[1] - ends_m[0])
    top_mps = _top_speed(distance_m, ends_s[1] - ends_s[0])
    at_m, t_s = 0.0, ends_s[0]
    while True:
        speed_mps, notch = _speed(at_m, distance_m, top_mps)
        arrived = at_m >= distance_m - 0.05
        here_m = ends_m[0] + train.direction * at_m
        piece = next(
            (p for p in pieces if line.pieces[p].from_m <= here_m <= line.pieces[p].to_m), pieces[-1]
        )
        row = (t_s, unit, train.number, int(train.direction), here_m, piece, 0.0 if arrived else speed_mps)
        stop_mps = math.sqrt(2 * 0.9 * max(distance_m - at_m, 0.0))
        permitted_mps = min(line.max_speed_mps, stop_mps + PERMITTED_MARGIN_MPS)
        target_mps = min(top_mps, math.sqrt(2 * BRAKE_MPS2 * max(distance_m - at_m, 0.0)))
        rows.add(
            "trajectory", *row, 0.0, 0.0 if arrived else notch, permitted_mps, target_mps, 0, 0.3, 2.0, 2.0
        )
        if arrived:
            return t_s
        at_m = min(at_m + max(speed_mps, 0.3) * STEP_S, distance_m)
        t_s += STEP_S


def _run_train(
    rows: Rows, line: Line, unit: str, train: TimetableTrain, late_s: float, draw: random.Random
) -> None:
    number, direction = train.number, train.direction
    tracks = [platform_of(line, call, direction) for call in train.calls]
    stations = [i for i, call in enumerate(train.calls) if not line.stations[call.station_id].is_halt]
    pieces: list[str] = []
    spans: list[tuple[int, int, tuple[str, ...]]] = []
    for i, j in pairwise(stations):
        route = find_route(line, tracks[i].section_id, tracks[j].section_id, direction)
        assert route is not None
        pieces += route.piece_ids
        spans.append((i, j, route.section_ids))
    left_s: dict[int, float] = {}
    came_s: dict[int, float] = {}
    for i, call in enumerate(train.calls):
        if i:
            before = train.calls[i - 1]
            reach_s = max(call.first_s + late_s, left_s[i - 1] + 30)
            ends_m = tracks[i - 1].marks_m[direction], tracks[i].marks_m[direction]
            came_s[i] = _hop(
                rows,
                line,
                (unit, train),
                ends_m,
                (left_s[i - 1], reach_s),
                tuple(pieces) or (tracks[0].piece_id,),
            )
            assert before.departure_s is not None
        if call.departure_s is not None:
            left_s[i] = max(call.departure_s + late_s, came_s.get(i, 0.0) + 20.0)
        arrival_s, departure_s = came_s.get(i), left_s.get(i)
        planned_arrival_s = call.arrival_s
        rows.add(
            "stops", unit, number, train.revenue, call.station_id, tracks[i].name, call.kind.value,
            planned_arrival_s, call.departure_s, arrival_s, departure_s,
            None if None in (arrival_s, planned_arrival_s) else arrival_s - planned_arrival_s,
            None if None in (departure_s, call.departure_s) else departure_s - call.departure_s,
            draw.gauss(0.02, 0.12) if i else None,
            False,
        )  # fmt: skip
    for i, j, sections in spans:
        for k, section in enumerate(sections):
            enters_s = left_s[i] + (came_s[j] - left_s[i]) * (k + 0.3) / len(sections)
            clears_s = (
                left_s.get(j, came_s[j] + 300) + 25 if k == len(sections) - 1 else came_s[j] - 10 + 8 * k
            )
            token = len(rows.tables["blocks"])
            rows.add("blocks", section, unit, number, token, left_s[i] - 20, clears_s + 3, enters_s, clears_s)
    km = abs(tracks[-1].marks_m[direction] - tracks[0].marks_m[direction]) / 1000
    traction, regenerated, auxiliary = 2.1 * km + 2, 0.6 * km, 0.4 * km
    figures = (traction, auxiliary, regenerated, traction + auxiliary - regenerated)
    motors = traction - regenerated
    figures += (
        0.0,
        0.4 * motors,
        0.0,
        0.0,
        0.2 * motors,
        0.3 * motors,
        0.1 * motors,
        0.05 * motors,
        0.0,
        0.1 * km,
    )
    rows.add("energy", unit, number, train.revenue, 2, km, 120.0 * km, 20.0 * km, *figures, "battery")
    ends = (train.calls[0].station_id, train.calls[-1].station_id)
    rows.add("energy_legs", unit, number, train.revenue, *ends, 2, km, 120.0 * km, 20.0 * km, *figures)
    end_s = came_s[len(train.calls) - 1]
    rows.add("layovers", unit, ends[1], number, None, end_s, end_s + 600.0, 0.0, 5.0, 0.0, 5.0, *[0.0] * 9)
    rows.add("margins", unit, number, train.revenue, *ends, 200.0, 160.0, 165.0, 40.0, 25.0, 190.0, 10.0)


def make_run(line: Line, timetable: Timetable, seed: int = 1) -> RunTables:
    """A run of every train of the timetable, some of them late, with telegrams and events."""
    rows, draw = Rows(), random.Random(seed)
    for diagram in timetable.diagrams:
        for number in diagram.train_numbers:
            late_s = 200.0 if draw.random() < 0.08 else abs(draw.gauss(0, 6))
            _run_train(rows, line, diagram.stock_id, timetable.trains[number], late_s, draw)
    for unit in [diagram.stock_id for diagram in timetable.diagrams]:
        rows.add("telegrams", unit, "block-manager", "RouteRequest", 900, 880, 15, 5, 900 * 96)
        rows.add("telegrams", "block-manager", unit, "RouteGranted", 800, 790, 8, 2, 800 * 210)
        rows.add("telegrams", unit, "OGN-W", "PointsCommand", 300, 296, 3, 1, 300 * 110)
    first = rows.tables["trajectory"][len(rows.tables["trajectory"]) // 2]
    rows.tables["trajectory"][len(rows.tables["trajectory"]) // 2] = (*first[:11], 1, *first[12:])
    for i in range(260):
        rows.add(
            "events", 36_000.0 + i, first[1], "refusal", f"route refused, number {i}", f"進路要求を拒否 {i}"
        )
    brakes = "service brake: 1.2 km/h above permitted <speed>"
    rows.add("events", first[0], first[1], "intervention", brakes, "常用ブレーキ")
    return rows.finish()


@pytest.fixture(scope="session")
def make_day() -> Callable[[str, str], ReportedRun]:
    """A made-up run of a shipped line and timetable; who changes it takes a copy."""

    @cache
    def make(line_name: str, timetable_name: str) -> ReportedRun:
        line = load_line(shipped_line(line_name))
        timetable = load_timetable(shipped_timetable(timetable_name), line)
        return ReportedRun(line, timetable, make_run(line, timetable))

    return make


@pytest.fixture(scope="session")
def weekday(make_day: Callable[[str, str], ReportedRun]) -> ReportedRun:
    return make_day("karasuyama", "karasuyama_weekday")
