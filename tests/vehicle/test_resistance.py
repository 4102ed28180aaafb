import pytest

from tests.rows import Rows
from vehicle.mass import mass_kg
from vehicle.resistance import curve_resistance_n, gradient_force_n, resistance_n, running_resistance_n


@pytest.mark.parametrize(
    ("speed_kmh", "expected_n"),
    [
        (0.0, 1.650 * 1177.2 + 0.780 * 784.8),  # 2554.5 N
        (36.0, 2.550 * 1177.2 + 0.888 * 784.8 + 9.810 * 0.1 * 1296.0),  # 4970.1 N
        (72.0, 3.450 * 1177.2 + 0.996 * 784.8 + 9.810 * 0.1 * 5184.0),  # 9928.5 N
    ],
)
def test_odas_equation_3_by_hand(oda: Rows, speed_kmh: float, expected_n: float) -> None:
    assert running_resistance_n(oda[0], 200_000.0, speed_kmh / 3.6) == pytest.approx(expected_n, rel=1e-9)


def test_hitachis_formula_in_kg_per_ton(hitachi: Rows) -> None:
    # 1.97 + 0.016 * 60 + 0.00084 * 3600 = 5.954 kg/ton
    expected_n = 5.954 * 129.0 * 9.81
    assert running_resistance_n(hitachi[0], 129_000.0, 60 / 3.6) == pytest.approx(expected_n, rel=1e-5)


def test_air_term_of_the_shipped_trains_is_that_of_their_number_of_cars(ev_e301: Rows, oda: Rows) -> None:
    assert ev_e301[0]["resistance"]["air_n_per_kmh2"] == pytest.approx(9.810 * (0.028 + 0.008))
    assert oda[0]["resistance"]["air_n_per_kmh2"] == pytest.approx(9.810 * (0.028 + 9 * 0.008))


def test_starting_resistance_is_a_line_from_30_n_per_tonne_to_3_kmh(ev_e301: Rows) -> None:
    train = ev_e301[0]
    mass = mass_kg(train, 0.0)
    assert resistance_n(train, mass, 0.0) == pytest.approx(77.9 * 30.0, rel=1e-3)
    at_3_kmh = running_resistance_n(train, mass, 3 / 3.6)
    middle = (resistance_n(train, mass, 0.0) + at_3_kmh) / 2
    assert resistance_n(train, mass, 1.5 / 3.6) == pytest.approx(middle)
    assert resistance_n(train, mass, 3 / 3.6) == at_3_kmh


def test_no_starting_resistance_where_the_file_gives_none(oda: Rows) -> None:
    assert resistance_n(oda[0], 200_000.0, 0.0) == running_resistance_n(oda[0], 200_000.0, 0.0)


def test_gradient_and_curve(ev_e301: Rows) -> None:
    assert gradient_force_n(100_000.0, 25.0) == pytest.approx(100_000 * 9.81 * 0.025)
    assert gradient_force_n(100_000.0, -25.0) == -gradient_force_n(100_000.0, 25.0)
    # 600 / 300 m = 2 permille, whichever way it bends
    for curvature in (1 / 300, -1 / 300):
        assert curve_resistance_n(ev_e301[0], 100_000.0, curvature) == pytest.approx(100_000 * 9.81 * 0.002)
