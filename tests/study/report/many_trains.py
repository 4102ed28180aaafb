"""A day of many trains on the busy line: its own timetable again and again, every run a little different."""

from dataclasses import replace
from itertools import count
from typing import Final

import numpy as np
import polars as pl

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import Call, Timetable, TimetableTrain, load_timetable
from study.record.tables import RunTables
from study.report.data import ReportedRun
from tests.study.conftest import make_run

APART_S: Final = 150
WOBBLE_KMH: Final = 1.2  # speeds of real trains are no trapezoids: they notch in and out


def busy_day(trains: int) -> ReportedRun:
    """So many trains in some fourteen hours."""
    line = load_line(shipped_line("busy_line"))
    timetable = _repeated(load_timetable(shipped_timetable("busy_line"), line), trains)
    return ReportedRun(line, timetable, _wobbling(make_run(line, timetable)))


def _later(train: TimetableTrain, number: str, by_s: int) -> TimetableTrain:
    def moved(time_s: int | None) -> int | None:
        return None if time_s is None else time_s + by_s

    def call(one: Call) -> Call:
        return replace(one, arrival_s=moved(one.arrival_s), departure_s=moved(one.departure_s))

    return replace(train, number=number, calls=tuple(call(one) for one in train.calls))


def _repeated(timetable: Timetable, trains: int) -> Timetable:
    made: dict[str, TimetableTrain] = {}
    diagrams = []
    for again in count():
        for diagram in timetable.diagrams:
            numbers = [f"{number}{again}" for number in diagram.train_numbers][: trains - len(made)]
            for old, number in zip(diagram.train_numbers, numbers, strict=False):
                made[number] = _later(timetable.trains[old], number, again * APART_S)
            if numbers:
                stock = f"{diagram.stock_id}-{again}"
                diagrams.append(replace(diagram, stock_id=stock, train_numbers=tuple(numbers)))
            if len(made) == trains:
                return replace(timetable, trains=made, diagrams=tuple(diagrams))
    raise AssertionError


def _wobbling(tables: RunTables) -> RunTables:
    """Speeds that rise and fall with a period and a phase of each train's own; places with them."""
    course = tables.trajectory
    draw = np.random.default_rng(5)
    numbers = course["train"].unique(maintain_order=True).to_list()
    period_s = dict(zip(numbers, draw.uniform(25.0, 60.0, len(numbers)), strict=True))
    phase = dict(zip(numbers, draw.uniform(0.0, 6.28, len(numbers)), strict=True))
    own_s = np.array([period_s[number] for number in course["train"]])
    turn = 2.0 * np.pi * course["t_s"].to_numpy() / own_s + np.array([phase[n] for n in course["train"]])
    speed_mps = course["speed_mps"].to_numpy()
    runs = speed_mps > 5.0
    wobble_mps = WOBBLE_KMH / 3.6
    place_m = course["kilometrage_m"].to_numpy() - runs * wobble_mps * own_s / (2.0 * np.pi) * np.cos(turn)
    return replace(
        tables,
        trajectory=course.with_columns(
            pl.Series("speed_mps", speed_mps + runs * wobble_mps * np.sin(turn)),
            pl.Series("kilometrage_m", place_m),
        ),
    )
