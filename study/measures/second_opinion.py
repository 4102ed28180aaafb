"""A second opinion on energy: our figures beside those of another formula, and of other people."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import polars as pl

from network.units import J_PER_KWH
from simulation.result import RunResult
from simulation.setup import Setup
from study.measures.public_figures import PUBLIC_FIGURES, FigureBasis
from study.measures.replayed import (
    KMH_PER_MPS,
    Resistance,
    jr_resistance_n,
    mass_kg,
    own_resistance_n,
    traction_j,
)
from study.record.journal_rows import ComparedFigure
from study.record.tables import make_table
from vehicle.train_file import TrainType

JR_SOURCE = (
    "1.32 + 0.0164 V + (0.028 + 0.0078 n) V²/W kgf/t, the formula published for JR's electric multiple units"
)
SPEEDS_KMH = (20.0, 40.0)


def _beside(
    figure: str, unit: str, ours: float, theirs: float, source: str, comparable: str
) -> ComparedFigure:
    return ComparedFigure(figure, ours, theirs, unit, 100.0 * (ours / theirs - 1.0), source, comparable)


def comparisons_of(
    result: RunResult, setup: Setup, energy: pl.DataFrame, layovers: pl.DataFrame
) -> pl.DataFrame:
    """The table comparisons of a run: resistance, traction on the same speeds, kWh per car-km and train-km."""
    kinds = {kind.id: kind for stock_id, kind in sorted(setup.trains.items()) if stock_id in result.stock_ids}
    rows = [row for kind in kinds.values() for row in _forces(kind, setup)]
    rows += _replays(
        result, setup, float(energy["traction_kwh"].sum()) + float(layovers["traction_kwh"].sum())
    )
    planned = (*result.trains_planned, *result.empty_planned)
    # stuck trains stand, and use energy for no km
    if set(planned) == {*result.trains_arrived, *result.empty_arrived}:
        rows += _public(setup, energy, layovers)
    return make_table("comparisons", rows)


def _forces(kind: TrainType, setup: Setup) -> Iterator[ComparedFigure]:
    """Running resistance with the mean load, to the greatest speed that the line and the train allow."""
    mass = mass_kg(kind, setup.load.load_share_mean)
    top_kmh = min(setup.line.max_speed_mps, float(kind.row[0]["speed_max_mps"])) * KMH_PER_MPS
    for speed_kmh in sorted({*(speed for speed in SPEEDS_KMH if speed < top_kmh), round(top_kmh, 3)}):
        at_mps = np.array([speed_kmh / KMH_PER_MPS])
        yield _beside(
            f"running resistance of {kind.id} at {speed_kmh:g} km/h",
            "N",
            float(own_resistance_n(kind, mass, at_mps)[0]),
            float(jr_resistance_n(kind, mass, at_mps)[0]),
            JR_SOURCE,
            f"the same train of {mass / 1000.0:.1f} t on straight level track; both are planning formulas, set high",
        )


def _replays(result: RunResult, setup: Setup, booked_kwh: float) -> Iterator[ComparedFigure]:
    """The day's traction from the trace: with our resistance, as a check of the method, and with the other."""

    def kwh(resistance: Resistance) -> float:
        return traction_j(result, setup.line, setup.trains, resistance) / J_PER_KWH

    own_kwh, jr_kwh = kwh(own_resistance_n), kwh(jr_resistance_n)
    if min(own_kwh, jr_kwh) <= 0.0:
        return
    yield _beside(
        "traction of the day as booked",
        "kWh",
        booked_kwh,
        own_kwh,
        "worked out again from the trace of a second with our own resistance",
        "the same day; what differs is the method: powering and coasting within one second, starting resistance",
    )
    yield _beside(
        "traction of the day on the same speeds",
        "kWh",
        own_kwh,
        jr_kwh,
        JR_SOURCE,
        "the same day by the same method: what differs is the running resistance alone",
    )


def _public(setup: Setup, energy: pl.DataFrame, layovers: pl.DataFrame) -> Iterator[ComparedFigure]:
    train_km = float(energy["distance_km"].sum())
    if train_km <= 0.0:
        return
    car_km = float((energy["distance_km"] * energy["cars"]).sum())
    trains_kwh, stays_kwh = float(energy["net_kwh"].sum()), float(layovers["net_kwh"].sum())
    ours = {
        FigureBasis.CAR_KM: (trains_kwh + stays_kwh) / car_km,
        FigureBasis.TRAIN_KM: trains_kwh / train_km,
    }
    run = {setup.trains[stock_id].id for stock_id in energy["unit"]}
    for figure in PUBLIC_FIGURES:
        if figure.train_id and run != {figure.train_id}:
            continue
        name = f"{figure.name}, less than" if figure.bound else figure.name
        yield _beside(name, figure.per.value, ours[figure.per], figure.kwh, figure.source, figure.comparable)
