"""`[battery]` of a scenario: who and what it names must be there; a cold day is more auxiliaries."""

from pathlib import Path

import pytest

from network.errors import InputError
from scenario.scenario import Scenario
from simulation.world.roster import drawn_up
from simulation.world.ways import ways_of
from tests.scenario.own import own_scenario

FAULT = '[[fault]]\nkind = "charger_dead"\ntarget = "{target}"\nstart = "14:00:00"\n'


def loaded(folder: Path, text: str, base: str = "karasuyama_battery") -> Scenario:
    return own_scenario(folder, text, base)


@pytest.mark.parametrize(
    ("text", "base", "key"),
    [
        ("[battery.start_of]\nV9 = 0.5\n", "karasuyama_battery", "battery.start_of.V9"),
        (
            "[battery.beyond_after.321M]\ncharge_min = 5.0\n",
            "karasuyama_battery",
            "battery.beyond_after.321M",
        ),
        ("[battery]\ndeparture = 'later'\n", "karasuyama_battery", "battery.departure"),
        ("[battery]\nreserve_share = 2.0\n", "karasuyama_battery", "battery.reserve_share"),
        ("[battery.beyond]\ncharge_min = -1.0\n", "karasuyama_battery", "battery.beyond.charge_min"),
        ('[trains]\ndefault = "br642"\n', "karasuyama_battery", "battery"),
        (FAULT.format(target="OGN"), "karasuyama_battery", "fault[0].target"),
        (FAULT.format(target="KRS"), "karasuyama_weekday", "fault[0].target"),
    ],
)
def test_nonsense_is_refused_with_its_key(tmp_path: Path, text: str, base: str, key: str) -> None:
    with pytest.raises(InputError) as error:
        loaded(tmp_path, text, base)
    assert error.value.key == key and "\n" not in str(error.value)


def test_a_cold_day_is_more_auxiliaries_for_train_and_unit(tmp_path: Path) -> None:
    mild = loaded(tmp_path, "").setup
    cold = loaded(tmp_path, "[battery]\nheating_kw = 15.0\n").setup
    for setup, power_w in ((mild, 30e3), (cold, 45e3)):
        assert setup.trains["V1"].row[0]["auxiliary_power_w"] == pytest.approx(power_w)
        assert setup.believed_train("V1").row[0]["auxiliary_power_w"] == pytest.approx(power_w)


def test_what_a_set_does_off_the_line_is_in_its_ways(tmp_path: Path) -> None:
    text = "[battery.beyond]\nconsumption_kwh_per_km = 2.0\n[battery.beyond_after.322M]\ncharge_min = 0.0\n"
    setup = loaded(tmp_path, text).setup
    hops = [hop for way in ways_of(setup, drawn_up(setup, setup.line)).values() for hop in way.hops]
    off = {hop.number: hop for hop in hops if hop.to_place == "HSK.MU"}
    uncharged = off.pop("322M")  # a table of its own, in which the wire feeds it
    assert not uncharged.wire and uncharged.beyond_j == 0.0
    assert all(hop.wire for hop in off.values())
    assert {hop.beyond_j for hop in off.values()} == {2.0 * 23.4 * 3.6e6}
    assert not any(hop.beyond_j for hop in hops if hop.to_place != "HSK.MU")


def test_what_a_set_does_off_the_line_may_be_said_by_train(tmp_path: Path) -> None:
    setup = loaded(tmp_path, "[battery.beyond_after.322M]\ncharge_min = 5.0\n").setup
    assert setup.battery is not None
    assert setup.battery.beyond_of("322M").charge_min == 5.0
    assert setup.battery.beyond_of("324M").charge_min == 20.0
