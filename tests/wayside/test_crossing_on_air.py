"""A unit, the device of a level crossing and its equipment, over a bad air and with power cuts: no
front comes onto a road that is not closed, or has not been for its least time, whatever happens.

The train is a point that runs at what speed the case says, never over 20 m/s, and stops at the road unless its unit may
pass; all that the unit is told of it is true, but that it may come sooner than it meant.
"""

import math
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import CrossingClass, CrossingControl, LevelCrossing
from onboard.crossings import machine, talk
from onboard.crossings.machine import CrossingPlace
from onboard.crossings.talk import CrossingTalk
from onboard.duty.records import DutyPhase, DutyState, StopLimit
from radio.envelope import Received
from radio.messages import AnyMessage, CrossingOver, CrossingRequest, Restarted
from simulation.events import BarrierState
from simulation.world import crossing_equipment
from wayside import level_crossing
from wayside.actions import Action, Drive, Send
from wayside.config import CrossingConfig
from wayside.crossing_said import CloseCrossing
from wayside.level_crossing import ClosureAsked, CrossingLeft, CrossingMemory, CrossingTimeDue

CROSSING = LevelCrossing(
    "C", "C", CrossingClass.BARRIERS, CrossingControl.RADIO, "6", 600.0, 6.0, 8.0, 15.0, 20.0
)
CONFIG = CrossingConfig("line", "C", barriers=True, closing_s=15.0, closed_s=20.0)
ROAD_M, LENGTH_M, FASTEST_MPS = 600.0, 40.0, 20.0
LEAST_S = 15.0
RUNS = DutyState(phase=DutyPhase.RUNNING, limit=StopLimit(1, None, "end of the path"))


@dataclass
class Ride:
    """One train over one crossing, in steps of a second."""

    now_s: float = 0.0
    front_m: float = 0.0
    speed_mps: float = 20.0
    talk: CrossingTalk = field(default_factory=lambda: CrossingTalk(forgot=False))
    memory: CrossingMemory = field(default_factory=CrossingMemory)
    powered: bool = True
    boots: int = 1
    known_boots: int = 1  # of the device, to the unit
    on_air: list[tuple[float, int, str, int, AnyMessage]] = field(default_factory=list)
    sent: int = 0
    heard: dict[str, int] = field(default_factory=dict[str, int])
    lowered_s: float = math.inf
    came: bool = False
    passed: bool = False

    def __post_init__(self) -> None:
        self.device = level_crossing.start(CONFIG, self.memory)
        self.equipment = crossing_equipment.equipment_of(CROSSING)
        self._device(crossing_equipment.detection(self.equipment))

    # the device and its equipment ---------------------------------------------------------------------------------

    def _device(self, event: level_crossing.CrossingEvent) -> None:
        if not self.powered:
            return
        self.device, actions = level_crossing.step(self.device, event, self.now_s)
        self.memory = self.device.memory  # kept before anything leaves it
        for action in actions:
            self._does(action)

    def _does(self, action: Action) -> None:
        match action:
            case Drive(output):
                assert not isinstance(output, level_crossing.OpenCrossing) or not self.on_road, (
                    "opens under the train"
                )
                self._equipment(output)
            case Send(_, message, correlation):
                self.say("C", correlation, message)
            case _:
                pass

    def _equipment(self, event: object) -> None:
        before = self.equipment
        self.equipment = crossing_equipment.step(before, event, self.now_s)  # type: ignore[arg-type]
        if self.equipment.barriers is not before.barriers:
            lowered = self.equipment.barriers is BarrierState.LOWERED
            self.lowered_s = self.now_s if lowered else math.inf
        if crossing_equipment.detection(self.equipment) != crossing_equipment.detection(before):
            self._device(crossing_equipment.detection(self.equipment))

    def cut_power(self) -> None:
        if self.powered:
            self.powered = False
            self._equipment(CloseCrossing("C"))

    def give_power(self) -> None:
        if not self.powered:
            self.powered, self.boots = True, self.boots + 1
            self.device = level_crossing.start(CONFIG, self.memory)
            self._device(crossing_equipment.detection(self.equipment))

    # the air --------------------------------------------------------------------------------------------------------

    def say(
        self, source: str, correlation: int, message: AnyMessage, delays_s: tuple[float, ...] = ()
    ) -> None:
        self.sent += 1
        for delay_s in delays_s or self.delays_s:
            self.on_air.append((self.now_s + delay_s, self.sent, source, correlation, message))

    delays_s: tuple[float, ...] = (0.0,)

    def deliver(self) -> None:
        due = sorted(item for item in self.on_air if item[0] <= self.now_s)
        self.on_air = [item for item in self.on_air if item[0] > self.now_s]
        for _, number, source, correlation, message in due:
            if number <= self.heard.get(source, 0):
                continue  # doubled, or overtaken: the envelope drops it
            self.heard[source] = number
            if source == "C":
                self.talk.hear(
                    Received("C", 1, number, True, correlation, self.now_s, None, 0, message), self.now_s
                )
            elif self.powered and self.known_boots != self.boots:
                self.known_boots = self.boots
                self.say("C", 0, Restarted())
            elif isinstance(message, CrossingRequest):
                self._device(ClosureAsked("U", correlation, message))
            elif isinstance(message, CrossingOver):
                self._device(CrossingLeft("U", correlation, message))

    # the train ------------------------------------------------------------------------------------------------------

    @property
    def on_road(self) -> bool:
        """Whether any part of the train is on the road."""
        return self.front_m >= ROAD_M and self.front_m - LENGTH_M < ROAD_M + CROSSING.width_m

    @property
    def place(self) -> CrossingPlace:
        """How the train is to the road; it means to run as fast as it runs now, or 10 m/s."""
        way_m = ROAD_M - self.front_m
        meant_mps = max(self.speed_mps, 10.0)
        on = way_m <= 0.0
        return CrossingPlace(
            "C", 0, 0, 35.0, 15.0, LEAST_S,
            0.0 if on else way_m / meant_mps,
            0.0 if on else way_m / FASTEST_MPS,
            0.0 if on else way_m / meant_mps - 12.0,
            entered=on, under=on, beyond=way_m <= -6.0, clear=way_m < -46.0, stands=self.speed_mps == 0.0,
        )  # fmt: skip

    def look(self) -> None:
        self.talk.look((self.place,), RUNS, math.inf, self.now_s)
        for letter in self.talk.letters:
            self.say("U", letter.correlation, letter.message)
        self.talk.letters.clear()

    def second(self, wanted_mps: float, delays_s: tuple[float, ...]) -> None:
        self.delays_s = delays_s
        self.now_s += 1.0
        self._equipment(crossing_equipment.BarrierTimeOver())
        self.deliver()
        self._device(CrossingTimeDue())
        self.look()
        self.deliver()
        may_pass = not self.talk.held_before(self.now_s)
        after_m = self.front_m + wanted_mps
        if self.front_m < ROAD_M <= after_m and not may_pass:
            after_m = ROAD_M - 1.0
        self.speed_mps = after_m - self.front_m
        if self.front_m < ROAD_M <= after_m:
            self.came = True
            shut_s = self.now_s - self.lowered_s
            assert self.equipment.barriers is BarrierState.LOWERED, "the road is open"
            assert shut_s >= LEAST_S - 1.0, f"closed for {shut_s} s"
        self.front_m = after_m
        self.passed = self.place.clear


