"""What ran and what was planned, as the page draws it: thinned curves, calls, occupation of sections, the line."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from network.model import Alignment, Direction, Line
from network.timetable import AtPortal, BecomesTrain, FromTrain, Stabled
from study.report.data import ReportedRun, limits_mps, sections_in_order
from study.report.packing import packed_column, places_in
from study.report.thinning import kept_samples, strands

Floats = NDArray[np.float64]
KMH_PER_MPS: Final = 3.6
_END_WORDS: Final[Mapping[type, str]] = {
    AtPortal: "portal",
    Stabled: "stabled",
    FromTrain: "turns",
    BecomesTrain: "turns",
}
_TIME_PER_S: Final = 10  # the run's own step
_PLACE_PER_M: Final = 10
_SPEED_PER_KMH: Final = 10
_NOTCH_PER_NOTCH: Final = 10
_SHOWN_ABOVE_MAX: Final = 2.0  # a permitted speed above so many times the line's greatest says nothing more


@dataclass(frozen=True, slots=True)
class Fineness:
    """How far the page's curves may be from the run's samples, at the same time."""

    place_m: float
    speed_kmh: float
    notch: float


FINEST_FIRST: Final = (
    Fineness(1.0, 0.5, 0.25),
    Fineness(2.5, 1.0, 0.5),
    Fineness(5.0, 1.5, 1.0),
    Fineness(10.0, 3.0, 2.0),
    Fineness(20.0, 5.0, 4.0),
)


def courses_shown(run: ReportedRun, fineness: Fineness) -> list[dict[str, Any]]:
    """Every run of a train, in the order of `Run.courses`: time, place, speed; permitted and target speed; notch."""
    alignments = {alignment_id: i for i, alignment_id in enumerate(run.line.alignments)}
    of_piece = {piece.id: alignments[piece.alignment_id] for piece in run.line.pieces.values()}
    return [
        _course(run, unit, train, course, of_piece, fineness) for (unit, train), course in run.courses.items()
    ]


def bare_courses_shown(run: ReportedRun, fineness: Fineness, trains: Collection[str]) -> list[dict[str, Any]]:
    """Time and place alone of the runs of some trains."""
    tolerance = np.array([fineness.place_m - 0.5 / _PLACE_PER_M])
    found: list[dict[str, Any]] = []
    for (unit, train), course in run.courses.items():
        if train not in trains:
            continue
        t_s, at_m = course["t_s"].to_numpy(), course["kilometrage_m"].to_numpy()
        held = kept_samples(t_s, at_m[:, None], tolerance)
        times, places = packed_column(t_s[held], _TIME_PER_S), packed_column(at_m[held], _PLACE_PER_M)
        found.append({"unit": unit, "train": train, "t": times, "m": places})
    return found


def _course(
    run: ReportedRun,
    unit: str,
    train: str,
    course: pl.DataFrame,
    of_piece: Mapping[str, int],
    fineness: Fineness,
) -> dict[str, Any]:
    t_s = course["t_s"].to_numpy()
    at_m = course["kilometrage_m"].to_numpy()
    speed_kmh = course["speed_mps"].to_numpy() * KMH_PER_MPS
    axis = np.array([of_piece[piece] for piece in course["piece"]], dtype=np.int64)
    # What is rounded for the page takes its part of the tolerance.
    half_m, half_kmh = 0.5 / _PLACE_PER_M, 0.5 / _SPEED_PER_KMH
    tolerances = np.array([fineness.place_m - half_m, fineness.speed_kmh - half_kmh])
    chosen: list[int] = []
    cuts: list[list[int]] = []
    for part in strands(t_s, axis):
        cuts.append([len(chosen), int(axis[part.start])])
        curves = np.column_stack([at_m[part], speed_kmh[part]])
        chosen += (kept_samples(t_s[part], curves, tolerances) + part.start).tolist()
    braked = course["intervention"].to_numpy() != 0
    began = np.flatnonzero(braked & ~np.concatenate(([False], braked[:-1])))
    top_kmh = _SHOWN_ABOVE_MAX * run.line.max_speed_mps * KMH_PER_MPS
    shown: dict[str, Any] = {
        "unit": unit,
        "train": train,
        "direction": int(run.directions[train]),
        "t": packed_column(t_s[chosen], _TIME_PER_S),
        "m": packed_column(at_m[chosen], _PLACE_PER_M),
        "v": packed_column(speed_kmh[chosen], _SPEED_PER_KMH),
        "axes": cuts,
        "braked": [round(float(t), 1) for t in t_s[began]],
    }
    for name, column in (("permitted", "permitted_mps"), ("target", "target_mps")):
        values = course[column].to_numpy() * KMH_PER_MPS
        values = np.where(np.isfinite(values), np.minimum(values, top_kmh), np.nan)
        shown[name] = _curve(t_s, values, fineness.speed_kmh, _SPEED_PER_KMH)
    shown["notch"] = _curve(t_s, course["notch"].to_numpy(), fineness.notch, _NOTCH_PER_NOTCH)
    return shown


def _curve(t_s: Floats, values: Floats, tolerance: float, per_unit: int) -> dict[str, Any]:
    """A curve of its own over time; where it has a gap, a null stands at the time at which the gap begins."""
    times: list[float] = []
    found: list[float | None] = []
    for part in strands(values):
        if times:
            times.append(times[-1])
            found.append(None)
        held = (
            kept_samples(t_s[part], values[part][:, None], np.array([tolerance - 0.5 / per_unit]))
            + part.start
        )
        times += t_s[held].tolist()
        found += values[held].tolist()
    return {"t": packed_column(times, _TIME_PER_S), "v": packed_column(found, per_unit)}


def trains_shown(run: ReportedRun) -> list[dict[str, Any]]:
    """Every train planned or run, by the time at which it begins; calls as planned and as they went.

    A call is (station, track, kind, planned arrival and departure, arrival, departure, error at the mark); what ran
    is joined in the order in which the train came by.
    """
    came = run.tables.stops.filter(~pl.col("cancelled"))
    ran = {train: rows.to_dicts() for (train,), rows in came.group_by("train", maintain_order=True)}
    units = {number: d.stock_id for d in run.timetable.diagrams for number in d.train_numbers}
    units |= {train: unit for unit, train in run.courses}
    return [_train(run, number, ran.get(number, []), units.get(number)) for number in run.trains]


def _train(run: ReportedRun, number: str, went: list[dict[str, Any]], unit: str | None) -> dict[str, Any]:
    planned = run.timetable.trains.get(number)
    rows: list[tuple[Any, ...]] = []
    ahead = list(went)
    for call in planned.due_calls if planned else ():
        found = next((i for i, row in enumerate(ahead) if row["station"] == call.station_id), None)
        row: dict[str, Any] = {} if found is None else ahead.pop(found)
        track = row.get("track") or call.track
        plan = (float_of(call.arrival_s), float_of(call.departure_s))
        rows.append((call.station_id, track, call.kind.value, *plan, *_as_run(row)))
    for row in ahead:  # what ran and is not in the timetable
        plan = (row["planned_arrival_s"], row["planned_departure_s"])
        rows.append((row["station"], row["track"], "stop", *plan, *_as_run(row)))
    columns = list(zip(*rows, strict=True)) if rows else [()] * 8
    revenue = planned.revenue if planned else bool(went and went[0]["revenue"])
    return {
        "number": number,
        "unit": unit,
        "direction": int(run.directions[number]),
        "revenue": revenue,
        "planned": planned is not None,
        "begins": _END_WORDS[type(planned.begins)] if planned else None,
        "ends": _END_WORDS[type(planned.ends)] if planned else None,
        "station": list(columns[0]),
        "track": list(columns[1]),
        "kind": list(columns[2]),
        **{
            name: packed_column(values, 1000 if name == "error" else 10)
            for name, values in zip(("pa", "pd", "a", "d", "error"), columns[3:], strict=True)
        },
    }


def float_of(value: float | None) -> float | None:
    """The same as a float."""
    return None if value is None else float(value)


def _as_run(row: Mapping[str, Any]) -> tuple[float | None, float | None, float | None]:
    return row.get("arrival_s"), row.get("departure_s"), row.get("stop_error_m")


def sections_shown(run: ReportedRun) -> list[dict[str, Any]]:
    """Sections by place: name, kind, kilometrage from and to."""
    found: list[dict[str, Any]] = []
    for section in sections_in_order(run):
        pieces = [run.line.pieces[piece] for piece in section.piece_ids]
        found.append(
            {
                "id": section.id,
                "kind": section.kind.value,
                "station": section.station_id,
                "track": section.track,
                "from": min((piece.from_m for piece in pieces), default=0.0),
                "to": max((piece.to_m for piece in pieces), default=0.0),
            }
        )
    return found


def blocks_shown(run: ReportedRun) -> dict[str, Any]:
    """What was held and what was occupied, by the time of the grant; the other times from there, whole seconds."""
    known = run.tables.blocks.filter(pl.col("section").is_in(list(run.line.sections)))
    blocks = known.sort("granted_s", maintain_order=True)
    after = [pl.col(name) - pl.col("granted_s") for name in ("released_s", "entered_s", "cleared_s")]
    blocks = blocks.with_columns(after)
    sections, at = places_in(blocks["section"].to_list())
    units, by = places_in(blocks["unit"].to_list())
    trains, of = places_in(blocks["train"].to_list())
    return {
        "sections": sections,
        "units": units,
        "trains": trains,
        "section": at,
        "unit": by,
        "train": of,
        "granted": packed_column(blocks["granted_s"], 1),
        **{name: _plain(blocks[f"{name}_s"]) for name in ("released", "entered", "cleared")},
    }


def _plain(values: pl.Series) -> list[int | None]:
    return [None if value is None else round(value) for value in values]


def devices_shown(line: Line) -> dict[str, float]:
    """Where each point terminal is, m: in the middle of the stems that it throws, for the marks of its events."""
    stems: dict[str, list[float]] = {}
    for points in line.points.values():
        stem = line.pieces[points.stem_piece]
        stems.setdefault(points.terminal_id, []).append((stem.from_m + stem.to_m) / 2)
    return {terminal: sum(at_m) / len(at_m) for terminal, at_m in stems.items()}


def line_shown(line: Line) -> dict[str, Any]:
    """The line: names, stations by kilometrage with their tracks, axes with limits, gradients and curves."""
    stations = sorted(line.stations.values(), key=lambda station: station.position_m)
    return {
        "name": line.name,
        "ja": line.name_ja,
        "max_kmh": round(line.max_speed_mps * KMH_PER_MPS, 2),
        "stations": [
            {
                "id": station.id,
                "name": station.name,
                "ja": station.name_ja,
                "m": station.position_m,
                "halt": station.is_halt,
                "signal": station.is_signal_station,
                "tracks": [track.name for track in station.tracks],
                "marks": sorted({m for track in station.tracks for m in track.marks_m.values()}),
            }
            for station in stations
        ],
        **_crossings(line),
        "axes": [_axis(line, alignment) for alignment in line.alignments.values()],
    }


def _crossings(line: Line) -> dict[str, Any]:
    """Level crossings by kilometrage; a line without any says nothing."""
    along = sorted(line.crossings.values(), key=lambda crossing: crossing.position_m)
    return {"crossings": [{"id": c.id, "name": c.name, "m": c.position_m} for c in along]} if along else {}


def _axis(line: Line, alignment: Alignment) -> dict[str, Any]:
    limits: dict[str, list[list[float]]] = {}
    for direction in Direction:
        breaks_m, speed_mps = limits_mps(line, alignment, direction)
        limits[str(int(direction))] = [
            [float(m), round(float(v) * KMH_PER_MPS, 2)] for m, v in zip(breaks_m, speed_mps, strict=True)
        ]
    return {
        "id": alignment.id,
        "from": alignment.from_m,
        "to": alignment.to_m,
        "limits": limits,
        "gradients": [[g.from_m, g.to_m, g.permille] for g in alignment.gradients],
        "curves": [[c.from_m, c.to_m, c.radius_m, c.transition_m] for c in alignment.curves],
    }
