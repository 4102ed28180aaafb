import pytest

from tests.rows import Change, Rows
from vehicle.traction import full_force_n, notch_share, traction_target_n


def test_constant_force_then_constant_power(ev_e301: Rows) -> None:
    train = ev_e301[0]
    assert full_force_n(train, 0.0, 0.0) == pytest.approx(48_000.0)
    base_mps = 380_000.0 / 48_000.0
    assert full_force_n(train, 0.0, base_mps * 0.99) == pytest.approx(48_000.0)
    for speed in (10.0, 20.0, 27.0):
        assert full_force_n(train, 0.0, speed) * speed == pytest.approx(380_000.0)


def test_weak_field_region_falls_with_the_square_of_speed(ev_e301: Rows, changed: Change) -> None:
    train = changed(ev_e301, traction_weak_field_speed_mps=15.0)[0]
    assert full_force_n(train, 0.0, 15.0) == pytest.approx(380_000.0 / 15.0)
    assert full_force_n(train, 0.0, 24.0) * 24.0**2 == pytest.approx(380_000.0 * 15.0)


def test_the_published_starting_acceleration_is_2_kmh_per_s_at_any_load(ev_e301: Rows) -> None:
    train = ev_e301[0]
    for load_share in (0.0, 0.5, 1.0):
        mass = 77_900 + load_share * 14_600
        net_n = full_force_n(train, load_share, 0.0) - 1.65 * mass * 9.81e-3
        assert net_n / (mass * 1.08) * 3.6 == pytest.approx(2.0, rel=0.01)


def test_hitachis_maximum_acceleration_is_3_3_kmh_per_s(hitachi: Rows) -> None:
    net_n = full_force_n(hitachi[0], 0.0, 0.0) - 1.97 * 129 * 9.81
    assert net_n / (129_000 * 1.09) * 3.6 == pytest.approx(3.3, rel=0.005)


def test_notches_share_the_force_and_fractions_count_downwards(ev_e301: Rows) -> None:
    train = ev_e301[0]
    assert [notch_share(train, n, 5.0) for n in (-1.0, 0.0, 0.9, 1.0, 2.5, 5.0, 9.0)] == pytest.approx(
        [0.0, 0.0, 0.0, 0.2, 0.4, 1.0, 1.0]
    )
    assert traction_target_n(train, 0.0, 3.0, 5.0) == pytest.approx(0.6 * 48_000.0)


def test_a_notch_pulls_up_to_its_speed_cap(ev_e301: Rows, changed: Change) -> None:
    rows = changed(ev_e301)
    rows["traction_speed_cap_mps"][0, 1] = 8.0
    assert notch_share(rows[0], 1.0, 8.0) == pytest.approx(0.2)
    assert notch_share(rows[0], 1.0, 8.01) == 0.0
    assert notch_share(rows[0], 2.0, 8.01) == pytest.approx(0.4)


@pytest.mark.parametrize(("speed_kmh", "force_n"), [(0, 94_400), (51, 31_590), (51.5, 28_945), (120, 13_380)])
def test_the_measured_curve_of_the_br_642_is_met_between_points_too(
    br642: Rows, speed_kmh: float, force_n: float
) -> None:
    assert full_force_n(br642[0], 1.0, speed_kmh / 3.6) == pytest.approx(force_n, rel=1e-6)


def test_the_curve_is_level_beyond_its_end(br642: Rows) -> None:
    assert full_force_n(br642[0], 0.0, 150 / 3.6) == pytest.approx(13_380.0)
