"""Runs as the check of the batteries reckons with them: at their own mean power, whatever their sign."""

import re
from dataclasses import replace

import pytest

from scenario.scenario import load_scenario
from simulation.battery_settings import BatterySettings, Beyond
from simulation.setup import Setup
from simulation.world.roster import drawn_up
from simulation.world.ways import ways_of
from study.feasibility import charge
from study.feasibility.check import feasibility
from study.feasibility.finding import FindingKind, Severity
from vehicle.battery import available_j, stored_j

KWH = 3.6e6


def one_set(setup: Setup, soc: float, auxiliary_w: float = 30e3) -> charge._SetCharge:
    kind = setup.trains["V4"]
    assert kind.battery is not None and setup.battery is not None
    row = kind.battery[0].copy()
    row["charge_c"] = soc * row["full_c"]
    ways = ways_of(setup, drawn_up(setup, setup.believed_line))["V4"]
    rules = charge.ChargeRules(waits=True, reserve_j=0.0, prediction_share=0.0)
    return charge._SetCharge(setup, setup.battery, ways, row, rules, auxiliary_w)


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_scenario("karasuyama_battery").setup


@pytest.mark.parametrize("auxiliary_w", [0.0, 30e3])
def test_a_run_is_at_its_own_mean_power(setup: Setup, auxiliary_w: float) -> None:
    one = one_set(setup, 0.6, auxiliary_w)
    before_j = available_j(one.battery)
    one.run(10.0 * KWH, 180.0)
    lost_j = float(one.battery["flows"]["lost_j"])
    resistance = float(one.battery["pack"]["resistance_ohm"])
    current_a = 10.0 * KWH / 180.0 / 620.0
    assert lost_j == pytest.approx(resistance * current_a**2 * 180.0, rel=0.15)
    assert before_j - available_j(one.battery) == pytest.approx(10.0 * KWH + lost_j, rel=1e-3)


def test_a_run_that_gives_more_than_it_takes_charges(setup: Setup) -> None:
    one = one_set(setup, 0.5)
    before_j = stored_j(one.battery, 0.5)
    one.run(-2.0 * KWH, 300.0)
    gained_j = stored_j(one.battery, float(one.battery["charge_c"] / one.battery["full_c"])) - before_j
    assert gained_j == pytest.approx(2.0 * KWH - float(one.battery["flows"]["lost_j"]), rel=1e-3)


def test_every_hop_has_the_time_of_its_run(setup: Setup) -> None:
    hops = one_set(setup, 0.5).ways.hops
    assert all(20.0 < hop.run_s < 1800.0 for hop in hops)


@pytest.mark.parametrize("away_s", [0.0, 60.0, 7200.0])
def test_what_is_run_off_the_line_is_taken_whole_however_short_the_time(setup: Setup, away_s: float) -> None:
    settings = BatterySettings(beyond=Beyond(distance_km=20.0, consumption_kwh_per_km=2.0, charge_min=0.0))
    one = one_set(replace(setup, battery=settings), 0.9)
    before_j = available_j(one.battery)
    charge._beyond(one, "321M", away_s)
    lost_j = float(one.battery["flows"]["lost_j"])
    assert before_j - available_j(one.battery) == pytest.approx(40.0 * KWH + lost_j, rel=1e-3)


def test_a_plan_that_waits_for_a_charger_does_not_run_as_printed() -> None:
    """A third of the power: a set charges ten minutes longer at Karasuyama, of which a day in blocks knows nothing."""
    weak = {"patch": {"line": {"times": {"chargers.*.power_kw": 0.35}}}}
    found = feasibility(load_scenario("karasuyama_battery", tables=weak).setup)
    assert found.good
    assert not found.on_time
    (waits,) = (f for f in found.findings if f.kind is FindingKind.CHARGE)
    assert waits.severity is Severity.LATE
    assert waits.short_s is not None
    assert waits.short_s > 300.0


def test_a_stand_without_a_charger_takes_what_is_on(setup: Setup) -> None:
    """10 kWh above what is kept are 20 min at 30 kW; in the 70 min that are left 5 kW stay on, as stated."""
    one = one_set(setup, 0.6)
    keeps_j = available_j(one.battery) - 10.0 * KWH
    assert one.wait(5400.0, keeps_j) == pytest.approx(4200.0, abs=10.0)
    assert available_j(one.battery) == pytest.approx(keeps_j - 5.0 * 70.0 / 60.0 * KWH, abs=0.1 * KWH)


def test_a_plan_whose_stand_comes_to_what_is_kept_is_told() -> None:
    """Sets that leave whatever, Karasuyama without its charger: what is kept there is the reserve alone."""
    table = {
        "battery": {"departure": "leave", "heating_kw": 36.0},
        "patch": {"line": {"remove": {"chargers": ["KRS"]}}},
    }
    found = feasibility(load_scenario("karasuyama_battery", tables=table).setup)
    stands = [f for f in found.findings if f.kind is FindingKind.CHARGE and f.severity is Severity.TIGHT]
    assert "KRS" in {f.place for f in stands} and all("heating and cooling off" in f.text for f in stands)


def test_what_helps_a_set_that_is_full_is_not_more_charging() -> None:
    """Without the charger at Karasuyama sets stand there on batteries: of 66 kW and of 30 kW 5 kW have to stay on."""
    spared_kwh: list[float] = []
    for heating_kw in (36.0, 0.0):
        table = {
            "battery": {"heating_kw": heating_kw},
            "patch": {"line": {"remove": {"chargers": ["KRS"]}}},
        }
        found = feasibility(load_scenario("karasuyama_battery", tables=table).setup)
        (remedy,) = (f.remedy for f in found.impossible if f.trains == ("321M",))
        assert "more charging" not in remedy
        named = re.search(r"; a charger at KRS or a shorter stand there: ([0-9.]+) kWh", remedy)
        assert named is not None, remedy
        spared_kwh.append(float(named[1]))
    assert spared_kwh[0] / spared_kwh[1] == pytest.approx((66.0 - 5.0) / (30.0 - 5.0), rel=0.01)


def test_a_set_that_lacks_its_way_beyond_the_line_is_told_with_the_minute_of_its_last_call() -> None:
    """322M leaves Karasuyama at 05:40 and Hoshakuji, where its calls end, for the main line."""
    tables = {"battery": {"beyond": {"consumption_kwh_per_km": 3.0, "charge_min": 0.0}}}
    setup = load_scenario("karasuyama_battery", tables=tables).setup
    (lacks,) = (f for f in feasibility(setup).findings if f.kind is FindingKind.CHARGE and "322M" in f.trains)
    assert (lacks.place, lacks.time_s) == ("HSK", setup.timetable.trains["322M"].calls[-1].arrival_s)


@pytest.mark.parametrize(("share", "named"), [(0.01, False), (0.05, True)])
def test_a_set_that_would_come_to_its_charger_but_for_its_reserve_is_told_so(
    share: float, named: bool
) -> None:
    """321M comes in by the portal at Hoshakuji, whose charger is one run away: waiting there gives it nothing."""
    tables = {"battery": {"start_of": {"V2": share}}}
    found = feasibility(load_scenario("karasuyama_battery", tables=tables).setup).findings
    (lacks,) = (f for f in found if f.kind is FindingKind.CHARGE)
    assert (lacks.place, "a smaller reserve_share" in lacks.remedy) == ("HSK.MD", named)
