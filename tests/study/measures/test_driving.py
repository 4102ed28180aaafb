"""The table of how hops were driven: records made by hand, with their figures by hand."""

from dataclasses import fields, replace
from types import SimpleNamespace
from typing import Any, Final

import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.units import J_PER_KWH
from simulation.result import COUNTED, DRAWN, EnergyPhase, EnergyRecord
from simulation.ride import Ride
from study.measures.driving import Stock, driven_hops, driving_summary, driving_sums, driving_table
from study.record.driving import DrivenHop
from study.record.figure import rows_in, schema_of
from study.record.tables import ROWS, make_table
from vehicle.train_file import RegenerationReceiver

STOCKS: Final = {
    "K1": Stock("hold_speed", RegenerationReceiver.BATTERY),
    "K2": Stock("follow_plan", RegenerationReceiver.RESISTORS),
}


def run_of(
    unit: str, train: str, ends: str, times_s: tuple[float, float], kwh: tuple[float, float], ride: Ride
) -> EnergyRecord:
    joules = (figure * J_PER_KWH for figure in kwh)
    counted_j = dict.fromkeys(COUNTED, 0.0) | dict(zip(DRAWN, (*joules, 9e6), strict=True))
    return EnergyRecord(
        unit, train, True, EnergyPhase.RUNNING, *ends.split("-"), *times_s, ride.moved_m, counted_j, ride=ride
    )


# 100 s and 1000 m: 40 s and 400 m accelerating, 10 and 100 even, 30 and 400 coasting, 20 and 100 braking.
WHOLE: Final = Ride(6, 4, 0.8, 1.0, 0.4, (40.0, 10.0, 30.0, 20.0), (400.0, 100.0, 400.0, 100.0))
REST: Final = Ride(2, 1, 0.9, 3.0, 0.2, (50.0, 0.0, 0.0, 50.0), (250.0, 0.0, 0.0, 250.0))
HOPS: Final = (
    run_of("K1", "T1", "A-B", (10.0, 110.0), (5.0, 2.0), WHOLE),
    replace(run_of("K1", "T1", "B-B", (110.0, 140.0), (0.0, 0.0), Ride()), phase=EnergyPhase.AT_STOP),
    run_of("K1", "T1", "B-C", (140.0, 240.0), (4.0, 1.0), WHOLE),
    replace(run_of("K1", "T1", "B-C", (240.0, 300.0), (0.0, 0.0), Ride()), phase=EnergyPhase.HELD),
    run_of("K1", "T1", "B-C", (300.0, 400.0), (3.0, 1.0), REST),  # held before C
    run_of("K2", "T2", "B-A", (10.0, 110.0), (5.0, 2.0), WHOLE),
)
LATE: Final = {("T1", "A", "B"): -8.0, ("T1", "B", "C"): 2.0}


def hops() -> tuple[DrivenHop, ...]:
    return driven_hops(HOPS, STOCKS, LATE, {("T1", "B"): 0.1})


def test_a_hop_is_late_by_what_was_not_left_on_its_arrival() -> None:
    kind = SimpleNamespace(regenerated_to=RegenerationReceiver.BATTERY)
    result: Any = SimpleNamespace(energy=HOPS[:1])
    setup: Any = SimpleNamespace(laws={"K1": "follow_plan"}, trains={"K1": kind})
    ends = {"train": ["T1"], "from_station": ["A"], "to_station": ["B"], "left_s": [30.0]}
    stops = {"train": ["T1"], "station": ["B"], "stop_error_m": [0.2], "cancelled": [False]}
    row = driving_table(result, setup, pl.DataFrame(ends), pl.DataFrame(stops)).row(0, named=True)
    assert (row["law"], row["late_s"], row["stop_error_m"]) == ("follow_plan", -30.0, 0.2)


