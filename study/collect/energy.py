"""Energy by train, by leg and by layover, from the phases that the simulation booked (電力量)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import polars as pl

from network.units import J_PER_KWH
from simulation.result import EnergyPhase, EnergyRecord
from study.collect.energy_parts import spent_kwh
from study.record.energy import LayoverEnergy, LegEnergy, TrainEnergy
from study.record.tables import make_table
from vehicle.train_file import RegenerationReceiver, TrainType

ON_LEG: Final = frozenset({EnergyPhase.RUNNING, EnergyPhase.HELD})


@dataclass(frozen=True, slots=True)
class StockMake:
    """What the tables say of a stock. Raises nothing; `cars` counts as the train file does."""

    cars: int
    regenerated_to: RegenerationReceiver

    @classmethod
    def of(cls, kind: TrainType) -> StockMake:
        """That of a kind of train."""
        return cls(round(float(kind.row[0]["cars"])), kind.regenerated_to)


@dataclass(slots=True)
class Layover:
    """One layover: the train that ended it there, and the one that begins; None where there is none."""

    records: list[EnergyRecord]
    after_train: str | None = None
    before_train: str | None = None


def _ran(records: Sequence[EnergyRecord]) -> dict[str, float]:
    """How long and far, with the part of the auxiliaries that was taken at a stand: fields of `SpentByTrain`."""
    moving = [r for r in records if r.phase is EnergyPhase.RUNNING]
    still = [r for r in records if r.phase is not EnergyPhase.RUNNING]
    return {
        "running_s": sum(r.end_s - r.begin_s for r in moving),
        "standing_s": sum(r.end_s - r.begin_s for r in still),
        "distance_km": sum(r.distance_m for r in records) / 1000.0,
        "standing_kwh": sum(r.counted_j["auxiliary"] for r in still) / J_PER_KWH,
    }


def energy_tables(records: Sequence[EnergyRecord], fleet: Mapping[str, StockMake]) -> dict[str, pl.DataFrame]:
    """The tables energy, energy_legs and layovers. Stock stabled after its last train stands in none of them."""
    by_train: dict[tuple[str, str], list[EnergyRecord]] = {}
    for record in records:
        if record.phase not in (EnergyPhase.LAYOVER, EnergyPhase.STABLED):
            by_train.setdefault((record.stock_id, record.number), []).append(record)
    legs = {
        (*train, *ends): part for train, whole in by_train.items() for ends, part in _legs_of(whole).items()
    }
    return {
        "energy": make_table("energy", [_of_train(*train, fleet) for train in by_train.items()]),
        "energy_legs": make_table("energy_legs", [_of_leg(*leg, fleet) for leg in legs.items()]),
        "layovers": make_table("layovers", [_of_stay(stay, fleet) for stay in stays_of(records)]),
    }


def stays_of(records: Sequence[EnergyRecord]) -> tuple[Layover, ...]:
    """Every layover of every stock, in the order in which they began."""
    stays: list[Layover] = []
    open_stay: dict[str, Layover] = {}
    ran: set[tuple[str, str]] = set()
    for record in records:
        if record.phase is not EnergyPhase.LAYOVER:
            ran.add((record.stock_id, record.number))
            continue
        stay = open_stay.get(record.stock_id)
        if stay is None or stay.records[-1].end_s != record.begin_s:
            stay = open_stay[record.stock_id] = Layover([])
            stays.append(stay)
        stay.records.append(record)
        if (record.stock_id, record.number) in ran:
            stay.after_train = record.number
        else:
            stay.before_train = record.number
    stays = [stay for stay in stays if stay.records[-1].end_s > stay.records[0].begin_s]
    return tuple(sorted(stays, key=lambda stay: (stay.records[0].begin_s, stay.records[0].stock_id)))


def _legs_of(records: Iterable[EnergyRecord]) -> dict[tuple[str, str], list[EnergyRecord]]:
    """The records of one train by its legs, each with the stop that ends it."""
    legs: dict[tuple[str, str], list[EnergyRecord]] = {}
    last: tuple[str, str] | None = None
    for record in records:
        goes_on = record.from_id != record.to_id  # not so in the portal by which it leaves
        if (record.phase in ON_LEG and goes_on) or last is None:
            last = (record.from_id, record.to_id)
        legs.setdefault(last, []).append(record)
    return legs


def _of_train(
    train: tuple[str, str], records: Sequence[EnergyRecord], fleet: Mapping[str, StockMake]
) -> TrainEnergy:
    make = fleet[train[0]]
    return TrainEnergy(
        unit=train[0],
        train=train[1],
        revenue=records[0].revenue,
        cars=make.cars,
        regenerated_to=make.regenerated_to,
        **_ran(records),
        **spent_kwh(records, make.regenerated_to),
    )


def _of_leg(
    leg: tuple[str, str, str, str], records: Sequence[EnergyRecord], fleet: Mapping[str, StockMake]
) -> LegEnergy:
    make = fleet[leg[0]]
    return LegEnergy(
        unit=leg[0],
        train=leg[1],
        revenue=records[0].revenue,
        from_station=leg[2],
        to_station=leg[3],
        cars=make.cars,
        **_ran(records),
        **spent_kwh(records, make.regenerated_to),
    )


def _of_stay(stay: Layover, fleet: Mapping[str, StockMake]) -> LayoverEnergy:
    first = stay.records[0]
    return LayoverEnergy(
        unit=first.stock_id,
        station=first.from_id,
        after_train=stay.after_train,
        before_train=stay.before_train,
        from_s=first.begin_s,
        to_s=stay.records[-1].end_s,
        **spent_kwh(stay.records, fleet[first.stock_id].regenerated_to),
    )
