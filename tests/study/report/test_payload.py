"""What the page is told of a run is what its tables say."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest

from network.model import Direction
from study.measures.summary import summarise
from study.record.energy import PARTS
from study.record.tables import make_table
from study.record.wait import Cause, Wait
from study.report.beside import Beside
from study.report.charts import draw_energy
from study.report.courses import FINEST_FIRST, Fineness, blocks_shown, courses_shown, line_shown, trains_shown
from study.report.crossings import crossing_tables_shown
from study.report.data import ReportedRun
from study.report.packing import unpacked
from study.report.payload import PageContents, courses_of, payload_of
from study.report.style import drawing
from tests.study.crossed_day import with_crossing
from tests.study.report.page import table_in, with_table


def read(column: Mapping[str, Any]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in unpacked(dict(column))])


@pytest.mark.parametrize("fineness", FINEST_FIRST)
@pytest.mark.parametrize("name", [("karasuyama", "karasuyama_weekday"), ("rtri_test_line", "rtri_crossing")])
def test_every_sample_is_within_the_tolerance_that_the_page_states(
    make_day: Callable[[str, str], ReportedRun], name: tuple[str, str], fineness: Fineness
) -> None:
    run = make_day(*name)
    for shown in courses_shown(run, fineness):
        course = run.courses[shown["unit"], shown["train"]]
        t_s = course["t_s"].to_numpy()
        times = read(shown["t"])
        assert (np.diff(times) >= 0).all()
        # Times are rounded to a tenth of a second, the run's own step: these made-up ones lie between two steps.
        at_m = np.interp(t_s, times, read(shown["m"]))
        assert np.abs(at_m - course["kilometrage_m"].to_numpy()).max() <= fineness.place_m + 0.05 * 35.0
        speed_kmh = np.interp(t_s, times, read(shown["v"]))
        assert np.abs(speed_kmh - course["speed_mps"].to_numpy() * 3.6).max() <= fineness.speed_kmh + 0.3
        assert shown["axes"] == [[0, 0]]


def test_a_gap_of_a_curve_stays_a_gap(weekday: ReportedRun) -> None:
    key, course = next(iter(weekday.courses.items()))
    low, high = float(course["t_s"][20]), float(course["t_s"][40])
    here = pl.col("train") == key[1]
    gone = weekday.tables.trajectory.with_columns(
        target_mps=pl.when(here & pl.col("t_s").is_between(low, high))
        .then(float("inf"))
        .otherwise(pl.col("target_mps"))
    )
    run = with_table(weekday, trajectory=gone)
    shown = next(c for c in courses_shown(run, FINEST_FIRST[0]) if c["train"] == key[1])
    times, values = read(shown["target"]["t"]), read(shown["target"]["v"])
    (gap,) = np.flatnonzero(np.isnan(values))
    assert times[gap] < low and times[gap + 1] > high


def test_calls_are_those_of_plan_and_run(weekday: ReportedRun) -> None:
    shown = {train["number"]: train for train in trains_shown(weekday)}
    assert list(shown) == list(weekday.trains)
    for (number,), rows in weekday.tables.stops.group_by("train", maintain_order=True):
        train = shown[str(number)]
        planned = weekday.timetable.trains[str(number)]
        assert train["station"] == [call.station_id for call in planned.calls]
        assert unpacked(train["pd"]) == [
            None if c.departure_s is None else float(c.departure_s) for c in planned.calls
        ]
        assert unpacked(train["a"]) == pytest.approx(rows["arrival_s"].to_list(), abs=0.051, nan_ok=True)
        assert unpacked(train["error"]) == pytest.approx(rows["stop_error_m"].to_list(), abs=0.00051)
        assert train["unit"] == rows["unit"][0]
        assert Direction(train["direction"]) is planned.direction


def test_the_page_waits_for_no_departure_where_a_train_ends_on_the_line(weekday: ReportedRun) -> None:
    plan = weekday.timetable.trains["321M"]
    last = replace(plan.calls[-1], departure_s=plan.calls[-1].arrival_s)
    trains = {**weekday.timetable.trains, "321M": replace(plan, calls=(*plan.calls[:-1], last))}
    run = ReportedRun(weekday.line, replace(weekday.timetable, trains=trains), weekday.tables)
    shown = {train["number"]: train for train in trains_shown(run)}
    assert unpacked(shown["321M"]["pd"])[-1] is None


def test_of_a_train_that_is_cut_what_came_is_shown_and_its_cancelled_calls_as_planned(
    weekday: ReportedRun,
) -> None:
    """321M comes to Ogane and is ended there; the departure that does not come has a row of its own."""
    stops = weekday.tables.stops.filter(pl.col("train") == "321M")
    at = stops["station"].to_list().index("OGN")
    none = {name: pl.lit(None, pl.Float64) for name in ("arrival_s", "departure_s", "stop_error_m")}
    cut = stops.slice(at).with_columns(**none, cancelled=pl.lit(value=True))
    ended = stops.head(at + 1).with_columns(
        departure_s=pl.when(pl.col("station") != "OGN").then("departure_s")
    )
    others = weekday.tables.stops.filter(pl.col("train") != "321M")
    (shown,) = (
        train
        for train in trains_shown(with_table(weekday, stops=pl.concat([ended, cut, others])))
        if train["number"] == "321M"
    )
    assert shown["station"] == stops["station"].to_list()
    came = [None if s is None else round(s, 1) for s in stops["arrival_s"].head(at + 1)]
    assert unpacked(shown["a"]) == [*came, *[None] * (len(stops) - at - 1)]


def test_a_train_that_broke_down_in_a_station_stands_there_for_as_long_as_it_waited(
    weekday: ReportedRun,
) -> None:
    """322M comes to Ogane and never leaves: the page has its stay from the waits, as the plot has."""
    stops = weekday.tables.stops.filter(pl.col("train") == "322M")
    stops = stops.head(stops["station"].to_list().index("OGN") + 1)
    stops = stops.with_columns(departure_s=pl.when(pl.col("station") != "OGN").then("departure_s"))
    came_s = stops["arrival_s"][-1]
    waits = [Wait(stops["unit"][0], "322M", came_s, came_s + 3600.0, Cause.UNIT_OFF, "OGN")]
    run = with_table(weekday, stops=stops, waits=make_table("waits", waits))
    shown = table_in(payload_of(run, summarise(run.tables, run.timetable), PageContents()), "occupation")
    at = list(zip(shown["station"], shown["train"], strict=True)).index(("OGN", "322M"))
    assert shown["to_s"][at] - shown["from_s"][at] == pytest.approx(3600.0, abs=0.11)


def test_punctuality_of_a_part_of_a_day_counts_what_is_due(weekday: ReportedRun) -> None:
    """Nothing ran, and the run was ended at 06:00."""
    run, end_s = with_table(weekday, stops=weekday.tables.stops.clear()), 6 * 3600.0
    due_s = [
        end_s - call.arrival_s
        for train in weekday.timetable.trains.values()
        for call in train.calls[1:]
        if call.arrival_s is not None and call.arrival_s <= end_s
    ]
    facts = {**summarise(run.tables, run.timetable, end_s), "latest_end_s": end_s}
    columns = table_in(payload_of(run, facts, PageContents()), "punctuality")
    row = list(zip(columns["station"], (what[0] for what in columns["what"]), strict=True)).index(
        ("", "arrivals")
    )
    assert columns["planned"][row] == len(due_s) > 0
    assert columns["mean_s"][row] == pytest.approx(sum(due_s) / len(due_s), abs=0.05)


def test_a_train_that_is_not_in_the_timetable_is_shown_as_it_ran(weekday: ReportedRun) -> None:
    rename = (
        pl.when(pl.col("train") == "321M").then(pl.lit("9999X")).otherwise(pl.col("train")).alias("train")
    )
    run = with_table(
        weekday,
        trajectory=weekday.tables.trajectory.with_columns(rename),
        stops=weekday.tables.stops.with_columns(rename),
    )
    shown = {train["number"]: train for train in trains_shown(run)}
    assert not shown["9999X"]["planned"] and len(shown["9999X"]["station"]) == 8
    assert shown["321M"]["planned"] and set(unpacked(shown["321M"]["a"])) == {None}


def test_blocks_are_the_register_and_the_truth(make_day: Callable[[str, str], ReportedRun]) -> None:
    day = make_day("rtri_test_line", "rtri_test_line")
    blocks = make_table(
        "blocks",
        {
            "section": ["7", "6"], "unit": ["K1", "K1"], "train": ["T1", "T1"], "token": [2, 1],
            "granted_s": [36_020.0, 36_010.0], "released_s": [None, 36_050.0],
            "entered_s": [None, 36_020.0], "cleared_s": [None, 36_040.0],
        },
    )  # fmt: skip
    shown = blocks_shown(with_table(day, blocks=blocks))
    assert [shown["sections"][at] for at in shown["section"]] == ["6", "7"]
    assert unpacked(shown["granted"]) == [36_010.0, 36_020.0]
    assert (shown["released"], shown["entered"], shown["cleared"]) == ([40, None], [10, None], [30, None])


def test_waits_are_told_in_both_languages(weekday: ReportedRun) -> None:
    row = {
        "unit": "V1", "train": "321M", "from_s": 36_000.0, "to_s": 36_060.0, "cause": "departure time", "place": "OGN",
        "at_m": None, "asked": "", "section": "", "points": "", "party": "", "party_train": "", "since_s": None,
        "until_s": 36_060.0, "reason": "",
    }  # fmt: skip
    runs = {**row, "cause": "runs", "from_s": 36_060.0, "to_s": 36_100.0}
    waits = make_table("waits", {name: [row[name], runs[name]] for name in row})
    run = with_table(weekday, waits=waits)
    shown = payload_of(run, summarise(run.tables, run.timetable), PageContents())["waits"]
    assert (unpacked(shown["from"]), unpacked(shown["to"])) == ([36_000.0], [36_060.0])
    assert "Ogane" in shown["said"][0][0] and "大金" in shown["said"][0][1]


def test_margins_name_the_train_of_the_smallest(weekday: ReportedRun) -> None:
    facts = summarise(weekday.tables, weekday.timetable)
    margins = table_in(payload_of(weekday, facts, PageContents()), "margins")
    assert set(margins["margin_s"]) == {40}
    assert set(margins["train"]) <= set(weekday.timetable.trains)


def test_energy_per_km_is_net_over_distance(weekday: ReportedRun) -> None:
    energy = make_table(
        "energy",
        {
            "unit": ["V1", "V2"], "train": ["321M", "322M"], "revenue": [True, False], "cars": [2, 2],
            "regenerated_to": ["battery", "battery"], "distance_km": [20.0, 0.0], "running_s": [1800.0, 1.0],
            "standing_s": [300.0, 0.0], "traction_kwh": [50.0, 0.0], "regenerated_kwh": [14.0, 0.0],
            "auxiliary_kwh": [9.0, 1.0], "standing_kwh": [2.0, 0.0], "net_kwh": [45.0, 1.0],
            **{name: [0.0, 0.0] for name in PARTS},
        },
    )  # fmt: skip
    run = with_table(weekday, energy=energy, layovers=weekday.tables.layovers.clear())
    payload = payload_of(run, summarise(run.tables, run.timetable), PageContents())
    assert table_in(payload, "energy_parts")["percent_of_net"][0] == round(100.0 * 10.0 / 46.0, 1)
    shown = table_in(payload, "energy_trains")
    assert shown["net_per_km"] == [2.25, None]  # (50 + 9 - 14) / 20
    assert shown["revenue"] == ["yes", "no"]
    with drawing():
        (axes,) = draw_energy(run).axes  # type: ignore[union-attr]
    assert [text.get_text() for text in axes.texts] == ["2.25", "–"]
    assert sorted(bar.get_height() for bar in axes.patches if bar.get_height()) == [
        -14.0,
        1.0,
        2.0,
        7.0,
        50.0,
    ]


def test_of_a_run_beside_only_what_moved_or_is_gone_is_drawn(weekday: ReportedRun) -> None:
    beside = Beside("before", weekday, frozenset({"321M"}), frozenset({"322M"}))
    shown = courses_of(weekday, FINEST_FIRST[0], beside)["beside"]
    assert (shown["label"], shown["gone"]) == ("before", ["322M"])
    assert {course["train"] for course in shown["courses"]} == {"321M", "322M"}
    assert courses_of(weekday, FINEST_FIRST[0])["beside"] is None


def shown_of_crossings(run: ReportedRun) -> dict[str, list[dict[str, Any]]]:
    """The tables of level crossings, as rows."""
    return {
        table.id: [
            {column.label: value for column, value in zip(table.columns, values, strict=True)}
            for values in zip(*(column.values for column in table.columns), strict=True)
        ]
        for table in crossing_tables_shown(run)
    }


def test_closed_minutes_and_warnings_of_a_crossing_are_added_up_over_its_hours(weekday: ReportedRun) -> None:
    shown = shown_of_crossings(with_crossing(weekday))
    (whole,) = shown["crossings"]
    assert whole == {
        "crossing": "Mill lane",
        "closed_min": 4.0,
        "closures": 3,
        "closure_s_max": 120.0,
        "trains": 4,
        "warned_s_mean": 36.0,
        "warned_s_min": 30.0,
        "warned_s_max": 44.0,
        "from_stand": 1,
        "warned_s_running": 38.0,
    }
    assert [(row["hour"], row["closed_min"], row["trains"]) for row in shown["crossing_hours"]] == [
        (7, 1.0, 1),
        (8, 3.0, 3),
    ]
    assert [row["from_stand"] for row in shown["warnings"]] == ["yes", "no", "no", "no"]


def test_the_road_stands_beside_the_crossing_where_there_is_one(weekday: ReportedRun) -> None:
    shown = shown_of_crossings(with_crossing(weekday, vehicles=True))
    (whole,) = shown["crossings"]
    assert (whole["passages"], whole["waited_h"], whole["waited_s_max"], whole["queue"]) == (
        40,
        0.5,
        100.0,
        7,
    )
    assert [row["queue"] for row in shown["crossing_hours"]] == [None, 7]


def test_a_line_without_crossings_has_no_part_of_them(weekday: ReportedRun) -> None:
    assert crossing_tables_shown(weekday) == ()
    assert "crossings" not in line_shown(weekday.line)
    crossed = line_shown(with_crossing(weekday).line)
    assert crossed["crossings"] == [{"id": "C1", "name": "Mill lane", "m": 5000.0}]
