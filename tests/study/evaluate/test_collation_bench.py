"""The budgets of collation: what is over them is said to be."""

from typing import Any

import pytest

from scenario.scenario import load_scenario
from simulation.settings import PositionSensor
from study.evaluate.collation import WITH, WITHOUT, bench, report, setup_carrying
from study.evaluate.parts import part_of


def day(wall_s: float, digest: str = "d") -> dict[str, Any]:
    return {"wall_s": wall_s, "digest": digest}


@pytest.mark.parametrize(("ms", "wall_s", "kept"), [(0.1, 14.0, [True, True]), (0.3, 16.0, [False, False])])
def test_budgets_are_judged(ms: float, wall_s: float, kept: list[bool]) -> None:
    found = report(ms, {WITHOUT: [day(10.0)] * 3, WITH: [day(wall_s), day(wall_s), day(99.0)]})
    assert [budget["kept"] for budget in found["budgets"]] == kept
    assert found["same_digest"] and found["rows"][1]["of_tags"] == wall_s / 10.0
    assert not report(ms, {WITHOUT: [day(1.0), day(1.0, "e")], WITH: [day(1.0)]})["same_digest"]


def test_the_part_is_listed_and_puts_a_gyro_on_every_train() -> None:
    assert part_of("collation") is bench
    setup = load_scenario("rtri_test_line").setup
    assert setup_carrying(setup, WITH).sensors.carried_by("K1") == {
        PositionSensor.TAGS,
        PositionSensor.CURVATURE,
    }
    assert setup_carrying(setup, WITHOUT).sensors.carried_by("K1") == {PositionSensor.TAGS}
