"""`[curvature] map`: the design, or a file beside the scenario that fits the line."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from branchline.cli import app
from network.errors import InputError
from onboard.localisation.curvature_map import design_map
from onboard.localisation.curvature_map_file import write_map
from scenario.scenario import Scenario, load_scenario
from tests.scenario.own import own_scenario


def loaded(tmp_path: Path, more: str, base: str = "rtri_test_line") -> Scenario:
    return own_scenario(tmp_path, f'[sensors]\ncarries = ["tags", "curvature"]\n{more}', base)


def test_without_a_file_it_is_the_design(tmp_path: Path) -> None:
    setup = loaded(tmp_path, "").setup
    assert setup.curvature_map is None and setup.sensors.any_gyro
    assert not load_scenario("rtri_test_line").setup.sensors.any_gyro


def test_a_file_beside_the_scenario_is_read(tmp_path: Path) -> None:
    line = load_scenario("rtri_test_line").setup.line
    write_map(design_map(line), tmp_path / "curves.json")
    setup = loaded(tmp_path, '[curvature]\nmap = "curves.json"\n').setup
    assert setup.curvature_map is not None and set(setup.curvature_map.pieces) == set(line.pieces)


@pytest.mark.parametrize(
    ("map_name", "key", "expected"),
    [
        ("missing.json", "curvature.map", "'design', or a file"),
        ("other.json", "line", "rtri_test_line"),
        ("cut.json", "", "valid JSON"),
        ("own.toml", "", "valid JSON"),
    ],
)
def test_a_map_that_cannot_be_used_is_refused(tmp_path: Path, map_name: str, key: str, expected: str) -> None:
    write_map(design_map(load_scenario("karasuyama_weekday").setup.line), tmp_path / "other.json")
    (tmp_path / "cut.json").write_bytes((tmp_path / "other.json").read_bytes()[:999])
    with pytest.raises(InputError) as error:
        loaded(tmp_path, f'[curvature]\nmap = "{map_name}"\n')
    assert error.value.key == key and expected in str(error.value) and "\n" not in str(error.value)
    assert str(error.value).startswith(str(tmp_path / ("own.toml" if key == "curvature.map" else map_name)))


def test_the_command_says_it_in_one_line_with_code_2(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        loaded(tmp_path, '[curvature]\nmap = "no.json"\n')
    done = CliRunner().invoke(app, ["check", str(tmp_path / "own.toml")])
    assert done.exit_code == 2 or isinstance(done.exception, InputError)


def test_the_design_can_be_written_out(tmp_path: Path) -> None:
    out = tmp_path / "curves.json"
    done = CliRunner().invoke(app, ["new", "curvature-map", "rtri_test_line", str(out)])
    assert done.exit_code == 0
    data = json.loads(out.read_text("utf-8"))
    assert data["version"] == 1 and data["line"] == "rtri_test_line" and data["made"] == "design"
    assert loaded(tmp_path, f'[curvature]\nmap = "{out.name}"\n').setup.curvature_map is not None


@pytest.mark.parametrize(
    "text", ["filter = 'none'", "window_m = 5000.0", "rails = 'bad'", "noise_factor = -1.0", "search_m = 1e9"]
)
def test_nonsense_in_the_table_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError) as error:
        loaded(tmp_path, f"[curvature]\n{text}\n")
    assert error.value.key == f"curvature.{text.split(maxsplit=1)[0]}"
