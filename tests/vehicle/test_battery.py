"""The battery: energy closes for any power, its charge stays in its window, a charge tapers; figures by hand."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from network.errors import InputError
from vehicle.battery import (
    available_j,
    carry,
    charge_current_max_a,
    current_for_a,
    exchange,
    gives_max_w,
    ocv_at,
    soc_of,
    stand,
    stored_j,
    takes_max_w,
)
from vehicle.train_file import load_train, shipped_train

KWH = 3.6e6
STEP_S = 0.1


def battery(soc: float = 0.5) -> NDArray[np.void]:
    """The EV-E301's, shape (1,)."""
    row = load_train(shipped_train("ev_e301")).battery
    assert row is not None
    own = row.copy()
    own["charge_c"] = soc * own["full_c"]
    return own


powers_w = st.lists(st.floats(-2e6, 2e6), min_size=1, max_size=60)
socs = st.floats(0.2, 0.9)


def test_a_full_one_holds_what_its_file_says() -> None:
    row = battery()[0]
    assert stored_j(row, 1.0) == pytest.approx(0.9 * 190.0 * KWH)
    assert stored_j(row, 0.0) == 0.0


def test_stored_energy_by_hand() -> None:
    """From empty to a fifth of full: 546 to 585 V over a tenth, 585 to 598 V over the next."""
    row = battery()[0]
    volts = 0.5 * (546.0 + 585.0) * 0.1 + 0.5 * (585.0 + 598.0) * 0.1
    assert stored_j(row, 0.2) == pytest.approx(volts * row["full_c"])


def test_current_and_loss_by_hand() -> None:
    """At half charge 630 V: 300 kW out through 0.03 ohm are I = (630 - sqrt(630^2 - 4 * 0.03 * 3e5)) / 0.06."""
    row = battery()[0]
    amperes = (630.0 - math.sqrt(630.0**2 - 4.0 * 0.03 * 3e5)) / 0.06
    assert current_for_a(row, 3e5) == pytest.approx(amperes)
    assert exchange(row, 3e5, 0.0, 1.0) == pytest.approx(3e5)
    assert row["flows"]["lost_j"] == pytest.approx(0.03 * amperes**2)
    assert row["charge_c"] == pytest.approx(0.5 * row["full_c"] - amperes)


def test_ten_minutes_at_400_kw_by_hand() -> None:
    """With 30 kW of auxiliaries 370 kW go in: 61.7 kWh, less I^2 R of about 570 A."""
    row = battery(0.3)[0]
    before_j = stored_j(row, 0.3)
    stand(row, 30e3, 400e3, 600.0, 1.0)
    gained_j = stored_j(row, soc_of(row)) - before_j
    assert row["flows"]["taken_j"] == pytest.approx(370e3 * 600.0)
    assert row["flows"]["supplied_j"] == pytest.approx(400e3 * 600.0)
    assert gained_j == pytest.approx(370e3 * 600.0 - 0.03 * 570.0**2 * 600.0, rel=0.005)


@given(socs, powers_w)
def test_energy_closes_for_any_power_and_the_charge_stays_in_its_window(
    soc: float, powers: list[float]
) -> None:
    row = battery(soc)[0]
    before_j = stored_j(row, soc_of(row))
    for power_w in powers:
        carry(row, max(power_w, 0.0), max(-power_w, 0.0), STEP_S)
        assert row["pack"]["soc_low"] - 1e-12 <= soc_of(row) <= row["pack"]["soc_high"] + 1e-12
    change_j = stored_j(row, soc_of(row)) - before_j
    through_j = row["flows"]["given_j"] + row["flows"]["taken_j"]
    assert row["flows"]["taken_j"] - row["flows"]["given_j"] - row["flows"]["lost_j"] == pytest.approx(
        change_j, abs=1e-3 * through_j + 1.0
    )
    asked_j = sum(powers) * STEP_S
    flowed_j = row["flows"]["given_j"] - row["flows"]["taken_j"]
    assert flowed_j == pytest.approx(
        asked_j - row["flows"]["missing_j"] + row["flows"]["spilled_j"], abs=1e-6 * 2e6
    )


