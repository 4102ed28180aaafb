"""The figures by which runs are compared, and the rows behind them, on made-up tables whose figures are known."""

from dataclasses import replace

import polars as pl
import pytest

from study.compare.comparison import compare, compare_two, verdict_of
from study.compare.grids import inputs_grid, measures_grid, moved_matrix, once_grid, rows_grid
from study.compare.measures import compare_rows, figures_of, measures_of
from study.measures.missing import planned_times
from study.measures.summary import energy_summary
from study.report.data import ReportedRun
from tests.study.compare.sides import side, with_tables
from tests.study.crossed_day import with_crossing


def figure(run: ReportedRun, group: str, name: str, unit: str = "") -> float | None:
    (found,) = (f for f in figures_of(side(run)) if (f.group, f.name, f.unit) == (group, name, unit))
    return found.value


LATE: list[float | None] = [-20.0, 0.0, 5.0, 15.0, 60.0, 60.1, 180.0, 300.1, None, -1.0]


def arrivals(run: ReportedRun, late_s: list[float | None]) -> ReportedRun:
    """A run with so many planned arrivals at one station each, late by so much; None did not come."""
    stops = run.tables.stops.filter(pl.col("planned_arrival_s").is_not_null()).head(len(late_s))
    late = pl.Series(late_s, dtype=pl.Float64)
    # What is planned stands in the stops.
    own = ReportedRun(run.line, replace(run.timetable, trains={}), run.tables)
    return with_tables(
        own,
        stops=stops.with_columns(
            late.alias("late_arrival_s"), (pl.col("planned_arrival_s") + late).alias("arrival_s")
        ),
    )


def test_punctuality_counts_what_did_not_come_as_late(weekday: ReportedRun) -> None:
    run = arrivals(weekday, LATE)
    shares = {
        name: figure(run, "arrivals", name, "%")
        for name in (
            "not late (within 5 s)",
            "at most 15 s late",
            "at most 1 min late",
            "at most 3 min late",
            "at most 5 min late",
        )
    }
    assert list(shares.values()) == pytest.approx([40.0, 50.0, 60.0, 80.0, 80.0])
    assert figure(run, "arrivals", "never came", "") == 1.0
    never_s = figure(run, "arrivals", "worst lateness", "s")
    assert never_s is not None and never_s > 300.1
    known = [late for late in LATE if late is not None]
    assert figure(run, "arrivals", "mean lateness", "s") == pytest.approx((sum(known) + never_s) / 10)


def test_nothing_is_better_for_trains_that_never_ran(weekday: ReportedRun) -> None:
    """Half of the trains left out of the table of stops: they are planned all the same."""
    assert planned_times(weekday.tables.stops, weekday.timetable)["came"].all()
    half = set(sorted(weekday.timetable.trains)[::2])
    fewer = with_tables(weekday, stops=weekday.tables.stops.filter(pl.col("train").is_in(half)))
    for group in ("arrivals", "departures"):
        assert figure(fewer, group, "planned", "") == figure(weekday, group, "planned", "")
        assert figure(fewer, group, "at most 5 min late", "%") < figure(
            weekday, group, "at most 5 min late", "%"
        )
        for name in ("mean lateness", "worst lateness"):
            assert figure(fewer, group, name, "s") > figure(weekday, group, name, "s") + 60.0


def test_of_a_part_of_a_day_trains_are_counted_as_in_its_summary(weekday: ReportedRun) -> None:
    end_s = 8 * 3600.0
    due = {n for n, train in weekday.timetable.trains.items() if train.calls[-1].first_s <= end_s}
    counted = {f.name: f.value for f in figures_of(side(weekday, latest_end_s=end_s)) if f.group == "trains"}
    assert 0 < len(due) < len(weekday.timetable.trains)
    assert counted["planned"] == counted["ran their whole journey"] == len(due)


def test_figures_of_a_run_without_anything_are_none_or_nought(weekday: ReportedRun) -> None:
    empty = ReportedRun(
        weekday.line,
        weekday.timetable,
        type(weekday.tables)(
            **{name: getattr(weekday.tables, name).clear() for name in weekday.tables.__slots__}
        ),
    )
    values = [f.value for f in figures_of(side(empty))]
    assert None in values and all(value is None or value >= 0.0 for value in values)
    found = compare((side(weekday), side(empty, "empty")), 1.0)
    assert "there is nothing to compare" in verdict_of(found.pairs[0])[0]
    assert len(found.pairs[0].times.only_base) == len(weekday.timetable.trains)


def test_margins_name_their_hop_and_leave_out_what_no_train_can_run(weekday: ReportedRun) -> None:
    margins = weekday.tables.margins.with_columns(
        pl.when(pl.col("train") == "330M").then(-3.0).otherwise(0.0).alias("margin_s"),
        pl.when(pl.col("train") == "331M").then(float("-inf")).otherwise(20.0).alias("margin_percent"),
    )
    found = list(figures_of(side(with_tables(weekday, margins=margins))))
    least = next(f for f in found if (f.group, f.name, f.unit) == ("margins", "smallest planned", "s"))
    assert (least.value, least.where.en) == (-3.0, "330M Karasuyama – Hoshakuji")
    percent = next(f for f in found if (f.group, f.name, f.unit) == ("margins", "smallest planned", "%"))
    assert percent.value == 20.0
    short = next(f for f in found if f.name == "hops that the plan cannot keep")
    assert short.value == margins.filter(train="330M").height > 0  # to do what it can just do is kept


