"""The weekday on batteries, and the dead charger: who runs until when, against energy added up by hand.

The hand knows the hops' energies of the day in which every charger worked, what a battery holds, and the rule. It
knows nothing of predictions, of pantographs or of the step.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import polars as pl
import pytest

from network.clock import clock
from onboard.charge import ChargeWatch
from onboard.notes import AbleToLeave, UnableToLeave
from papers.battery_day import UNBALANCED_PERCENT_MAX, _home
from papers.reproduction import UnjudgedFigure
from scenario.scenario import Scenario, load_scenario
from simulation.battery_settings import Departure
from simulation.judge.log import Checker
from simulation.result import Ending
from simulation.setup import Setup
from study.collect.battery import windows_of
from study.drilling.drill import find_drill
from study.feasibility.check import feasibility
from study.feasibility.finding import FindingKind
from study.runner.run import FinishedRun
from tests.plain import run_on_plain

KWH = 3.6e6
FIRST = ("V4", "333M", "336M")  # down and back: the first round after the charger has failed
SECOND = ("V1", "335M", "338M")  # the next, with a longer stay at Karasuyama


def scenario(name: str) -> Scenario:
    return load_scenario(name if "/" not in name else str(find_drill(name)))


@cache
def run(name: str) -> FinishedRun:
    return run_on_plain(scenario(name))


def day() -> FinishedRun:
    return run("karasuyama_battery")


def by_hand(of: tuple[str, str, str] = FIRST) -> list[tuple[str, float]]:
    """What a set has taken from its battery (kWh at its terminals) at each stop from Hoshakuji and back there."""
    took, found = 0.0, [("HSK", 0.0)]
    for train in of[1:]:
        for leg in day().tables.energy_legs.filter(pl.col("train") == train).iter_rows(named=True):
            if leg["from_station"].startswith("HSK.") or leg["to_station"].startswith("HSK."):
                continue
            took += leg["net_kwh"]
            found.append((leg["to_station"], took))
        if train == of[1]:
            stay = day().tables.layovers.filter(pl.col("after_train") == train).row(0, named=True)
            took += stay["auxiliary_kwh"]
    return found


def held_kwh(setup: Setup) -> float:
    """What a full battery gives above its window's low end."""
    window = windows_of(setup)["V4"]
    return (window.high_j - window.low_j) / KWH


def lost_share(unit: str) -> float:
    """Of what passes the terminals, what the battery loses: of the whole day, since the hand knows no currents."""
    figures = day().summary["battery"][unit]
    return float(figures["lost_kwh"] / (figures["given_kwh"] + figures["taken_kwh"]))


# the day ---------------------------------------------------------------------------------------------------


def test_every_set_comes_home_with_its_reserve_and_the_energy_closes() -> None:
    assert not day().broken and day().result.ended_because is Ending.FINISHED
    for figures in day().summary["battery"].values():
        assert figures["margin_kwh"] > 0.0 and figures["missing_kwh"] == 0.0
        assert abs(figures["unbalanced_percent"]) <= UNBALANCED_PERCENT_MAX


def test_what_the_battery_gave_is_what_the_plant_drew() -> None:
    """Two books that share no counter: the plant's, cut by phase, and the battery's."""
    drew = sum(
        record.counted_j["traction"] - record.counted_j["regenerated"] + record.counted_j["auxiliary"]
        for record in day().result.energy
        if record.stock_id == "V4"
    )
    figures = day().summary["battery"]["V4"]
    beyond = day().tables.charges.filter(pl.col("unit") == "V4", pl.col("station") == "")
    wire_kwh = sum(
        row["taken_kwh"]
        for row in (_between(row["from_s"], row["to_s"]) for row in beyond.iter_rows(named=True))
    )
    supplied = figures["supplied_kwh"] - wire_kwh
    into_train = figures["given_kwh"] - (figures["taken_kwh"] - wire_kwh) + supplied
    assert into_train == pytest.approx(drew / KWH, rel=1e-3)


def _between(from_s: float, to_s: float) -> dict[str, float]:
    rows = day().tables.battery.filter(pl.col("unit") == "V4", pl.col("t_s") >= from_s, pl.col("t_s") <= to_s)
    return {"taken_kwh": rows["taken_kwh"][-1] - rows["taken_kwh"][0]}


