"""Energy by train, by leg and by layover, from the phases that the simulation booked (電力量)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import polars as pl

from network.units import J_PER_KWH
from simulation.result import EnergyRecord, Phase
from study.run.energy_parts import parts_columns
from study.run.tables import make_table
from vehicle.train_file import Receiver, TrainType

ON_LEG: Final = frozenset({Phase.RUNNING, Phase.HELD})


@dataclass(frozen=True, slots=True)
class Make:
    """What the tables say of a stock. Raises nothing; `cars` counts as the train file does."""

    length_m: float
    cars: int
    regenerated_to: Receiver

    @classmethod
    def of(cls, kind: TrainType) -> Make:
        """That of a kind of train."""
        row = kind.row[0]
        return cls(float(row["length_m"]), round(float(row["cars"])), kind.regenerated_to)


@dataclass(frozen=True, slots=True)
class Sum:
    """Records added up: s, km, kWh. `standing_kwh` is the part of the auxiliaries that they took at a stand."""

    running_s: float
    standing_s: float
    distance_km: float
    traction_kwh: float
    regenerated_kwh: float
    auxiliary_kwh: float
    standing_kwh: float

    def net_kwh(self, receiver: Receiver) -> float:
        """What was drawn less what came back; from resistors nothing does."""
        back_kwh = 0.0 if receiver is Receiver.RESISTORS else self.regenerated_kwh
        return self.traction_kwh + self.auxiliary_kwh - back_kwh


@dataclass(slots=True)
class Stay:
    """One layover: the train that ended it there, and the one that begins; None where there is none."""

    records: list[EnergyRecord]
    after_train: str | None = None
    before_train: str | None = None


def added(records: Iterable[EnergyRecord]) -> Sum:
    """The sum of some records."""
    whole = tuple(records)
    moving = [r for r in whole if r.phase is Phase.RUNNING]
    still = [r for r in whole if r.phase is not Phase.RUNNING]
    return Sum(
        sum(r.end_s - r.begin_s for r in moving),
        sum(r.end_s - r.begin_s for r in still),
        sum(r.distance_m for r in whole) / 1000.0,
        sum(r.traction_j for r in whole) / J_PER_KWH,
        sum(r.regenerated_j for r in whole) / J_PER_KWH,
        sum(r.auxiliary_j for r in whole) / J_PER_KWH,
        sum(r.auxiliary_j for r in still) / J_PER_KWH,
    )


def energy_tables(records: Sequence[EnergyRecord], fleet: Mapping[str, Make]) -> dict[str, pl.DataFrame]:
    """The tables energy, energy_legs and layovers. Stock stabled after its last train stands in none of them."""
    by_train: dict[tuple[str, str], list[EnergyRecord]] = {}
    for record in records:
        if record.phase not in (Phase.LAYOVER, Phase.STABLED):
            by_train.setdefault((record.stock_id, record.number), []).append(record)
    legs = {
        (*train, *ends): part for train, whole in by_train.items() for ends, part in _legs_of(whole).items()
    }
    return {
        "energy": _frame("energy", list(by_train.items()), fleet),
        "energy_legs": _frame("energy_legs", list(legs.items()), fleet),
        "layovers": _layovers(stays_of(records), fleet),
    }


def stays_of(records: Sequence[EnergyRecord]) -> tuple[Stay, ...]:
    """Every layover of every stock, in the order in which they began."""
    stays: list[Stay] = []
    open_stay: dict[str, Stay] = {}
    ran: set[tuple[str, str]] = set()
    for record in records:
        if record.phase is not Phase.LAYOVER:
            ran.add((record.stock_id, record.number))
            continue
        stay = open_stay.get(record.stock_id)
        if stay is None or stay.records[-1].end_s != record.begin_s:
            stay = open_stay[record.stock_id] = Stay([])
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


def _frame(
    name: str, parts: Sequence[tuple[tuple[str, ...], list[EnergyRecord]]], fleet: Mapping[str, Make]
) -> pl.DataFrame:
    sums = [added(records) for _, records in parts]
    makes = [fleet[key[0]] for key, _ in parts]
    columns: dict[str, list[object]] = {
        "unit": [key[0] for key, _ in parts],
        "train": [key[1] for key, _ in parts],
        "revenue": [records[0].revenue for _, records in parts],
        "cars": [make.cars for make in makes],
        **_energy_columns(sums, makes),
        **parts_columns([records for _, records in parts], [make.regenerated_to for make in makes]),
    }
    if name == "energy_legs":
        columns |= {"from_station": [k[2] for k, _ in parts], "to_station": [k[3] for k, _ in parts]}
    else:
        columns["regenerated_to"] = [make.regenerated_to.value for make in makes]
    return make_table(name, columns)


def _energy_columns(sums: Sequence[Sum], makes: Sequence[Make]) -> dict[str, list[object]]:
    names = ("distance_km", "running_s", "standing_s", "traction_kwh", "regenerated_kwh", "auxiliary_kwh")
    return {
        **{name: [getattr(one, name) for one in sums] for name in (*names, "standing_kwh")},
        "net_kwh": [one.net_kwh(make.regenerated_to) for one, make in zip(sums, makes, strict=True)],
    }


def _layovers(stays: Sequence[Stay], fleet: Mapping[str, Make]) -> pl.DataFrame:
    firsts = [stay.records[0] for stay in stays]
    makes = [fleet[record.stock_id] for record in firsts]
    energy = _energy_columns([added(stay.records) for stay in stays], makes)
    kept = ("traction_kwh", "regenerated_kwh", "auxiliary_kwh", "net_kwh")
    return make_table(
        "layovers",
        {
            "unit": [record.stock_id for record in firsts],
            "station": [record.from_id for record in firsts],
            "after_train": [stay.after_train for stay in stays],
            "before_train": [stay.before_train for stay in stays],
            "from_s": [record.begin_s for record in firsts],
            "to_s": [stay.records[-1].end_s for stay in stays],
            **{name: energy[name] for name in kept},
            **parts_columns([stay.records for stay in stays], [make.regenerated_to for make in makes]),
        },
    )
