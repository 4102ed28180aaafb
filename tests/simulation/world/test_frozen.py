"""A frozen party does nothing, and finds later what has come to it meanwhile, in its order; one that dies, nothing."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from host.devices import CODEC, DeviceSaid
from host.party import Advance
from network.model import Line, Position
from onboard.duty.records import DrivingCommand, Looked, WheelsTurning
from onboard.unit import UnitAnswer
from simulation.agenda import Agenda
from simulation.cabs import Cabs
from simulation.clock import Clock
from simulation.journal import Journal
from simulation.people import People
from simulation.setup import Setup
from simulation.world.cable import Cable
from simulation.world.points import WaysideWorld
from wayside.said import PointsDetected

TERMINAL = "B-W"


class Parties:
    """Devices that write down what they are given."""

    def __init__(self) -> None:
        self.given: list[tuple[tuple[bytes, ...], int]] = []
        self.shown_s: list[float] = []
        self.wakes_s: float | None = None

    def advance(self, _party: str, now_s: float, telegrams: list[bytes], told: bytes) -> Advance:
        self.given.append((tuple(telegrams), len(CODEC.decode_told(told).inputs)))
        self.shown_s.append(now_s)
        return Advance((), CODEC.encode(DeviceSaid()), self.wakes_s)

    def kill(self, _party: str) -> None: ...

    def restart(self, _party: str) -> None: ...


@pytest.fixture
def agenda() -> Agenda:
    return Agenda()


@pytest.fixture
def wayside(rtri_setup: Setup, agenda: Agenda) -> tuple[WaysideWorld, Parties]:
    line: Line = rtri_setup.line
    parties = Parties()
    cable = Cable(line, rtri_setup.operation)
    radio: Any = SimpleNamespace()
    return WaysideWorld(
        line, cast("Any", parties), radio, agenda, Journal(), cable, lambda _unit: 0.0
    ), parties


def go_on(world: WaysideWorld, agenda: Agenda, step: int) -> None:
    """As the loop does it: what is due for the device is put to it."""
    while (item := agenda.pop_due(step)) is not None:
        world.advance(step, item.subject, [] if item.data is None else [item.data])


def test_a_frozen_device_keeps_what_piled_up(wayside: tuple[WaysideWorld, Parties], agenda: Agenda) -> None:
    world, parties = wayside
    world.freeze(1, TERMINAL, frozen=True)
    for step, data in ((2, b"one"), (3, b"two")):
        world.advance(step, TERMINAL, [data])
    world.input(4, TERMINAL, PointsDetected("P7", Position.NORMAL, True))
    world.advance(4, TERMINAL, [])
    assert parties.given == []
    world.freeze(5, TERMINAL, frozen=False)
    go_on(world, agenda, 5)
    assert sum((telegrams for telegrams, _ in parties.given), ()) == (b"one", b"two")
    assert sum(inputs for _, inputs in parties.given) == 1
    world.advance(6, TERMINAL, [b"three"])
    assert parties.given[-1] == ((b"three",), 0)


def test_without_power_what_piled_up_is_lost(wayside: tuple[WaysideWorld, Parties], agenda: Agenda) -> None:
    world, parties = wayside
    world.freeze(1, TERMINAL, frozen=True)
    world.advance(2, TERMINAL, [b"one"])
    world.input(2, TERMINAL, PointsDetected("P7", None, False))
    world.power_off(3, TERMINAL)
    world.power_on(4, TERMINAL)
    world.freeze(5, TERMINAL, frozen=False)
    go_on(world, agenda, 5)
    assert all(telegrams == () for telegrams, _ in parties.given)
    assert sum(inputs for _, inputs in parties.given) == len(world.points_of[TERMINAL])  # as they lie now


def test_a_device_is_shown_its_own_clock_and_woken_by_it(
    wayside: tuple[WaysideWorld, Parties], agenda: Agenda
) -> None:
    world, parties = wayside
    parties.wakes_s = 100.0
    world.set_clock(1, TERMINAL, Clock(ahead_s=30.0))
    go_on(world, agenda, 1)
    assert agenda.next_step() == 700
    parties.wakes_s = None
    go_on(world, agenda, 700)
    assert parties.shown_s == pytest.approx([30.1, 100.0])


class Units:
    """Units that write down what they are told."""

    def __init__(self) -> None:
        self.unpowered: set[int] = set()
        self.told: list[tuple[Any, Any]] = []

    def tell(self, _slot: int, _now_s: float, happened: Any, telegrams: Any) -> tuple[UnitAnswer, tuple[()]]:  # noqa: ANN401
        self.told.append((happened, telegrams))
        return UnitAnswer((), DrivingCommand(), (), (), None), ()

    def power_off(self, slot: int) -> None:
        self.unpowered.add(slot)


@pytest.fixture
def cabs(monkeypatch: pytest.MonkeyPatch) -> tuple[Cabs, Units]:
    units = Units()
    truth = SimpleNamespace(sight_m=0.0)
    at_once = SimpleNamespace(people=People(times=0.0), seed=1, today=(), line=SimpleNamespace(crossings={}))
    trains = SimpleNamespace(stock_ids=("K1",), truths=(truth,))
    world: Any = SimpleNamespace(
        setup=at_once,
        trains=trains,
        on_board=units,
        wayside=SimpleNamespace(machines={}, crossings=SimpleNamespace(guarded=frozenset[str]())),
        books=SimpleNamespace(),
        agenda=Agenda(),
        journal=Journal(),
        charging=None,
        signs=SimpleNamespace(),
    )
    monkeypatch.setattr(Cabs, "_look", lambda *_: None)
    return Cabs(world), units


def test_a_frozen_unit_keeps_what_piled_up(cabs: tuple[Cabs, Units]) -> None:
    cab, units = cabs
    cab.freeze(0, 1, frozen=True)
    cab.tell(0, 2, (WheelsTurning(),))
    cab.tell(0, 3, (), (b"one",))
    cab.tell(0, 4, (Looked(),), (b"two",))
    assert units.told == []
    cab.freeze(0, 5, frozen=False)
    assert units.told == [((WheelsTurning(),), ()), ((), (b"one",)), ((Looked(),), (b"two",))]
    cab.tell(0, 6, (Looked(),))
    assert units.told[-1] == ((Looked(),), ())


def test_a_unit_that_dies_frozen_forgets_what_piled_up(cabs: tuple[Cabs, Units]) -> None:
    cab, units = cabs
    cab.freeze(0, 1, frozen=True)
    cab.tell(0, 2, (WheelsTurning(),), (b"one",))
    cab.power_off(0, 3)
    units.unpowered.clear()
    cab.freeze(0, 5, frozen=False)
    assert units.told == []
