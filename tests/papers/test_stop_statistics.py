import numpy as np
import pytest

from network.errors import InputError
from papers.reproduction import Options
from papers.stop_statistics import (
    FACTORS,
    SLIPPERY,
    Factor,
    StopStatistics,
    drawn_factors,
    effects_m,
    first_order_share,
    reproduce,
    share_rows,
    stop_statistics,
    stops_of,
    within_rows,
)


@pytest.fixture(scope="module")
def usual() -> StopStatistics:
    return stop_statistics(4000, 1)


def test_first_order_shares_of_a_sum_are_its_parts() -> None:
    rng = np.random.default_rng(1)
    first, second = rng.normal(size=(2, 20_000))
    total = 2.0 * first + second
    # variances 4 and 1
    assert first_order_share(first, total) == pytest.approx(0.8, abs=0.02)
    assert first_order_share(second, total) == pytest.approx(0.2, abs=0.02)
    assert first_order_share(rng.normal(size=20_000), total) == pytest.approx(0.0, abs=0.005)
    assert first_order_share(rng.normal(size=2_000), total[:2_000]) == pytest.approx(0.0, abs=0.012)
    assert first_order_share(np.ones(20_000), total) == 0.0


def test_factors_are_drawn_over_their_ranges() -> None:
    values = drawn_factors(2000, 1, FACTORS)
    assert values["last_beacon"].min() == pytest.approx(10.0, abs=0.02)
    assert values["last_beacon"].max() == pytest.approx(20.0, abs=0.02)
    assert values["brake"].std() == pytest.approx(0.02, rel=0.02)
    assert np.abs(values["brake"] - 1.0).max() <= 0.06 + 1e-12
    off_s = stops_of(values, 0.3)["brake_lag_off_s"]
    assert 0.3 + off_s == pytest.approx(values["brake_lag"])  # the brake has the lag that is drawn


def test_the_shares_within_grow_with_the_limit(usual: StopStatistics) -> None:
    assert usual.errors_m.size == 4000
    assert 0.5 < usual.within[0.35] <= usual.within[0.5] <= usual.within[1.0] <= 1.0
    assert 0.8 < sum(usual.variance_shares.values()) < 1.1
    assert [row.passed for row in share_rows(usual)] == [True, True]  # and is what each factor does alone


@pytest.mark.nightly
def test_the_same_seed_gives_the_same_stops(usual: StopStatistics) -> None:
    assert np.array_equal(stop_statistics(4000, 1).errors_m, usual.errors_m)
    assert not np.array_equal(stop_statistics(4000, 2).errors_m, usual.errors_m)


def test_a_factor_held_still_has_no_share_and_takes_its_scatter_away(usual: StopStatistics) -> None:
    steady = stop_statistics(4000, 1, {"brake": Factor(1.0, 0.0, "", "test")})
    assert steady.variance_shares["brake"] == 0.0
    assert steady.errors_m.std() < usual.errors_m.std()


@pytest.mark.nightly
def test_slippery_rails_outweigh_everything() -> None:
    assert stop_statistics(4000, 1, {"adhesion": SLIPPERY}).weightiest == "adhesion"


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="at least 400 stops"):
        stop_statistics(10, 1)
    with pytest.raises(InputError, match="wheels"):
        stop_statistics(4000, 1, {"wheels": Factor(0.0, 1.0, "", "test")})


def test_counts_are_not_rounded_and_have_their_interval() -> None:
    """Of 4,000 stops all but one: Clopper and Pearson give 0.99861 to 0.99999."""
    result = StopStatistics(np.zeros(4000), {0.35: 0.5, 0.5: 0.9, 1.0: 3999 / 4000}, {})
    (judged,), told = within_rows(result)
    assert judged.ours == "3,999 of 4,000 (0.99861 to 0.99999)"
    assert judged.passed
    assert told[0].value == "2,000 of 4,000 (0.48438 to 0.51562)"
    short, _ = within_rows(StopStatistics(np.zeros(4000), {1.0: 0.998}, {}))
    assert not short[0].passed


def test_what_a_factor_does_alone_has_the_sign_of_its_physics() -> None:
    """A stronger brake and a climb stop sooner; a heavier train and a beacon taken to lie nearer later."""
    effects = effects_m()
    assert effects["brake"] < 0.0 < effects["load"]
    assert effects["gradient"] < 0.0
    assert effects["adhesion"] == 0.0  # the brake stays below it
    # The last beacon taken to lie 0.05 m further ahead puts the estimate as far ahead.
    assert effects["beacon_error"] == pytest.approx(-0.05, abs=0.005)
    assert effects["wheel"] < 0.0  # a wheel that shows more way than it runs


@pytest.mark.nightly
def test_the_reproduction_judges_only_what_can_fail() -> None:
    result = reproduce(Options(quick=True))
    assert result.passed
    assert all(row.paper is None or row.case.endswith("stops within 1 m") for row in result.rows)
    assert all(row.criterion != "told, not judged" for row in result.rows)
    assert {figure.name for figure in result.figures} >= {"stops within 0.35 m", "stops within 0.5 m"}
