"""Track occupation, station timetable and punctuality, by hand on a small day."""

import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.files.timetable_schema import HeadTable
from network.model import Line
from network.timetable import Timetable, parse_timetable
from study.measures.missing import planned_times
from study.measures.punctuality import ALL_STATIONS, punctuality
from study.measures.station_papers import (
    STATION_TIMETABLE,
    TRACK_OCCUPATION,
    station_timetable,
    track_occupation,
)
from study.record.figure import schema_of
from study.record.tables import ROWS, make_table
from tests.conftest import TURN_BACK_TIMETABLE

END_S = 86_400.0
NO_TRAINS = Timetable(HeadTable(id="none", line="karasuyama"), {}, ())  # what is planned stands in the stops
PASSED = '{ station = "OGN", track = "1", arrival = "05:57" }'
TIMES = TURN_BACK_TIMETABLE.replace(PASSED, f'{{ station = "NIT", pass = "05:45:30" }}, {PASSED}').replace(
    'ends = "stabled"', 'ends = "portal:HSK.MU"'
)
H5, H6 = 5 * 3600.0, 6 * 3600.0
# unit, train, station, track, kind, planned arrival and departure, arrival and departure
CALLS = (
    ("V1", "1D", "HSK", "1", "stop", None, H5 + 37 * 60, H5 + 1900, H5 + 37 * 60 + 1),
    ("V1", "1D", "SHN", "1", "stop", H5 + 42 * 60, H5 + 43 * 60, H5 + 42 * 60 - 10, H5 + 43 * 60 + 2),
    ("V1", "1D", "NIT", "1", "pass", None, H5 + 45 * 60 + 30, None, H5 + 45 * 60 + 40),
    ("V1", "1D", "OGN", "1", "stop", H5 + 57 * 60, None, H5 + 58 * 60 + 5, None),
    ("V1", "2U", "OGN", "1", "stop", None, H6 + 5 * 60, None, H6 + 5 * 60 + 3),
    ("V1", "2U", "HSK", "2", "stop", H6 + 26 * 60, None, H6 + 25 * 60 + 40, None),
)


@pytest.fixture(scope="module")
def line() -> Line:
    return load_line(shipped_line("karasuyama"))


@pytest.fixture(scope="module")
def timetable(line: Line) -> Timetable:
    return parse_timetable(TIMES, "small.toml", line)


@pytest.fixture(scope="module")
def stops() -> pl.DataFrame:
    names = ("unit", "train", "station", "track", "kind", "planned_arrival_s", "planned_departure_s")
    rows = [dict(zip((*names, "arrival_s", "departure_s"), call, strict=True)) for call in CALLS]
    for row in rows:
        for what in ("arrival", "departure"):
            came, due = row[f"{what}_s"], row[f"planned_{what}_s"]
            row[f"late_{what}_s"] = None if came is None or due is None else came - due
    return make_table(
        "stops",
        {name: [row.get(name, True) for row in rows] for name in schema_of(ROWS["stops"])}
        | {"stop_error_m": [None] * len(rows), "cancelled": [False] * len(rows)},
    )


