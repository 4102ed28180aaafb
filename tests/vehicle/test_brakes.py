import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rows import Rows
from vehicle.brakes import regenerative_limit_n, service_notch, service_target_mps2


def test_full_service_is_what_the_sources_say(ev_e301: Rows, oda: Rows, hitachi: Rows) -> None:
    assert service_target_mps2(ev_e301[0], -7.0) * 3.6 == pytest.approx(3.6)
    assert service_target_mps2(oda[0], -1.0) == pytest.approx(0.93)
    assert service_target_mps2(hitachi[0], -9.0) * 3.6 == pytest.approx(5.14)


def test_power_and_coast_do_not_brake_and_nothing_lies_beyond_the_last_notch(ev_e301: Rows) -> None:
    train = ev_e301[0]
    assert service_target_mps2(train, 0.0) == 0.0
    assert service_target_mps2(train, 4.0) == 0.0
    assert service_target_mps2(train, -16.0) == service_target_mps2(train, -7.0)


def test_a_fraction_lies_between_notches_or_counts_as_the_stronger(ev_e301: Rows, hitachi: Rows) -> None:
    train = ev_e301[0]
    between = (service_target_mps2(train, -2.0) + service_target_mps2(train, -3.0)) / 2
    assert service_target_mps2(train, -2.5) == pytest.approx(between)
    assert service_target_mps2(hitachi[0], -2.5) == service_target_mps2(hitachi[0], -3.0)
    assert service_target_mps2(hitachi[0], -3.0) < service_target_mps2(hitachi[0], -4.0)


@given(deceleration=st.floats(0.0, 1.0))
def test_the_notch_for_a_deceleration_gives_it_back(
    ev_e301: Rows, hitachi: Rows, deceleration: float
) -> None:
    stepless = service_notch(ev_e301[0], deceleration)
    assert service_target_mps2(ev_e301[0], stepless) == pytest.approx(deceleration, abs=1e-9)
    stepped = service_notch(hitachi[0], deceleration)
    assert stepped == int(stepped)
    assert service_target_mps2(hitachi[0], stepped) >= deceleration - 1e-9
    assert service_target_mps2(hitachi[0], stepped) < deceleration + 5.14 / 9 / 3.6 + 1e-3


def test_regeneration_by_force_power_and_fade(ev_e301: Rows, br642: Rows) -> None:
    train = ev_e301[0]
    assert regenerative_limit_n(train, 6.0) == pytest.approx(48_000.0)
    assert regenerative_limit_n(train, 20.0) == pytest.approx(380_000.0 / 20.0)
    assert regenerative_limit_n(train, 7.5 / 3.6) == pytest.approx(24_000.0)  # half-way from 10 to 5 km/h
    assert regenerative_limit_n(train, 5.0 / 3.6) == 0.0
    assert regenerative_limit_n(train, 0.0) == 0.0
    assert regenerative_limit_n(br642[0], 20.0) == 0.0
