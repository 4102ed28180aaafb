"""All readers: what they make of trains that do not carry their sensors."""

from typing import Any

import numpy as np
import pytest

from onboard.localisation.fix import NOTHING
from onboard.localisation.table import READERS, READERS_ROW, READINGS, Reader
from onboard.records import PATTERN, PLACE, PLACE_BEACON, PLACE_MARKERS, UNIT, Chart

STEP_S = 0.1
SPEED_MPS = 20.0


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
def test_a_train_without_the_sensor_misses_nothing(reader: Reader) -> None:
    """It runs past beacons and markers that its database has."""
    places = [
        (PLACE_BEACON, 100.0, 1, 1, 1, 0.0),
        (PLACE_MARKERS, 150.0, 2, 1, 1, 0.0),
        (PLACE_BEACON, 200.0, 3, 0, 1, 0.0),
        (PLACE_BEACON, 300.0, 4, 0, 1, 0.0),
    ]
    chart = Chart(np.zeros(1000, dtype=PATTERN), np.array(places, dtype=PLACE))
    unit: Any = np.zeros(1, UNIT).view(np.recarray)[0]
    unit.odometer_scale, unit.position_known, unit.paths_taken_up = 1.0, 1, 1
    unit.places_rows, unit.path_rows = len(places), 1000
    unit.bound_ahead_m = unit.bound_behind_m = 5.0
    own = np.zeros(1, READERS_ROW).view(np.recarray)[0][reader.name]
    reading = np.zeros(1, READINGS).view(np.recarray)[0][reader.name]
    outcomes = set[int]()
    for _ in range(400):
        unit.speed_mps = SPEED_MPS
        unit.odometer_m += SPEED_MPS * STEP_S
        unit.position_m += SPEED_MPS * STEP_S
        outcomes.add(int(reader.function(own, reading, unit, chart, STEP_S)))
    assert outcomes == {NOTHING}
