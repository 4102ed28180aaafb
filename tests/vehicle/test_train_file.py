import tomllib
from pathlib import Path

import numpy as np
import pytest

from network.errors import InputError
from tests.rows import Rows
from vehicle.records import PLANT, TRAIN
from vehicle.train_file import TrainType, load_train, new_plant, shipped_train

SHIPPED = tuple(sorted(file.stem for file in shipped_train("ev_e301").parent.glob("*.toml")))


@pytest.fixture
def text() -> str:
    return shipped_train("ev_e301").read_text(encoding="utf-8")


def load(tmp_path: Path, text: str) -> TrainType:
    file = tmp_path / "train.toml"
    file.write_text(text, encoding="utf-8")
    return load_train(file)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_trains_load_and_every_figure_has_a_source_or_is_assumed(name: str) -> None:
    train = load_train(shipped_train(name))
    assert train.id == name
    assert train.row.shape == (1,) and train.row.dtype == TRAIN
    assert not train.row.flags.writeable
    assert train.sources and train.assumed
    raw = tomllib.loads(shipped_train(name).read_text(encoding="utf-8"))
    assert len(train.sources) + len(train.assumed) == len(raw["provenance"])


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_trains_name_their_motors_with_their_source(name: str) -> None:
    raw = tomllib.loads(shipped_train(name).read_text(encoding="utf-8"))
    assert raw["traction"]["motors"] >= 1
    assert raw["provenance"]["traction.motors"].startswith(("published", "assumed"))


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_trains_start_on_dry_rail_without_a_slip(name: str) -> None:
    """The pull at a start by what the driven axles of the full train carry, by hand, in N."""
    train = load_train(shipped_train(name)).row[0]
    mass_kg = float(train["mass_empty_kg"] + train["mass_load_full_kg"])
    pull_n = float(train["traction_force_max_n"])
    if train["traction_load_compensated"]:
        pull_n *= mass_kg / float(train["mass_empty_kg"])
    grip_n = mass_kg * 9.81 * float(train["motored_axle_mass_share"]) * float(train["adhesion_dry"])
    assert pull_n <= grip_n


@pytest.mark.parametrize("force_kn", [200.0, 150.0])
def test_a_train_that_slips_at_each_start_on_dry_rail_is_refused(tmp_path: Path, force_kn: float) -> None:
    """Of 100 t half on driven axles, 0.30: 147.15 kN, in whatever load, as the force grows with it."""
    text = shipped_train("flirt3_3").read_text(encoding="utf-8")
    file = tmp_path / "train.toml"
    file.write_text(text.replace("force_max_kn = 132.6", f"force_max_kn = {force_kn}", 1), encoding="utf-8")
    with pytest.raises(InputError) as raised:
        load_train(file)
    assert (raised.value.key, raised.value.value) == ("traction.force_max_kn", force_kn)
    assert "on dry rail, full at most 1" in str(raised.value)


@pytest.mark.parametrize(("name", "start_mps2"), [("flirt3_3", 1.2), ("flirt3_6", 1.0)])
def test_a_flirt_starts_as_published_of_its_family(name: str, start_mps2: float) -> None:
    """0.8 to 1.3 m/s2; less what it needs to move at all, 3.06 N/kN."""
    train = load_train(shipped_train(name)).row[0]
    mass_kg = float(train["mass_empty_kg"])
    start_n = float(train["traction_force_max_n"]) - 3.06e-3 * mass_kg * 9.81
    assert start_n / (mass_kg * 1.08) == pytest.approx(start_mps2, abs=0.01)


def test_units_at_the_edge_become_si(ev_e301: Rows) -> None:
    train = ev_e301[0]
    assert train["mass_empty_kg"] == pytest.approx(77_900.0)
    assert train["speed_max_mps"] == 100 / 3.6
    assert train["traction_force_max_n"] == 48_000.0
    assert train["traction_power_max_w"] == 380_000.0
    assert train["brake_deceleration_mps2"][7] == 1.0
    assert train["wheel_diameter_m"] == 0.86
    assert train["brake_notches"] == 7 and train["power_notches"] == 5
    assert train["brake_deceleration_mps2"][0] == 0.0


