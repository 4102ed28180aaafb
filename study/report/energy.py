"""The report on energy: what was drawn and given back, by what, where, and beside whose figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import polars as pl

from study.report.charts import draw_energy
from study.report.data import Run
from study.report.parts import Fact, Grid, Part, signed
from study.report.style import clock, svg_of
from vehicle.train_file import Receiver

RECEIVERS: Final[Mapping[str, str]] = {
    Receiver.BATTERY.value: "the train's own battery",
    Receiver.OTHER_TRAINS.value: "other trains on the wire (assumed: all of it)",
    Receiver.SUBSTATION.value: "the substation",
    Receiver.RESISTORS.value: "resistors, from which nothing comes back",
}
KINDS: Final = ("traction", "auxiliary", "regenerated", "net")
COLUMNS: Final = tuple(f"{kind}_kwh" for kind in KINDS)


def energy_fact(facts: Mapping[str, Any], tables_energy: pl.DataFrame) -> Fact:
    """Net energy of the day in one line."""
    energy = facts["energy"]
    whole, per_km, per_car = energy["all"], energy["net_kwh_per_train_km"], energy["net_kwh_per_car_km"]
    text = (
        f"{whole['net']:,.1f} kWh net {drawn_at(tables_energy)}: traction {whole['traction']:,.1f},"
        f" auxiliary {whole['auxiliary']:,.1f}, regenerated {whole['regenerated']:,.1f}"
    )
    if per_km["all"] is not None:
        text += (
            f"; {per_km['trains']:.2f} kWh/train-km ({per_car['trains']:.2f} per car-km),"
            f" {per_km['all']:.2f} ({per_car['all']:.2f}) with layovers"
        )
    return Fact("Energy", text)


def drawn_at(energy: pl.DataFrame) -> str:
    """Where energy is counted: at the wire, or at the battery of trains that regenerate into their own."""
    receivers = set(energy["regenerated_to"])
    if receivers == {Receiver.BATTERY.value}:
        return "at the battery"
    return "at the wire or battery" if Receiver.BATTERY.value in receivers else "at the wire"


def energy_parts(run: Run, facts: Mapping[str, Any]) -> tuple[Part, ...]:
    """Energy by train, by phase, by leg and layover, and the second opinion."""
    tables = run.tables
    if tables.energy.is_empty():
        return (Part("Energy by train", "Nothing to show: the run has none."),)
    figure = draw_energy(run)
    caption = (
        f"kWh {drawn_at(tables.energy)}, from where a train begins to move to where it ends; layovers are counted"
        " below. Figures above the bars: net kWh per train-km. Numbers in brackets carry no passengers."
    )
    parts = [
        Part(
            "Energy by train",
            caption,
            () if figure is None else (svg_of(figure, "energy"),),
            _sums(facts),
        ),
        Part(
            "Energy by leg",
            "All trains of the day between two places where they stop, with the stop at the end.",
            grids=(_leg_grid(run),),
            folded="kWh by leg and direction; each train's own are in energy_legs.parquet",
        ),
        Part(
            "Energy in layovers",
            "Stock that stands where one of its trains ends and the next begins: the auxiliaries go on. Stock stabled"
            " after its last train is taken to be switched off.",
            grids=(_layover_grid(run),),
            folded="Every layover",
        ),
    ]
    return (*parts, *_opinion(facts))


def _sums(facts: Mapping[str, Any]) -> tuple[Grid, ...]:
    energy = facts["energy"]
    names = (
        ("trains, running", "running"),
        ("trains, standing", "standing"),
        ("layovers", "layovers"),
        ("all", "all"),
    )
    rows = tuple((text, *(f"{energy[key][kind]:,.1f}" for kind in KINDS)) for text, key in names)
    grids = [Grid(("kWh", *KINDS), rows, numbers_from=1)]
    per_km = tuple(
        (unit, f"{energy[km]:,.1f}", *(f"{energy[key][which]:.2f}" for which in ("trains", "all")))
        for unit, km, key in (
            ("train-km", "train_km", "net_kwh_per_train_km"),
            ("car-km", "car_km", "net_kwh_per_car_km"),
        )
        if energy[key]["all"] is not None
    )
    grids.append(Grid(("per", "km", "net kWh, trains", "with layovers"), per_km, numbers_from=1))
    taken = tuple((RECEIVERS[receiver], f"{kwh:,.1f}") for receiver, kwh in energy["regenerated_to"].items())
    grids.append(Grid(("regenerated energy is taken by", "kWh"), taken, numbers_from=1))
    return tuple(grids)


def _leg_grid(run: Run) -> Grid:
    """A row a leg, DOWN before UP, along the line."""
    sums = (
        run.tables.energy_legs.group_by("from_station", "to_station", maintain_order=True)
        .agg(
            pl.len().alias("trains"),
            pl.col("train").first(),
            pl.col("distance_km", "running_s", "standing_s", "standing_kwh", *COLUMNS).sum(),
        )
        .iter_rows(named=True)
    )
    order = {station.id: station.position_m for station in run.stations}

    def place(row: dict[str, Any]) -> tuple[int, float]:
        direction = run.directions[row["train"]]
        at_m = order.get(row["from_station"], -direction * float("inf"))
        return -int(direction), direction * at_m

    rows = tuple(
        (
            f"{place_name(run, row['from_station'])} – {place_name(run, row['to_station'])}",
            str(row["trains"]),
            f"{row['distance_km']:,.1f}",
            *(f"{row[column]:,.1f}" for column in COLUMNS),
            f"{row['standing_kwh']:,.1f}",
            f"{row['net_kwh'] / row['distance_km']:.2f}" if row["distance_km"] > 0.0 else "–",
        )
        for row in sorted(sums, key=place)
    )
    header = ("leg", "trains", "train-km", *KINDS, "of it standing", "net per train-km")
    return Grid(header, rows, numbers_from=1)


def _layover_grid(run: Run) -> Grid:
    rows = tuple(
        (
            row["unit"],
            place_name(run, row["station"]),
            row["after_train"] or "–",
            row["before_train"] or "–",
            clock(row["from_s"], seconds=True),
            clock(row["to_s"], seconds=True),
            *(f"{row[column]:,.1f}" for column in COLUMNS),
        )
        for row in run.tables.layovers.iter_rows(named=True)
    )
    header = ("unit", "at", "after train", "before train", "from", "to", *KINDS)
    return Grid(header, rows, numbers_from=4)


def place_name(run: Run, place: str) -> str:
    """A station's name; a portal section's id."""
    station = run.line.stations.get(place)
    return place if station is None else station.name


def _opinion(facts: Mapping[str, Any]) -> tuple[Part, ...]:
    """Our figures beside others'; nothing where there are none."""
    compared = facts["comparisons"]
    if not compared:
        return ()
    rows = tuple(
        (
            row["figure"],
            f"{row['ours']:,.{_digits(row['theirs'])}f}",
            f"{row['theirs']:,.{_digits(row['theirs'])}f}",
            row["unit"],
            signed(row["difference_percent"], 1, "%"),
            row["source"],
            row["comparable"],
        )
        for row in compared
    )
    header = ("figure", "ours", "theirs", "unit", "difference", "source", "what is comparable, what not")
    return (
        Part(
            "A second opinion on energy",
            "The running resistance by another published formula, the day's traction with it on the same speeds, and"
            " consumption beside public figures. None of these sources describes this line on this day.",
            grids=(Grid(header, rows, numbers_from=1, numbers_to=3),),
            notes=meanings(compared),
        ),
    )


