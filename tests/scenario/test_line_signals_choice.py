"""What `[line_signals]` names must be there: one message each, with file, key and what was expected."""

from pathlib import Path

import pytest

from network.errors import InputError
from scenario.scenario import Scenario
from tests.scenario.own import own_scenario

SIGNAL = 'signal = [{ id = "a", at = "SGR.2", runs = "up", block = "ONT-SGR" }]\n'


def loaded(folder: Path, text: str, base: str = "shigaraki_1991") -> Scenario:
    return own_scenario(folder, text, base)


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        (SIGNAL.replace("SGR.2", "SGR.3"), "line_signals.signal[0].at", "SGR.2"),
        (SIGNAL.replace("ONT-SGR", "ONT-SGA"), "line_signals.signal[0].block", "ONT-SGR"),
        (SIGNAL.replace('"up"', '"left"'), "line_signals.signal[0].runs", "up"),
        (SIGNAL.replace("]", f", {SIGNAL[10:-2]}]"), "line_signals.signal[1].id", "each name once"),
        (SIGNAL + 'lever = [{ id = "l", runs = "up", blocks = ["x"] }]', "lever[0].blocks[0]", "ONT-SGR"),
        (SIGNAL + 'detector = [{ signal = "b", holds = ["a"] }]', "detector[0].signal", "a"),
        (SIGNAL + 'detector = [{ signal = "a", holds = ["b"] }]', "detector[0].holds[0]", "a"),
        (SIGNAL + 'act = [{ at = "10:00", who = "w", does = "set", target = "b" }]', "act[0].target", "a"),
        (
            SIGNAL + 'act = [{ at = "10:00", who = "w", does = "lever", target = "a" }]',
            "act[0].target",
            "nothing: there are none",
        ),
    ],
)
def test_a_name_that_is_not_there(tmp_path: Path, text: str, key: str, expected: str) -> None:
    with pytest.raises(InputError) as error:
        loaded(tmp_path, f"[line_signals]\n{text}")
    assert key in error.value.key
    assert expected in error.value.expected


@pytest.mark.parametrize(
    ("base", "more", "key"),
    [
        ("shigaraki_1991", "[people]\nreact = true\n[substitute]\n", "substitute"),
        ("karasuyama_weekday", "", "line_signals"),
    ],
)
def test_what_line_signals_cannot_be_with(tmp_path: Path, base: str, more: str, key: str) -> None:
    text = (
        SIGNAL if base == "shigaraki_1991" else SIGNAL.replace("SGR.2", "OGN.2").replace("ONT-SGR", "HSK-OGN")
    )
    with pytest.raises(InputError) as error:
        loaded(tmp_path, f"{more}[line_signals]\n{text}", base)
    assert error.value.key == key


def test_a_collision_may_be_expected_of_a_line_as_it_was_alone(tmp_path: Path) -> None:
    expects = '[[expect]]\ntext = "x"\nproperty = "no_invariant_broken"\nabsent = true\nrules = ["sumo-collision"]\n'
    assert loaded(tmp_path, f"[line_signals]\n{SIGNAL}\n{expects}").setup.script.expectations
    with pytest.raises(InputError) as error:
        loaded(tmp_path, expects)
    assert error.value.key == "expect[0].rules[0]"
