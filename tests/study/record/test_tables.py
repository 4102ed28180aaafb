"""Tables and summary: exact round trip through Parquet, and figures that were worked out by hand."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.errors import InputError
from network.files.timetable_schema import HeadTable
from network.model import Direction
from network.timetable import Call, Stabled, Timetable, TimetableTrain
from study.measures.summary import arrived_trains, summarise
from study.record.energy import PARTS
from study.record.figure import Adds, Figure, schema_of, summed_figures
from study.record.tables import ROWS, RunTables, make_table
from study.report.data import ReportedRun
from study.wording.phrase import Phrase


def empty() -> dict[str, pl.DataFrame]:
    return {name: make_table(name) for name in ROWS}


def timetable() -> Timetable:
    def train(number: str, revenue: bool) -> TimetableTrain:
        calls = (Call("A", None, None, 600), Call("B", None, 900, 930), Call("C", None, 1200, None))
        return TimetableTrain(number, Direction.DOWN, revenue, calls, Stabled(), Stabled())

    trains = {number: train(number, number != "X") for number in ("1", "3", "X")}
    return Timetable(HeadTable(id="t", line="l"), trains, ())


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
            "kind": ["stop"] * len(rows),
            "planned_arrival_s": [row[3] for row in rows],
            "planned_departure_s": [row[4] for row in rows],
            "arrival_s": [row[5] for row in rows],
            "departure_s": [row[6] for row in rows],
            "late_arrival_s": [None if None in (row[5], row[3]) else row[5] - row[3] for row in rows],
            "late_departure_s": [None if None in (row[6], row[4]) else row[6] - row[4] for row in rows],
            "stop_error_m": [row[7] for row in rows],
            "cancelled": [False] * len(rows),
        },
    )


def test_summary_of_a_small_run_worked_out_by_hand() -> None:
    energy = make_table(
        "energy",
        {
            "unit": ["U", "U"], "train": ["1", "3"], "revenue": [True, True], "cars": [2, 2],
            "regenerated_to": ["battery", "battery"], "distance_km": [2.0, 1.0],
            "running_s": [200.0, 100.0], "standing_s": [60.0, 30.0],
            "traction_kwh": [10.0, 4.5], "regenerated_kwh": [3.0, 1.0], "auxiliary_kwh": [2.0, 0.25],
            "standing_kwh": [0.5, 0.05], "net_kwh": [9.0, 3.75], **{name: [0.0, 0.25] for name in PARTS},
        },
    )  # fmt: skip
    layovers = make_table(
        "layovers",
        {
            "unit": ["U"], "station": ["C"], "after_train": ["1"], "before_train": ["3"], "from_s": [0.0],
            "to_s": [60.0], "traction_kwh": [0.0], "regenerated_kwh": [0.0], "auxiliary_kwh": [0.75], "net_kwh": [0.75],
            **{name: [0.5] for name in PARTS},
        },
    )  # fmt: skip
    telegrams = make_table(
        "telegrams",
        {
            "source": ["U", "M"], "destination": ["M", "U"], "kind": ["a", "b"], "sent": [10, 5],
            "delivered": [7, 5], "lost": [2, 0], "dropped": [1, 0], "bytes": [100, 50],
        },
    )  # fmt: skip
    parts = {"stops": small_stops(), "energy": energy, "layovers": layovers, "telegrams": telegrams}
    tables = RunTables(**{**empty(), **parts})
    summary = summarise(tables, timetable())
    assert (summary["trains_planned"], summary["trains_arrived"]) == (2, 1)
    assert arrived_trains(tables.stops, timetable()) == {"1"}
    assert summary["late_s_max"] == 3600.0  # train 3 never came to C
    assert summary["late_at"] == {"train": "3", "station": "C", "what": "missing arrival", "late_s": 3600.0}
    assert summary["early_departure_s_max"] == 5.0
    assert summary["early_at"] == {"train": "1", "station": "A", "what": "departure", "late_s": -5.0}
    assert summary["stops"] == 4
    # Errors 0.1, -0.3, 0.5, 0.1: mean 0.1, deviations 0, -0.4, 0.4, 0: sigma = sqrt(0.32 / 3).
    assert summary["stop_error_m_mean"] == pytest.approx(0.1)
    assert summary["stop_error_m_sigma"] == pytest.approx((0.32 / 3) ** 0.5)
    kinds = {"A": "pass", "B": "operational", "C": "stop"}
    kind = pl.col("station").replace(kinds).alias("kind")
    cut = (pl.col("planned_arrival_s").is_not_null() & pl.col("arrival_s").is_null()).alias("cancelled")
    short = {**parts, "stops": small_stops().with_columns(pl.col("stop_error_m") * -2.0, kind, cut)}
    wide = summarise(RunTables(**{**empty(), **short}), timetable())
    assert (wide["stop_error_m_max_abs"], wide["stops_off"], wide["stop_off_at"]["error_m"]) == (1.0, 2, -1.0)
    assert wide["late_passing_at"] == {"train": "3", "station": "A", "late_s": 2.0}
    assert [wide["trains_cancelled"], wide["trains_shortened"], summary["trains_shortened"]] == [0, 1, 0]
    assert summary["stop_error_m_max_abs"] == 0.5
    assert summary["stops_off"] == 1
    off = summary["stop_off_at"]
    assert off["error_m"] == 0.5
    of = small_stops().filter(train=off["train"], station=off["station"])
    assert of["stop_error_m"].to_list() == [0.5]
    assert summary["energy_kwh"] == {"traction": 14.5, "regenerated": 4.0, "auxiliary": 3.0}
    told = summary["energy"]
    assert told["running"] == pytest.approx(
        {"traction": 14.5, "regenerated": 4.0, "auxiliary": 1.7, "net": 12.2}
    )
    assert told["standing"]["net"] == told["standing"]["auxiliary"] == pytest.approx(0.55)
    assert told["all"] == pytest.approx({"traction": 14.5, "regenerated": 4.0, "auxiliary": 3.0, "net": 13.5})
    assert (told["train_km"], told["car_km"]) == (3.0, 6.0)
    assert told["net_kwh_per_train_km"] == pytest.approx({"trains": 4.25, "all": 4.5})
    assert told["net_kwh_per_car_km"] == pytest.approx({"trains": 2.125, "all": 2.25})
    assert told["regenerated_to"] == {"battery": 4.0}
    assert told["parts"] == {name.removesuffix("_kwh"): 0.75 for name in PARTS}
    assert summary["telegrams"] == {"sent": 15, "delivered": 12, "lost": 2, "dropped": 1}


def test_summary_of_an_empty_run_claims_nothing() -> None:
    summary = summarise(RunTables(**empty()), timetable())
    assert summary["trains_arrived"] == 0
    assert summary["late_s_max"] is summary["late_at"] is None
    assert summary["early_departure_s_max"] is None
    assert summary["energy"]["net_kwh_per_car_km"] == {"trains": None, "all": None}
    assert summary["margins"] is None
    assert summary["stop_error_m_mean"] is summary["stop_error_m_sigma"] is None
    assert summary["stop_error_m_max_abs"] is summary["stop_off_at"] is None
    assert summary["stops_off"] == 0
    assert summary["energy_kwh"]["traction"] == 0.0


@given(late_s=st.lists(st.floats(-900, 900), min_size=1, max_size=8))
def test_lateness_is_the_worst_and_never_negative(late_s: list[float]) -> None:
    arrived = small_stops().filter(pl.col("train") == "1", pl.col("station") == "C")
    stops = small_stops().head(1)
    stops = pl.concat([stops.with_columns(late_departure_s=pl.lit(late)) for late in late_s])
    on_time = arrived.with_columns(late_arrival_s=pl.lit(0.0))
    train = timetable().trains["1"]
    to_c_only = replace(train, calls=(train.calls[0], train.calls[-1]))
    plan = replace(timetable(), trains={"1": to_c_only})
    summary = summarise(RunTables(**{**empty(), "stops": pl.concat([stops, on_time])}), plan)
    assert summary["late_s_max"] == pytest.approx(max(0.0, *late_s, 0.0), abs=1e-9)
    assert summary["early_departure_s_max"] == pytest.approx(max(0.0, -min(late_s)), abs=1e-9)


def test_how_late_trains_are_that_never_arrive_nobody_knows() -> None:
    """Train 3 alone left A 2 s late and stood for good at B: that is no lateness of 65 s, and none of 0."""
    stops = small_stops().filter(pl.col("train") == "3")
    summary = summarise(RunTables(**{**empty(), "stops": stops}), timetable())
    assert (summary["trains_planned"], summary["trains_arrived"]) == (2, 0)
    assert summary["late_s_max"] is None
    assert json.loads(json.dumps(summary))["late_at"] is None


@pytest.mark.parametrize("cancelled", [False, True])
def test_an_empty_train_that_never_came_is_not_the_latest(cancelled: bool) -> None:
    """Train 1 was 40 s late at C, for which empty train X set out as well, or was left out by the dispatcher."""
    lost = pl.col("train") == "X"
    came = (pl.when(~lost).then(pl.col(name)).alias(name) for name in ("arrival_s", "late_arrival_s"))
    stops = small_stops().filter(pl.col("train") != "3").with_columns(*came, cancelled=lost & cancelled)
    plan = replace(timetable(), trains={number: timetable().trains[number] for number in "1X"})
    summary = summarise(RunTables(**{**empty(), "stops": stops}), plan)
    assert summary["late_at"] == {"train": "1", "station": "C", "what": "arrival", "late_s": 40.0}


def test_round_trip_through_parquet(tmp_path: Path, weekday: ReportedRun) -> None:
    weekday.tables.write(tmp_path / "run")
    again = RunTables.read(tmp_path / "run")
    for name in ROWS:
        assert getattr(again, name).equals(getattr(weekday.tables, name)), name
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == sorted(f"{n}.parquet" for n in ROWS)


def test_writing_again_replaces_what_was_there(tmp_path: Path) -> None:
    RunTables(**{**empty(), "stops": small_stops()}).write(tmp_path)
    RunTables(**empty()).write(tmp_path)
    assert len(RunTables.read(tmp_path).stops) == 0


def test_a_missing_table_is_named(tmp_path: Path) -> None:
    RunTables(**empty()).write(tmp_path)
    (tmp_path / "blocks.parquet").unlink()
    tables = RunTables.read(tmp_path)
    assert tables.stops.is_empty()
    with pytest.raises(InputError, match=r"blocks\.parquet.*earlier version") as error:
        assert tables.blocks
    assert error.value.file == str(tmp_path / "blocks.parquet")


def test_a_file_that_is_no_parquet_is_named(tmp_path: Path) -> None:
    RunTables(**empty()).write(tmp_path)
    (tmp_path / "energy.parquet").write_text("not a table")
    tables = RunTables.read(tmp_path)
    assert tables.stops.is_empty()
    with pytest.raises(InputError, match=r"energy\.parquet"):
        assert tables.energy


def test_a_table_of_another_form_is_named(tmp_path: Path) -> None:
    RunTables(**empty()).write(tmp_path)
    pl.DataFrame({"t_s": [1.0]}).write_parquet(tmp_path / "events.parquet")
    with pytest.raises(InputError, match=r"events\.parquet.*'kind'"):
        assert RunTables.read(tmp_path).events


def test_frames_must_match_their_schema() -> None:
    with pytest.raises(ValueError, match="table stops: columns"):
        RunTables(**{**empty(), "stops": make_table("events")})
    wrong = make_table("events").with_columns(pl.col("t_s").cast(pl.Int64))
    with pytest.raises(ValueError, match="table events: column t_s holds Int64, not Float64"):
        RunTables(**{**empty(), "events": wrong})
    turned = make_table("events").select(list(schema_of(ROWS["events"]))[::-1])
    with pytest.raises(ValueError, match="order"):
        RunTables(**{**empty(), "events": turned})
    with pytest.raises(ValueError, match="table events: columns"):
        make_table("events", {"t_s": [1.0]})


def test_events_of_a_run_before_they_had_japanese_are_read_with_the_english(tmp_path: Path) -> None:
    tables = RunTables(**empty())
    tables.write(tmp_path)
    path = tmp_path / "events.parquet"
    tables.events.drop("text_ja").write_parquet(path)
    assert RunTables.read(tmp_path).events.columns == list(schema_of(ROWS["events"]))


def test_tables_that_a_run_of_before_them_lacks_are_empty(tmp_path: Path) -> None:
    RunTables(**empty()).write(tmp_path)
    for name in ("road", "crossings", "warnings"):
        (tmp_path / f"{name}.parquet").unlink()
        assert getattr(RunTables.read(tmp_path), name).equals(make_table(name))


def test_what_a_later_version_has_besides_is_left_out(tmp_path: Path) -> None:
    tables = RunTables(**empty())
    tables.write(tmp_path)
    tables.events.with_columns(weather=pl.lit("rain")).write_parquet(tmp_path / "events.parquet")
    tables.stops.write_parquet(tmp_path / "weather.parquet")
    assert RunTables.read(tmp_path).events.equals(tables.events)


@dataclass(frozen=True, slots=True)
class Drop:
    """A row with a figure of every way of adding up."""

    weight: float
    summed: Annotated[float | None, Figure(Phrase("s"), "", 0, Adds.SUM)]
    mean: Annotated[float | None, Figure(Phrase("m"), "", 0, Adds.MEAN)]
    largest: Annotated[float | None, Figure(Phrase("l"), "", 0, Adds.LARGEST)]
    smallest: Annotated[float | None, Figure(Phrase("n"), "", 0, Adds.SMALLEST)]
    weighed: Annotated[float | None, Figure(Phrase("w"), "", 0, Adds.WEIGHED_MEAN, "weight")]
    square: Annotated[float | None, Figure(Phrase("q"), "", 0, Adds.WEIGHED_ROOT_MEAN_SQUARE, "weight")]
    alone: Annotated[float | None, Figure(Phrase("a"), "", 0)]


def test_rows_add_up_as_their_figures_say() -> None:
    rows = (
        Drop(1.0, 1.0, 2.0, 3.0, 3.0, 4.0, 3.0, 9.0),
        Drop(3.0, 5.0, 6.0, 1.0, 1.0, 8.0, 5.0, 9.0),
        Drop(7.0, *[None] * 7),
    )
    assert summed_figures(rows) == {
        "summed": 6.0,
        "mean": 4.0,
        "largest": 3.0,
        "smallest": 1.0,
        "weighed": 7.0,  # (4 + 3 * 8) / 4
        "square": pytest.approx((84.0 / 4.0) ** 0.5),  # (9 + 3 * 25) / 4
    }
    names = ("summed", "mean", "largest", "smallest", "weighed", "square")
    assert summed_figures(rows[2:]) == dict.fromkeys(names)
    assert Figure(Phrase("late", "遅れ"), "s", 1).heading == Phrase("late, s", "遅れ 秒")
