"""Counted noise: the same whatever else was drawn before, and spread as it should be."""

import numpy as np
import pytest

from simulation.sensors.noise import normal, source_of, uniform

SOURCE = source_of(1, "tag reader", "K1")


def test_a_step_has_its_noise_in_whatever_order_it_is_asked_for() -> None:
    steps = list(range(100))
    forwards = [normal(SOURCE, step) for step in steps]
    assert [normal(SOURCE, step) for step in reversed(steps)] == forwards[::-1]
    assert len(set(forwards)) == len(forwards)


@pytest.mark.parametrize("names", [("tag reader", "K2"), ("camera", "K1")])
def test_sources_and_seeds_have_nothing_in_common(names: tuple[str, str]) -> None:
    for other in (source_of(1, *names), source_of(2, "tag reader", "K1")):
        mine = np.array([normal(SOURCE, step) for step in range(4000)])
        its = np.array([normal(other, step) for step in range(4000)])
        assert abs(np.corrcoef(mine, its)[0, 1]) < 4.0 / np.sqrt(4000.0)


def test_the_spread_is_that_of_the_distribution() -> None:
    """Within four standard errors: mean, variance and 1.96 sigma of 20,000 draws; neighbours uncorrelated."""
    drawn = np.array([normal(SOURCE, step) for step in range(20_000)])
    assert abs(drawn.mean()) < 4.0 / np.sqrt(20_000)
    assert abs(drawn.var() - 1.0) < 4.0 * np.sqrt(2.0 / 20_000)
    assert abs(np.mean(np.abs(drawn) < 1.96) - 0.95) < 4.0 * np.sqrt(0.05 * 0.95 / 20_000)
    assert abs(np.corrcoef(drawn[1:], drawn[:-1])[0, 1]) < 4.0 / np.sqrt(20_000)
    shares = np.array([uniform(SOURCE, step) for step in range(20_000)])
    assert 0.0 <= shares.min() < shares.max() < 1.0