def meanings(compared: list[Mapping[str, Any]]) -> tuple[str, ...]:
    """What the differences mean, a sentence each."""
    by_figure = {row["figure"]: row for row in compared}
    found: list[str] = []
    traction = by_figure.get("traction of the day on the same speeds")
    if traction is not None:
        kwh, percent = traction["ours"] - traction["theirs"], traction["difference_percent"]
        more = "more" if kwh >= 0.0 else "less"
        found.append(
            f"With the train file's resistance the day takes {abs(kwh):,.0f} kWh ({abs(percent):.1f} %) {more} traction"
            " than with the other formula: the day's traction is known no better than that."
        )
    for row in compared:
        if row["figure"].endswith("less than"):
            kept = row["ours"] < row["theirs"]
            found.append(
                f"{row['ours']:.2f} kWh per train-km lies {'within' if kept else 'ABOVE'} the bound of"
                f" {row['theirs']:.2f}{'; a bound shows no more than that' if kept else ': something is wrong here'}."
            )
        elif row["unit"] == "kWh per car-km":
            less = "below" if row["ours"] < row["theirs"] else "above"
            found.append(
                f"Per car-km we lie {abs(row['difference_percent']):.0f} % {less} {row['figure']}: the order of"
                " magnitude agrees; with other trains, speeds, loads and losses more cannot be said."
            )
    if not any(row["unit"] == "kWh per car-km" for row in compared):
        found.append("No public figure stands beside a day on which not every train arrived.")
    return tuple(found)


def _digits(value: float) -> int:
    return 2 if abs(value) < 10.0 else 0
