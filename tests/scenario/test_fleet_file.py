import json
from pathlib import Path

import pytest

from network.errors import InputError
from onboard.driving.tuning import Learned
from scenario.fleet_file import learned_json, read_learned
from scenario.scenario import load_scenario

HEAD = 'extends = "rtri_test_line"\nid = "x"\nname = "x"\n'


def scenario(tmp_path: Path, text: str) -> str:
    file = tmp_path / "x.toml"
    file.write_text(HEAD + text, encoding="utf-8")
    return str(file)


def test_tables_become_the_setup(tmp_path: Path) -> None:
    text = """
    [scatter]
    brake_sigma = 0.05
    weather = [{ from = "05:30", to = "25:00", adhesion_low = 0.5, adhesion_high = 0.6 }]
    [scatter.stock.K1]
    brake_factor = 0.9
    [tuning]
    days = 3
    [vision]
    stations = ["B"]
    """
    setup = load_scenario(scenario(tmp_path, text)).setup
    assert setup.scatter.brake_sigma == 0.05
    assert (setup.scatter.weather[0].from_s, setup.scatter.weather[0].to_s) == (19800.0, 90000.0)
    assert setup.scatter.stock["K1"].brake_factor == 0.9
    assert (setup.tuning.learn, setup.tuning.days) == (True, 3)
    assert setup.vision.stations == ("B",)


def test_without_tables_nothing_scatters_learns_or_looks() -> None:
    setup = load_scenario("karasuyama_weekday").setup
    assert not setup.tuning.learn
    assert not setup.vision.wanted
    assert setup.scatter.weather == ()


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("[scatter.stock.K9]\nbrake_factor = 0.9", "scatter.stock.K9"),
        ("[scatter]\nbrake_sigma = 0.9", "scatter.brake_sigma"),
        (
            '[scatter]\nweather = [{ from = "5 am", to = "08:00", adhesion_low = 0.5, adhesion_high = 0.6 }]',
            "scatter.weather[0].from",
        ),
        (
            '[scatter]\nweather = [{ from = "08:00", to = "07:00", adhesion_low = 0.5, adhesion_high = 0.6 }]',
            "scatter.weather[0].to",
        ),
        (
            '[scatter]\nweather = [{ from = "07:00", to = "08:00", adhesion_low = 0.5, adhesion_high = 0.4 }]',
            "scatter.weather[0].adhesion_high",
        ),
        ("[tuning]\ndays = 0", "tuning.days"),
        ('[vision]\nstations = ["C"]', "vision.stations[0]"),
        ('[dispatch]\ngiven = ["K1", "K9"]', "dispatch.given"),
    ],
)
def test_what_cannot_be_is_named(tmp_path: Path, text: str, key: str) -> None:
    with pytest.raises(InputError) as caught:
        load_scenario(scenario(tmp_path, text))
    assert caught.value.key == key


def test_learned_parameters_go_on(tmp_path: Path) -> None:
    counts = tuple(int(index == 7) for index in range(21))
    learned = {"K1": Learned("K1", 0.5, counts, counts, 2, (7, 7))}
    (tmp_path / "learned.json").write_text(learned_json(learned), encoding="utf-8")
    assert read_learned(tmp_path / "learned.json") == learned
    setup = load_scenario(scenario(tmp_path, '[tuning]\nlearned = "learned.json"')).setup
    assert setup.learned == learned


@pytest.mark.parametrize("text", ["{", "[1]", '{"K1": 3}', json.dumps({"K1": {"train_id": 3}})])
def test_a_file_that_holds_something_else_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "learned.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_scenario(scenario(tmp_path, '[tuning]\nlearned = "learned.json"'))
    assert caught.value.file.endswith("learned.json")
