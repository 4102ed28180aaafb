"""Tables of batteries from records made by hand: power between two, the balance, and the least charge that does."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from scenario.scenario import load_scenario
from simulation.result import BatteryEvent, BatteryRecord
from study.collect.battery import ChargeWindow, battery_summary, battery_tables, least_charge_s, windows_of
from vehicle.battery import BatteryFlows, soc_of, stand, stored_j
from vehicle.record import dtype_of

KWH = 3.6e6
setup = cache(lambda: load_scenario("karasuyama_battery").setup)


def record(t_s: float, soc: float, event: BatteryEvent = BatteryEvent.NONE, **values: float) -> BatteryRecord:
    """V1's; counters are 0 where not given, in kWh."""
    battery = setup().trains["V1"].battery
    assert battery is not None
    flows: Any = np.zeros(1, dtype=dtype_of(BatteryFlows)).view(np.recarray)[0]
    for name, kwh in values.items():
        setattr(flows, f"{name}_j", kwh * KWH)
    stored = float(stored_j(battery[0], soc))
    return BatteryRecord("V1", "322M", t_s, event, "KRS", soc, stored, 4e5, flows)


def test_a_window_by_hand() -> None:
    """A tenth of the window's energy above its low end."""
    window = windows_of(setup())["V1"]
    assert isinstance(window, ChargeWindow)
    assert window.kept_j == pytest.approx(window.low_j + 0.1 * (window.high_j - window.low_j))
    assert window.soc_low == 0.2 < window.soc_kept < 0.28


def test_power_is_the_mean_since_the_row_before() -> None:
    flows = ((0.0, 7.0, 3.0), (36.0, 11.0, 4.0), (72.0, 12.0, 5.0))
    tables = battery_tables(
        [record(t_s, 0.5, given=given, taken=taken) for t_s, given, taken in flows], setup()
    )
    assert tables["battery"]["power_kw"].to_list() == [0.0, pytest.approx(300.0), 0.0]


def test_what_does_not_balance_is_told() -> None:
    rows = [record(0.0, 0.5), record(36.0, 0.5, given=6.0, taken=5.0, lost=0.5)]
    figures = battery_summary(battery_tables(rows, setup())["battery"], setup())["V1"]
    assert figures["unbalanced_percent"] == pytest.approx(100.0 * -1.5 / 11.0)


def test_the_least_charge_is_enough_and_a_minute_less_is_not() -> None:
    window, begin = windows_of(setup())["V1"], record(0.0, 0.3, BatteryEvent.CONNECTED)
    needs_j = 60.0 * KWH
    least_s = least_charge_s(setup(), begin, needs_j, window, drawn=True)
    assert least_s is not None and least_s > 120.0
    kind = setup().trains["V1"]
    assert kind.battery is not None
    for charged_s, reaches in ((least_s, True), (least_s - 60.0, False)):
        row = kind.battery[0].copy()
        row["charge_c"] = 0.3 * row["full_c"]
        stand(row, 30e3, 4e5, charged_s, 1.0)
        assert (stored_j(row, soc_of(row)) - needs_j >= window.kept_j) is reaches


def test_no_charge_does_for_a_way_that_is_too_long() -> None:
    begin = record(0.0, 0.3, BatteryEvent.CONNECTED)
    assert least_charge_s(setup(), begin, 150.0 * KWH, windows_of(setup())["V1"], drawn=True) is None


def test_a_charge_goes_to_the_next_one() -> None:
    rows = [
        record(0.0, 0.4, BatteryEvent.CONNECTED),
        record(600.0, 0.7, BatteryEvent.DISCONNECTED),
        record(3000.0, 0.5, BatteryEvent.CONNECTED),
        record(3300.0, 0.6, BatteryEvent.DISCONNECTED),
    ]
    charges = battery_tables(rows, setup())["charges"]
    assert charges["minutes"].to_list() == [10.0, 5.0]
    assert charges["next_way_kwh"][0] == pytest.approx((rows[1].stored_j - rows[2].stored_j) / KWH)
    assert charges["margin_kwh"][0] == pytest.approx(
        (rows[2].stored_j - windows_of(setup())["V1"].kept_j) / KWH
    )


def test_what_a_generator_gives_is_a_charge_and_not_the_way_of_the_one_before() -> None:
    """60 kW less the 5 kW that stay on give 11 kWh in 12 min, less what is lost."""
    rows = [
        record(0.0, 0.4, BatteryEvent.CONNECTED),
        record(600.0, 0.7, BatteryEvent.DISCONNECTED),
        record(3000.0, 0.25, BatteryEvent.BROUGHT),
        record(4000.0, 0.35, BatteryEvent.TAKEN_AWAY),
        record(5000.0, 0.3, BatteryEvent.CONNECTED),
    ]
    charges = battery_tables(rows, setup())["charges"]
    assert charges["minutes"].to_list() == [10.0, pytest.approx(1000.0 / 60.0), 0.0]
    assert charges["next_way_kwh"][0] == pytest.approx((rows[1].stored_j - rows[2].stored_j) / KWH)
    window = windows_of(setup())["V1"]
    begin = record(0.0, 0.25, BatteryEvent.BROUGHT)
    needs_j = begin.stored_j + 10.9 * KWH - window.kept_j
    least_s = least_charge_s(setup(), begin, needs_j, window, drawn=True)
    assert least_s == pytest.approx(720.0, rel=0.02)
