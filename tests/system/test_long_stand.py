"""A set that stands for hours on a cold day: without a charger what it keeps, and who helps it; at one, how it waits.

66 kW would take 130 kWh in two hours; V4 comes to Ogane with less than 45.
"""

from pathlib import Path

import pytest

from network.errors import InputError
from onboard.notes import AbleToLeave, UnableToLeave
from simulation.events import Acted, BatteryAt, BatteryLevel
from simulation.result import Ending
from study.runner.run import FinishedRun
from tests.plain import run_on_plain
from tests.scenario.own import own_scenario

HOLD = '[[act]]\nkind = "hold_train"\nperson = "controller"\ntarget = "V4"\nstart = "train 333M arrives {}"\n'


def stood(folder: Path, hold_s: float, *, at: str = "OGN", react: bool = False) -> FinishedRun:
    """The day on which V4 is held at a station for a time: at Ogane, where there is no charger."""
    text = (
        "[battery]\nheating_kw = 36.0\n[dispatch]\ncertificate = true\n[limits]\nstall_limit_s = 20000.0\n"
        f"time_limit_s = 14400.0\n[people]\nreact = {str(react).lower()}\n{HOLD.format(at)}hold_s = {hold_s}\n"
    )
    return run_on_plain(own_scenario(folder, text, "karasuyama_battery"))


def levels(run: FinishedRun) -> list[BatteryLevel]:
    events = (e.event for e in run.result.journal.entries)
    return [event.level for event in events if isinstance(event, BatteryAt) and event.unit_id == "V4"]


@pytest.mark.nightly
def test_after_two_hours_it_goes_on_by_itself(tmp_path: Path) -> None:
    run = stood(tmp_path, 7200.0)
    assert run.result.ended_because is Ending.FINISHED and not run.broken
    assert levels(run)[:2] == [BatteryLevel.LOW, BatteryLevel.ENOUGH]
    assert unable(run, "OGN") == []


def unable(run: FinishedRun, station: str) -> list[float]:
    """When V4 said at a station that it is unable to leave, s."""
    entries = [(e.t_s, e.event) for e in run.result.journal.entries if e.who == "V4"]
    return [t_s for t_s, e in entries if isinstance(e, UnableToLeave) and e.station == station]


@pytest.mark.nightly
def test_at_a_charger_it_charges_until_its_way_is_free(tmp_path: Path) -> None:
    """Held for two hours it is unable when its time comes and as its pantograph comes down, and not all the while."""
    run = stood(tmp_path, 7200.0, at="KRS")
    assert run.result.ended_because is Ending.FINISHED and not run.broken
    arrives_s = run.tables.stops.filter(train="333M", station="KRS")["arrival_s"][0]
    assert arrives_s is not None
    assert 1 <= len([t_s for t_s in unable(run, "KRS") if t_s < arrives_s + 7200.0 + 900.0]) <= 2


@pytest.mark.nightly
def test_after_four_hours_staff_bring_it_power(tmp_path: Path) -> None:
    run = stood(tmp_path, 14000.0, react=True)
    told = [e for e in run.result.journal.entries if e.who == "V4" or isinstance(e.event, Acted)]
    (unable, able) = [e.t_s for e in told if isinstance(e.event, UnableToLeave | AbleToLeave)][:2]
    brought = [e.t_s for e in told if isinstance(e.event, Acted) and e.event.act == "bring_power"]
    assert unable < brought[0] < able
    left = run.tables.stops.filter(train="333M", station="OGN")["departure_s"][0]
    assert left is not None and left > able
    charge = run.tables.charges.filter(unit="V4", station="OGN")
    assert charge["from_s"][0] == pytest.approx(brought[0], abs=10.0)
    assert charge["to_s"][0] == pytest.approx(able, abs=10.0)


def test_power_is_brought_to_sets_on_batteries_alone(tmp_path: Path) -> None:
    act = '[[act]]\nkind = "bring_power"\nperson = "staff"\ntarget = "V4"\nstart = "09:00:00"\n'
    with pytest.raises(InputError, match=r"without \[battery\]"):
        own_scenario(tmp_path, act, "karasuyama_weekday")