SECONDS = st.tuples(
    st.sampled_from([0.0, 2.0, 7.0, 13.0, 20.0]),
    st.sampled_from([(), (0.0,), (0.0,), (0.0,), (1.0,), (4.0,), (0.0, 3.0)]),
    st.sampled_from([""] * 20 + ["cut", "power", "power"]),
)


def rides(seconds: list[tuple[float, tuple[float, ...], str]]) -> Ride:
    """A ride through these seconds, then twelve minutes in which nothing fails."""
    ride = Ride()
    for wanted_mps, delays_s, happens in seconds:
        if happens == "cut":
            ride.cut_power()
        elif happens == "power":
            ride.give_power()
        ride.second(wanted_mps, delays_s or (math.inf,))
    ride.give_power()
    for _ in range(200):
        ride.second(20.0, (0.0,))
    return ride


@given(st.lists(SECONDS, max_size=120))
def test_no_train_comes_onto_an_open_road_and_every_train_comes_over_it(
    seconds: list[tuple[float, tuple[float, ...], str]],
) -> None:
    ride = rides(seconds)
    assert ride.came
    assert ride.passed
    assert ride.device.state is level_crossing.CrossingState.OPEN
    assert ride.memory == CrossingMemory()


def test_the_road_warns_for_as_long_whatever_the_speed() -> None:
    """At 20 and at 10 m/s: 35 s before the front, to a step of a second and one of the air."""
    for speed_mps in (20.0, 10.0):
        ride = Ride(front_m=-600.0, speed_mps=speed_mps)
        while not ride.came:
            ride.second(speed_mps, (0.0,))
        assert ride.now_s - ride.lowered_s == pytest.approx(20.0, abs=2.0)


def test_without_the_least_time_a_fast_train_comes_too_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """It means to run at 10 m/s until the road is closed, and then runs at 20."""

    def run() -> None:
        ride = Ride(speed_mps=10.0)
        while not ride.came:
            ride.second(20.0 if ride.lowered_s < math.inf else 10.0, (0.0,))

    run()
    monkeypatch.setattr(machine, "KEEPS_LEAST_TIME", False)
    with pytest.raises(AssertionError, match="closed for"):
        run()


def test_a_unit_that_needs_no_proof_comes_onto_an_open_road(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(talk, "may_pass", lambda *_: True)
    with pytest.raises(AssertionError, match="open"):
        rides([(20.0, (), "")] * 40)
