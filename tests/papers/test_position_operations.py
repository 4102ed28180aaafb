"""What sensor sets do to a day: the cases are scenarios that load, and the criteria can fail."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from onboard.localisation.places import Places
from papers.position_cases import CASES, LATER_S, PositionCase
from papers.position_operations import (
    BASE,
    Quantiles,
    SensorDay,
    case_table,
    day_of,
    draw_cases,
    reproduce,
    rows_of,
)
from papers.reproduction import Options
from scenario.scenario import load_scenario
from simulation.settings import PositionSensor
from study.report.style import write_figure

ONE = Quantiles(1.0, 2.0, 3.0)


def a_day(
    case: PositionCase, releases: Mapping[tuple[str, str], float], broken: tuple[str, ...] = ()
) -> SensorDay:
    return SensorDay(case, 3, broken, releases, 3, ONE, ONE, ONE, ONE, 0.0, 0.0, 0, 0, 0)


def case_named(name: str) -> PositionCase:
    return next(case for case in CASES if case.name == name)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_case_is_a_scenario(case: PositionCase, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(case.text(BASE), "utf-8")
    setup = load_scenario(str(file)).setup
    assert setup.sensors.carried_by("V1") >= (
        {PositionSensor.TAGS} if case.name.startswith("tags") else set()
    )


def judged(*days: SensorDay) -> list[bool]:
    return [row.passed for row in rows_of({day.case.name: day for day in days})]


def test_what_is_judged_can_fail() -> None:
    tags = a_day(case_named("tags"), {("1", "A"): 1.0, ("1", "B"): 2.0})
    sound = a_day(case_named("curvature"), {("1", "A"): 1.0 + LATER_S, ("1", "B"): 2.0})
    assert all(judged(tags, sound))
    late = replace(sound, releases_s={("1", "A"): 2.0 + LATER_S, ("1", "B"): 3.0 + LATER_S})
    early = replace(sound, releases_s={("1", "A"): -5.0, ("1", "B"): 2.0})
    never = replace(sound, releases_s={("1", "A"): 1.0})
    for worse in (
        late,
        early,
        never,
        replace(sound, broken=("within-bounds",)),
        replace(sound, trains_arrived=2),
    ):
        assert not all(judged(tags, worse))


def test_a_picture_is_written(tmp_path: Path) -> None:
    days = {case.name: a_day(case, {("1", "A"): 1.0}) for case in CASES}
    files = write_figure("days", lambda: draw_cases(case_table(days)), tmp_path)
    assert [path.suffix for path in files] == [".svg", ".png"]
    assert all(path.stat().st_size > 10_000 for path in files)


@pytest.mark.nightly
def test_without_virtual_tags_a_train_that_goes_by_satellites_is_released_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    options = Options(quick=True)
    case = case_named("gnss_20")
    tags, sound = day_of(case_named("tags"), options), day_of(case, options)
    assert case.later_s is not None
    assert Quantiles.of_values(sound.later_than(tags)).p95 <= case.later_s  # type: ignore[operator]
    monkeypatch.setattr(Places, "tags_proved", lambda _self: iter(()))
    without = day_of(case, options)
    assert Quantiles.of_values(without.later_than(tags)).p95 > case.later_s  # type: ignore[operator]


@pytest.mark.nightly
def test_the_quick_reproduction_passes() -> None:
    result = reproduce(Options(quick=True))
    assert result.passed, [row for row in result.rows if not row.passed]
