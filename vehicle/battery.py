"""A traction battery (蓄電池): what it can give and take now, and what it keeps. SI units, discharging counts as > 0.

One open-circuit voltage over the state of charge and one resistance: V = U(s) - R I, and I^2 R is lost as heat. A
charge falls off by itself, first at the limits of current and power, then linearly over the state of charge (CC), and
at the last where V would pass its maximum (CV). Outside of its window a battery neither gives nor takes. No
temperature is kept; what cold costs stands in the resistance and in the auxiliaries.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from vehicle.battery_file import OCV_POINTS_MAX, BatteryTable
from vehicle.compiled import compiled
from vehicle.record import dtype_of, put_settings


class BatteryFlows(Protocol):
    """What has gone through a battery, and what has not, since its record was made."""

    given_j: Annotated[float, "at the terminals, out of the battery"]
    taken_j: Annotated[float, "at the terminals, into it"]
    lost_j: Annotated[float, "in its resistance"]
    supplied_j: Annotated[float, "what chargers and wires gave to the train, at its direct-current link"]
    missing_j: Annotated[float, "what was asked of it and could not be given"]
    spilled_j: Annotated[float, "what came back and could not be taken"]


class BatteryRow(Protocol):
    """One battery: what it is, what state it is in, and what has gone through it since the record was made."""

    fitted: Annotated[int, "0: the train has none, or its state is not followed"]
    full_c: Annotated[float, "charge from empty to full, as it is today"]
    ocv_points: int
    ocv_soc: Annotated[list[float], OCV_POINTS_MAX, "rising, from 0 to 1"]
    ocv_v: Annotated[list[float], OCV_POINTS_MAX, "open-circuit voltage there, not falling"]
    pack: Annotated[BatteryTable, "what it can give and take, and its window"]
    # state
    charge_c: float
    supply_w: Annotated[float, "what a charger or wire gives at most now; 0: none"]
    current_a: Annotated[float, "of the last step; > 0 discharges"]
    voltage_v: float
    flows: BatteryFlows


BATTERY: Final = dtype_of(BatteryRow)
SHEDS_S: Final = 60.0  # assumed: a set switches nothing off at a stop of the timetable


def battery_row(table: BatteryTable) -> NDArray[np.void]:
    """The checked table as one BATTERY record, shape (1,), empty; read-only."""
    row = np.zeros(1, dtype=BATTERY)
    points = len(table.open_circuit_soc)
    mean_v = float(np.trapezoid(table.open_circuit_v, table.open_circuit_soc))
    row["fitted"] = 1
    row["full_c"] = table.capacity_j * table.capacity_share / mean_v
    row["ocv_points"] = points
    row["ocv_soc"][0, :points] = table.open_circuit_soc
    row["ocv_v"][0, :points] = table.open_circuit_v
    put_settings(row.view(np.recarray)[0].pack, table)
    row.flags.writeable = False
    return row


@compiled
def soc_of(battery: BatteryRow) -> float:
    """State of charge, 0 to 1."""
    return battery.charge_c / battery.full_c


@compiled
def ocv_at(battery: BatteryRow, soc: float) -> float:
    """Open-circuit voltage at a state of charge, V, straight between the points of the curve."""
    last = battery.ocv_points - 1
    for i in range(last):
        if soc <= battery.ocv_soc[i + 1] or i == last - 1:
            share = (soc - battery.ocv_soc[i]) / (battery.ocv_soc[i + 1] - battery.ocv_soc[i])
            return float(battery.ocv_v[i] + share * (battery.ocv_v[i + 1] - battery.ocv_v[i]))
    return float(battery.ocv_v[0])


@compiled
def stored_j(battery: BatteryRow, soc: float) -> float:
    """Energy between empty and a state of charge, J: the integral of the open-circuit voltage over the charge."""
    sum_v = 0.0
    for i in range(battery.ocv_points - 1):
        low, high = battery.ocv_soc[i], min(battery.ocv_soc[i + 1], soc)
        if high > low:
            sum_v += 0.5 * (battery.ocv_v[i] + ocv_at(battery, high)) * (high - low)
    return sum_v * battery.full_c


@compiled
def window_j(battery: BatteryRow) -> float:
    """What the battery holds between the ends of its window, J."""
    return stored_j(battery, battery.pack.soc_high) - stored_j(battery, battery.pack.soc_low)


@compiled
def charge_to(battery: BatteryRow, share: float) -> None:
    """Set its charge to a share of its window."""
    low = battery.pack.soc_low
    battery.charge_c = battery.full_c * (low + share * (battery.pack.soc_high - low))


@compiled
def available_j(battery: BatteryRow) -> float:
    """What the battery holds above the low end of its window, J."""
    return stored_j(battery, soc_of(battery)) - stored_j(battery, battery.pack.soc_low)


@compiled
def current_for_a(battery: BatteryRow, power_w: float) -> float:
    """Current for a power at the terminals (> 0 out), A: P = U I - R I^2; the most there is where P is beyond that."""
    ocv_v = ocv_at(battery, soc_of(battery))
    resistance = battery.pack.resistance_ohm
    if resistance <= 0.0:
        return power_w / ocv_v
    root = ocv_v * ocv_v - 4.0 * resistance * power_w
    if root <= 0.0:
        return ocv_v / (2.0 * resistance)
    return 2.0 * power_w / (ocv_v + math.sqrt(root))


@compiled
def discharge_current_max_a(battery: BatteryRow, dt_s: float) -> float:
    """Greatest current that it gives for a step of `dt_s`, A: by current, power, least voltage, and its window."""
    limit_a = min(battery.pack.discharge_max_a, current_for_a(battery, battery.pack.discharge_max_w))
    if battery.pack.resistance_ohm > 0.0:
        sag_v = ocv_at(battery, soc_of(battery)) - battery.pack.voltage_min_v
        limit_a = min(limit_a, sag_v / battery.pack.resistance_ohm)
    left_c = battery.charge_c - battery.pack.soc_low * battery.full_c
    return max(0.0, min(limit_a, left_c / dt_s))


@compiled
def charge_current_max_a(battery: BatteryRow, power_max_w: float, dt_s: float) -> float:
    """Greatest charging current for a step, A (>= 0): by current, power, taper, greatest voltage, and its window.

    It never rises with the state of charge.
    """
    soc = soc_of(battery)
    limit_a = min(battery.pack.charge_max_a, -current_for_a(battery, -power_max_w))
    if soc > battery.pack.taper_from_soc:
        share = (battery.pack.soc_high - soc) / (battery.pack.soc_high - battery.pack.taper_from_soc)
        limit_a *= battery.pack.taper_to_share + (1.0 - battery.pack.taper_to_share) * min(
            max(share, 0.0), 1.0
        )
    if battery.pack.resistance_ohm > 0.0:
        rise_v = battery.pack.voltage_max_v - ocv_at(battery, soc)
        limit_a = min(limit_a, rise_v / battery.pack.resistance_ohm)
    room_c = battery.pack.soc_high * battery.full_c - battery.charge_c
    return max(0.0, min(limit_a, room_c / dt_s))


@compiled
def gives_max_w(battery: BatteryRow, dt_s: float) -> float:
    """Greatest power at the terminals for a step, W. Beyond U / 2R a greater current gives less, so it stops there."""
    current_a = discharge_current_max_a(battery, dt_s)
    ocv_v = ocv_at(battery, soc_of(battery))
    if battery.pack.resistance_ohm > 0.0:
        current_a = min(current_a, ocv_v / (2.0 * battery.pack.resistance_ohm))
    return current_a * (ocv_v - battery.pack.resistance_ohm * current_a)


@compiled
def takes_max_w(battery: BatteryRow, power_max_w: float, dt_s: float) -> float:
    """Greatest power into the terminals for a step, W (>= 0)."""
    current_a = charge_current_max_a(battery, power_max_w, dt_s)
    return current_a * (ocv_at(battery, soc_of(battery)) + battery.pack.resistance_ohm * current_a)


@compiled
def exchange(battery: BatteryRow, power_w: float, power_max_w: float, dt_s: float) -> float:
    """Let a power flow for a step, out (> 0) or in (at most `power_max_w`); returns what did, within the limits."""
    if power_w >= 0.0:
        flows_w = min(power_w, gives_max_w(battery, dt_s))
    else:
        flows_w = -min(-power_w, takes_max_w(battery, power_max_w, dt_s))
    current_a = current_for_a(battery, flows_w)
    battery.current_a = current_a
    battery.voltage_v = ocv_at(battery, soc_of(battery)) - battery.pack.resistance_ohm * current_a
    battery.charge_c -= current_a * dt_s
    battery.flows.lost_j += battery.pack.resistance_ohm * current_a * current_a * dt_s
    if flows_w > 0.0:
        battery.flows.given_j += flows_w * dt_s
    else:
        battery.flows.taken_j -= flows_w * dt_s
    return flows_w


@compiled
def carry(battery: BatteryRow, drawn_w: float, returned_w: float, dt_s: float) -> None:
    """One step of a train's direct-current link: `drawn_w` by motors and auxiliaries, `returned_w` by the motors.

    A charger or wire carries first what the train draws, then charges with what is left of its power.
    """
    demand_w = drawn_w - returned_w
    spare_w = battery.supply_w - demand_w
    if battery.supply_w > 0.0 and spare_w >= 0.0:
        flows_w = exchange(battery, -spare_w, battery.pack.charge_max_w, dt_s)
        battery.flows.supplied_j += max(demand_w - flows_w, 0.0) * dt_s
        battery.flows.spilled_j += max(flows_w - demand_w, 0.0) * dt_s
        return
    asked_w = demand_w - battery.supply_w
    flows_w = exchange(battery, asked_w, battery.pack.regeneration_max_w, dt_s)
    battery.flows.supplied_j += battery.supply_w * dt_s
    battery.flows.missing_j += max(asked_w - flows_w, 0.0) * dt_s
    battery.flows.spilled_j += max(flows_w - asked_w, 0.0) * dt_s


@compiled
def stand(battery: BatteryRow, drawn_w: float, supply_w: float, time_s: float, dt_s: float) -> None:
    """Draw a constant power for a time beside what a charger gives: off the line, or in a calculation."""
    before_w = battery.supply_w
    battery.supply_w = supply_w
    left_s = time_s
    while left_s > 1e-9:
        this_s = min(dt_s, left_s)
        carry(battery, drawn_w, 0.0, this_s)
        left_s -= this_s
    battery.supply_w = before_w