def test_hops_worked_out_by_hand() -> None:
    one, two, three = hops()
    assert (one.train, one.from_station, one.to_station, one.law) == ("T1", "A", "B", "hold_speed")
    assert (one.begin_s, one.run_s, one.distance_m) == (10.0, 100.0, 1000.0)
    assert (one.traction_kwh, one.regenerated_kwh, one.running_kwh) == pytest.approx((5.0, 2.0, 3.0))
    assert (one.power_changes, one.brake_changes, one.late_s, one.stop_error_m) == (6, 4, -8.0, 0.1)
    assert one.jerk_rms_mps3 == pytest.approx(0.1)  # of 1 m2/s5 in 100 s
    assert (one.coasting_time_percent, one.coasting_way_percent) == pytest.approx((30.0, 40.0))
    assert (one.cruising_time_percent, one.cruising_way_percent) == pytest.approx((10.0, 10.0))
    assert (one.braking_time_percent, one.braking_way_percent) == pytest.approx((20.0, 10.0))
    assert (two.run_s, two.distance_m, two.running_kwh) == pytest.approx((200.0, 1500.0, 5.0))
    assert (two.power_changes, two.brake_changes, two.jerk_max_mps3) == (8, 5, 0.9)
    assert two.jerk_rms_mps3 == pytest.approx((4.0 / 200.0) ** 0.5)
    assert two.coasting_way_percent == pytest.approx(100.0 * 400.0 / 1500.0)
    assert (two.late_s, two.stop_error_m) == (2.0, None)
    # from resistors nothing
    assert (three.law, three.running_kwh, three.late_s) == ("follow_plan", 5.0, None)


def test_hops_together() -> None:
    whole = driving_sums(hops(), (8.0, -2.0, None))
    assert whole is not None
    assert (whole["hops"], whole["late_hops"]) == (3, 1)
    assert whole["running_kwh"] == pytest.approx(3.0 + 5.0 + 5.0)
    assert whole["power_changes"] == pytest.approx(20 / 3)
    assert whole["early_s"] == pytest.approx(3.0)
    assert whole["coasting_way_percent"] == pytest.approx(100.0 * 1200.0 / 3500.0)
    assert whole["coasting_time_percent"] == pytest.approx(100.0 * 90.0 / 400.0)
    assert whole["jerk_rms_mps3"] == pytest.approx((6.0 / 400.0) ** 0.5)
    assert driving_sums(()) is None


def test_the_table_says_what_the_hops_are() -> None:
    assert list(schema_of(ROWS["driving"])) == [field.name for field in fields(DrivenHop)]
    made = hops()
    table = make_table("driving", {f.name: [getattr(hop, f.name) for hop in made] for f in fields(DrivenHop)})
    assert rows_in(DrivenHop, table) == made
    margins = pl.DataFrame({"unit": ["K1", "K2", "K3"], "left_s": [8.0, -2.0, -3600.0]})  # K3 never ran
    summary = driving_summary(table, margins)
    assert summary is not None
    assert (summary["early_s"], summary["late_hops"]) == (pytest.approx((8.0 - 2.0 - 3600.0) / 3), 2)
    assert summary["by_law"]["hold_speed"]["early_s"] == (8.0 - 3600.0) / 2
    assert summary["by_law"]["follow_plan"]["hops"] == 1
    assert summary["running_kwh"] == pytest.approx(13.0)
    assert driving_summary(make_table("driving"), margins) is None


@given(st.lists(st.tuples(st.sampled_from("AB"), st.floats(0.0, 9.0), st.floats(0.0, 9.0)), max_size=12))
def test_hops_take_all_that_runs_took(parts: list[tuple[str, float, float]]) -> None:
    records = [
        run_of("K1", "T1", f"{here}-C", (i * 10.0, i * 10.0 + 9.0), kwh, REST)
        for i, (here, *kwh) in enumerate(parts)
    ]  # fmt: skip
    made = driven_hops(records, STOCKS, {}, {})
    assert sum(hop.traction_kwh for hop in made) == pytest.approx(sum(kwh for _, kwh, _ in parts))
    assert sum(hop.regenerated_kwh for hop in made) == pytest.approx(sum(kwh for _, _, kwh in parts))
    assert sum(hop.power_changes for hop in made) == 2 * len(parts)
