"""The motion digest counts what moved where, and nothing of how it is written down."""

import numpy as np
import pytest
from numpy.typing import NDArray

from simulation.motion_digest import motion_digest
from simulation.world.records import TRACE

STOCKS = ("B", "A")


def trace() -> NDArray[np.void]:
    rows = np.zeros(40, dtype=TRACE)
    rows["step"] = np.repeat(np.arange(10, 210, 10), 2)
    rows["slot"] = np.tile([0, 1], 20)
    rows["position_m"] = np.linspace(3.0, 700.0, 40)
    rows["speed_mps"] = 12.0
    return rows


def test_order_of_rows_slots_and_other_fields_do_not_count() -> None:
    rows = trace()
    turned = rows[::-1].copy()
    turned["slot"] = 1 - turned["slot"]
    turned["notch"] = 3.0
    turned["bound_ahead_m"] = 9.0
    assert motion_digest(turned, STOCKS[::-1], 10) == motion_digest(rows, STOCKS, 10)


def test_samples_of_events_and_of_standing_trains_do_not_count() -> None:
    rows = trace()
    more = np.zeros(2, dtype=TRACE)
    more["step"] = [13, 300]
    more["speed_mps"] = [5.0, 0.0]
    assert motion_digest(np.concatenate([rows, more]), STOCKS, 10) == motion_digest(rows, STOCKS, 10)


@pytest.mark.parametrize(("name", "by"), [("position_m", 2e-4), ("speed_mps", -2e-4), ("step", 10)])
def test_whatever_moved_counts(name: str, by: float) -> None:
    rows = trace()
    rows[name][7] += by
    assert motion_digest(rows, STOCKS, 10) != motion_digest(trace(), STOCKS, 10)


def test_less_than_a_twentieth_of_a_millimetre_does_not_count() -> None:
    rows = trace()
    rows["position_m"] = np.rint(rows["position_m"])
    nudged = rows.copy()
    nudged["position_m"] += 4e-5
    assert motion_digest(nudged, STOCKS, 10) == motion_digest(rows, STOCKS, 10)


def test_which_train_moved_counts() -> None:
    assert motion_digest(trace(), STOCKS, 10) != motion_digest(trace(), STOCKS[::-1], 10)
