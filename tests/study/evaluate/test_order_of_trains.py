"""Late days in blocks and minutes: every rule has the same days, and all trains come to their ends."""

import pytest

from study.evaluate import order_of_trains
from study.evaluate.manager_day import config_of
from study.evaluate.order_of_trains import lost_min
from wayside.config import OrderRule

MIN_A_DAY = 1440.0


@pytest.mark.parametrize("order", OrderRule)
def test_a_day_on_which_nothing_is_late_loses_nothing(
    order: OrderRule, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(order_of_trains, "SHARE", 0.0)
    assert lost_min(config_of("busy_line", order), 1) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("order", OrderRule)
def test_all_trains_of_a_late_day_come_to_their_ends(order: OrderRule) -> None:
    """One that never came would alone lose a day and more."""
    config = config_of("karasuyama_weekday", order)
    assert 0.0 < lost_min(config, 1) < MIN_A_DAY / 2.0
    assert lost_min(config, 1) == lost_min(config, 1)