def test_energy_by_distance_is_told_with_and_without_layovers_as_the_report_tells_it(
    weekday: ReportedRun,
) -> None:
    tables = weekday.tables
    whole = energy_summary(tables)
    figures = {(f.name, f.unit): f.value for f in figures_of(side(weekday)) if f.group == "energy"}
    assert tables.layovers["net_kwh"].sum() > 0.0
    for key, unit in (("net_kwh_per_train_km", "kWh/train-km"), ("net_kwh_per_car_km", "kWh/car-km")):
        assert figures["net", unit] == whole[key]["trains"]
        assert figures["net, with layovers", unit] == whole[key]["all"]
    assert figures["net", "kWh/train-km"] != figures["net, with layovers", "kWh/train-km"]


def test_rows_are_matched_by_name_and_told_where_they_differ(weekday: ReportedRun) -> None:
    energy = weekday.tables.energy
    more = energy.with_columns(
        pl.when(pl.col("train") == "333M")
        .then(pl.col("net_kwh") + 2.5)
        .otherwise(pl.col("net_kwh"))
        .alias("net_kwh")
    ).reverse()
    base, new = side(weekday), side(with_tables(weekday, energy=more), "new")
    (row,) = compare_rows(base, new, "energy")
    assert row.names == ("333M",) and row.by("net_kwh") == pytest.approx(2.5)
    (net,) = (m for m in measures_of((base, new)) if (m.group, m.name, m.unit) == ("energy", "net", "kWh"))
    assert net.by(1) == pytest.approx(2.5)
    without = side(with_tables(weekday, energy=energy.filter(pl.col("train") != "333M")), "new")
    (gone,) = compare_rows(base, without, "energy")
    assert gone.values["net_kwh"][1] is None
    assert gone.by("net_kwh") == pytest.approx(-float(energy.filter(pl.col("train") == "333M")["net_kwh"][0]))
    (came,) = compare_rows(without, base, "energy")
    assert came.by("net_kwh") == pytest.approx(-float(gone.by("net_kwh") or 0.0))


def test_telegrams_are_counted_by_kind_whoever_sent_them(weekday: ReportedRun) -> None:
    telegrams = weekday.tables.telegrams
    asked = pl.col("kind") == "PointsCommand"
    more = telegrams.with_columns(
        pl.when(asked).then(pl.col("sent") + 7).otherwise(pl.col("sent")).alias("sent")
    )
    (row,) = compare_rows(side(weekday), side(with_tables(weekday, telegrams=more), "new"), "telegrams")
    units = telegrams.filter(asked).height
    assert row.names == ("PointsCommand",) and row.by("sent") == 7 * units


def test_grids_show_two_runs_with_their_difference_and_more_in_one_table(weekday: ReportedRun) -> None:
    late = arrivals(weekday, [5.0] * 20)
    three = compare((side(weekday), side(weekday, "same"), side(late, "late")), 1.0)
    grid = measures_grid(three)
    assert grid.header == ("", "", "base", "same", "late")
    assert all(row[2] == row[3] for row in grid.rows)
    two = measures_grid(three.of_two(1), changed_only=True)
    assert two.header == ("", "", "base", "late", "difference")
    assert 0 < len(two.rows) < len(grid.rows)
    assert all(row[4] != "=" for row in two.rows)
    assert not measures_grid(three.of_two(0), changed_only=True).rows
    assert len({len(row) for row in grid.rows}) == 1
    assert measures_of(three.sides) == three.measures


def test_every_grid_has_as_many_cells_as_headings(weekday: ReportedRun) -> None:
    stops = weekday.tables.stops.with_columns(pl.col("departure_s") + 9.0)
    base, new = side(weekday), side(with_tables(weekday, stops=stops), "new")
    pair = compare_two(base, new, 1.0)
    for grid in (moved_matrix(pair, new), inputs_grid(pair), *(rows_grid(pair, t, new) for t in pair.rows)):
        assert all(len(row) == len(grid.header) for row in grid.rows)
    last = pl.when(train="347M", station="KRS").then(None).otherwise(pl.col("arrival_s")).alias("arrival_s")
    gone = side(with_tables(weekday, stops=weekday.tables.stops.with_columns(last)), "gone")
    assert [row[3] for row in once_grid(compare_two(base, gone, 1.0), gone).rows] == ["base"]
    matrix = moved_matrix(pair, new)
    assert {cell for row in matrix.rows for cell in row[2:]} <= {"· / +9", ""}


def test_level_crossings_of_a_day_are_one_group_which_lines_without_any_leave_out(
    weekday: ReportedRun,
) -> None:
    """60 s and 180 s closed; one train was warned of for 30 s, and three for 38 s on average: 36 s."""
    crossed = with_crossing(weekday)
    found = {
        (one.name, one.unit): one.values
        for one in measures_of((side(weekday), side(crossed)))
        if one.group == "level crossings"
    }
    assert found == {
        ("road closed", "min"): (None, 4.0),
        ("closures", ""): (None, 3),
        ("longest closure", "s"): (None, 120.0),
        ("trains over it", ""): (None, 4),
        ("mean warning", "s"): (None, 36.0),
        ("least warning", "s"): (None, 30.0),
        ("longest warning", "s"): (None, 44.0),
    }
    assert all(one.group != "level crossings" for one in measures_of((side(weekday), side(weekday))))


def test_hours_of_a_crossing_are_compared_one_by_one(weekday: ReportedRun) -> None:
    crossed = with_crossing(weekday)
    hours = crossed.tables.crossings
    longer = with_tables(
        crossed,
        crossings=hours.with_columns(
            closed_s=pl.when(pl.col("hour") == 8).then(200.0).otherwise(pl.col("closed_s"))
        ),
    )
    (row,) = compare_rows(side(crossed), side(longer), "crossings")
    assert (row.names, row.by("closed_s"), row.by("trains")) == (("C1", "8"), 20.0, 0.0)
