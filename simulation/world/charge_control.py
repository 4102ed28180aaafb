"""What stands between a battery and its train's plant in each step, and the pantograph at chargers; compiled.

Before a step the battery says what it gives and takes; after it, it is charged or discharged by what the plant drew.
The pantograph is raised where a set stands at a charger long enough, or has too little to leave, and is down again
when the set is to leave by its unit's clock, but not before its battery has what the set's unit asks for. A set that
moves with its pantograph up draws nothing more by it and lowers it, and that is counted.

A set that stands and draws on its battery keeps what its unit asks for and a reserve: below that it switches off what
can wait of its auxiliaries (負荷制限), so that a long stand leaves it enough to go on. Where that has not sufficed
staff bring a generator; a set moves no wheel while that is connected.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, Protocol

from vehicle.battery import SHEDS_S, BatteryRow, available_j, carry, gives_max_w, takes_max_w
from vehicle.compiled import compiled, compiled_when_called
from vehicle.record import dtype_of
from vehicle.records import PlantRow, TrainRow

# charging.pantograph
DOWN: Final = 0
RISING: Final = 1
UP: Final = 2
FALLING: Final = 3

# charging.moved
NOT_MOVED: Final = 0
MOVED: Final = 1
TOLD: Final = 2

WORTH_S: Final = 30.0  # assumed: nobody raises a pantograph for less charging than this
FULL_SHARE: Final = 0.999
READY_S: Final = 1.0  # it is down this long before the set leaves


class ChargingRow(Protocol):
    """A set at a charger."""

    power_w: Annotated[float, "what the charger here gives at most; 0: none here, or it is dead"]
    connect_s: float
    disconnect_s: float
    leaves_s: Annotated[
        float, "when the set is to leave, by its unit's clock; -inf: once it has enough; +inf: not yet known"
    ]
    needed_j: Annotated[float, "what must be available before it leaves"]
    spare_j: Annotated[float, "and so much more before the pantograph comes down: it takes that to leave"]
    pantograph: Annotated[int, "DOWN, RISING, UP, FALLING"]
    moves_until_s: Annotated[float, "when it is up, or down"]
    moved: Annotated[int, "with the pantograph not down: NOT_MOVED, MOVED, TOLD"]
    keeps_j: Annotated[
        float, "what its stand is to leave in the battery, as it goes on less what it takes to run"
    ]
    reserve_j: Annotated[float, "the least of that"]
    keeps_w: Annotated[float, "auxiliaries that stay on with less than that"]
    brought_w: Annotated[float, "what a generator that staff have brought gives; 0: there is none"]
    stood_s: Annotated[float, "how long it has stood"]
    sheds: Annotated[int, "1: what can wait is switched off"]


CHARGING: Final = dtype_of(ChargingRow)


@compiled
def reset_charging(battery: BatteryRow, charging: ChargingRow) -> None:
    """A set that begins its day: nothing connected, nothing asked for."""
    charging.leaves_s = math.inf
    charging.needed_j = charging.spare_j = charging.keeps_j = charging.reserve_j = charging.brought_w = 0.0
    charging.keeps_w = math.inf
    charging.stood_s = 0.0
    charging.sheds = 0
    charging.pantograph = DOWN
    charging.moved = NOT_MOVED
    battery.supply_w = 0.0


@compiled
def is_full(battery: BatteryRow) -> bool:
    """Whether it takes no more, or next to nothing."""
    return bool(battery.charge_c >= FULL_SHARE * battery.pack.soc_high * battery.full_c)


@compiled
def has_enough(battery: BatteryRow, needed_j: float, spare_j: float) -> bool:
    """Whether the battery has what its unit asks for, and so much more, unless it takes no more."""
    return bool(available_j(battery) >= needed_j + (0.0 if is_full(battery) else spare_j))


@compiled_when_called
def steer(
    battery: BatteryRow,
    charging: ChargingRow,
    speed_mps: float,
    held: int,
    now_s: float,
    ahead_s: float,
) -> None:
    """Raise or lower the pantograph, and connect the battery to the charger while it is up.

    `held`: whether the unit holds the train, so that it may be raised; `ahead_s`: its clock, of true time `now_s`.
    """
    state = charging.pantograph
    if speed_mps > 0.0:
        charging.power_w = charging.brought_w = 0.0
        if state != DOWN and charging.moved == NOT_MOVED:
            charging.moved = MOVED
        if state == RISING:
            state = UP  # it comes down from wherever it is
    elif state == DOWN and charging.moved == TOLD:
        charging.moved = NOT_MOVED
    lowers_s = charging.leaves_s - ahead_s - charging.disconnect_s - READY_S
    if state == DOWN and held != 0 and charging.power_w > 0.0:
        worth = now_s + charging.connect_s + WORTH_S <= lowers_s
        if worth or not has_enough(battery, charging.needed_j, 0.0):
            state, charging.moves_until_s = RISING, now_s + charging.connect_s
    elif state == RISING and now_s >= charging.moves_until_s:
        state = UP
    elif state == UP and (
        (now_s >= lowers_s and has_enough(battery, charging.needed_j, charging.spare_j))
        or charging.power_w <= 0.0
    ):
        state, charging.moves_until_s = FALLING, now_s + charging.disconnect_s
    elif state == FALLING and now_s >= charging.moves_until_s:
        state = DOWN
    charging.pantograph = state
    if charging.brought_w > 0.0 and (
        is_full(battery) or available_j(battery) >= charging.keeps_j + charging.spare_j
    ):
        charging.brought_w = 0.0
    battery.supply_w = charging.power_w if state == UP else charging.brought_w


@compiled_when_called
def offer_power(battery: BatteryRow, charging: ChargingRow, plant: PlantRow, dt_s: float) -> None:
    """Say what the battery, and a charger beside it, can give and take in the step that follows."""
    plant.source_gives_w = gives_max_w(battery, dt_s) + battery.supply_w
    if charging.brought_w > 0.0:
        plant.source_gives_w = 0.0  # nothing for its motors
    plant.source_takes_w = takes_max_w(battery, battery.pack.regeneration_max_w, dt_s)


@compiled_when_called
def drain(
    battery: BatteryRow,
    charging: ChargingRow,
    plant: PlantRow,
    train: TrainRow,
    traction_j: float,
    regenerated_j: float,
    dt_s: float,
) -> None:
    """Charge or discharge by what the plant drew since its counters stood at these, J, less what is shed."""
    returned_w = (plant.energy_regenerated_j - regenerated_j) / dt_s
    drawn_w = (plant.energy_traction_j - traction_j) / dt_s + train.auxiliary_power_w
    if plant.speed_mps > 0.0:
        charging.keeps_j = max(charging.keeps_j - (drawn_w - returned_w) * dt_s, charging.reserve_j)
        charging.stood_s = 0.0
        charging.sheds = 0
    else:
        charging.stood_s += dt_s
        if charging.power_w > 0.0 or charging.stood_s < SHEDS_S:
            charging.sheds = 0
        else:
            charging.sheds = 1 if charging.brought_w > 0.0 or available_j(battery) < charging.keeps_j else 0
    if charging.sheds != 0:
        shed_w = max(train.auxiliary_power_w - charging.keeps_w, 0.0)
        plant.energy_auxiliary_j -= shed_w * dt_s
        drawn_w -= shed_w
    carry(battery, drawn_w, returned_w, dt_s)