def test_a_stock_that_turns_back_has_its_track_from_one_train_to_the_next(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    found = track_occupation(stops, line, timetable)
    assert list(found.columns) == list(TRACK_OCCUPATION)
    ogane = found.filter(pl.col("station") == "OGN").to_dicts()
    assert len(ogane) == 1
    assert (ogane[0]["train"], ogane[0]["next_train"], ogane[0]["track"]) == ("1D", "2U", "1")
    assert (ogane[0]["planned_from_s"], ogane[0]["planned_to_s"]) == (H5 + 57 * 60, H6 + 5 * 60)
    assert (ogane[0]["from_s"], ogane[0]["to_s"]) == (H5 + 58 * 60 + 5, H6 + 5 * 60 + 3)


def test_two_trains_of_a_stock_that_left_the_line_between_them_have_a_row_each(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    hoshakuji = track_occupation(stops, line, timetable).filter(pl.col("station") == "HSK").to_dicts()
    assert [(row["train"], row["next_train"], row["track"]) for row in hoshakuji] == [
        ("1D", "1D", "1"),
        ("2U", "2U", "2"),
    ]
    assert hoshakuji[0]["planned_from_s"] is None  # from another line, at no time of this one's plan
    assert hoshakuji[1]["planned_to_s"] is None


def test_a_train_that_comes_in_by_a_portal_begins_a_stay_of_its_own(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    around = pl.concat([stops[5:], stops[:1]])  # 2U ends at Hoshakuji and goes; its set comes back as 1D
    found = track_occupation(around, line, timetable).filter(pl.col("station") == "HSK").to_dicts()
    assert sorted((row["train"], row["next_train"]) for row in found) == [("1D", "1D"), ("2U", "2U")]


def test_waits_tell_how_long_a_stock_stood_that_no_call_says(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    arrived_s = H6 + 25 * 60 + 40
    stood = [
        ("HSK", arrived_s, arrived_s + 20),
        ("HSK", arrived_s + 20, arrived_s + 21.2),
        ("", arrived_s + 21.2, 9e4),
    ]
    columns: dict[str, list[object]] = {name: [None] * len(stood) for name in schema_of(ROWS["waits"])}
    columns |= {"unit": ["V1"] * 3, "place": [s[0] for s in stood]}
    columns |= {"from_s": [s[1] for s in stood], "to_s": [s[2] for s in stood]}
    found = track_occupation(stops, line, timetable, make_table("waits", columns)).to_dicts()
    last = next(row for row in found if row["train"] == "2U")
    assert (last["from_s"], last["to_s"]) == (arrived_s, arrived_s + 21.2)


def test_a_passing_train_has_its_track_for_a_moment(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    (passing,) = track_occupation(stops, line, timetable).filter(pl.col("station") == "NIT").to_dicts()
    assert passing["kind"] == "pass"
    assert passing["planned_from_s"] == passing["planned_to_s"] == H5 + 45 * 60 + 30
    assert passing["from_s"] == passing["to_s"] == H5 + 45 * 60 + 40


def test_occupation_stands_in_the_order_of_the_line(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    assert track_occupation(stops, line, timetable)["station"].to_list() == [
        "HSK",
        "HSK",
        "SHN",
        "NIT",
        "OGN",
    ]


def test_the_station_timetable_has_every_call_with_where_it_goes(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    found = station_timetable(stops, line, timetable)
    assert list(found.columns) == list(STATION_TIMETABLE)
    assert len(found) == len(CALLS)
    ogane = found.filter(pl.col("station") == "OGN").to_dicts()
    assert [(row["direction"], row["train"], row["origin"], row["destination"]) for row in ogane] == [
        ("down", "1D", "HSK", "OGN"),
        ("up", "2U", "OGN", "HSK"),
    ]
    assert ogane[1]["planned_departure_s"] == H6 + 5 * 60
    assert ogane[1]["departure_s"] == H6 + 5 * 60 + 3


def test_what_never_came_is_in_the_papers_of_a_station_as_it_was_planned(
    stops: pl.DataFrame, line: Line, timetable: Timetable
) -> None:
    """1D comes to a stand beyond its second stop, and its set never runs as 2U."""
    ogane = station_timetable(stops[:2], line, timetable).filter(pl.col("station") == "OGN")
    assert ogane.select("train", "planned_arrival_s", "planned_departure_s", "departure_s").rows() == [
        ("1D", H5 + 57 * 60, None, None),
        ("2U", None, H6 + 5 * 60, None),
    ]
    stays = track_occupation(stops[:2], line, timetable).filter(pl.col("station") == "OGN")
    assert stays.select(
        "train", "next_train", "track", "planned_from_s", "planned_to_s", "from_s"
    ).rows() == [("1D", "2U", "1", H5 + 57 * 60, H6 + 5 * 60, None)]
    # what the run was too short for is not missing
    until_six = station_timetable(stops[:2], line, timetable, H6)
    assert until_six.filter(pl.col("station") == "OGN")["train"].to_list() == ["1D"]


@pytest.mark.parametrize(("ends", "due"), [("stabled", 0), ("portal:HSK.MU", 1)])
def test_nobody_waits_for_a_departure_where_a_train_ends_on_the_line(
    stops: pl.DataFrame, line: Line, ends: str, due: int
) -> None:
    """Timetables of others have a departure at the last call too; whose set is stabled there has none to keep."""
    text = TURN_BACK_TIMETABLE.replace('arrival = "06:26" }', 'arrival = "06:26", departure = "06:28" }')
    timetable = parse_timetable(text.replace('ends = "stabled"', f'ends = "{ends}"'), "small.toml", line)
    last = (pl.col("train") == "2U") & (pl.col("station") == "HSK")
    given = stops.with_columns(
        planned_departure_s=pl.when(last).then(H6 + 28 * 60).otherwise("planned_departure_s")
    )
    for table in (given, given[:4]):  # it came there, and it never ran
        times = planned_times(table, timetable).filter(last, pl.col("what") == "departure")
        assert len(times) == due
        (row,) = station_timetable(table, line, timetable).filter(last).to_dicts()
        assert (row["planned_departure_s"] is not None) is bool(due)


def test_punctuality_by_station_by_hand(stops: pl.DataFrame, line: Line) -> None:
    found = {
        (row["station"], row["what"]): row
        for row in punctuality(planned_times(stops, NO_TRAINS), line).to_dicts()
    }
    ogane = found["OGN", "arrival"]
    assert (ogane["planned"], ogane["came"], ogane["on_time_share"]) == (1, 1, 0.0)  # 65 s late
    assert (ogane["mean_s"], ogane["sigma_s"], ogane["worst_s"]) == (65.0, None, 65.0)
    assert ogane["worst_train"] == "1D"
    assert ("NIT", "departure") not in found  # a passing is neither arrival nor departure
    everywhere = found[ALL_STATIONS, "arrival"]
    assert everywhere["planned"] == 3
    assert everywhere["on_time_share"] == pytest.approx(2 / 3)
    assert everywhere["mean_s"] == pytest.approx((-10 + 65 - 20) / 3)
    assert everywhere["whole_minutes"]


@pytest.mark.parametrize(("late_s", "share"), [(59.0, 1.0), (60.0, 0.0)])
def test_who_is_a_minute_late_is_not_on_time(
    stops: pl.DataFrame, line: Line, late_s: float, share: float
) -> None:
    """As Japanese operators count: less than a minute late is on time."""
    late = stops.with_columns(pl.lit(late_s).alias("late_arrival_s"))
    rows = punctuality(planned_times(late, NO_TRAINS, END_S), line).to_dicts()
    assert {row["on_time_share"] for row in rows if row["what"] == "arrival"} == {share}


def test_what_did_not_come_is_not_on_time(stops: pl.DataFrame, line: Line) -> None:
    lost = stops.with_columns(
        pl.when(pl.col("station") == "SHN").then(None).otherwise(pl.col(name)).alias(name)
        for name in ("arrival_s", "late_arrival_s")
    )
    row = next(
        row
        for row in punctuality(planned_times(lost, NO_TRAINS, END_S), line).to_dicts()
        if (row["station"], row["what"]) == ("SHN", "arrival")
    )
    assert (row["planned"], row["came"], row["on_time_share"]) == (1, 0, 0.0)
    assert (
        row["mean_s"]
        == row["worst_s"]
        == END_S - lost.filter(pl.col("station") == "SHN")["planned_arrival_s"].max()
    )


def test_a_train_that_never_ran_is_in_every_figure(line: Line, timetable: Timetable) -> None:
    rows = punctuality(planned_times(make_table("stops"), timetable, END_S), line).to_dicts()
    whole = {row["what"]: row for row in rows if row["station"] == ALL_STATIONS}
    planned = sum(
        call.stops and call.arrival_s is not None for t in timetable.trains.values() for call in t.calls
    )
    assert (whole["arrival"]["planned"], whole["arrival"]["came"]) == (planned, 0)
    assert whole["arrival"]["on_time_share"] == 0.0
    assert whole["departure"]["mean_s"] > 3600.0


def test_a_plan_in_seconds_is_not_marked_as_whole_minutes(stops: pl.DataFrame, line: Line) -> None:
    finer = stops.with_columns(pl.col("planned_arrival_s") + 15.0)
    rows = punctuality(planned_times(finer, NO_TRAINS), line).to_dicts()
    assert not any(row["whole_minutes"] for row in rows if row["what"] == "arrival")
    assert all(row["whole_minutes"] for row in rows if row["what"] == "departure")


@given(late_s=st.lists(st.integers(-300, 900), min_size=1, max_size=60))
def test_the_ninety_fifth_percentile_is_the_nearest_rank(late_s: list[int]) -> None:
    line = load_line(shipped_line("karasuyama"))
    count = len(late_s)
    columns = {name: [None] * count for name in schema_of(ROWS["stops"])} | {
        "train": [str(i) for i in range(count)],
        "station": ["OGN"] * count,
        "kind": ["stop"] * count,
        "planned_arrival_s": [36000.0] * count,
        "late_arrival_s": [float(s) for s in late_s],
        "cancelled": [False] * count,
    }
    row = punctuality(planned_times(make_table("stops", columns), NO_TRAINS), line).to_dicts()[0]
    at_most = sum(s <= row["p95_s"] for s in late_s)
    below = sum(s < row["p95_s"] for s in late_s)
    assert at_most >= 0.95 * count > below
    assert row["on_time_share"] == pytest.approx(sum(s < 60 for s in late_s) / count)
    assert late_s[int(row["worst_train"])] == row["worst_s"] == max(late_s)
