"""What sets carry is checked as a file is read: sets that there are, and something by which each knows where it is."""

from pathlib import Path

import pytest

from network.errors import InputError
from scenario.scenario import load_scenario
from scenario.sensor_choice import AT_LEAST_ONE
from simulation.settings import PositionSensor

BASE = 'extends = "karasuyama_weekday"\nid = "s"\nname = "s"\n[sensors]\n'


def written(folder: Path, text: str) -> str:
    file = folder / "s.toml"
    file.write_text(BASE + text, "utf-8")
    return str(file)


def test_sets_carry_what_they_are_given(tmp_path: Path) -> None:
    file = written(tmp_path, 'carries = ["gnss"]\ncarries_of = { V2 = ["tags", "curvature"] }\n')
    sensors = load_scenario(file).setup.sensors
    assert sensors.carried_by("V1") == {PositionSensor.GNSS}
    assert sensors.carried_by("V2") == {PositionSensor.TAGS, PositionSensor.CURVATURE}


@pytest.mark.parametrize(
    ("text", "key", "value", "expected"),
    [
        (
            'carries_of = { V9 = ["gnss"] }',
            "sensors.carries_of.V9",
            "V9",
            "a stock id: one of V1, V2, V3, V4",
        ),
        ("carries_of = { V2 = [] }", "sensors.carries_of.V2", [], AT_LEAST_ONE),
        ("carries = []", "sensors.carries", [], AT_LEAST_ONE),
        ('carries = ["tags", "tags"]', "sensors.carries", ["tags", "tags"], "each sensor once"),
        (
            'carries = ["curvature"]\n[curvature]\nwindow_m = 90.0',
            "curvature.window_least_m",
            100.0,
            "at most curvature.window_m, 90 m",
        ),
    ],
)
def test_others_are_refused_with_key_and_what_is_expected(
    tmp_path: Path, text: str, key: str, value: object, expected: str
) -> None:
    file = written(tmp_path, text + "\n")
    with pytest.raises(InputError) as refused:
        load_scenario(file)
    error = refused.value
    assert (error.file, error.key, error.value) == (file, key, value)
    assert error.expected.startswith(expected)


def test_who_carries_nothing_in_general_may_carry_something_each(tmp_path: Path) -> None:
    each = ", ".join(f'{stock_id} = ["tags"]' for stock_id in ("V1", "V2", "V3", "V4"))
    load_scenario(written(tmp_path, f"carries = []\ncarries_of = {{ {each} }}\n"))