@pytest.mark.nightly
def test_the_battery_neither_slows_nor_delays_the_day() -> None:
    plain = run("karasuyama_weekday")
    assert day().result.motion_digest == plain.result.motion_digest
    assert day().result.journal.entries == plain.result.journal.entries
    assert plain.tables.battery.is_empty() and plain.summary["battery"] == {}


def test_the_plan_is_checked_before() -> None:
    setup = scenario("karasuyama_battery").setup
    assert not [f for f in feasibility(setup).findings if f.kind is FindingKind.CHARGE]
    assert setup.battery is not None
    weak = replace(setup, line=replace(setup.line, chargers={}))
    found = [f for f in feasibility(weak).impossible if f.kind is FindingKind.CHARGE]
    assert {"321M", "323M"} <= {number for f in found for number in f.trains}


def test_charging_that_suffices_suffices_and_less_does_not() -> None:
    """A charge cut to the minutes that the table has leaves just what is to be kept back at the next one."""
    at_krs = day().tables.charges.filter(pl.col("station") == "KRS", pl.col("minutes_suffice") > 0.0)
    charge = at_krs.row(0, named=True)
    kept_kwh = windows_of(scenario("karasuyama_battery").setup)[charge["unit"]].kept_j / KWH
    rows = day().tables.battery.filter(pl.col("unit") == charge["unit"])
    at_s = charge["from_s"] + 60.0 * charge["minutes_suffice"]
    after = rows.filter(pl.col("t_s") >= at_s).row(0, named=True)["stored_kwh"]
    before = rows.filter(pl.col("t_s") <= at_s).row(-1, named=True)["stored_kwh"]
    assert before - charge["next_way_kwh"] <= kept_kwh <= after - charge["next_way_kwh"]


# the dead charger ---------------------------------------------------------------------------------------------


def test_by_hand_a_full_battery_does_not_meet_the_rule_for_the_round_trip() -> None:
    setup = scenario("karasuyama/60_charger_dead").setup
    assert setup.battery is not None and setup.battery.departure is Departure.WAIT
    whole_kwh = by_hand()[-1][1]
    reserve_kwh = setup.battery.reserve_share * held_kwh(setup)
    down_kwh = next(took for place, took in by_hand() if place == "KRS")
    assert whole_kwh * (1.0 + setup.battery.prediction_share) + reserve_kwh > held_kwh(setup)
    assert down_kwh * (1.0 + setup.battery.prediction_share) + reserve_kwh < held_kwh(setup)


def test_so_v4_says_so_and_stays_at_hoshakuji() -> None:
    dead = run("karasuyama/60_charger_dead")
    told = [entry for entry in dead.result.journal.entries if isinstance(entry.event, UnableToLeave)]
    assert [entry.who for entry in told] == ["V4"] and told[0].t_s > 14 * 3600
    ran = dead.tables.stops.filter(pl.col("departure_s").is_not_null())["train"].unique().to_list()
    assert "334M" in ran and not {"333M", "335M", "336M"} & set(ran)
    waiting = {w.stock_id: w for w in dead.result.waiting}
    assert "it is full" in waiting["V4"].waits_for and waiting["V4"].number == "333M"
    assert dead.result.ended_because is Ending.STALLED
    assert not dead.result.violations or all("arrive" in str(v.checker) for v in dead.result.violations)
    waits = dead.tables.waits.filter(pl.col("unit") == "V4", pl.col("cause") == "unable")
    assert waits["train"].to_list() == ["333M"]


def test_the_run_is_bad_and_says_why_but_no_state_is_dead() -> None:
    """Waiting for a charger that stays dead is no dead state: the set says what it lacks, and nobody has lied."""
    dead = run("karasuyama/60_charger_dead")
    assert dead.broken and dead.summary["trains_arrived"] == 13
    assert any("what takes it to SHN" in text and "it is full" in text for text in dead.broken)
    assert not [v for v in dead.result.violations if v.checker == Checker.NO_DEAD_STATE]


