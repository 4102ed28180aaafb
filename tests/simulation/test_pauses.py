"""People take time: what is drawn of `[people]`, and what a file may say of it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from network.errors import InputError
from network.files.toml_input import validate
from scenario.scenario import Scenario
from simulation.pauses import Pauses
from simulation.people import LID_TIMES, Pause, People
from simulation.setup import STEPS_PER_S, Setup
from tests.scenario.own import own_scenario

ALL = tuple(Pause)
AT_ONCE = {Pause.GONE}  # as the train passes the boundary


def takes_time(setup: Setup) -> Setup:
    return replace(setup, people=setup.people.model_copy(update={p.value: 10.0 for p in AT_ONCE}))


def drawn(setup: Setup, count: int = 5) -> dict[tuple[Pause, str], list[int]]:
    """So many draws of each pause, of two who make it."""
    pauses = Pauses(setup)
    return {(p, who): [pauses.steps(p, who) for _ in range(count)] for p in ALL for who in ("K1", "K2")}


def test_every_pause_is_a_key_and_none_but_of_who_leaves_is_zero_by_default(rtri_setup: Setup) -> None:
    assert {pause.value for pause in Pause} == set(People.model_fields) - {"times", "sigma", "react"}
    assert {pause for pause in Pause if not rtri_setup.people.mean_s(pause)} == AT_ONCE
    for (pause, _), steps in drawn(takes_time(rtri_setup), 400).items():
        taken_s = [step / STEPS_PER_S for step in steps]
        mean_s = takes_time(rtri_setup).people.mean_s(pause)
        assert sum(taken_s) / len(taken_s) == pytest.approx(mean_s, rel=0.12)
        assert 0.0 < min(taken_s) < 0.6 * mean_s < 1.7 * mean_s < max(taken_s) <= LID_TIMES * mean_s


def test_a_draw_follows_from_seed_pause_who_and_how_often(rtri_setup: Setup) -> None:
    rtri_setup = takes_time(rtri_setup)
    once = drawn(rtri_setup)
    assert once == drawn(rtri_setup)
    assert len({tuple(steps) for steps in once.values()}) == len(once)
    backwards = Pauses(rtri_setup)
    assert {k: [backwards.steps(*k) for _ in range(5)] for k in reversed(once)} == once
    others = drawn(replace(rtri_setup, seed=2)), drawn(rtri_setup.next_day({}))
    assert all(other != once for other in others)


def test_one_figure_moves_no_draw_of_another(rtri_setup: Setup) -> None:
    before, after = drawn(rtri_setup), drawn(replace(rtri_setup, people=People(boot_s=70.0)))
    assert after[Pause.BOOT, "K1"] == [
        pytest.approx(3.5 * step, abs=2.0) for step in before[Pause.BOOT, "K1"]
    ]
    assert all(after[key] == before[key] for key in before if key[0] is not Pause.BOOT)


def test_zero_is_allowed_when_it_is_said(rtri_setup: Setup) -> None:
    at_once = drawn(replace(rtri_setup, people=People(times=0.0)))
    assert {step for steps in at_once.values() for step in steps} == {0}
    one = drawn(replace(rtri_setup, people=People(leave_s=0.0, gone_s=1.0)))
    assert {pause for (pause, _), steps in one.items() if 0 in steps} == {Pause.LEAVE}


def test_always_the_mean(rtri_setup: Setup) -> None:
    fixed = drawn(replace(rtri_setup, people=People(sigma=0.0, times=2.0)))
    assert fixed[Pause.BOOT, "K1"] == [400] * 5


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"boots": 1.0}, "boots"),
        ({"boot_s": -1.0}, "boot_s"),
        ({"boot_s": 1e9}, "boot_s"),
        ({"boot_s": "long"}, "boot_s"),
        ({"times": -1.0}, "times"),
        ({"sigma": -0.1}, "sigma"),
    ],
)
def test_what_cannot_be_used_is_named(table: dict[str, object], key: str) -> None:
    with pytest.raises(InputError) as error:
        validate(table, "f", People)
    assert error.value.key == key


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[[str], Scenario]:
    """A scenario of the test line that says something of its own."""
    return lambda text: own_scenario(tmp_path, text, "rtri_test_line")


@pytest.mark.parametrize(
    "text",
    [
        "[people]\nboot_s = 60.0",
        "[patch.people]\nset = { boot_s = 60.0 }",
        "[patch.people]\ntimes = { boot_s = 3.0 }",
    ],
)
def test_a_scenario_and_a_patch_set_it(scenario: Callable[[str], Scenario], text: str) -> None:
    found = scenario(text)
    assert found.setup.people == People(boot_s=60.0)
    assert [(c.key, c.old, c.new) for c in found.inputs.changes if "boot" in c.key] == [
        ("people.boot_s", 20.0, 60.0)
    ]
