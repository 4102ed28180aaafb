"""Tables and summary: exact round trip through Parquet, and figures that were worked out by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from network.model import Direction
from network.timetable import Call, Stabled, Timetable, TimetableTrain
from study.report.data import Run
from study.run.summary import arrived_trains, summarise
from study.run.tables import EVENTS, SCHEMAS, STOPS, RunTables, make_table


def empty() -> dict[str, pl.DataFrame]:
    return {name: make_table(name) for name in SCHEMAS}


def timetable() -> Timetable:
    def train(number: str, revenue: bool) -> TimetableTrain:
        calls = (Call("A", None, None, 600), Call("B", None, 900, 930), Call("C", None, 1200, None))
        return TimetableTrain(number, Direction.DOWN, revenue, calls, Stabled(), Stabled())

    trains = {number: train(number, number != "X") for number in ("1", "3", "X")}
    return Timetable("t", "t", "l", 20.0, trains, ())


def small_stops() -> pl.DataFrame:
    """Train 1 leaves A 5 s early, B 12 s late, C 40 s late; train 3 stops for good after B, 65 s late there."""
    rows = [
        ("1", True, "A", None, 600.0, None, 595.0, None),
        ("1", True, "B", 900.0, 930.0, 905.0, 942.0, 0.10),
        ("1", True, "C", 1200.0, None, 1240.0, None, -0.30),
        ("3", True, "A", None, 600.0, None, 602.0, None),
        ("3", True, "B", 900.0, 930.0, 965.0, None, 0.50),
        ("3", True, "C", 1200.0, None, None, None, None),
        ("X", False, "C", 1200.0, None, 1200.0, None, 0.10),
    ]
    return make_table(
        "stops",
        {
            "unit": ["U"] * len(rows),
            "train": [row[0] for row in rows],
            "revenue": [row[1] for row in rows],
            "station": [row[2] for row in rows],
            "track": ["1"] * len(rows),
            "planned_arrival_s": [row[3] for row in rows],
            "planned_departure_s": [row[4] for row in rows],
            "arrival_s": [row[5] for row in rows],
            "departure_s": [row[6] for row in rows],
            "late_arrival_s": [None if None in (row[5], row[3]) else row[5] - row[3] for row in rows],
            "late_departure_s": [None if None in (row[6], row[4]) else row[6] - row[4] for row in rows],
            "stop_error_m": [row[7] for row in rows],
        },
    )


def test_summary_of_a_small_run_worked_out_by_hand() -> None:
    energy = make_table(
        "energy",
        {
            "unit": ["U", "U"], "train": ["1", "3"], "revenue": [True, True], "distance_km": [2.0, 1.0],
            "traction_kwh": [10.0, 4.5], "regenerated_kwh": [3.0, 1.0], "auxiliary_kwh": [2.0, 0.25],
        },
    )  # fmt: skip
    telegrams = make_table(
        "telegrams",
        {
            "source": ["U", "M"], "destination": ["M", "U"], "kind": ["a", "b"], "sent": [10, 5],
            "delivered": [7, 5], "lost": [2, 0], "dropped": [1, 0], "bytes": [100, 50],
        },
    )  # fmt: skip
    tables = RunTables(**{**empty(), "stops": small_stops(), "energy": energy, "telegrams": telegrams})
    summary = summarise(tables, timetable())
    assert (summary["trains_planned"], summary["trains_arrived"]) == (2, 1)
    assert arrived_trains(tables.stops, timetable()) == {"1"}
    assert summary["late_s_max"] == 65.0
    assert summary["early_departure_s_max"] == 5.0
    assert summary["stops"] == 4
    # Errors 0.1, -0.3, 0.5, 0.1: mean 0.1, deviations 0, -0.4, 0.4, 0: sigma = sqrt(0.32 / 3).
    assert summary["stop_error_m_mean"] == pytest.approx(0.1)
    assert summary["stop_error_m_sigma"] == pytest.approx((0.32 / 3) ** 0.5)
    assert summary["stop_error_m_max_abs"] == 0.5
    assert summary["energy_kwh"] == {"traction": 14.5, "regenerated": 4.0, "auxiliary": 2.25}
    assert summary["telegrams"] == {"sent": 15, "delivered": 12, "lost": 2, "dropped": 1}


def test_summary_of_an_empty_run_claims_nothing() -> None:
    summary = summarise(RunTables(**empty()), timetable())
    assert summary["trains_arrived"] == 0
    assert summary["late_s_max"] == summary["early_departure_s_max"] == 0.0
    assert summary["stop_error_m_mean"] is summary["stop_error_m_sigma"] is None
    assert summary["stop_error_m_max_abs"] is None
    assert summary["energy_kwh"]["traction"] == 0.0


@given(late_s=st.lists(st.floats(-900, 900), min_size=1, max_size=8))
def test_lateness_is_the_worst_and_never_negative(late_s: list[float]) -> None:
    stops = small_stops().head(1)
    stops = pl.concat([stops.with_columns(departure_s=pl.lit(600.0 + late)) for late in late_s])
    summary = summarise(RunTables(**{**empty(), "stops": stops}), timetable())
    assert summary["late_s_max"] == pytest.approx(max(0.0, *late_s, 0.0), abs=1e-9)
    assert summary["early_departure_s_max"] == pytest.approx(max(0.0, -min(late_s)), abs=1e-9)


def test_round_trip_through_parquet(tmp_path: Path, weekday: Run) -> None:
    weekday.tables.write(tmp_path / "run")
    again = RunTables.read(tmp_path / "run")
    for name in SCHEMAS:
        assert getattr(again, name).equals(getattr(weekday.tables, name)), name
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == sorted(
        f"{n}.parquet" for n in SCHEMAS
    )


def test_nan_in_times_is_a_gap() -> None:
    columns = {column: small_stops()[column].to_numpy() for column in STOPS}
    assert np.isnan(columns["arrival_s"]).any()
    again = make_table("stops", columns)
    assert again["arrival_s"].null_count() == small_stops()["arrival_s"].null_count()
    assert not again["arrival_s"].is_nan().any()


def test_writing_again_replaces_what_was_there(tmp_path: Path) -> None:
    RunTables(**{**empty(), "stops": small_stops()}).write(tmp_path)
    RunTables(**empty()).write(tmp_path)
    assert len(RunTables.read(tmp_path).stops) == 0


def test_a_missing_table_is_named(tmp_path: Path) -> None:
    RunTables(**empty()).write(tmp_path)
    (tmp_path / "blocks.parquet").unlink()
    with pytest.raises(InputError, match=r"blocks\.parquet.*expected the blocks table"):
        RunTables.read(tmp_path)


def test_a_file_that_is_no_parquet_is_named(tmp_path: Path) -> None:
    RunTables(**empty()).write(tmp_path)
    (tmp_path / "energy.parquet").write_text("not a table")
    with pytest.raises(InputError, match=r"energy\.parquet"):
        RunTables.read(tmp_path)


def test_a_table_of_another_form_is_named(tmp_path: Path) -> None:
    RunTables(**empty()).write(tmp_path)
    pl.DataFrame({"t_s": [1.0]}).write_parquet(tmp_path / "events.parquet")
    with pytest.raises(InputError, match=r"events\.parquet.*'kind'"):
        RunTables.read(tmp_path)


def test_frames_must_match_their_schema() -> None:
    with pytest.raises(ValueError, match="table stops: columns"):
        RunTables(**{**empty(), "stops": make_table("events")})
    wrong = make_table("events").with_columns(pl.col("t_s").cast(pl.Int64))
    with pytest.raises(ValueError, match="table events: column t_s holds Int64, not Float64"):
        RunTables(**{**empty(), "events": wrong})
    turned = make_table("events").select(list(EVENTS)[::-1])
    with pytest.raises(ValueError, match="order"):
        RunTables(**{**empty(), "events": turned})
    with pytest.raises(ValueError, match="table events: columns"):
        make_table("events", {"t_s": [1.0]})
