"""A first run makes a map that a second one, with other rails and noise, finds its way by."""

from dataclasses import replace

import numpy as np
import pytest

from network.errors import InputError
from papers.first_run import map_by_run
from papers.position_run import PositionRun
from scenario.scenario import load_scenario
from simulation.settings import PositionSensor


@pytest.mark.nightly
def test_a_run_by_the_map_of_another_run_keeps_its_bounds() -> None:
    setup = load_scenario("karasuyama_weekday").setup
    made = map_by_run(setup, "322M")
    assert "322M" in made.made and "OGN-KRS" in made.pieces and "OGN.1" not in made.pieces
    sensors = setup.sensors.model_copy(update={"carries": (PositionSensor.CURVATURE,)})
    second = replace(setup, seed=7, sensors=sensors)
    surveyed, result = PositionRun(second).run(), PositionRun(replace(second, curvature_map=made)).run()
    assert result.arrived and result.out_m <= 0.0
    assert float(result.trace["estimate_error_m"].std()) < 0.65
    assert np.median(result.trace["bound_ahead_m"]) < 1.5 * np.median(surveyed.trace["bound_ahead_m"])


def test_a_train_that_there_is_not_is_refused() -> None:
    with pytest.raises(InputError) as error:
        map_by_run(load_scenario("karasuyama_weekday").setup, "999Z")
    assert error.value.key == "--train"
