"""Energy by hour: nothing is lost or doubled, and a record lies in the hours in which it was."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.units import J_PER_KWH
from simulation.result import COUNTED, DRAWN, EnergyPhase, EnergyRecord
from study.collect.energy import StockMake
from study.collect.energy_hours import energy_hours_of, shares
from vehicle.train_file import RegenerationReceiver

FLEET = {
    "K1": StockMake(2, RegenerationReceiver.BATTERY),
    "K2": StockMake(2, RegenerationReceiver.RESISTORS),
}


def record(
    unit: str, phase: EnergyPhase, begin_s: float, end_s: float, kwh: tuple[float, float, float]
) -> EnergyRecord:
    joules = (one * J_PER_KWH for one in kwh)
    counted_j = dict.fromkeys(COUNTED, 0.0) | dict(zip(DRAWN, joules, strict=True))
    return EnergyRecord(unit, "1", True, phase, "A", "B", begin_s, end_s, 0.0, counted_j)


def test_a_run_over_a_whole_hour_is_shared_out_by_time() -> None:
    found = energy_hours_of([record("K1", EnergyPhase.RUNNING, 3500.0, 3800.0, (3.0, 0.6, 0.9))], FLEET)
    assert found.select("hour_s", "traction_kwh", "regenerated_kwh", "auxiliary_kwh", "net_kwh").rows() == [
        (0.0, pytest.approx(1.0), pytest.approx(0.2), pytest.approx(0.3), pytest.approx(1.1)),
        (3600.0, pytest.approx(2.0), pytest.approx(0.4), pytest.approx(0.6), pytest.approx(2.2)),
    ]


def test_what_resistors_take_is_not_given_back() -> None:
    found = energy_hours_of([record("K2", EnergyPhase.RUNNING, 0.0, 60.0, (3.0, 1.0, 0.5))], FLEET)
    assert found["net_kwh"].to_list() == pytest.approx([3.5])


@given(begin_s=st.floats(0.0, 200_000.0), length_s=st.floats(0.0, 40_000.0))
def test_the_shares_of_a_stretch_sum_to_one(begin_s: float, length_s: float) -> None:
    found = shares(begin_s, begin_s + length_s)
    assert sum(share for _, share in found) == pytest.approx(1.0)
    assert all(share >= 0.0 for _, share in found)
    assert all(hour_s % 3600.0 == 0.0 for hour_s, _ in found)
    assert found[0][0] <= begin_s < found[0][0] + 3600.0


@given(
    records=st.lists(
        st.builds(
            lambda unit, phase, begin_s, length_s, kwh: record(unit, phase, begin_s, begin_s + length_s, kwh),
            st.sampled_from(sorted(FLEET)),
            st.sampled_from(EnergyPhase),
            st.floats(0.0, 90_000.0),
            st.floats(0.0, 20_000.0),
            st.tuples(st.floats(0.0, 50.0), st.floats(0.0, 20.0), st.floats(0.0, 20.0)),
        ),
        max_size=12,
    )
)
def test_the_sum_over_all_hours_is_that_of_the_records(records: list[EnergyRecord]) -> None:
    found = energy_hours_of(records, FLEET)
    for kind in DRAWN:
        booked = sum(one.counted_j[kind] for one in records) / J_PER_KWH
        assert found[f"{kind}_kwh"].sum() == pytest.approx(booked, abs=1e-9)
