"""The report on energy: what was drawn and given back, by what, where, and beside whose figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import polars as pl

from study.report.data import Run
from study.report.tabular import Column, Kind, Table, table_of
from study.run.tables import PARTS_KWH
from study.wording import opinions as words
from study.wording.phrase import Phrase
from vehicle.train_file import Receiver

RECEIVER_WORDS: Final[Mapping[str, str]] = {
    Receiver.BATTERY.value: "to_battery",
    Receiver.OTHER_TRAINS.value: "to_other_trains",
    Receiver.SUBSTATION.value: "to_substation",
    Receiver.RESISTORS.value: "to_resistors",
}
KINDS: Final = ("traction", "auxiliary", "regenerated", "net")
PARTS: Final = tuple(PARTS_KWH)  # auxiliaries apart
COLUMNS: Final = tuple(f"{kind}_kwh" for kind in KINDS)
_KWH: Final = dict.fromkeys(COLUMNS, (Kind.NUMBER, 2))


def energy_tables(run: Run, facts: Mapping[str, Any]) -> tuple[Table, ...]:
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
        _legs(run),
        table_of(
            "layovers",
            run.tables.layovers.to_dicts(),
            {
                "unit": (Kind.TEXT, 0),
                "station": (Kind.PLACE, 0),
                "after_train": (Kind.TRAIN, 0),
                "before_train": (Kind.TRAIN, 0),
                "from_s": (Kind.CLOCK, 0),
                "to_s": (Kind.CLOCK, 0),
                **_KWH,
            },
        ),
        *_opinion(facts),
    )


def _by_train(run: Run) -> Table:
    order = {train: i for i, train in enumerate(run.trains)}
    rows = sorted(
        run.tables.energy.iter_rows(named=True), key=lambda row: order.get(row["train"], len(order))
    )
    per_km = [row["net_kwh"] / row["distance_km"] if row["distance_km"] > 0 else None for row in rows]
    table = table_of(
        "energy_trains",
        rows,
        {
            "train": (Kind.TRAIN, 0),
            "unit": (Kind.TEXT, 0),
            "distance_km": (Kind.NUMBER, 1),
            "running_s": (Kind.NUMBER, 0),
            "standing_s": (Kind.NUMBER, 0),
            **_KWH,
            "standing_kwh": (Kind.NUMBER, 2),
        },
    )
    carries = ["yes" if row["revenue"] else "no" for row in rows]
    more = (Column("net_per_km", Kind.NUMBER, per_km, 2), Column("revenue", Kind.WORD, carries))
    return Table(table.id, (*table.columns, *more))


def _sums(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    energy = facts["energy"]
    phases = ("running", "standing", "layovers", "all")
    sums = Table(
        "energy_sums",
        (
            Column("phase", Kind.WORD, [f"phase_{name}" for name in phases]),
            *(
                Column(f"{kind}_kwh", Kind.NUMBER, [energy[name][kind] for name in phases], 1)
                for kind in KINDS
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
    per_km = Table(
        "energy_per_km",
        (
            Column("per", Kind.WORD, [row[0] for row in per]),
            Column("km", Kind.NUMBER, [row[1] for row in per], 1),
            Column("net_trains", Kind.NUMBER, [row[2] for row in per], 2),
            Column("net_all", Kind.NUMBER, [row[3] for row in per], 2),
        ),
    )
    taken = energy["regenerated_to"]
    takes = Table(
        "energy_taken",
        (
            Column("taken_by", Kind.WORD, [RECEIVER_WORDS[receiver] for receiver in taken]),
            Column("kwh", Kind.NUMBER, list(taken.values()), 1),
        ),
    )
    return sums, per_km, takes


def _parts(facts: Mapping[str, Any]) -> Table:
    """Where the net energy of the day went, with what of it."""
    energy = facts["energy"]
    whole = energy["all"]
    rows = {"auxiliary_kwh": whole["auxiliary"]} | {
        name: energy["parts"][name.removesuffix("_kwh")] for name in PARTS
    }
    share = [100.0 * kwh / whole["net"] if whole["net"] > 0.0 else None for kwh in rows.values()]
    return Table(
        "energy_parts",
        (
            Column("part", Kind.WORD, list(rows)),
            Column("kwh", Kind.NUMBER, list(rows.values()), 1),
            Column("percent_of_net", Kind.SIGNED, share, 1),
        ),
    )


def _by_hour(run: Run) -> tuple[Table, ...]:
    """The day's energy by the hour in which it was taken, of all stock and phases."""
    hours = (
        run.tables.energy_hours.group_by("hour_s")
        .agg(pl.col(*COLUMNS).sum())
        .sort("hour_s")
        .with_columns((pl.col("hour_s") // 3600).alias("hour"))
    )
    if hours.is_empty():
        return ()
    return (table_of("energy_hours", hours.to_dicts(), {"hour": (Kind.NUMBER, 0), **_KWH}),)


def _by_leg(run: Run) -> Table:
    """A row a leg, DOWN before UP, along the line."""
    return table_of(
        "energy_by_leg",
        _summed_by_leg(run),
        {
            "from_station": (Kind.PLACE, 0),
            "to_station": (Kind.PLACE, 0),
            "trains": (Kind.NUMBER, 0),
            "distance_km": (Kind.NUMBER, 1),
            **_KWH,
            "standing_kwh": (Kind.NUMBER, 2),
            "net_per_km": (Kind.NUMBER, 2),
        },
    )


def _parts_by_leg(run: Run) -> Table:
    """Where the energy of each leg went, a train on average: what driving and timetable can change stands out."""
    kwh = ("auxiliary_kwh", *PARTS, "net_kwh")
    rows = [{**row, **{name: row[name] / row["trains"] for name in kwh}} for row in _summed_by_leg(run)]
    ends = {"from_station": (Kind.PLACE, 0), "to_station": (Kind.PLACE, 0), "trains": (Kind.NUMBER, 0)}
    return table_of("energy_parts_by_leg", rows, {**ends, **dict.fromkeys(kwh, (Kind.NUMBER, 2))})


def _summed_by_leg(run: Run) -> list[dict[str, Any]]:
    """The sums of all trains of each leg, with one of the trains; DOWN before UP, along the line."""
    sums = (
        run.tables.energy_legs.group_by("from_station", "to_station", maintain_order=True)
        .agg(
            pl.len().alias("trains"),
            pl.col("train").first(),
            pl.col("distance_km", "running_s", "standing_s", "standing_kwh", *COLUMNS, *PARTS).sum(),
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


def _legs(run: Run) -> Table:
    """Every leg of every train."""
    return table_of(
        "energy_legs",
        run.tables.energy_legs.to_dicts(),
        {
            "train": (Kind.TRAIN, 0),
            "from_station": (Kind.PLACE, 0),
            "to_station": (Kind.PLACE, 0),
            "distance_km": (Kind.NUMBER, 2),
            "running_s": (Kind.NUMBER, 0),
            **_KWH,
        },
    )


_SAID: Final = ("figure", "unit", "source", "comparable")


def _opinion(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    """Our figures beside others'; nothing where there are none."""
    compared = facts["comparisons"]
    if not compared:
        return ()
    return (
        table_of(
            "opinion",
            [row | {name: words.opinion(row[name]).both for name in _SAID} for row in compared],
            {
                "figure": (Kind.SAID, 0),
                "ours": (Kind.NUMBER, 2),
                "theirs": (Kind.NUMBER, 2),
                "unit": (Kind.SAID, 0),
                "difference_percent": (Kind.SIGNED, 1),
                "source": (Kind.SAID, 0),
                "comparable": (Kind.SAID, 0),
            },
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
