"""How a stock is driven, counted in every step of its body: notches, jerk, and in which manner it goes (惰行, 力行).

The trace has a sample a second, in which a notch that was put in and taken out again does not appear and a jerk is
smoothed away. So the kernel counts, from stand to stand, and the books cut the counts where they cut the energy.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Final, Protocol

from onboard.records import MODE_DRIVE, UnitRow
from vehicle.compiled import compiled
from vehicle.records import PlantRow

# in which manner a train goes, by the command that its body follows in a step
ACCELERATES: Final = 0  # power, and its speed changes by more than CRUISING_MPS2
CRUISES: Final = 1  # power that holds the speed
COASTS: Final = 2  # neither power nor brake (惰行)
BRAKES: Final = 3
MANNERS: Final = 4
CRUISING_MPS2: Final = 0.1  # assumed: what one power notch is worth


class RideRow(Protocol):
    """What has been counted since the last cut; the notches go on over cuts."""

    notch: Annotated[float, "the command to the body in this step: > 0 power, < 0 brake"]
    power_notch: Annotated[float, "as it was when it was last counted"]
    brake_notch: float
    power_changes: Annotated[int, "times that the power notch changed while the train was driven"]
    brake_changes: int
    jerk_max_mps3: Annotated[float, "largest size; the step that ends in a stand is left out"]
    jerk_squared_m2ps5: Annotated[float, "integral over time of the square of the jerk, of the same steps"]
    jolt_mps2: Annotated[float, "deceleration in the last whole step before a stand"]
    time_s: Annotated[list[float], MANNERS, "moving, by manner"]
    way_m: Annotated[list[float], MANNERS, "the same of the way"]


@dataclass(frozen=True, slots=True)
class Ride:
    """How one run from a stand to a stand was driven; see `RideRow`. Times and ways are by manner, in their order."""

    power_changes: int = 0
    brake_changes: int = 0
    jerk_max_mps3: float = 0.0
    jerk_squared_m2ps5: float = 0.0
    jolt_mps2: float = 0.0
    time_s: tuple[float, ...] = (0.0,) * MANNERS
    way_m: tuple[float, ...] = (0.0,) * MANNERS

    @property
    def moving_s(self) -> float:
        """How long the train moved."""
        return sum(self.time_s)

    @property
    def moved_m(self) -> float:
        """How far."""
        return sum(self.way_m)

    @property
    def jerk_rms_mps3(self) -> float:
        """Root of the mean square of the jerk over the time in which the train moved; 0 of one that did not."""
        moving_s = self.moving_s
        return (self.jerk_squared_m2ps5 / moving_s) ** 0.5 if moving_s > 0.0 else 0.0


NO_RIDE: Final = Ride()


@compiled
def manner_of(notch: float, emergency: bool, acceleration_mps2: float) -> int:
    """In which manner a train goes under a command that moves it so."""
    if emergency or notch < 0.0:
        return BRAKES
    if notch == 0.0:
        return COASTS
    return CRUISES if abs(acceleration_mps2) <= CRUISING_MPS2 else ACCELERATES


@compiled
def is_another(before: float, notch: float) -> bool:
    """Whether a notch is a change against the one counted last: by a whole one or more, or put in, or taken out.

    Of notches that are whole every change is; a brake without steps changes a little in every tick.
    """
    return abs(notch - before) >= 1.0 or (notch == 0.0) != (before == 0.0)


@compiled
def count_notches(ride: RideRow, unit: UnitRow, plant: PlantRow, notch: float) -> None:
    """Count a step's command to the body. What is put in while a train is held at a stand counts for nothing."""
    ride.notch = notch
    power, brake = max(notch, 0.0), max(-notch, 0.0)
    if unit.mode != MODE_DRIVE and plant.speed_mps == 0.0:
        ride.power_notch, ride.brake_notch = power, brake
        return
    if is_another(ride.power_notch, power):
        ride.power_notch = power
        ride.power_changes += 1
    if is_another(ride.brake_notch, brake):
        ride.brake_notch = brake
        ride.brake_changes += 1


@compiled
def count_motion(
    ride: RideRow, plant: PlantRow, before_mps: float, before_mps2: float, emergency: bool, step_s: float
) -> None:
    """Count what a step made of the body, whose speed and acceleration were `before_mps` and `before_mps2`."""
    if before_mps == 0.0 and plant.speed_mps == 0.0:
        return
    manner = manner_of(ride.notch, emergency, plant.acceleration_mps2)
    ride.time_s[manner] += step_s
    ride.way_m[manner] += 0.5 * (before_mps + plant.speed_mps) * step_s
    if plant.speed_mps == 0.0:
        ride.jolt_mps2 = max(ride.jolt_mps2, -before_mps2)
        return
    jerk_mps3 = (plant.acceleration_mps2 - before_mps2) / step_s
    ride.jerk_max_mps3 = max(ride.jerk_max_mps3, abs(jerk_mps3))
    ride.jerk_squared_m2ps5 += jerk_mps3 * jerk_mps3 * step_s


def cut_ride(row: RideRow) -> Ride:
    """What has been counted since the last cut, which is made here."""
    ride = Ride(
        int(row.power_changes),
        int(row.brake_changes),
        float(row.jerk_max_mps3),
        float(row.jerk_squared_m2ps5),
        float(row.jolt_mps2),
        tuple(float(row.time_s[manner]) for manner in range(MANNERS)),
        tuple(float(row.way_m[manner]) for manner in range(MANNERS)),
    )
    row.power_changes = row.brake_changes = 0
    row.jerk_max_mps3 = row.jerk_squared_m2ps5 = row.jolt_mps2 = 0.0
    for manner in range(MANNERS):
        row.time_s[manner] = row.way_m[manner] = 0.0
    return ride


def joined_rides(rides: Iterable[Ride]) -> Ride:
    """Several runs as one."""
    whole = tuple(rides)
    return Ride(
        sum(ride.power_changes for ride in whole),
        sum(ride.brake_changes for ride in whole),
        max((ride.jerk_max_mps3 for ride in whole), default=0.0),
        sum(ride.jerk_squared_m2ps5 for ride in whole),
        max((ride.jolt_mps2 for ride in whole), default=0.0),
        tuple(sum(ride.time_s[manner] for ride in whole) for manner in range(MANNERS)),
        tuple(sum(ride.way_m[manner] for ride in whole) for manner in range(MANNERS)),
    )
