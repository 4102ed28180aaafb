"""What one stop taught its train, for the page: the evaluation function over its grid, and the waves it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.tuning import (
    DEAD_TIMES,
    OFFSET_STEP_MPS2,
    OFFSET_ZERO,
    OFFSETS,
    STEP_S,
    StopDecelerations,
    misfit,
    waves,
    window,
)
from study.record.shown import LearnedTrain

if TYPE_CHECKING:  # the page of a run draws these itself
    pass

Floats = NDArray[np.float64]

KMHPS_PER_MPS2: Final = 3.6


def response_surface(stop: StopDecelerations) -> Floats | None:
    """J, (m/s^2)^2, at every dead time (column) and offset (row) of the grid; None for a stop without a window."""
    span = window(stop)
    if span is None:
        return None
    smooth = waves(stop)
    return np.array(
        [
            [misfit(*smooth, *span, x, (y - OFFSET_ZERO) * OFFSET_STEP_MPS2) for x in range(DEAD_TIMES)]
            for y in range(OFFSETS)
        ]
    )


def most_telling(tuned: Mapping[str, LearnedTrain]) -> str | None:
    """The train that differs most from its design: the one to show. None where none has learned."""
    away = {
        unit: abs(one.learned.offset_mps2) / OFFSET_STEP_MPS2
        + abs(one.learned.dead_time_s - one.learned.design_dead_time_s) / STEP_S
        for unit, one in sorted(tuned.items())
    }
    return max(away, key=lambda unit: away[unit]) if away else None


def waves_shown(stop: StopDecelerations) -> tuple[Floats, Floats, Floats]:
    """Designed, measured and smoothed deceleration of a stop, m/s^2, a step apart and up to rest."""
    return stop.designed_mps2, stop.actual_mps2, waves(stop)[1]
