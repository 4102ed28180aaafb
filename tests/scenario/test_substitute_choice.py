"""What `[substitute]` names must be there: one message each, with file, key and what was expected."""

from pathlib import Path

import pytest

from network.errors import InputError
from scenario.scenario import Scenario
from simulation.procedure import Regime
from tests.scenario.own import own_scenario

REACT = "[people]\nreact = true\n"


def loaded(folder: Path, text: str) -> Scenario:
    return own_scenario(folder, text, "karasuyama_weekday")


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        ("[substitute]\n", "people.react", "true with [substitute]"),
        (REACT + '[substitute]\nstaffed = ["OGM"]', "substitute.staffed[0]", "OGN"),
        (REACT + '[substitute]\nregime = "pilot"', "substitute.regime", "pilot_by_telephone"),
        (REACT + '[substitute]\nleft_out = [{ step = "askk" }]', "substitute.left_out[0].step", "ask"),
        (
            REACT + '[substitute]\nleft_out = [{ step = "ask", block = "OGN" }]',
            "substitute.left_out[0].block",
            "OGN-KRS",
        ),
        (
            REACT + '[substitute]\nleft_out = [{ step = "ask", train = "1M" }]',
            "substitute.left_out[0].train",
            "321M",
        ),
        (
            REACT + '[substitute]\nof_block = { "OGN-KRY" = "pilot_shuttle" }',
            "substitute.of_block.OGN-KRY",
            "OGN-KRS",
        ),
        (
            REACT + '[substitute]\nregime = "pilot_shuttle"\nleft_out = [{ step = "agree" }]',
            "substitute.left_out[0].step",
            "a step of pilot_shuttle",
        ),
    ],
)
def test_what_is_not_there_is_refused(text: str, key: str, expected: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        loaded(tmp_path, text)
    assert error.value.key == key
    assert expected in error.value.expected


def test_a_battery_train_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        own_scenario(tmp_path, f"{REACT}[substitute]\n", "karasuyama_battery")
    assert error.value.key == "substitute"


def test_what_is_there_is_read(tmp_path: Path) -> None:
    setup = loaded(tmp_path, REACT + '[substitute]\nregime = "pilot_by_dispatcher"\nstaffed = ["HSK"]').setup
    assert setup.substitute is not None
    assert setup.substitute.regime is Regime.DISPATCHER
    assert setup.substitute.speed_mps == pytest.approx(12.5)
