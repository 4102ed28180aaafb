"""Where the inputs of two runs differ, by file and key, and whose patch wrote it."""

from collections.abc import Callable
from pathlib import Path

import pytest

from scenario.inputs import Inputs
from scenario.scenario import load_scenario
from study.compare.changes import COMMAND_LINE, InputChange, input_changes
from study.compare.side import ComparedRun
from study.report.data import ReportedRun
from tests.study.compare.pairs import OTHER_TRAIN, RADIO_OF_2_S, RESTRICTION, SLOWER_POINTS, scenario
from tests.study.compare.sides import side


@pytest.fixture
def inputs(tmp_path: Path) -> Callable[[str], Inputs]:
    def read(text: str) -> Inputs:
        return load_scenario(str(scenario(tmp_path, "karasuyama_weekday", "what_if", text))).inputs

    return read


@pytest.fixture
def changes(weekday: ReportedRun, inputs: Callable[[str], Inputs]) -> Callable[..., tuple[InputChange, ...]]:
    def compared(old: str, new: str, **summary: str) -> tuple[InputChange, ...]:
        sides: list[ComparedRun] = [
            side(weekday, "base", inputs(old)),
            side(weekday, "new", inputs(new), **summary),
        ]
        return input_changes(*sides)

    return compared


Compared = Callable[..., tuple[InputChange, ...]]


def test_the_same_inputs_differ_in_nothing_whatever_they_are_called(changes: Compared) -> None:
    assert changes("", "") == ()
    assert changes("", 'assumed = ["something"]') == ()
    assert changes(SLOWER_POINTS, SLOWER_POINTS) == ()


def test_a_default_that_is_written_out_is_no_difference(changes: Compared) -> None:
    law = load_scenario("karasuyama_weekday").setup.driving.driving_margin_mps
    assert changes("", f"[driving]\ndriving_margin_mps = {law}") == ()
    (change,) = changes("", f"[driving]\ndriving_margin_mps = {law + 0.1}")
    assert (change.key, change.old, change.new) == ("driving.driving_margin_mps", law, law + 0.1)


def test_each_figure_that_a_patch_wrote_names_the_run_whose_patch_it_is(changes: Compared) -> None:
    found = changes("", SLOWER_POINTS)
    assert [(c.file, c.key, c.old, c.new, c.by) for c in found] == [
        ("karasuyama.toml", f"points.OGN.{n}.throw_time_s", 6.0, 45.0, ("new",)) for n in (11, 21)
    ]
    back = changes(SLOWER_POINTS, "")
    assert [(c.old, c.new, c.by) for c in back] == [(45.0, 6.0, ("base",))] * 2
    both = changes(SLOWER_POINTS, SLOWER_POINTS.replace("45.0", "50.0"))
    assert [(c.old, c.new, c.by) for c in both] == [(45.0, 50.0, ("base", "new"))] * 2


def test_what_comes_and_what_goes_has_one_side(changes: Compared) -> None:
    (added,) = changes("", RESTRICTION)
    assert (added.key, added.old, added.by) == ("alignments.main.limits", None, ("new",))
    assert isinstance(added.new, dict) and added.new["speed_kmh"] == 25.0
    (gone,) = changes(RESTRICTION, "")
    assert (gone.old, gone.new) == (added.new, None)


def test_only_who_set_it_is_named_where_both_have_set_something_under_that_key(changes: Compared) -> None:
    second = RESTRICTION.replace("9.4", "3.0").replace("9.8", "3.2").replace("[[patch", "\n[[patch")
    (added,) = changes(RESTRICTION, RESTRICTION + second)
    assert isinstance(added.new, dict) and added.new["from_km"] == 3.0
    assert added.by == ("new",)


def test_settings_trains_seed_and_the_command_line_are_inputs_too(changes: Compared) -> None:
    (radio,) = changes("", RADIO_OF_2_S)
    assert (radio.file, radio.key) == ("scenario", "air.delay_mean_s")
    keys = {change.key for change in changes("", OTHER_TRAIN)}
    assert "trains.default" in keys and "train of V1" in keys
    (mass,) = changes("", "[patch.train.ev_e301.times]\nmass_empty_t = 1.1")
    assert (mass.file, mass.key) == ("ev_e301.toml", "body.mass_empty_t")
    (seed,) = changes("", "seed = 9")
    assert (seed.key, seed.new, seed.by) == ("seed", 9, ("new",))
    (link,) = changes("", "", link="zenoh")
    assert (link.file, link.key, link.new) == (COMMAND_LINE, "--link", "zenoh")


def test_a_drill_against_the_day_without_it_has_its_fault_among_the_inputs(weekday: ReportedRun) -> None:
    plain, drill = (load_scenario(name).inputs for name in ("rtri_test_line", _drill()))
    found = input_changes(side(weekday, "base", plain), side(weekday, "new", drill))
    assert any(change.key == "fault" for change in found)


def _drill() -> str:
    from study.drilling.drill import find_drill

    return find_drill("rtri/09_manager_power")


def test_another_timetable_is_told_train_by_train(weekday: ReportedRun) -> None:
    days = [load_scenario(f"karasuyama_{day}").inputs for day in ("weekday", "holiday")]
    found = input_changes(side(weekday, "base", days[0]), side(weekday, "new", days[1]))
    assert {change.file for change in found} >= {
        "scenario",
        "karasuyama_weekday.toml | karasuyama_holiday.toml",
    }
    same = input_changes(side(weekday, "base", days[0]), side(weekday, "new", days[0].model_copy()))
    assert same == ()
