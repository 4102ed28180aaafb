"""The spatial filter (空間フィルタ) that both the map of curvature and what a run measures of it go through.

Harada, Maki, Kazato and Ishiguri, section 3.3: waves under 25 m differ from run to run (the body's motion, the rails'
own faults), waves over 50 m stay for ten years; low delay, because it stands between a curve and the fix. The paper
names no kind. Here: Butterworth's low pass of fourth order, two sections one after the other, by the metre, its corner
at the middle of the two on a scale of ratios. It passes 97 % of a wave of 50 m and 24 % of one of 25 m, and is late
by 14.7 m; since map and run are late alike, that cancels.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.curvature_row import RISES_M
from vehicle.compiled import compiled

PASSED_M: Final = 50.0  # waves longer than this pass (section 3.3)
DAMPED_M: Final = 25.0  # shorter ones are damped
CORNER_M: Final = math.sqrt(PASSED_M * DAMPED_M)
QUALITIES: Final = (0.541196100146197, 1.306562964876377)  # of Butterworth's two sections
SETTLES_M: Final = 70.0  # what it began with is forgotten to a thousandth
SECTION: Final = 5  # numbers of a section
DELAY_RAD: Final = sum(1.0 / quality for quality in QUALITIES)  # 2.613: delay of long waves times the corner

Floats = NDArray[np.float64]
Numbers = NDArray[np.float64] | list[float]  # a part of a record is an array, and said to be a list


def sections(corner_samples: float) -> tuple[float, ...]:
    """The two sections' b0, b1, b2, a1, a2 for a corner at a wave of that many samples (bilinear, prewarped)."""
    numbers: list[float] = []
    for quality in QUALITIES:
        corner_rad = 2.0 * math.pi / corner_samples
        alpha = math.sin(corner_rad) / (2.0 * quality)
        a0, low = 1.0 + alpha, (1.0 - math.cos(corner_rad)) / 2.0
        numbers += [low / a0, 2.0 * low / a0, low / a0, -2.0 * math.cos(corner_rad) / a0, (1.0 - alpha) / a0]
    return tuple(numbers)


def delay_m(corner_m: float = CORNER_M) -> float:
    """By how much it delays long waves, m."""
    return DELAY_RAD * corner_m / (2.0 * math.pi)


def filter_gain(wave_m: Floats, corner_m: float = CORNER_M) -> Floats:
    """What is left of waves of those lengths (m), as a share."""
    numbers, z = sections(corner_m), np.exp(-2.0j * np.pi / wave_m)
    left = np.ones_like(z)
    for first in range(0, len(numbers), SECTION):
        b0, b1, b2, a1, a2 = numbers[first : first + SECTION]
        left = left * (b0 + b1 * z + b2 * z * z) / (1.0 + a1 * z + a2 * z * z)
    return np.asarray(np.abs(left), dtype=np.float64)


@compiled
def settle_filter(numbers: Numbers, kept: Numbers, value: float) -> None:
    """As if `value` had come in for ever."""
    for i in range(2):
        b1, b2 = numbers[SECTION * i + 1], numbers[SECTION * i + 2]
        a1, a2 = numbers[SECTION * i + 3], numbers[SECTION * i + 4]
        kept[2 * i + 1] = (b2 - a2) * value
        kept[2 * i] = (b1 - a1) * value + kept[2 * i + 1]


@compiled
def shift_filter(numbers: Numbers, kept: Numbers, by: float) -> None:
    """As if all that has come in for ever had been greater by so much."""
    for i in range(2):
        b1, b2 = numbers[SECTION * i + 1], numbers[SECTION * i + 2]
        a1, a2 = numbers[SECTION * i + 3], numbers[SECTION * i + 4]
        kept[2 * i + 1] += (b2 - a2) * by
        kept[2 * i] += (b1 - a1 + b2 - a2) * by


@compiled
def filtered_sample(numbers: Numbers, kept: Numbers, value: float) -> float:
    """One sample through both sections (direct form II, transposed); what comes out."""
    for i in range(2):
        b0, b1, b2 = numbers[SECTION * i], numbers[SECTION * i + 1], numbers[SECTION * i + 2]
        a1, a2 = numbers[SECTION * i + 3], numbers[SECTION * i + 4]
        out = b0 * value + kept[2 * i]
        kept[2 * i] = b1 * value - a1 * out + kept[2 * i + 1]
        kept[2 * i + 1] = b2 * value - a2 * out
        value = out
    return value


@compiled
def pass_all(numbers: Floats, values: Floats) -> Floats:
    """Samples a metre apart through the filter; nan where it has not settled since the last nan."""
    kept = np.zeros(4)
    out = np.empty(values.size)
    since = SETTLES_M
    settled = False
    for i in range(values.size):
        out[i] = np.nan
        if np.isnan(values[i]):
            settled = False
            continue
        if not settled:
            settle_filter(numbers, kept, values[i])
            since, settled = 0.0, True
        value = filtered_sample(numbers, kept, values[i])
        since += 1.0
        if since > SETTLES_M:
            out[i] = value
    return out


def step_response(numbers: Floats) -> Floats:
    """What the filter makes of a step of 1, sample by sample, RISES_M of them."""
    kept = np.zeros(4)
    return np.array([filtered_sample(numbers, kept, 1.0) for _ in range(RISES_M)])
