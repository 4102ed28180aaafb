"""The spatial filter: what it passes, what it damps, how late it is, and that it forgets."""

import numpy as np
import pytest

from onboard.localisation.spatial_filter import (
    CORNER_M,
    DAMPED_M,
    PASSED_M,
    SETTLES_M,
    delay_m,
    filter_gain,
    pass_all,
    sections,
)

NUMBERS = np.array(sections(CORNER_M))


def amplitude(wave_m: float, numbers: np.ndarray) -> float:
    """What is left of a wave by running it through, after it has settled."""
    at_m = np.arange(2000.0)
    out = pass_all(numbers, np.sin(2.0 * np.pi * at_m / wave_m))[-1000:]
    return float(np.sqrt(2.0) * out.std())


@pytest.mark.parametrize("wave_m", [200.0, 80.0, PASSED_M, DAMPED_M, 12.0])
def test_what_runs_through_is_what_the_gain_says(wave_m: float) -> None:
    assert amplitude(wave_m, NUMBERS) == pytest.approx(float(filter_gain(np.array([wave_m]))[0]), abs=0.01)


def test_waves_over_50_m_pass_and_those_under_25_m_are_damped() -> None:
    assert np.all(filter_gain(np.array([50.0, 60.0, 100.0, 500.0])) > 0.96)
    assert np.all(filter_gain(np.array([25.0, 20.0, 10.0, 4.0])) < 0.25)
    assert filter_gain(np.array([DAMPED_M]), corner_m=10.0)[0] > 0.9  # another corner does not


def test_a_constant_passes_at_once_and_a_ramp_comes_late_by_the_delay() -> None:
    flat = pass_all(NUMBERS, np.full(300, 3.0e-3))
    assert np.all(np.isnan(flat[: int(SETTLES_M)])) and flat[-1] == pytest.approx(3.0e-3)
    ramp = pass_all(NUMBERS, 1e-5 * np.arange(600.0))
    assert ramp[-1] == pytest.approx(1e-5 * (599.0 - delay_m()), rel=1e-3)


def test_after_a_gap_nothing_is_told_until_it_has_settled() -> None:
    values = np.ones(500)
    values[200:210] = np.nan
    out = pass_all(NUMBERS, values)
    first = int(SETTLES_M)
    assert np.all(np.isnan(out[200 : 210 + first])) and np.all(np.isfinite(out[211 + first :]))
