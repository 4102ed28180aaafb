"""The report on energy: what was drawn and given back, by what, where, and beside whose figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

import polars as pl

from study.record.columns import FROM, TO, TRAIN, TRAINS, said_in_both
from study.record.energy import PARTS, TAKEN, EnergyDrawn, LayoverEnergy, LegEnergy, TrainEnergy
from study.record.figure import Figure, Kind, ShownIn, figures_of, seen_in
from study.record.journal_rows import ComparedFigure
from study.report.data import ReportedRun
from study.report.tabular import Column, Table, table_of
from study.wording import opinions as words
from study.wording.catalogue import phrase
from study.wording.phrase import Phrase
from vehicle.train_file import RegenerationReceiver

RECEIVERS: Final[Mapping[str, Phrase]] = {
    RegenerationReceiver.BATTERY.value: phrase("the train's own battery"),
    RegenerationReceiver.OTHER_TRAINS.value: phrase("other trains on the wire (assumed: all of it)"),
    RegenerationReceiver.SUBSTATION.value: phrase("the substation"),
    RegenerationReceiver.RESISTORS.value: phrase("resistors, from which nothing comes back"),
}
PHASES: Final[Mapping[str, Phrase]] = {
    "running": phrase("trains, running"),
    "standing": phrase("trains, standing"),
    "layovers": phrase("layovers"),
    "all": phrase("all"),
}
NET_PER_KM: Final = Figure(phrase("net per train-km"), digits=2)
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
        table_of(
            "energy_legs",
            phrase("Energy of each train by leg"),
            run.tables.energy_legs.to_dicts(),
            seen_in(LegEnergy, ShownIn.REPORT),
        ),
        table_of(
            "layovers",
            phrase("Layovers"),
            run.tables.layovers.to_dicts(),
            seen_in(LayoverEnergy, ShownIn.REPORT),
        ),
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
    return table_of(
        "energy_trains",
        phrase("Energy of each train"),
        sorted(rows, key=lambda row: order.get(row["train"], len(order))),
        shown,
    )


def _sums(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    energy = facts["energy"]
    sums = Table(
        "energy_sums",
        phrase("Energy of the day"),
        (
            Column("phase", said_in_both("phase"), [phase.both for phase in PHASES.values()]),
            *(
                Column(
                    name,
                    replace(figure, digits=1),
                    [energy[phase][name.removesuffix("_kwh")] for phase in PHASES],
                )
                for name, figure in figures_of(EnergyDrawn).items()
            ),
        ),
    )
    per = [
        (phrase(unit).both, energy[km], energy[key]["trains"], energy[key]["all"])
        for unit, km, key in (
            ("train-km", "train_km", "net_kwh_per_train_km"),
            ("car-km", "car_km", "net_kwh_per_car_km"),
        )
        if energy[key]["all"] is not None
    ]
    headings = (
        ("per", said_in_both("per")),
        ("km", Figure(Phrase("km"), digits=1)),
        ("net_trains", Figure(phrase("net kWh, trains"), digits=2)),
        ("net_all", Figure(phrase("with layovers"), digits=2)),
    )
    per_km = Table(
        "energy_per_km",
        phrase("Net energy per km"),
        tuple(Column(name, figure, [row[i] for row in per]) for i, (name, figure) in enumerate(headings)),
    )
    returned_kwh = energy["regenerated_to"]
    takes = Table(
        "energy_taken",
        phrase("Regenerated energy is taken by"),
        (
            Column(
                "taken_by", said_in_both("taken by"), [RECEIVERS[receiver].both for receiver in returned_kwh]
            ),
            Column("kwh", _KWH, list(returned_kwh.values())),
        ),
    )
    return sums, per_km, takes


def _parts(facts: Mapping[str, Any]) -> Table:
    """Where the net energy of the day went, with what of it."""
    energy, figures = facts["energy"], figures_of(TrainEnergy)
    whole = energy["all"]
    rows = {"auxiliary_kwh": whole["auxiliary"]} | {
        name: energy["parts"][name.removesuffix("_kwh")] for name in PARTS
    }
    share = [100.0 * kwh / whole["net"] if whole["net"] > 0.0 else None for kwh in rows.values()]
    return Table(
        "energy_parts",
        phrase("Where the net energy went"),
        (
            Column("part", said_in_both("part"), [figures[name].heading.both for name in rows]),
            Column("kwh", _KWH, list(rows.values())),
            Column(
                "percent_of_net",
                Figure(phrase("% of net"), digits=1, kind=Kind.SIGNED),
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
    shown = {"hour": Figure(phrase("h", "short")), **figures_of(EnergyDrawn)}
    return (table_of("energy_hours", phrase("Energy by hour"), hours.to_dicts(), shown),)


def _by_leg(run: ReportedRun) -> Table:
    """A row a leg, DOWN before UP, along the line."""
    shown = {**_ENDS, **seen_in(LegEnergy, ShownIn.SUMS), "net_per_km": NET_PER_KM}
    return table_of("energy_by_leg", phrase("Energy by leg, all trains"), _summed_by_leg(run), shown)


def _parts_by_leg(run: ReportedRun) -> Table:
    """Where the energy of each leg went, a train on average: what driving and timetable can change stands out."""
    kwh = {**seen_in(LegEnergy, ShownIn.PARTS), "net_kwh": figures_of(LegEnergy)["net_kwh"]}
    rows = [{**row, **{name: row[name] / row["trains"] for name in kwh}} for row in _summed_by_leg(run)]
    return table_of(
        "energy_parts_by_leg", phrase("Where it went by leg, a train on average"), rows, {**_ENDS, **kwh}
    )


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

    def place(row: Mapping[str, Any]) -> tuple[int, object]:
        direction = run.directions[row["train"]]
        return -int(direction), run.along(direction, (row["from_station"], row["to_station"]))

    return sorted(sums, key=place)


def _opinion(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    """Our figures beside others'; nothing where there are none."""
    compared = facts["comparisons"]
    if not compared:
        return ()
    figures = seen_in(ComparedFigure, ShownIn.REPORT)
    texts = [name for name, figure in figures.items() if figure.kind is Kind.SAID]
    return (
        table_of(
            "opinion",
            phrase("A second opinion on energy"),
            [row | {name: words.opinion(row[name]).both for name in texts} for row in compared],
            figures,
            meanings(compared),
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
        found.append(words.TRACTION.fill(kwh=abs(kwh), percent=abs(percent), more=more))
    for row in compared:
        ours, theirs = row["ours"], row["theirs"]
        if row["figure"].endswith("less than"):
            form = words.WITHIN if ours < theirs else words.ABOVE_BOUND
            found.append(form.fill(ours=ours, theirs=theirs))
        elif row["unit"] == "kWh per car-km":
            which = words.BELOW if ours < theirs else words.ABOVE
            percent, figure = abs(row["difference_percent"]), words.opinion(row["figure"])
            found.append(words.PER_CAR.fill(percent=percent, which=which, figure=figure))
    if not any(row["unit"] == "kWh per car-km" for row in compared):
        found.append(words.NONE)
    return tuple(found)
