"""Times drawn from named distributions: their means are those of the distribution, and wrong figures are refused."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy import stats

from radio.chance import generator
from simulation.late.spread import DrawnTime

MANY = 20_000
SIGMAS = 4.5  # a draw of this many fails once in 150 000 tries; the seeds are fixed
SHAPES = {
    "exponential": {"mean_s": 240.0},
    "lognormal": {"mean_s": 15.0, "sigma": 0.6},
    "weibull": {"mean_s": 10.0, "shape": 1.4},
    "gamma": {"mean_s": 60.0, "shape": 2.0},
    "uniform": {"low_s": 10.0, "high_s": 50.0},
    "fixed": {"mean_s": 30.0},
}


def spread(name: str, **more: float) -> DrawnTime:
    return DrawnTime.model_validate({"distribution": name, **SHAPES[name], **more})


def frozen(name: str) -> Any:  # noqa: ANN401 - scipy's frozen distributions
    """The same distribution as scipy has it."""
    of = SHAPES[name]
    match name:
        case "exponential":
            return stats.expon(scale=of["mean_s"])
        case "lognormal":
            return stats.lognorm(of["sigma"], scale=of["mean_s"] * math.exp(-0.5 * of["sigma"] ** 2))
        case "weibull":
            return stats.weibull_min(of["shape"], scale=of["mean_s"] / math.gamma(1 + 1 / of["shape"]))
        case "gamma":
            return stats.gamma(of["shape"], scale=of["mean_s"] / of["shape"])
        case _:
            return stats.uniform(of["low_s"], of["high_s"] - of["low_s"])


def drawn(source: DrawnTime, seed: int = 1) -> list[float]:
    chance = generator(seed, "test")
    return [source.draw_s(chance) for _ in range(MANY)]


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "fixed"])
def test_draws_follow_the_distribution(name: str) -> None:
    law, times = frozen(name), drawn(spread(name))
    mean = sum(times) / MANY
    assert mean == pytest.approx(law.mean(), abs=SIGMAS * law.std() / math.sqrt(MANY) + 0.05)
    assert stats.kstest(times, law.cdf).pvalue > 1e-4
    wrong = stats.expon(scale=law.mean() * 1.1)
    assert stats.kstest(times, wrong.cdf).pvalue < 1e-4  # the test can fail


@pytest.mark.parametrize("name", [name for name in SHAPES if name not in ("fixed", "uniform")])
def test_a_lid_takes_what_is_above_it(name: str) -> None:
    lid_s = SHAPES[name]["mean_s"] * 1.5
    times = drawn(spread(name, max_s=lid_s))
    law = frozen(name)
    expected = law.expect(lambda x: x, ub=lid_s) + lid_s * law.sf(lid_s)
    assert max(times) == lid_s
    assert sum(times) / MANY == pytest.approx(expected, abs=SIGMAS * law.std() / math.sqrt(MANY) + 0.05)


def test_a_fixed_time_is_itself() -> None:
    assert set(drawn(spread("fixed"))) == {30.0}


@given(st.sampled_from(sorted(SHAPES)), st.integers(0, 1000))
def test_times_are_steps_and_none_is_negative(name: str, seed: int) -> None:
    source, chance = spread(name), generator(seed, "steps")
    times = [source.draw_s(chance) for _ in range(20)]
    assert all(time >= 0.0 and math.isclose(time * 10, round(time * 10)) for time in times)


@given(st.sampled_from(sorted(SHAPES)), st.floats(1.0, 5.0))
def test_a_greater_mean_makes_every_draw_greater(name: str, times: float) -> None:
    """The same chance gives the same place in the distribution, so that points of a grid are compared day by day."""
    if "mean_s" not in SHAPES[name]:
        return
    less, more = spread(name), spread(name, mean_s=SHAPES[name]["mean_s"] * times)
    pairs = [(less.draw_s(generator(s, "a")), more.draw_s(generator(s, "a"))) for s in range(10)]
    assert all(high == pytest.approx(low * times, abs=0.05 + 0.05 * times) for low, high in pairs)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"distribution": "weibull", "mean_s": 1.0}, "mean_s and shape"),
        ({"distribution": "exponential", "mean_s": 1.0, "sigma": 1.0}, "mean_s, and no other"),
        ({"distribution": "uniform", "low_s": 9.0, "high_s": 3.0}, "at least low_s = 9"),
        ({"distribution": "normal", "mean_s": 1.0}, "exponential"),
        ({"distribution": "fixed", "mean_s": 1e9}, "259200"),
    ],
)
def test_figures_that_are_not_the_distributions_are_refused(table: dict[str, Any], expected: str) -> None:
    with pytest.raises(ValidationError, match=expected):
        DrawnTime.model_validate(table)
