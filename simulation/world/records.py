"""All that compiled code works on: one row of STOCK a train slot, with the truth about it and what it has on board.

The truth is never handed to `onboard`: the unit sees what the sensors make of it.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from onboard.board import BoardRow, SensedRow
from simulation.ride import RideRow
from simulation.sensors.scene import SceneRow
from simulation.sensors.table import SensorsRow
from simulation.world.charge_control import ChargingRow
from vehicle.battery import BatteryRow
from vehicle.record import dtype_of
from vehicle.records import PlantRow, TrainRow

# what a train passed, as the world reports it; a word of its own beside the unit's events
PASSED_TAG: Final = 1
PASSED_FRONT: Final = 2  # the front passed the end of a track piece
PASSED_REAR: Final = 4  # the rear passed the end of a track piece
PASSED_CROSSING: Final = 8  # the front came to a road, or front or rear to a contact, of a level crossing
PASSED_TO_A_STAND: Final = 16  # the train came to a stand
PASSED_FROM_A_STAND: Final = 32  # it began to move


class TruthRow(Protocol):
    """Where a train really is."""

    active: int
    powered: Annotated[int, "0: its unit is dead, or has no train number yet; the emergency brake is applied"]
    position_m: Annotated[float, "path coordinate of the front, from the carrier"]
    offset_m: Annotated[float, "position_m - plant.travelled_m"]
    profile_offset: int
    profile_rows: int
    front_boundary_m: Annotated[float, "path coordinate at which the front leaves its piece"]
    rear_boundary_m: float
    crossing_m: Annotated[float, "the front's at the next road or contact of a level crossing; +inf: none"]
    tag_next: Annotated[int, "row of the tag pool; the next tag ahead"]
    tag_end: int
    track_end_m: Annotated[float, "where the track ends, which every driver sees"]
    sight_m: Annotated[float, "where a driver on sight stops; +inf: does not drive on sight"]
    sign_m: Annotated[float, "path coordinate of the next stop sign; +inf: none"]
    clock_ahead_s: Annotated[float, "of the unit's clock, when the unit was last asked"]
    wheels_vary: Annotated[int, "1: its wheels creep, or have treads with a slope"]
    carries_more: Annotated[int, "1: it has sensors that look at more than tags and signs"]
    lead_bogie_m: Annotated[float, "how far behind the front the leading car's first bogie is"]
    bogie_base_m: Annotated[float, "from there to its second"]
    beacon_next: Annotated[int, "row of the pool of places; the next beacon ahead"]
    beacon_end: int
    markers_next: Annotated[int, "the same of markers"]
    markers_end: int


class StockRow(Protocol):
    """One stock: where it is, what it is, what it senses and what it has on board."""

    truth: Annotated[TruthRow, "where it really is"]
    plant: Annotated[PlantRow, "the state of its body and machinery"]
    body: Annotated[TrainRow, "the train as it is; its board holds the train as believed"]
    battery: Annotated[BatteryRow, "its traction battery, if it is followed"]
    charging: Annotated[ChargingRow, "its pantograph at a charger"]
    scene: Annotated[SceneRow, "what there is to be sensed"]
    sensors: Annotated[SensorsRow, "its sensors"]
    sensed: Annotated[SensedRow, "what its sensors show"]
    board: Annotated[BoardRow, "what it has on board"]
    ride: Annotated[RideRow, "how it is driven"]


TRUTH: Final = dtype_of(TruthRow)
STOCK: Final = dtype_of(StockRow)


class TraceRow(Protocol):
    """One sample of how a train went."""

    step: int
    slot: int
    position_m: float
    speed_mps: float
    acceleration_mps2: float
    notch: float
    intervention: int
    permitted_mps: float
    target_mps: float
    stop_limit_m: float
    estimate_error_m: float
    bound_ahead_m: float
    bound_behind_m: float


TRACE: Final = dtype_of(TraceRow)