def test_odas_and_hitachis_figures(oda: Rows, hitachi: Rows) -> None:
    assert oda["mass_empty_kg"][0] * 9.81e-3 == pytest.approx(1177.2 + 784.8)
    assert oda["motored_mass_share"][0] == pytest.approx(1177.2 / (1177.2 + 784.8))
    assert (oda["brake_dead_time_s"][0], oda["brake_jerk_max_mps3"][0]) == (1.0, 4.65)
    assert (hitachi["length_m"][0], hitachi["mass_empty_kg"][0]) == (83.5, 129_000.0)
    assert (hitachi["power_notches"][0], hitachi["brake_notches"][0]) == (7, 9)
    assert (hitachi["brake_dead_time_s"][0], hitachi["brake_lag_s"][0]) == (0.2, 0.6)


@pytest.mark.parametrize(
    ("old", "new", "key", "value"),
    [
        ("length_m = 40.0", "length_m = -40.0", "body.length_m", -40.0),
        ("length_m = 40.0", 'length_m = "long"', "body.length_m", "long"),
        ("length_m = 40.0", "", "body.length_m", None),
        ("mass_empty_t = 77.9", "mass_empty_t = 77.9\nmass_empty_kg = 1.0", "body.mass_empty_kg", 1.0),
        ("cars = 2", "cars = 2\ncolour = 3", "body.colour", 3),
        ("mass_empty_t = 77.9", "mass_empty_t = 0", "body.mass_empty_t", 0.0),
        ("dry = 0.245", "dry = 2.45", "adhesion.dry", 2.45),
        ("stepless = true", "stepless = 1", "brakes.stepless", 1),
        ("[0.2, 0.4, 0.6, 0.8, 1.0]", "[0.2, 0.4, 1.8]", "traction.notch_share[2]", 1.8),
        ("[0.2, 0.4, 0.6, 0.8, 1.0]", "[0.2, 0.6, 0.4, 0.8, 1.0]", "traction", None),
        ("[0.514, 1.029,", "[1.029, 0.514,", "brakes", None),
        ("fade_to_kmh = 5.0", "fade_to_kmh = 15.0", "regeneration", None),
        ("motors = 4", "motors = 4\ncurve_speed_kmh = [0.0, 10.0]", "traction", None),
        ('"traction.motors" =', '"traction.moters" =', "provenance.traction.moters", None),
        ('\n"sensors" = "', '\n"sensors.wheel_diameter_mm" = "', "provenance", None),
    ],
)
def test_an_error_names_file_key_value_and_what_was_expected(
    tmp_path: Path, text: str, old: str, new: str, key: str, value: object
) -> None:
    assert old in text
    with pytest.raises(InputError) as caught:
        load(tmp_path, text.replace(old, new))
    error = caught.value
    assert error.file.endswith("train.toml")
    assert error.key == key
    assert value is None or error.value == value
    assert error.expected and "\n" not in str(error)


def test_a_missing_table_a_missing_file_and_broken_toml(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match="emergency"):
        load(tmp_path, text.replace("[emergency]", "[emergencies]"))
    with pytest.raises(InputError, match="readable"):
        load_train(tmp_path / "none.toml")
    with pytest.raises(InputError, match="valid TOML"):
        load(tmp_path, "id = ")


def test_an_unknown_shipped_train_names_those_there_are() -> None:
    with pytest.raises(InputError, match="ev_e301"):
        shipped_train("../ev_e301")


def test_the_curve_of_the_br_642_lies_on_a_1_kmh_grid(br642: Rows) -> None:
    assert br642["traction_curve_points"][0] == 121
    assert br642["traction_curve_step_mps"][0] == pytest.approx(1 / 3.6)
    assert br642["traction_curve_n"][0, 10] == 80_000.0


def test_new_plants_stand_braked_or_coast() -> None:
    standing, rolling = new_plant(2), new_plant(1, 12.0)
    assert standing.dtype == PLANT and standing.shape == (2,)
    assert np.all(standing["command_notch"] < 0) and np.all(standing["service_deceleration_mps2"] > 0)
    assert np.all(rolling["command_notch"] == 0) and rolling["service_deceleration_mps2"][0] == 0
    assert rolling["wheel_speed_mps"][0] == 12.0
    assert np.all(rolling["adhesion_factor"] == 1.0) and np.all(rolling["brake_factor"] == 1.0)
