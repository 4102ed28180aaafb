"""Least running times in closed form, and margins of a timetable and a run that can be checked on paper."""

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.graph import find_route
from network.model import Direction
from network.path import Path, path_of
from network.profile import PROFILE
from scenario.scenario import load_scenario
from study.collect.margins import margins_of
from study.measures import running_times
from study.measures.running_times import PlannedLeg, RunWay, least_running_time_s, planned_legs
from study.measures.summary import smallest
from study.record.tables import make_table
from vehicle.train_file import TrainType, load_train, shipped_train

MakeStops: TypeAlias = Callable[[Sequence[tuple[str, str, float | None, float | None]]], pl.DataFrame]

LINE = load_line(shipped_line("rtri_test_line"))
EV = load_train(shipped_train("ev_e301"))
LENGTH_M, POWER_MPS2, BRAKE_MPS2 = 40.0, 48_000.0 / (77_900.0 * 1.08), 0.5


def free_train() -> TrainType:
    """The EV-E301 without resistance, with power for its full force at every speed."""
    row = np.array(EV.row)
    row["resistance"] = 0.0
    row["traction_power_max_w"] = 1e9
    row["speed_max_mps"] = 40.0
    return TrainType("free", "free", (), (), row)


def path() -> Path:
    route = find_route(LINE, "3", "8", Direction.DOWN)
    assert route is not None
    return path_of(LINE, route.piece_ids, Direction.DOWN)


@pytest.fixture
def track(monkeypatch: pytest.MonkeyPatch) -> NDArray[np.void]:
    """Four kilometres of level straight track at 15 m/s, in place of the path's own."""
    rows = np.zeros(4001, PROFILE)
    rows["limit_mps"] = 15.0
    monkeypatch.setattr(running_times, "profile_of", lambda *_: rows)
    return rows


def test_a_trapezoid_in_closed_form(track: NDArray[np.void]) -> None:
    assert track.size == 4001
    time_s = least_running_time_s(free_train(), RunWay(LINE, path(), 100.0, 3100.0), 0.0, BRAKE_MPS2)
    assert time_s == pytest.approx(3000 / 15 + 15 / 2 * (1 / POWER_MPS2 + 1 / BRAKE_MPS2), abs=0.1)
    below_s = least_running_time_s(free_train(), RunWay(LINE, path(), 100.0, 3100.0), 0.0, BRAKE_MPS2, 3.0)
    assert below_s == pytest.approx(3000 / 12 + 12 / 2 * (1 / POWER_MPS2 + 1 / BRAKE_MPS2), abs=0.1)


def test_a_limit_holds_until_the_rear_has_left_it(track: NDArray[np.void]) -> None:
    track["limit_mps"][1500:2001] = 10.0
    time_s = least_running_time_s(free_train(), RunWay(LINE, path(), 0.0, 4000.0), 0.0, BRAKE_MPS2)
    slow_m = 500.0 + LENGTH_M
    expected_s = slow_m / 10 + (4000.0 - slow_m) / 15 + 15 / 2 * (1 / POWER_MPS2 + 1 / BRAKE_MPS2)
    for a in (POWER_MPS2, BRAKE_MPS2):  # each change between 10 and 15 m/s, against having run it at 15 m/s
        expected_s += 5 / a - (15**2 - 10**2) / (2 * a) / 15
    assert time_s == pytest.approx(expected_s, abs=0.3)


def test_a_climb_too_steep_has_no_time(track: NDArray[np.void]) -> None:
    track["elevation_m"] = np.arange(4001) * 0.2
    assert least_running_time_s(EV, RunWay(LINE, path(), 100.0, 3000.0), 1.0, BRAKE_MPS2) == np.inf


def test_curves_and_climbs_take_time(track: NDArray[np.void]) -> None:
    """20 permille over 2 km, or a curve of 30 m over as much: the same to this train, by 600/R permille."""
    way = RunWay(LINE, path(), 200.0, 3600.0)
    track["limit_mps"] = 25.0  # more than 380 kW hold on the climb
    level_s = least_running_time_s(EV, way, 0.5, BRAKE_MPS2)
    along_m = np.clip(np.arange(4001) - 1000.0, 0.0, 2000.0)
    track["turn_rad"] = along_m * 0.02 / 0.6  # a radius of 30 m: 600 / 30 is 20 permille
    curve_s = least_running_time_s(EV, way, 0.5, BRAKE_MPS2)
    track["turn_rad"], track["elevation_m"] = 0.0, along_m * 0.02
    climb_s = least_running_time_s(EV, way, 0.5, BRAKE_MPS2)
    assert curve_s == pytest.approx(climb_s)
    assert curve_s > level_s + 1.0


@given(load=st.floats(0.0, 1.0), below=st.floats(0.0, 5.0), start=st.floats(0.0, 300.0))
def test_load_and_caution_never_make_a_run_shorter(load: float, below: float, start: float) -> None:
    way = RunWay(LINE, path(), start, start + 500.0)
    least_s = least_running_time_s(EV, way, 0.0, 0.6)
    assert least_s >= 500.0 / LINE.max_speed_mps
    assert least_running_time_s(EV, way, load, 0.6, below) >= least_s - 0.05


