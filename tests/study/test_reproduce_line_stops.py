from __future__ import annotations

import numpy as np

from onboard.tuning import OFFSET_STEP_MPS2, Learned
from study.reproduce_line_stops import figures, is_right


def test_figures_of_stops() -> None:
    """Of 0.1, -0.4, 0.6 and 0 m two are within 0.35 m and three within 0.5 m."""
    found = figures(np.array([0.1, -0.4, 0.6, 0.0]))
    assert (found["within_0.35_m"], found["within_0.5_m"], found["worst_m"]) == (0.5, 0.75, 0.6)


def test_right_is_within_a_step_and_a_half_of_the_grid() -> None:
    counts = tuple(int(index == 12) for index in range(21))  # 1.2 s, +2 steps
    learned = Learned("V1", 0.5, counts, counts)
    assert is_right(learned, 1.35, 3.5 * OFFSET_STEP_MPS2)
    assert not is_right(learned, 1.36, 2.0 * OFFSET_STEP_MPS2)
    assert not is_right(learned, 1.2, 0.4 * OFFSET_STEP_MPS2)
