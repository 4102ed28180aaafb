"""Which times moved: matched by train and station, beyond the threshold, with their sign."""

import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.compare.times import CallEvent, compare_times
from study.report.data import ReportedRun
from tests.study.compare.sides import with_tables


def shifted(run: ReportedRun, train: str, station: str, what: str, by_s: float) -> pl.DataFrame:
    """The table of stops with one time moved."""
    here = (pl.col("train") == train) & (pl.col("station") == station)
    column = f"{what}_s"
    return run.tables.stops.with_columns(
        pl.when(here).then(pl.col(column) + by_s).otherwise(pl.col(column)).alias(column)
    )


def test_a_run_against_itself_moves_nothing(weekday: ReportedRun) -> None:
    times = compare_times(weekday, weekday, 0.0)
    stops = weekday.tables.stops
    assert times.compared == sum(
        stops[f"{what.value}_s"].count() for what in (CallEvent.ARRIVAL, CallEvent.DEPARTURE)
    )
    assert (times.largest_s, times.moved, times.once) == (0.0, (), ())
    assert (times.only_base, times.only_new) == ((), ())


def test_one_time_that_moved_is_told_with_train_station_and_sign(weekday: ReportedRun) -> None:
    stops = shifted(weekday, "324M", "OGN", "departure", -7.5)
    (moved,) = compare_times(weekday, with_tables(weekday, stops=stops), 1.0).moved
    assert (moved.train, moved.station, moved.what, moved.direction) == (
        "324M",
        "OGN",
        CallEvent.DEPARTURE,
        "up",
    )
    assert (moved.by_s, moved.plan_by_s) == (-7.5, 0.0)
    assert moved.new_s == pytest.approx(moved.old_s - 7.5)


@pytest.mark.parametrize(
    ("by_s", "over_s", "told"), [(1.0, 1.0, 0), (1.1, 1.0, 1), (-1.1, 1.0, 1), (0.1, 0.0, 1), (5.0, 5.0, 0)]
)
def test_more_than_the_threshold_is_more(weekday: ReportedRun, by_s: float, over_s: float, told: int) -> None:
    """Times are of tenths of a second; their floats are not allowed to tip the scale."""
    stops = shifted(weekday, "321M", "TAK", "arrival", by_s)
    times = compare_times(weekday, with_tables(weekday, stops=stops), over_s)
    assert len(times.moved) == told
    assert times.largest_s == pytest.approx(abs(by_s))


def test_rows_in_another_order_move_nothing_and_hide_nothing(weekday: ReportedRun) -> None:
    """Matched by row, every train would have moved, or the wrong one."""
    stops = shifted(weekday, "340M", "KNY", "arrival", 33.0)
    for table in (stops.reverse(), stops.sample(fraction=1.0, shuffle=True, seed=3)):
        (moved,) = compare_times(weekday, with_tables(weekday, stops=table), 1.0).moved
        assert (moved.train, moved.station, moved.by_s) == ("340M", "KNY", 33.0)


def test_a_train_taken_out_before_the_others_shifts_no_row(weekday: ReportedRun) -> None:
    stops = weekday.tables.stops.filter(pl.col("train") != "321M")
    times = compare_times(weekday, with_tables(weekday, stops=stops), 0.0)
    assert (times.moved, times.only_base, times.only_new) == ((), ("321M",), ())
    back = compare_times(with_tables(weekday, stops=stops), weekday, 0.0)
    assert (back.moved, back.only_base, back.only_new) == ((), (), ("321M",))
    # A train of one run only is told as that, and not each of its times.
    assert times.once == back.once == ()


def test_what_came_in_one_run_only_is_told(weekday: ReportedRun) -> None:
    last = (pl.col("train") == "347M") & (pl.col("station") == "KRS")
    stops = weekday.tables.stops.with_columns(
        pl.when(last).then(None).otherwise(pl.col("arrival_s")).alias("arrival_s")
    )
    times = compare_times(weekday, with_tables(weekday, stops=stops), 1.0)
    (once,) = times.once
    assert (once.train, once.station, once.what, once.in_new) == ("347M", "KRS", CallEvent.ARRIVAL, False)
    assert times.compared == compare_times(weekday, weekday, 1.0).compared - 1


def test_a_station_called_at_twice_is_two_calls(weekday: ReportedRun) -> None:
    """As of a train that comes by again: the second call is compared with the second."""
    stops = weekday.tables.stops
    again = stops.filter(pl.col("train") == "321M", pl.col("station") == "KNY")
    again = again.with_columns(pl.col("arrival_s") + 900.0, pl.col("departure_s") + 900.0)
    twice = pl.concat([stops, again])
    first = shifted(weekday, "321M", "KNY", "departure", 2.0)
    later = pl.concat([first, again.with_columns(pl.col("departure_s") + 4.0)])
    times = compare_times(with_tables(weekday, stops=twice), with_tables(weekday, stops=later), 1.0)
    assert [(m.station, m.what, m.by_s) for m in times.moved] == [
        ("KNY", CallEvent.DEPARTURE, 2.0),
        ("KNY", CallEvent.DEPARTURE, 4.0),
    ]


def test_a_train_that_passes_has_one_time_and_its_own_word(weekday: ReportedRun) -> None:
    here = (pl.col("train") == "321M") & (pl.col("station") == "TAK")
    passes = weekday.tables.stops.with_columns(
        pl.when(here).then(pl.lit("pass")).otherwise(pl.col("kind")).alias("kind"),
        pl.when(here).then(None).otherwise(pl.col("arrival_s")).alias("arrival_s"),
    )
    later = passes.with_columns(
        pl.when(here).then(pl.col("departure_s") + 6.0).otherwise(pl.col("departure_s")).alias("departure_s")
    )
    (moved,) = compare_times(with_tables(weekday, stops=passes), with_tables(weekday, stops=later), 1.0).moved
    assert (moved.what, moved.by_s) == (CallEvent.PASSING, 6.0)
    # One that stops in one run and passes in the other did not move: it does something else.
    times = compare_times(weekday, with_tables(weekday, stops=passes), 1.0)
    assert times.moved == ()
    assert {(once.what, once.in_new) for once in times.once} == {
        (CallEvent.ARRIVAL, False),
        (CallEvent.DEPARTURE, False),
        (CallEvent.PASSING, True),
    }


@given(st.data())
def test_whatever_moved_is_told_and_nothing_else(weekday: ReportedRun, data: st.DataObject) -> None:
    stops = weekday.tables.stops
    order = data.draw(st.permutations(range(stops.height)))
    by_s = data.draw(
        st.lists(st.integers(-50, 50).map(lambda t: t / 10), min_size=stops.height, max_size=stops.height)
    )
    over_s = data.draw(st.sampled_from([0.0, 0.5, 1.0, 3.0]))
    moved = stops.with_columns(pl.col("arrival_s") + pl.Series(by_s))[list(order)]
    times = compare_times(weekday, with_tables(weekday, stops=moved), over_s)
    rows = zip(stops["train"], stops["station"], stops["arrival_s"], by_s, strict=True)
    expected = {
        (train, station): by for train, station, at_s, by in rows if at_s is not None and abs(by) > over_s
    }
    assert {(m.train, m.station): m.by_s for m in times.moved} == expected
    assert [m.new_s for m in times.moved] == sorted(m.new_s for m in times.moved)
