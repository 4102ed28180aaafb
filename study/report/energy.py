"""The report on energy: what was drawn and given back, by what, where, and beside whose figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

import polars as pl

from study.record.columns import FROM, TO, TRAIN, TRAINS
from study.record.energy import PARTS, TAKEN, LayoverEnergy, LegEnergy, Taken, TrainEnergy
from study.record.figure import Figure, Kind, ShownIn, figures_of, seen_in
from study.record.told import ComparedFigure
from study.report.data import ReportedRun
from study.report.tabular import Column, Table, table_of
from study.wording import opinions as words
from study.wording.phrase import Phrase
from vehicle.train_file import RegenerationReceiver

RECEIVER_WORDS: Final[Mapping[str, str]] = {
    RegenerationReceiver.BATTERY.value: "to_battery",
    RegenerationReceiver.OTHER_TRAINS.value: "to_other_trains",
    RegenerationReceiver.SUBSTATION.value: "to_substation",
    RegenerationReceiver.RESISTORS.value: "to_resistors",
}
NET_PER_KM: Final = Figure(Phrase("net per train-km", "正味/列車キロ"), digits=2)
_KWH: Final = Figure(Phrase("kWh"), digits=1)
_ENDS: Final = {"from_station": FROM, "to_station": TO, "trains": TRAINS}


def energy_tables(run: ReportedRun, facts: Mapping[str, Any]) -> tuple[Table, ...]:
    """Energy by train, by phase, by leg and layover, and beside others' figures; none for a run without any."""
    if run.tables.energy.is_empty():
        return ()
    return (
        _by_train(run),
        *_sums(facts),
        _parts(facts),
        *_by_hour(run),
        _by_leg(run),
        _parts_by_leg(run),
        table_of("energy_legs", run.tables.energy_legs.to_dicts(), seen_in(LegEnergy, ShownIn.REPORT)),
        table_of("layovers", run.tables.layovers.to_dicts(), seen_in(LayoverEnergy, ShownIn.REPORT)),
        *_opinion(facts),
    )


def _by_train(run: ReportedRun) -> Table:
    order = {train: i for i, train in enumerate(run.trains)}
    rows = [
        row
        | {
            "net_per_km": row["net_kwh"] / row["distance_km"] if row["distance_km"] > 0 else None,
            "revenue": "yes" if row["revenue"] else "no",
        }
        for row in run.tables.energy.iter_rows(named=True)
    ]
    revenue = figures_of(TrainEnergy)["revenue"]
    shown = {
        "train": TRAIN,
        **seen_in(TrainEnergy, ShownIn.REPORT),
        "net_per_km": NET_PER_KM,
        "revenue": revenue,
    }
    return table_of("energy_trains", sorted(rows, key=lambda row: order.get(row["train"], len(order))), shown)