@pytest.mark.nightly
def test_with_the_charger_mended_it_goes_on(tmp_path: Path) -> None:
    fault = '[[fault]]\nkind = "charger_dead"\ntarget = "KRS"\nstart = "14:00:00"\nduration_s = 4500.0\n'
    path = tmp_path / "mended.toml"
    path.write_text(f'extends = "karasuyama_battery"\nid = "mended"\nname = "mended"\n{fault}', "utf-8")
    mended = run_on_plain(path)
    able = [entry for entry in mended.result.journal.entries if isinstance(entry.event, AbleToLeave)]
    left = mended.tables.stops.filter(pl.col("train") == "333M", pl.col("station") == "HSK")["departure_s"][0]
    mended_s = 14 * 3600 + 4500.0
    assert able[0].who == "V4" and mended_s <= able[0].t_s <= left <= mended_s + 60.0
    assert not mended.broken and mended.result.ended_because is Ending.FINISHED
    told = mended.tables.events.filter(pl.col("source") == "V4", pl.col("kind").str.ends_with("to leave"))
    assert told["kind"].to_list()[:2] == ["unable to leave", "able to leave"]


def test_ten_minutes_are_told_alone_and_not_judged() -> None:
    """They were what the power was chosen by; what was in the battery before has no part in them."""
    figure = _home(day())
    charge = day().tables.charges.filter(pl.col("station") == "KRS", pl.col("minutes") > 10.0).sort("from_s")
    most_kwh = 400.0 * 10.0 / 60.0
    assert isinstance(figure, UnjudgedFigure) and charge.height > 0
    told_kwh = float(str(figure.value).split(" kWh")[0])
    assert 0.0 < told_kwh <= most_kwh + 0.5
    assert "no independent check" in figure.meaning


@pytest.mark.nightly
def test_without_its_reckoning_v4_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the drill guards, switched off by name: then 333M departs, and the drill would fail."""
    monkeypatch.setattr(ChargeWatch, "why_not", lambda _self, _mission, _at: None)
    loose = run_on_plain(scenario("karasuyama/60_charger_dead"))
    stops = loose.tables.stops.filter(pl.col("train") == "333M", pl.col("station") == "HSK")
    assert stops["departure_s"][0] is not None


@pytest.mark.nightly
def test_by_hand_v4_comes_home_and_v1_does_not_as_in_the_drill() -> None:
    """Sets that leave whatever: from what each held as it left, stop by stop."""
    dead = run("karasuyama/61_charger_dead_leaving")
    homes: dict[str, float] = {}
    for unit, down, up in (FIRST, SECOND):
        rows = dead.tables.battery.filter(pl.col("unit") == unit)
        left = rows.filter(pl.col("train") == down, pl.col("event") == "departs")["above_low_kwh"]
        has_kwh = float(left[1])  # from the portal, then from Hoshakuji
        took = [(place, kwh * (1.0 + lost_share(unit))) for place, kwh in by_hand((unit, down, up))]
        homes[unit] = has_kwh - took[-1][1]
        called = dead.tables.stops.filter(pl.col("train") == up, pl.col("arrival_s").is_not_null())["station"]
        ways = [place for place, kwh in took[8:] if kwh <= has_kwh]
        # With an empty battery it may still roll on, on what its brakes give back, as far as the next stop.
        assert len(ways) <= len(called) <= len(ways) + 1
        if called[-1] == "HSK":
            came = rows.filter(pl.col("train") == up, pl.col("station") == "HSK")["above_low_kwh"][0]
            assert came == pytest.approx(homes[unit], abs=2.0)
    assert homes["V1"] < 0.0 < homes["V4"]
    stood = {w.stock_id: w for w in dead.result.waiting}
    assert stood["V1"].number == "338M" and stood["V1"].waits_for == "power: its battery is empty"
    assert stood["V4"].number == "340M" and "V1" in stood["V4"].waits_for
    empty = dead.tables.battery.filter(pl.col("unit") == "V1", pl.col("above_low_kwh") < 0.01)
    assert 17.5 * 3600 < empty["t_s"][0] < 17.75 * 3600, clock(round(empty["t_s"][0]))
