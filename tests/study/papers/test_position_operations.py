"""What sensor sets do to a day: the cases are scenarios that load, and the criteria can fail."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from onboard.localisation.places import Places
from simulation.settings import Carried
from study.papers import position_operations
from study.papers.position_cases import CASES, LATER_S, Case
from study.papers.position_chart import write_chart
from study.papers.position_operations import BASE, Day, Spread, day_of, reproduce
from study.papers.reproduction import Options
from study.scenario.scenario import load_scenario

ONE = Spread(1.0, 2.0, 3.0)


def a_day(case: Case, releases: Mapping[tuple[str, str], float], broken: tuple[str, ...] = ()) -> Day:
    return Day(case, 3, 3, broken, ONE, ONE, ONE, releases, ONE, 0.0, 0.0, 0, 0, 0)


def case_named(name: str) -> Case:
    return next(case for case in CASES if case.name == name)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_case_is_a_scenario(case: Case, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(case.text(BASE), "utf-8")
    setup = load_scenario(str(file)).setup
    assert setup.sensors.carried_by("V1") >= ({Carried.TAGS} if case.name.startswith("tags") else set())


def rows_of(days: list[Day]) -> dict[str, bool]:
    return {row.case: row.passed for row in position_operations._rows({day.case.name: day for day in days})}


def test_what_is_judged_can_fail() -> None:
    tags = a_day(case_named("tags"), {("1", "A"): 1.0, ("1", "B"): 2.0})
    sound = a_day(case_named("curvature"), {("1", "A"): 1.0 + LATER_S, ("1", "B"): 2.0})
    assert all(rows_of([tags, sound]).values())
    late = replace(sound, releases={("1", "A"): 2.0 + LATER_S, ("1", "B"): 3.0 + LATER_S})
    early = replace(sound, releases={("1", "A"): -5.0, ("1", "B"): 2.0})
    for worse in (late, early, replace(sound, broken=("within-bounds",)), replace(sound, arrived=2)):
        assert not all(rows_of([tags, worse]).values())


def test_a_picture_is_written(tmp_path: Path) -> None:
    days = {case.name: a_day(case, {("1", "A"): 1.0}).as_dict() for case in CASES}
    written = write_chart(days, tmp_path)
    assert [path.suffix for path in written] == [".svg", ".png"]
    assert all(path.stat().st_size > 10_000 for path in written)


@pytest.mark.nightly
def test_without_virtual_tags_a_train_that_goes_by_satellites_is_released_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    options = Options(quick=True)
    case = case_named("gnss_20")
    tags, sound = day_of(case_named("tags"), options), day_of(case, options)
    assert case.later_s is not None
    assert Spread.of(sound.later_than(tags)).p95 <= case.later_s  # type: ignore[operator]
    monkeypatch.setattr(Places, "proved", lambda _self: iter(()))
    without = day_of(case, options)
    assert Spread.of(without.later_than(tags)).p95 > case.later_s  # type: ignore[operator]


@pytest.mark.nightly
def test_the_quick_reproduction_passes() -> None:
    result = reproduce(Options(quick=True))
    assert result.passed, [row for row in result.rows if not row.passed]
