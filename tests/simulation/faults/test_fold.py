"""Faults that overlap: at any time a quantity is what those in force make of its base, and nothing else."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import Position
from radio.air import Delivery
from simulation.agenda import Agenda
from simulation.clock import Clock
from simulation.faults.clocks import WrongClock
from simulation.faults.devices import Frozen, PowerCut
from simulation.faults.fault import Fault, InForce, folded_value
from simulation.faults.lidar import LidarFog
from simulation.faults.links import Cut, Delay, FaultyLink, disturbed
from simulation.faults.points import NoDetection, Slow, Stuck
from simulation.faults.rail import Slippery
from simulation.faults.script import Script, ScriptedFault, Trigger
from simulation.faults.speech import FalseClaims
from simulation.faults.tachometer import NoOutput, Scale, StuckOutput
from simulation.faults.tag_reader import Miss, WrongId
from simulation.faults.vehicle import Brake, Doors, Motors
from simulation.injector import Injector
from simulation.journal import Journal
from simulation.people import People
from simulation.world.point_machine import Forced, PointMachine, Repaired, step
from simulation.world.premises import FalsePositions

WHEEL_MPS: Final = 10.0
THROW_S: Final = 5.0
WHERE: Final = FaultyLink("K1", "B-W", both_ways=True)


@dataclass
class World:
    """A train K1, a terminal B-W and points P7, and the value of every quantity that faults change."""

    failures: tuple[ScriptedFault, ...]
    weather: float = 0.5
    power: dict[str, bool] = field(default_factory=lambda: {"K1": True, "B-W": True})
    frozen: dict[str, bool] = field(default_factory=lambda: {"K1": False, "B-W": False})
    vehicle: dict[str, float] = field(default_factory=lambda: {"doors_closed": True, "brake_good": True})
    claims: dict[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    clocks: dict[str, Clock] = field(default_factory=lambda: {"K1": Clock(), "B-W": Clock()})

    def __post_init__(self) -> None:
        self.tachometer = SimpleNamespace(gain=1.0, frozen_mps=-1.0, wheel_factor=1.0)
        self.plant = SimpleNamespace(wheel_speed_mps=WHEEL_MPS)
        self.unit = SimpleNamespace(odometer_scale=1.0, bound_growth=0.02, position_known=1)
        self.rail_share = 1.0
        self.brake_reserve = 1.0
        self.cut_out = 0
        self.trains: Any = SimpleNamespace(
            slot_of={"K1": 0},
            setup=SimpleNamespace(people=People(times=0.0), seed=1, today=()),
            tachometers=[self.tachometer],
            plants=[self.plant],
            premises=FalsePositions([self.tachometer], [self.unit]),  # type: ignore[list-item]
            tag_faults={},
            set_rail=lambda _slot, share: setattr(self, "rail_share", share),
            set_brake=lambda _slot, reserve: setattr(self, "brake_reserve", reserve),
            set_motors=self.set_motors,
        )
        machines = {"P7": PointMachine("P7", THROW_S, Position.NORMAL)}
        self.wayside: Any = SimpleNamespace(
            section_ids=(),
            points_of={},
            machines=machines,
            set_machine=lambda _step, machine: machines.update({machine.points_id: machine}),
            power_on=lambda _step, device: self.power.update({device: True}),
            power_off=lambda _step, device: self.power.update({device: False}),
            freeze=lambda _step, device, *, frozen: self.frozen.update({device: frozen}),
            set_clock=lambda _step, device, clock: self.clocks.update({device: clock}),
        )
        self.agenda, self.in_force = Agenda(), InForce()
        world: Any = SimpleNamespace(
            setup=self.trains.setup,
            journal=Journal(),
            agenda=self.agenda,
            in_force=self.in_force,
            trains=self.trains,
            wayside=self.wayside,
            on_board=SimpleNamespace(),
            charging=None,
            road=None,
        )
        shown = self.vehicle
        cabs: Any = SimpleNamespace(
            power_off=lambda _slot, _step: self.power.update({"K1": False}),
            freeze=lambda _slot, _step, *, frozen: self.frozen.update({"K1": frozen}),
            set_clock=lambda _slot, _step, clock: self.clocks.update({"K1": clock}),
            vehicle_shows=lambda _slot, _step, part, value: shown.update({part: value}),
            claim_besides=lambda _slot, _step, sections: self.claims.update({"K1": sections}),
        )
        duties: Any = SimpleNamespace(power_on=lambda _slot, _step: self.power.update({"K1": True}))
        platforms: Any = SimpleNamespace(
            fault=lambda _slot, _step, *, closed: shown.update({"doors_closed": closed})
        )
        self.injector = Injector(Script(self.failures), world, cabs, duties, platforms)
        self.injector.start(0)

    def set_motors(self, _slot: int, cut_out: int) -> float:
        """Of four motors."""
        self.cut_out = cut_out
        return 1.0 - cut_out / 4

    def run_to(self, step_now: int) -> None:
        while (item := self.agenda.pop_due(step_now)) is not None:
            self.injector.due(item.step, item.subject)

    def seen(self, seconds: Sequence[int], look: Callable[[int], object]) -> list[object]:
        """What is to be seen after each of these."""
        found: list[object] = []
        for second in seconds:
            self.run_to(second * 10)
            found.append(look(second))
        return found

    def arrives(self) -> list[int]:
        """Steps at which a telegram of step 100 arrives."""
        return [d.step for d in disturbed(self.in_force, "K1", "B-W", (Delivery(100, b"x"),))]


def failure(fault: Fault[Any], at_s: float, duration_s: float | None = None) -> ScriptedFault:
    return ScriptedFault(fault, Trigger(at_s=at_s), duration_s)


def test_a_short_fault_inside_a_long_one_takes_only_itself_away() -> None:
    world = World(
        (failure(Scale(target="K1", factor=0.8), 2.0, 60.0), failure(NoOutput(target="K1"), 8.0, 6.0))
    )
    seen = world.seen((1, 5, 10, 20, 70), lambda _: world.tachometer.gain)
    assert seen == [1.0, 0.8, 0.0, 0.8, 1.0]


def test_a_unit_claims_what_every_fault_in_force_has_it_claim() -> None:
    claims = (FalseClaims(target="K1", section="7"), FalseClaims(target="K1", section="9"))
    world = World((failure(claims[0], 2.0, 60.0), failure(claims[1], 8.0, 6.0)))
    seen = world.seen((5, 10, 20, 70), lambda _: world.claims["K1"])
    assert seen == [("7",), ("7", "9"), ("7",), ()]


def test_bounds_are_not_judged_until_the_last_of_a_tachometers_faults_is_over() -> None:
    world = World(
        (failure(Scale(target="K1", factor=0.8), 2.0, 60.0), failure(NoOutput(target="K1"), 8.0, 6.0))
    )
    rests = []
    for second in (1, 5, 20, 70):
        world.run_to(second * 10)
        world.trains.premises.note_fix(0, holds=True)
        rests.append(world.trains.premises.is_false(0))
    assert rests == [False, True, True, False]
    world.unit.bound_growth, world.tachometer.wheel_factor = 0.0, 1.1
    assert not world.trains.premises.is_false(0)  # wheels that no fault makes wrong are the unit's own affair


def test_power_comes_back_with_the_last_of_its_cuts() -> None:
    world = World((failure(PowerCut(target="B-W"), 5.0, 50.0), failure(PowerCut(target="B-W"), 10.0, 5.0)))
    for second, on in ((4, True), (7, False), (12, False), (20, False), (60, True)):
        world.run_to(second * 10)
        assert world.power["B-W"] is on


@pytest.mark.parametrize("party", ["K1", "B-W"])
def test_a_clock_drifts_from_when_it_begins_to_and_is_right_again_afterwards(party: str) -> None:
    world = World(
        (
            failure(WrongClock(target=party, offset_s=30.0), 100.0, 300.0),
            failure(WrongClock(target=party, drift_ppm=10_000.0), 200.0, 100.0),
        )
    )
    seen = world.seen(
        (50, 150, 250, 350, 450), lambda second: round(world.clocks[party].shows(second) - second, 6)
    )
    assert seen == [0.0, 30.0, 30.5, 30.0, 0.0]


def test_a_brake_is_in_order_again_with_the_last_of_its_faults() -> None:
    world = World(
        (
            failure(Brake(target="K1", reserve=0.5), 1.0, 20.0),
            failure(Brake(target="K1", reserve=0.4), 5.0, 5.0),
        )
    )
    seen = world.seen((0, 2, 6, 12, 30), lambda _: (world.vehicle["brake_good"], world.brake_reserve))
    assert seen == [(True, 1.0), (False, 0.5), (False, 0.2), (False, 0.5), (True, 1.0)]


def test_motors_cut_out_one_after_the_other_add_up() -> None:
    world = World(
        (
            failure(Motors(target="K1", cut_out=2), 1.0, 20.0),
            failure(Motors(target="K1", cut_out=1), 5.0, 5.0),
        )
    )
    seen = world.seen((0, 2, 6, 12, 30), lambda _: (world.cut_out, world.vehicle.get("motors_share", 1.0)))
    assert seen == [(0, 1.0), (2, 0.5), (3, 0.25), (2, 0.5), (0, 1.0)]


def test_doors_and_brake_are_two_things() -> None:
    world = World((failure(Doors(target="K1"), 1.0, 5.0), failure(Brake(target="K1"), 2.0, 20.0)))
    world.run_to(30)
    assert world.vehicle == {"doors_closed": False, "brake_good": False}
    world.run_to(100)
    assert world.vehicle == {"doors_closed": True, "brake_good": False}


def test_what_is_stuck_shows_what_it_showed_whatever_the_factor() -> None:
    scale = failure(Scale(target="K1", factor=0.5), 1.0)
    world = World(
        (scale, failure(StuckOutput(target="K1"), 2.0, 10.0), failure(NoOutput(target="K1"), 4.0, 2.0))
    )
    world.run_to(25)
    world.plant.wheel_speed_mps = 20.0
    assert world.tachometer.frozen_mps == 5.0
    world.run_to(50)
    assert (world.tachometer.gain, world.tachometer.frozen_mps) == (0.0, -1.0)
    world.run_to(70)
    assert world.tachometer.frozen_mps == 5.0
    world.run_to(130)
    assert (world.tachometer.gain, world.tachometer.frozen_mps) == (0.5, -1.0)


def test_what_is_stuck_at_a_stand_is_so_for_a_second_fault_too() -> None:
    world = World((failure(StuckOutput(target="K1"), 1.0), failure(StuckOutput(target="K1"), 2.0)))
    world.plant.wheel_speed_mps = 0.0
    world.run_to(15)
    world.plant.wheel_speed_mps = 20.0
    world.run_to(30)
    assert world.tachometer.frozen_mps == 0.0


def test_of_two_fogs_the_thicker_counts() -> None:
    fogs = (LidarFog(target="K1", visibility_m=20.0), LidarFog(target="K1", visibility_m=50.0))
    assert folded_value(100.0, fogs) == folded_value(100.0, fogs[::-1]) == 20.0


def test_a_tag_that_is_not_read_reads_as_no_other_either() -> None:
    world = World((failure(Miss(target="602"), 1.0, 10.0), failure(WrongId(target="602", id=601), 2.0, 20.0)))
    for second, read in ((3, {602: None}), (15, {602: 601}), (30, {})):
        world.run_to(second * 10)
        assert world.trains.tag_faults == read


def test_points_that_a_train_ran_through_are_not_mended_by_the_end_of_a_fault() -> None:
    world = World((failure(Stuck(target="P7"), 1.0, 10.0),))
    world.run_to(20)
    world.wayside.machines["P7"] = step(world.wayside.machines["P7"], Forced(), 2.0)
    world.run_to(200)
    machine = world.wayside.machines["P7"]
    assert (machine.stuck, machine.forced) == (False, True)
    assert not step(machine, Repaired(Position.NORMAL), 30.0).forced


FAMILIES: Final[dict[str, tuple[Fault[Any], ...]]] = {
    "tachometer": (Scale(target="K1", factor=0.9), Scale(target="K1", factor=1.5), NoOutput(target="K1")),
    "rail": (Slippery(target="K1", factor=0.5), Slippery(target="K1", factor=0.25)),
    "tag": (Miss(target="602"), WrongId(target="602", id=601), WrongId(target="602", id=603)),
    "points": (Stuck(target="P7"), NoDetection(target="P7"), Slow(target="P7", factor=2.0)),
    "power of a unit": (PowerCut(target="K1"),),
    "power of a device": (PowerCut(target="B-W"),),
    "frozen unit": (Frozen(target="K1"),),
    "frozen device": (Frozen(target="B-W"),),
    "link": (Delay(target=WHERE, seconds=1.0), Delay(target=WHERE, seconds=2.0), Cut(target=WHERE)),
}


def _product(values: list[float]) -> float:
    total = 1.0
    for value in values:
        total *= value
    return total


def expected(family: str, faults: list[Fault[Any]]) -> object:
    """What the faults in force come to, said without folding anything."""
    match family:
        case "tachometer":
            silent = any(isinstance(f, NoOutput) for f in faults)
            return 0.0 if silent else _product([f.factor for f in faults if isinstance(f, Scale)])
        case "rail":
            return _product([f.factor for f in faults if isinstance(f, Slippery)])
        case "tag":
            wrong = [f.id for f in faults if isinstance(f, WrongId)]
            missed = any(isinstance(f, Miss) for f in faults)
            return {602: None} if missed else {602: wrong[-1]} if wrong else {}
        case "points":
            kinds = [type(f) for f in faults]
            return Stuck in kinds, NoDetection in kinds, 2.0 ** kinds.count(Slow)
        case "link":
            later = sum(round(f.seconds * 10) for f in faults if isinstance(f, Delay))
            return [] if any(isinstance(f, Cut) for f in faults) else [100 + later]
        case "power of a unit" | "power of a device":
            return not faults
        case _:
            return bool(faults)


def found(family: str, world: World) -> object:
    machine = world.wayside.machines["P7"]
    return {
        "tachometer": world.tachometer.gain,
        "rail": world.rail_share,
        "tag": world.trains.tag_faults,
        "points": (machine.stuck, machine.detection_fault, machine.throw_factor),
        "power of a unit": world.power["K1"],
        "power of a device": world.power["B-W"],
        "frozen unit": world.frozen["K1"],
        "frozen device": world.frozen["B-W"],
        "link": world.arrives(),
    }[family]


@pytest.mark.parametrize("family", FAMILIES)
@given(data=st.data())
def test_at_every_time_a_quantity_is_what_those_in_force_make_of_it(family: str, data: st.DataObject) -> None:
    faults = FAMILIES[family]
    drawn = st.tuples(st.integers(0, len(faults) - 1), st.integers(0, 30), st.integers(1, 30) | st.none())
    intervals = data.draw(st.lists(drawn, max_size=6))
    world = World(
        tuple(
            failure(faults[i], begin / 10, None if length is None else length / 10)
            for i, begin, length in intervals
        )
    )
    for now in range(62):
        world.run_to(now)
        in_force = [
            (begin, order, faults[i])
            for order, (i, begin, length) in enumerate(intervals)
            if begin <= now and (length is None or now < begin + length)
        ]
        in_force.sort(key=lambda item: item[:2])
        want = expected(family, [fault for _, _, fault in in_force])
        assert found(family, world) == (pytest.approx(want) if isinstance(want, float) else want)