@given(socs, st.floats(0.0, 1e6), st.floats(0.0, 5e5), st.floats(0.0, 5e5))
def test_the_link_balances_with_a_charger(soc: float, supply: float, drawn: float, back: float) -> None:
    """What comes in (charger, motors, battery) is what goes out (draw, battery), but what is missing or spilled."""
    row = battery(soc)[0]
    row["supply_w"] = supply
    carry(row, drawn, back, 1.0)
    into = row["flows"]["supplied_j"] + back + row["flows"]["given_j"] + row["flows"]["missing_j"]
    out_of = drawn + row["flows"]["taken_j"] + row["flows"]["spilled_j"]
    assert into == pytest.approx(out_of, rel=1e-9, abs=1e-3)
    assert row["flows"]["supplied_j"] <= supply + 1e-6


@pytest.mark.parametrize("limit_w", [50e3, 150e3, 250e3])
def test_from_the_motors_it_takes_what_its_limit_says_and_from_a_charger_more(limit_w: float) -> None:
    """300 kW come back, which the shipped limit of 400 kW lets in: a lower one binds, and a charger has its own."""
    free, held, charged = battery()[0], battery()[0], battery()[0]
    held["pack"]["regeneration_max_w"] = charged["pack"]["regeneration_max_w"] = limit_w
    carry(free, 0.0, 300e3, 1.0)
    assert (free["flows"]["taken_j"], free["flows"]["spilled_j"]) == (
        pytest.approx(300e3),
        pytest.approx(0.0, abs=1e-3),
    )
    carry(held, 0.0, 300e3, 1.0)
    assert held["flows"]["taken_j"] == pytest.approx(limit_w)
    assert held["flows"]["spilled_j"] == pytest.approx(300e3 - limit_w)
    charged["supply_w"] = 300e3
    carry(charged, 0.0, 0.0, 1.0)
    assert charged["flows"]["taken_j"] == pytest.approx(300e3)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(1e3, 1e6))
def test_a_charge_tapers(one: float, other: float, power_w: float) -> None:
    low, high = sorted((one, other))
    currents = [charge_current_max_a(battery(soc)[0], power_w, STEP_S) for soc in (low, high)]
    assert currents[1] <= currents[0] + 1e-9
    assert ocv_at(battery()[0], low) <= ocv_at(battery()[0], high)


def test_without_its_taper_the_current_would_not_fall() -> None:
    straight, tapered = battery(0.88), battery(0.88)
    straight["pack"]["taper_to_share"] = 1.0
    both = [charge_current_max_a(row[0], 4e5, STEP_S) for row in (straight, tapered)]
    assert both[1] < 0.5 * both[0]


def test_empty_it_gives_nothing_and_full_it_takes_nothing() -> None:
    empty, full = battery(0.2)[0], battery(0.9)[0]
    assert gives_max_w(empty, STEP_S) == 0.0 and available_j(empty) == 0.0
    assert takes_max_w(full, 4e5, STEP_S) == 0.0
    carry(empty, 5e4, 0.0, 1.0)
    assert empty["flows"]["missing_j"] == 5e4


def changed(tmp_path: Path, old: str, new: str) -> Path:
    text = shipped_train("ev_e301").read_text("utf-8")
    assert old in text
    path = tmp_path / "train.toml"
    path.write_text(text.replace(old, new), "utf-8")
    return path


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("capacity_kwh = 190.0", "capacity_kwh = 1e-9", "1 to 10000 kWh"),
        ("soc_low = 0.2", "soc_low = 0.85", "soc_low below taper_from_soc below soc_high"),
        ("voltage_max_v = 714.0", "voltage_max_v = 660.0", "voltage_max_v above the open-circuit voltage"),
        ("voltage_min_v = 500.0", "voltage_min_v = 650.0", "voltage_min_v below the open-circuit voltage"),
        ("[0.0, 0.1, 0.3,", "[0.0, 0.3, 0.1,", "states of charge that rise from 0 to 1"),
        ("546.0, 585.0", "590.0, 585.0", "voltages that do not fall"),
        ("resistance_ohm = 0.03", "resistance_ohm = 3.0", "less than half of the voltage"),
        ("discharge_max_kw = 600.0", "discharge_max_kw = -5.0", "power of a traction battery"),
    ],
)
def test_nonsense_is_refused_in_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(InputError, match="battery") as error:
        load_train(changed(tmp_path, old, new))
    assert said in str(error.value) and "\n" not in str(error.value)


def test_a_train_without_the_table_has_none() -> None:
    assert load_train(shipped_train("br642")).battery is None