def _sums(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    energy = facts["energy"]
    phases = ("running", "standing", "layovers", "all")
    sums = Table(
        "energy_sums",
        (
            Column("phase", _word("phase", "区分"), [f"phase_{name}" for name in phases]),
            *(
                Column(
                    name,
                    replace(figure, digits=1),
                    [energy[phase][name.removesuffix("_kwh")] for phase in phases],
                )
                for name, figure in figures_of(Taken).items()
            ),
        ),
    )
    per = [
        (unit, energy[km], energy[key]["trains"], energy[key]["all"])
        for unit, km, key in (
            ("per_train_km", "train_km", "net_kwh_per_train_km"),
            ("per_car_km", "car_km", "net_kwh_per_car_km"),
        )
        if energy[key]["all"] is not None
    ]
    headings = (
        ("per", _word("per", "当たり")),
        ("km", Figure(Phrase("km"), digits=1)),
        ("net_trains", Figure(Phrase("net kWh, trains", "正味 kWh（列車）"), digits=2)),
        ("net_all", Figure(Phrase("with layovers", "折返し含む"), digits=2)),
    )
    per_km = Table(
        "energy_per_km",
        tuple(Column(name, figure, [row[i] for row in per]) for i, (name, figure) in enumerate(headings)),
    )
    taken = energy["regenerated_to"]
    takes = Table(
        "energy_taken",
        (
            Column("taken_by", _word("taken by", "行先"), [RECEIVER_WORDS[receiver] for receiver in taken]),
            Column("kwh", _KWH, list(taken.values())),
        ),
    )
    return sums, per_km, takes


def _word(en: str, ja: str) -> Figure:
    return Figure(Phrase(en, ja), kind=Kind.WORD)


def _parts(facts: Mapping[str, Any]) -> Table:
    """Where the net energy of the day went, with what of it."""
    energy, figures = facts["energy"], figures_of(TrainEnergy)
    whole = energy["all"]
    rows = {"auxiliary_kwh": whole["auxiliary"]} | {
        name: energy["parts"][name.removesuffix("_kwh")] for name in PARTS
    }
    share = [100.0 * kwh / whole["net"] if whole["net"] > 0.0 else None for kwh in rows.values()]
    said = Figure(Phrase("part", "内訳"), kind=Kind.SAID)
    return Table(
        "energy_parts",
        (
            Column("part", said, [figures[name].heading.both for name in rows]),
            Column("kwh", _KWH, list(rows.values())),
            Column(
                "percent_of_net",
                Figure(Phrase("% of net", "正味比 %"), digits=1, kind=Kind.SIGNED),
                share,
            ),
        ),
    )


def _by_hour(run: ReportedRun) -> tuple[Table, ...]:
    """The day's energy by the hour in which it was taken, of all stock and phases."""
    hours = (
        run.tables.energy_hours.group_by("hour_s")
        .agg(pl.col(*TAKEN).sum())
        .sort("hour_s")
        .with_columns((pl.col("hour_s") // 3600).alias("hour"))
    )
    if hours.is_empty():
        return ()
    shown = {"hour": Figure(Phrase("h", "時")), **figures_of(Taken)}
    return (table_of("energy_hours", hours.to_dicts(), shown),)


def _by_leg(run: ReportedRun) -> Table:
    """A row a leg, DOWN before UP, along the line."""
    shown = {**_ENDS, **seen_in(LegEnergy, ShownIn.SUMS), "net_per_km": NET_PER_KM}
    return table_of("energy_by_leg", _summed_by_leg(run), shown)


def _parts_by_leg(run: ReportedRun) -> Table:
    """Where the energy of each leg went, a train on average: what driving and timetable can change stands out."""
    kwh = {**seen_in(LegEnergy, ShownIn.PARTS), "net_kwh": figures_of(LegEnergy)["net_kwh"]}
    rows = [{**row, **{name: row[name] / row["trains"] for name in kwh}} for row in _summed_by_leg(run)]
    return table_of("energy_parts_by_leg", rows, {**_ENDS, **kwh})


def _summed_by_leg(run: ReportedRun) -> list[dict[str, Any]]:
    """The sums of all trains of each leg, with one of the trains; DOWN before UP, along the line."""
    sums = (
        run.tables.energy_legs.group_by("from_station", "to_station", maintain_order=True)
        .agg(
            pl.len().alias("trains"),
            pl.col("train").first(),
            pl.col(*seen_in(LegEnergy, ShownIn.SUMS | ShownIn.PARTS)).sum(),
        )
        .with_columns((pl.col("net_kwh") / pl.col("distance_km")).alias("net_per_km"))
        .iter_rows(named=True)
    )
    order = {station.id: station.position_m for station in run.stations}

    def place(row: Mapping[str, Any]) -> tuple[int, float]:
        direction = run.directions[row["train"]]
        at_m = order.get(row["from_station"], -direction * float("inf"))
        return -int(direction), direction * at_m

    return sorted(sums, key=place)


def _opinion(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    """Our figures beside others'; nothing where there are none."""
    compared = facts["comparisons"]
    if not compared:
        return ()
    figures = seen_in(ComparedFigure, ShownIn.REPORT)
    said = [name for name, figure in figures.items() if figure.kind is Kind.SAID]
    return (
        table_of(
            "opinion",
            [row | {name: words.opinion(row[name]).both for name in said} for row in compared],
            figures,
            tuple((said.en, said.in_("ja")) for said in meanings(compared)),
        ),
    )


def meanings(compared: list[Mapping[str, Any]]) -> tuple[Phrase, ...]:
    """What the differences mean, a sentence each."""
    by_figure = {row["figure"]: row for row in compared}
    found: list[Phrase] = []
    traction = by_figure.get("traction of the day on the same speeds")
    if traction is not None:
        kwh, percent = traction["ours"] - traction["theirs"], traction["difference_percent"]
        more = words.MORE if kwh >= 0.0 else words.LESS
        found.append(words.TRACTION.of(kwh=abs(kwh), percent=abs(percent), more=more))
    for row in compared:
        ours, theirs = row["ours"], row["theirs"]
        if row["figure"].endswith("less than"):
            form = words.WITHIN if ours < theirs else words.ABOVE_BOUND
            found.append(form.of(ours=ours, theirs=theirs))
        elif row["unit"] == "kWh per car-km":
            which = words.BELOW if ours < theirs else words.ABOVE
            percent, figure = abs(row["difference_percent"]), words.opinion(row["figure"])
            found.append(words.PER_CAR.of(percent=percent, which=which, figure=figure))
    if not any(row["unit"] == "kWh per car-km" for row in compared):
        found.append(words.NONE)
    return tuple(found)
