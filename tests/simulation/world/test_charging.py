"""The batteries of a run as the world keeps them: clocks, chargers that fail, pantographs, and what is off the line."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from onboard.charge import ChargeWatch
from scenario.scenario import load_scenario
from simulation.battery_settings import Beyond
from simulation.carriers.plain_track import PlainTrack
from simulation.clock import Clock
from simulation.events import Danger
from simulation.loop import Simulation
from simulation.result import BatteryEvent
from simulation.setup import STEP_S, STEPS_PER_S, Setup
from simulation.world.books import Books
from simulation.world.charge_control import DOWN, FALLING, MOVED, TOLD, UP
from simulation.world.charging import Charging
from simulation.world.on_board import OnBoard
from simulation.world.roster import drawn_up
from simulation.world.trains import Trains
from simulation.world.ways import ways_of
from vehicle.battery import available_j

KWH = 3.6e6


def battery_setup(beyond: Beyond | None = None) -> Setup:
    setup = load_scenario("karasuyama_battery").setup
    assert setup.battery is not None
    if beyond is None:
        return setup
    return replace(setup, battery=setup.battery.model_copy(update={"beyond": beyond}))


class World:
    """All sets before their day begins; `V4` has its first train."""

    def __init__(self, setup: Setup) -> None:
        assert setup.battery is not None
        lengths_m = {p.id: round(p.length_m, 6) for p in setup.line.pieces.values()}
        self.trains = Trains(setup, PlainTrack(lengths_m, STEP_S))
        duties = drawn_up(setup, setup.believed_line)
        self.charging = Charging(setup, setup.battery, self.trains, Books(self.trains), duties)
        self.slot = self.trains.slot_of["V4"]
        self.trains.place(self.slot, duties["V4"][0])
        self.control = self.trains.stock["charging"][self.slot]

    @property
    def available_kwh(self) -> float:
        return float(available_j(self.trains.stock["battery"][self.slot])) / KWH


def test_a_charger_that_fails_is_not_looked_for_by_sets_that_move() -> None:
    world = World(battery_setup())
    world.trains.plants[world.slot].speed_mps = 10.0
    world.charging.charger_is("KRS", works=False, step=100)
    assert world.charging.records == []
    world.trains.plants[world.slot].speed_mps = 0.0
    world.charging.charger_is("KRS", works=True, step=100)
    assert [record.event for record in world.charging.records] == [BatteryEvent.STANDS]


@pytest.mark.parametrize("away_s", [0.0, 60.0, 7200.0])
def test_what_is_run_off_the_line_is_taken_whole_however_short_the_time(away_s: float) -> None:
    beyond = Beyond(distance_km=20.0, consumption_kwh_per_km=2.0, charge_min=0.0)
    world = World(battery_setup(beyond))
    before_kwh = world.available_kwh
    world.charging.leaves(world.slot, 1000)
    world.charging.enters(world.slot, 1000 + round(away_s * STEPS_PER_S))
    lost_kwh = float(world.trains.stock["battery"][world.slot]["flows"]["lost_j"]) / KWH
    assert before_kwh - world.available_kwh == pytest.approx(40.0 + lost_kwh, rel=1e-3)


def test_who_moves_with_its_pantograph_up_is_told_of_once() -> None:
    world = World(battery_setup())
    assert list(world.charging.moved_connected()) == []
    world.control["moved"] = MOVED
    assert list(world.charging.moved_connected()) == [world.slot]
    assert list(world.charging.moved_connected()) == [] and world.control["moved"] == TOLD


@pytest.mark.parametrize(("on_sight", "told"), [(True, 1), (False, 0)])
def test_who_moves_so_is_unsafe_and_who_is_held_on_sight_looks_again(on_sight: bool, told: int) -> None:
    world, happened, unsafe = World(battery_setup()), list[Any](), list[Danger]()
    loop: Any = SimpleNamespace(
        _step=0,
        _unsafe=lambda _slot, danger: unsafe.append(danger),
        _cabs=SimpleNamespace(tell=lambda slot, _step, what: happened.append((slot, what))),
        on_board=SimpleNamespace(shown_to_driver=lambda _slot: SimpleNamespace(on_sight=on_sight)),
    )
    world.control["moved"], world.control["pantograph"] = MOVED, FALLING
    Simulation._look_at_pantographs(loop, world.charging)
    assert unsafe == [Danger.PANTOGRAPH_UP] and not happened
    world.control["pantograph"] = DOWN
    Simulation._look_at_pantographs(loop, world.charging)
    assert len(unsafe) == 1 and len(happened) == told


def test_a_unit_looks_at_its_charge_by_its_own_clock() -> None:
    world, asked = World(battery_setup()), list[float]()
    watch = world.charging.watch_of(world.slot)
    assert isinstance(watch, ChargeWatch)

    def advance(_stock_id: str, now_s: float, _telegrams: object, _report: object) -> object:
        asked.append(now_s)
        raise StopIteration

    units: Any = SimpleNamespace(advance=advance)
    on_board = OnBoard(world.trains.setup, world.trains, units, world.charging)
    on_board.clocks[world.slot] = Clock(ahead_s=90.0)
    with pytest.raises(StopIteration):
        on_board.tell(world.slot, 1000.0)
    assert watch.now_s == asked[0] == 1090.0


def test_a_battery_charges_with_its_pantograph_up_alone() -> None:
    world = World(battery_setup())
    watch = world.charging.watch_of(world.slot)
    assert watch is not None
    gauge = watch._gauge
    for state in (DOWN, UP, FALLING):
        world.control["pantograph"] = state
        assert gauge.up is (state == UP) and gauge.connected is (state != DOWN)


def test_a_stand_without_a_charger_can_do_without_what_is_off_in_a_long_one() -> None:
    """336M stands at Ogane for 7 min by plan: 30 kW, of which 25 kW can be off once it has stood for a minute."""
    setup = battery_setup()
    hops = ways_of(setup, drawn_up(setup, setup.line))["V4"].ahead("336M", 0)
    stand = next(hop for hop in hops if hop.to_place == "OGN")
    assert stand.stand_j == pytest.approx(420.0 * 30e3)
    assert stand.saves_j == pytest.approx(360.0 * 25e3)
    assert next(hop for hop in hops if hop.to_place == "KNY").saves_j == 0.0


def test_a_generator_that_comes_and_goes_is_written_down() -> None:
    world = World(battery_setup())
    world.charging.look(0)
    for brought_w in (60e3, 60e3, 0.0):
        world.control["brought_w"] = brought_w
        world.charging.look(1)
    events = [record.event for record in world.charging.records if record.stock_id == "V4"]
    assert events[1:] == [BatteryEvent.BROUGHT, BatteryEvent.TAKEN_AWAY]