@pytest.fixture(scope="module")
def weekday_legs() -> dict[tuple[str, str], PlannedLeg]:
    legs = planned_legs(load_scenario("karasuyama_weekday").setup)
    return {(leg.number, leg.from_id): leg for leg in legs}


def test_planned_times_leave_the_least_dwell(weekday_legs: dict[tuple[str, str], PlannedLeg]) -> None:
    """321M leaves Shimotsuke-Hanaoka at 05:43, comes to Niita and leaves it at 05:46; 20 s is the least dwell."""
    assert weekday_legs["321M", "SHN"].planned_s == 3 * 60 - 20
    # a minute at Shimotsuke-Hanaoka is more than enough
    assert weekday_legs["321M", "HSK"].planned_s == 5 * 60
    assert weekday_legs["321M", "TAK"].planned_s == 5 * 60  # it ends at Karasuyama
    assert len(weekday_legs) == 27 * 7 + 2  # the empty working calls at Ogane alone


def test_a_leg_takes_each_direction_its_own_time(weekday_legs: dict[tuple[str, str], PlannedLeg]) -> None:
    """20 permille between Konoyama and Ogane: longer up the hill."""
    down, up = weekday_legs["321M", "KNY"], weekday_legs["322M", "OGN"]
    assert (down.to_id, up.to_id) == ("OGN", "KNY")
    assert down.least_s != up.least_s
    for leg in weekday_legs.values():
        assert 0.0 < leg.least_s < leg.attainable_s


def legs() -> tuple[PlannedLeg, ...]:
    return (
        PlannedLeg("K1", "T1", True, "A", "B", 100.0, 200.0, 80.0, 85.0),
        PlannedLeg("K1", "T1", True, "B", "C", 220.0, 520.0, 290.0, 295.0),
        PlannedLeg("K2", "T3", True, "A", "B", 400.0, 500.0, 110.0, 115.0),
    )


def test_margins_worked_out_by_hand(make_stops: MakeStops) -> None:
    stops = make_stops([("T1", "A", None, 101.0), ("T1", "B", 195.0, 222.0), ("T1", "C", 523.0, None)])
    made = margins_of(legs(), stops)
    names = ("train", "from_station", "planned_s", "margin_s", "margin_percent", "run_s", "left_s")
    assert made.select(names).rows() == [
        ("T1", "A", 100.0, 20.0, pytest.approx(25.0), 94.0, 5.0),
        ("T1", "B", 300.0, 10.0, pytest.approx(100 / 29), 301.0, -3.0),
        ("T3", "A", 100.0, -10.0, pytest.approx(-1000 / 110), None, None),  # it never ran
    ]
    # T1 is ended at C: the departure from there, which does not come, has a row of its own.
    ended = stops.tail(1).with_columns(arrival_s=pl.lit(None, pl.Float64), cancelled=pl.lit(value=True))
    assert margins_of(legs(), pl.concat([stops, ended])).equals(made)
    found = smallest(made)
    assert found is not None
    assert (found["smallest_margin_s"]["train"], found["smallest_margin_s"]["margin_s"]) == ("T3", -10.0)
    assert (found["smallest_left_s"]["train"], found["smallest_left_s"]["left_s"]) == ("T1", -3.0)
    assert found["smallest_left_s"]["from_station"] == "B"


def test_what_never_ran_is_as_late_as_the_run_may_last(make_stops: MakeStops) -> None:
    """T1 comes to B 5 s before its time and stands there, T3 never runs: of the three hops one is better than none."""
    stops = make_stops([("T1", "A", None, 101.0), ("T1", "B", 195.0, None)])
    assert margins_of(legs(), stops, 1000.0)["left_s"].to_list() == [5.0, 520.0 - 1000.0, 500.0 - 1000.0]
    # C is not due yet
    assert margins_of(legs(), stops, 510.0)["left_s"].to_list() == [5.0, None, 500.0 - 510.0]
    cut = make_stops([("T1", "C", None, None)]).with_columns(late_arrival_s=180.0, cancelled=True)
    assert margins_of(legs(), pl.concat([stops, cut]), 510.0)["left_s"].to_list() == [5.0, -180.0, -10.0]


def test_the_smallest_margin_in_seconds_need_not_be_that_in_percent(make_stops: MakeStops) -> None:
    two = (
        PlannedLeg("K1", "T1", True, "A", "B", 0.0, 110.0, 100.0, 100.0),  # 10 s, 10 %
        PlannedLeg("K1", "T1", True, "B", "C", 0.0, 1012.0, 1000.0, 1000.0),  # 12 s, 1.2 %
    )
    found = smallest(margins_of(two, make_stops([])))
    assert found is not None
    assert found["smallest_margin_s"]["from_station"] == "A"
    assert found["smallest_margin_percent"]["from_station"] == "B"
    assert "smallest_left_s" not in found


def test_no_hop_has_no_smallest_margin() -> None:
    assert smallest(make_table("margins")) is None
