"""The batteries of a run: state of charge over the day, each charge with the minutes that would do, and the summary.

Energy is balanced here from the records alone: between two moments of a set, what its battery holds by its state of
charge and open-circuit voltage must be what went in less what went out and what was lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import polars as pl

from network.units import J_PER_KWH
from simulation.battery_settings import BatterySettings
from simulation.result import BatteryEvent, BatteryRecord
from simulation.setup import Setup
from study.record.battery import BatteryMoment, ChargeTaken
from study.record.tables import make_table
from vehicle.battery import BatteryFlows, soc_of, stand, stored_j
from vehicle.record import fields_of

STEP_S: Final = 1.0
LONGEST_S: Final = 4.0 * 3600.0  # a charge that does not suffice within it never does
BEYOND: Final = ""  # the station of what happens off the line
_ENDS: Final = {
    BatteryEvent.CONNECTED: BatteryEvent.DISCONNECTED,
    BatteryEvent.BROUGHT: BatteryEvent.TAKEN_AWAY,
}
FLOWS: Final = tuple(field.name.removesuffix("_j") for field in fields_of(BatteryFlows))


@dataclass(frozen=True, slots=True)
class ChargeWindow:
    """Energy between empty and the ends of a battery's window, and what is to be kept back, J."""

    low_j: float
    kept_j: float
    high_j: float
    soc_low: float
    soc_kept: float

    @classmethod
    def of_battery(cls, row: Any, settings: BatterySettings) -> ChargeWindow:  # noqa: ANN401
        """That of a BATTERY record."""
        pack = row["pack"]
        low_j, high_j = (float(stored_j(row, pack[name])) for name in ("soc_low", "soc_high"))
        kept_j = low_j + settings.reserve_share * (high_j - low_j)
        socs = np.linspace(float(pack["soc_low"]), float(pack["soc_high"]), 201)
        kept_soc = float(np.interp(kept_j, [float(stored_j(row, soc)) for soc in socs], socs))
        return cls(low_j, kept_j, high_j, float(pack["soc_low"]), kept_soc)


def windows_of(setup: Setup) -> dict[str, ChargeWindow]:
    """By stock id, of sets that run on a battery."""
    settings = setup.battery
    if settings is None:
        return {}
    batteries = {stock_id: kind.battery for stock_id, kind in setup.trains.items()}
    return {
        stock_id: ChargeWindow.of_battery(battery[0], settings)
        for stock_id, battery in batteries.items()
        if battery is not None
    }


def battery_tables(records: Sequence[BatteryRecord], setup: Setup) -> dict[str, pl.DataFrame]:
    """The tables battery and charges; empty where no set runs on a battery."""
    windows = windows_of(setup)
    by_set = {stock_id: [r for r in records if r.stock_id == stock_id] for stock_id in windows}
    rows = [row for stock_id, own in by_set.items() for row in _rows(own, windows[stock_id])]
    charges = [
        charge for stock_id, own in by_set.items() for charge in _charges(own, windows[stock_id], setup)
    ]
    return {"battery": make_table("battery", rows), "charges": make_table("charges", charges)}


def _rows(records: Sequence[BatteryRecord], window: ChargeWindow) -> list[BatteryMoment]:
    """A row a record; power is the mean since the one before."""
    found: list[BatteryMoment] = []
    for i, record in enumerate(records):
        before = records[max(i - 1, 0)]
        out_j = record.flows.given_j - record.flows.taken_j - before.flows.given_j + before.flows.taken_j
        since_s = record.t_s - before.t_s
        found.append(
            BatteryMoment(
                record.t_s,
                record.stock_id,
                record.number,
                record.event,
                record.station,
                record.soc,
                window.soc_low,
                window.soc_kept,
                stored_kwh=record.stored_j / J_PER_KWH,
                above_low_kwh=(record.stored_j - window.low_j) / J_PER_KWH,
                power_kw=out_j / since_s / 1e3 if since_s > 0.0 else 0.0,
                supply_kw=record.supply_w / 1e3,
                **{f"{name}_kwh": getattr(record.flows, f"{name}_j") / J_PER_KWH for name in FLOWS},
            )
        )
    return found


