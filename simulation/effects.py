"""What faults make of the world: each value put to the device, the unit or the equipment whose it is.

What concerns trains and track alone is `simulation.world.disorder`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatchmethod
from typing import Any

from onboard.duty.records import Looked
from simulation.cabs import Cabs
from simulation.clock import Clock
from simulation.duties import Duties
from simulation.faults.cable import CableCut, CableFault
from simulation.faults.chargers import ChargerFault
from simulation.faults.clocks import ClockFault
from simulation.faults.crossing_road import CrossingRoadFault
from simulation.faults.crossings import CrossingCondition, CrossingFault
from simulation.faults.devices import Frozen, LostStore, PowerFault
from simulation.faults.fault import Fault
from simulation.faults.points import Condition, PointsFault
from simulation.faults.speech import SpeechFault
from simulation.faults.vehicle import BrakeFault, BrakeState, DoorsFault, MotorsFault
from simulation.platforms import Platforms
from simulation.setup import STEPS_PER_S
from simulation.world import disorder
from simulation.world.stage import World


class Effects:
    """Makes a quantity so that a fault changes; `step` is the present one."""

    def __init__(self, world: World, cabs: Cabs, duties: Duties, platforms: Platforms) -> None:
        self._trains, self._on_board, self._wayside = world.trains, world.on_board, world.wayside
        self._road = world.road
        self._charging, self._cabs, self._duties, self._platforms = world.charging, cabs, duties, platforms

    @singledispatchmethod
    def put_effect(self, fault: Fault[Any], value: Any, _step: int) -> None:  # noqa: ANN401 - of the fault's own type
        """Make it so."""
        disorder.put_fault(fault, self._trains, value)

    @put_effect.register
    def _power(self, fault: PowerFault, on: bool, step: int) -> None:
        slot = self._trains.slot_of.get(fault.target)
        if slot is None:
            (self._wayside.power_on if on else self._wayside.power_off)(step, fault.target)
        elif on:
            self._duties.power_on(slot, step)
        else:
            self._cabs.power_off(slot, step)

    @put_effect.register
    def _store(self, fault: LostStore, on: bool, step: int) -> None:
        self._power(fault, on, step)
        if on:
            return
        if fault.target in self._trains.slot_of:
            self._on_board.lose_store(self._trains.slot_of[fault.target])
        else:
            self._wayside.lose_store(fault.target)

    @put_effect.register
    def _frozen(self, fault: Frozen, frozen: bool, step: int) -> None:
        slot = self._trains.slot_of.get(fault.target)
        if slot is None:
            self._wayside.freeze(step, fault.target, frozen=frozen)
        else:
            self._cabs.freeze(slot, step, frozen=frozen)

    @put_effect.register
    def _clock(self, fault: ClockFault, clock: Clock, step: int) -> None:
        slot = self._trains.slot_of.get(fault.target)
        if slot is None:
            self._wayside.set_clock(step, fault.target, clock)
        else:
            self._cabs.set_clock(slot, step, clock)

    @put_effect.register
    def _claims(self, fault: SpeechFault, section_ids: tuple[str, ...], step: int) -> None:
        self._cabs.claim_besides(self._trains.slot_of[fault.target], step, section_ids)

    @put_effect.register
    def _cable(self, _fault: CableFault, cuts: tuple[CableCut, ...], step: int) -> None:
        self._wayside.cable.cut(cuts, step / STEPS_PER_S)

    @put_effect.register
    def _crossing(self, fault: CrossingFault, condition: CrossingCondition, step: int) -> None:
        self._wayside.crossings.put_condition(step, fault.target, condition)

    @put_effect.register
    def _points(self, fault: PointsFault, condition: Condition, step: int) -> None:
        changed = replace(
            self._wayside.machines[fault.target],
            stuck=condition.stuck,
            detection_fault=condition.detection_fault,
            throw_factor=condition.throw_factor,
        )
        self._wayside.set_machine(step, changed)

    @put_effect.register
    def _charger(self, fault: ChargerFault, works: bool, step: int) -> None:
        """Every unit is asked anew whether its train can go on."""
        if self._charging is not None:
            self._charging.charger_is(fault.target, works=works, step=step)
            for slot in self._trains.active():
                self._cabs.tell(slot, step, (Looked(),))

    @put_effect.register
    def _crossing_road(self, fault: CrossingRoadFault, stands: bool, _step: int) -> None:
        if self._road is not None:
            self._road.stall(fault.target, stands=stands)

    @put_effect.register
    def _doors(self, fault: DoorsFault, closed: bool, step: int) -> None:
        self._platforms.fault(self._trains.slot_of[fault.target], step, closed=closed)

    @put_effect.register
    def _brake(self, fault: BrakeFault, brake: BrakeState, step: int) -> None:
        slot = self._trains.slot_of[fault.target]
        self._trains.set_brake(slot, brake.reserve)
        self._cabs.vehicle_shows(slot, step, "brake_good", brake.good)

    @put_effect.register
    def _motors(self, fault: MotorsFault, cut_out: int, step: int) -> None:
        slot = self._trains.slot_of[fault.target]
        self._cabs.vehicle_shows(slot, step, "motors_share", self._trains.set_motors(slot, cut_out))
