"""Which set of parameters a reproduction goes by is what it says, and there are no others."""

from collections.abc import Callable

import numpy as np
import pytest

from onboard.driving.tuning import Learned
from onboard.driving_settings import Driving
from onboard.unit_records import UnitParameters
from papers.line_stops import SCENARIO, WITH_SIGNS
from papers.oda_scale_track import TrackTest, car_bench
from papers.oda_tuning import HiddenBrake, bench_with
from papers.parameter_sets import LINE, SECTION_3_2, SETS, TABLE_1, TENTH_SCALE, ParameterSet
from papers.single_train import Bench
from papers.specification import REPRODUCTIONS, reproduction
from papers.stop_statistics import statistics_bench
from papers.table4_stops import best_gain_per_s, controller, oda_train
from papers.yasunobu_train import paper_bench
from scenario.scenario import load_scenario

BENCHES = (
    (SECTION_3_2, lambda: controller(best_gain_per_s())),
    (LINE, lambda: bench_with(oda_train(), HiddenBrake(1.0, 0.1, 0.0), Learned("A", 1.0))),
    (LINE, lambda: statistics_bench(0.3)),
    (TENTH_SCALE, lambda: car_bench(TrackTest())),
    (TABLE_1, lambda: paper_bench("hold_speed")),
)


def test_every_reproduction_has_one_set_or_drives_nothing() -> None:
    driven = [reproduction(name).driven for name in REPRODUCTIONS]
    assert {each.name for each in driven if isinstance(each, ParameterSet)} == {each.name for each in SETS}
    assert len(SETS) == 4
    assert all(each.why for each in driven)


@pytest.mark.parametrize(("stated", "built"), BENCHES, ids=lambda value: getattr(value, "name", ""))
def test_a_bench_drives_by_its_set(stated: ParameterSet, built: Callable[[], Bench]) -> None:
    bench = built()
    own = bench.prepared.view(np.recarray)[0].board
    assert float(bench.design.pattern_mps2) == stated.driving.stop_deceleration_mps2
    assert float(bench.design.gain_per_s) == stated.driving.stop_gain_per_s
    assert float(own.unit.bound_ahead_m) == stated.unit.tag_accuracy_m
    assert float(own.unit.bound_growth) == stated.unit.wheel_error_share
    assert bench.unit == stated.unit


def test_line_runs_go_by_the_defaults() -> None:
    assert LINE.driving == Driving()
    assert LINE.unit == UnitParameters()
    for name in (SCENARIO, WITH_SIGNS):
        setup = load_scenario(name).setup
        assert (setup.driving, setup.unit) == (LINE.driving, LINE.unit)