def _charges(records: Sequence[BatteryRecord], window: ChargeWindow, setup: Setup) -> list[ChargeTaken]:
    """Every charge: from the first current to the last, and what the set took until the next one."""
    ends = [
        (r, next((e for e in records[i + 1 :] if e.event is _ENDS[r.event]), records[-1]))
        for i, r in enumerate(records)
        if r.event in _ENDS
    ]
    following = [begin for begin, _ in ends[1:]]
    found: list[ChargeTaken] = []
    for index, (begin, end) in enumerate(ends):
        until = following[index] if index < len(following) else records[-1]
        needs_j = end.stored_j - until.stored_j
        on_line = begin.station != BEYOND or begin.event is BatteryEvent.BROUGHT
        suffices_s = least_charge_s(setup, begin, needs_j, window, drawn=on_line)
        found.append(
            ChargeTaken(
                begin.stock_id,
                end.number or begin.number,
                begin.station,
                begin.t_s,
                end.t_s,
                begin.soc,
                end.soc,
                gained_kwh=(end.stored_j - begin.stored_j) / J_PER_KWH,
                next_way_kwh=needs_j / J_PER_KWH,
                margin_kwh=(until.stored_j - window.kept_j) / J_PER_KWH,
                minutes=(end.t_s - begin.t_s) / 60.0,
                minutes_suffice=None if suffices_s is None else suffices_s / 60.0,
            )
        )
    return found


def least_charge_s(
    setup: Setup, begin: BatteryRecord, needs_j: float, window: ChargeWindow, *, drawn: bool
) -> float | None:
    """The least time of charging after which a set comes to its next charge with the reserve, s; None: no time does.

    `needs_j` is what the battery loses on its way there; `drawn`: the auxiliaries run while it charges.
    """
    kind = setup.trains[begin.stock_id]
    assert kind.battery is not None
    row = kind.battery[0].copy()
    row["charge_c"] = begin.soc * row["full_c"]
    auxiliary_w = float(kind.row[0]["auxiliary_power_w"]) if drawn else 0.0
    supply_w = _supply_w(setup, begin)
    if begin.event is BatteryEvent.BROUGHT and setup.battery is not None:  # all is off that can wait
        auxiliary_w = min(auxiliary_w, setup.battery.shed_to_kw * 1e3)
    wanted_j = window.kept_j + needs_j
    time_s = 0.0
    while float(stored_j(row, soc_of(row))) < wanted_j:
        if time_s >= LONGEST_S or float(soc_of(row)) >= float(row["pack"]["soc_high"]) - 1e-6:
            return None
        stand(row, auxiliary_w, supply_w, STEP_S, STEP_S)
        time_s += STEP_S
    return time_s


def _supply_w(setup: Setup, begin: BatteryRecord) -> float:
    """What charger, wire or generator gives at most."""
    if begin.event is BatteryEvent.BROUGHT and setup.battery is not None:
        return setup.battery.brought_kw * 1e3
    charger = setup.line.chargers.get(begin.station)
    if charger is not None:
        return charger.power_w
    return 0.0 if setup.battery is None else setup.battery.beyond_of(begin.number).charge_kw * 1e3


def battery_summary(battery: pl.DataFrame, setup: Setup) -> dict[str, Any]:
    """By set: state of charge at the ends of the day and lowest, margin above the reserve, energy, its balance.

    `margin_kwh` is the lowest energy of the day less what is to be kept back (< 0: it went below);
    `unbalanced_percent` is what the balance lacks, of what went through the terminals.
    """
    if battery.is_empty():
        return {}
    windows = windows_of(setup)
    return {
        unit: _set_summary(battery.filter(pl.col("unit") == unit), windows[unit])
        for unit in sorted(battery["unit"].unique())
    }


def _set_summary(rows: pl.DataFrame, window: ChargeWindow) -> dict[str, Any]:
    first, last = rows.row(0, named=True), rows.row(-1, named=True)
    lowest = rows.row(int(rows["stored_kwh"].arg_min() or 0), named=True)
    flows = {name: last[f"{name}_kwh"] - first[f"{name}_kwh"] for name in FLOWS}
    through = flows["given"] + flows["taken"]
    change = last["stored_kwh"] - first["stored_kwh"]
    lacks = flows["taken"] - flows["given"] - flows["lost"] - change
    return {
        "soc_first": first["soc"],
        "soc_last": last["soc"],
        "soc_lowest": lowest["soc"],
        "lowest_at_s": lowest["t_s"],
        "lowest_train": lowest["train"],
        "lowest_station": lowest["station"],
        "margin_kwh": lowest["stored_kwh"] - window.kept_j / J_PER_KWH,
        "above_low_kwh": lowest["above_low_kwh"],
        **{f"{name}_kwh": value for name, value in flows.items()},
        "change_kwh": change,
        "unbalanced_percent": 100.0 * lacks / through if through > 0.0 else 0.0,
    }
