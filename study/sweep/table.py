"""What a sweep shows, as tables: points with intervals, differences from the first point, effects of each axis."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from study.sweep.figures import FIGURES, DayFigure
from study.sweep.go import SweepProgress
from study.sweep.plan import GridPoint
from study.sweep.records import DayOutcome, DayRecord
from study.sweep.statistics import QUANTILES, FigureEstimate, difference_of, mean_of, quantile_of, share_of
from study.sweep.worker import replay_command


@dataclass(frozen=True, slots=True)
class FigureRow:
    """One figure at one point: its mean, its quantiles by share, and by how much it differs from the first point."""

    figure: DayFigure
    mean: FigureEstimate
    quantiles: Mapping[float, FigureEstimate]
    less_first: FigureEstimate

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "mean": self.mean.as_dict(),
            "quantiles": {f"{share:g}": found.as_dict() for share, found in self.quantiles.items()},
            "less_first_point": self.less_first.as_dict(),
        }


@dataclass(frozen=True, slots=True)
class PointRow:
    """A point of the grid: its days by outcome, and its figures."""

    point: GridPoint
    days: int
    stopped_early: bool
    outcomes: Mapping[DayOutcome, FigureEstimate]
    counts: Mapping[DayOutcome, int]
    figures: Mapping[str, FigureRow]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "point": self.point.number,
            "label": self.point.label,
            "days": self.days,
            "stopped_early": self.stopped_early,
            "outcomes": {
                outcome.name.lower(): {"days": self.counts[outcome], "share": found.as_dict()}
                for outcome, found in self.outcomes.items()
            },
            "figures": {name: row.as_dict() for name, row in self.figures.items()},
        }


@dataclass(frozen=True, slots=True)
class Effect:
    """What one place of an axis does to a figure: its mean over all points there, less that of the axis's first place.

    Seed by seed, over those seeds that all these points have.
    """

    axis: str
    place: str
    figure: DayFigure
    less_first: FigureEstimate


def value_of(record: DayRecord, name: str) -> float | None:
    """A figure of a day; None where it has none."""
    return None if record.figures is None else FIGURES[name].of(record.figures)


def point_rows(state: SweepProgress) -> tuple[PointRow, ...]:
    """All points, in the order of the grid."""
    if not state.plan.points:
        return ()
    first = {record.index: record for record in state.days_counted(state.plan.points[0])}
    return tuple(_point_row(state, point, first) for point in state.plan.points)


def _point_row(state: SweepProgress, point: GridPoint, first: Mapping[int, DayRecord]) -> PointRow:
    confidence = state.plan.confidence
    records = state.days_counted(point)
    counts = Counter(record.outcome for record in records)
    rows: dict[str, FigureRow] = {}
    for name, figure in FIGURES.items():
        values = [value for record in records if (value := value_of(record, name)) is not None]
        pairs = [
            (before, after)
            for record in records
            if record.index in first
            and (before := value_of(first[record.index], name)) is not None
            and (after := value_of(record, name)) is not None
        ]
        quantiles = {share: quantile_of(values, share, confidence) for share in QUANTILES}
        rows[name] = FigureRow(
            figure, mean_of(values, confidence), quantiles, difference_of(pairs, confidence)
        )
    return PointRow(
        point,
        len(records),
        state.stopped_early(point),
        {outcome: share_of(counts[outcome], len(records), confidence) for outcome in DayOutcome},
        counts,
        rows,
    )


def effects(state: SweepProgress, name: str) -> tuple[Effect, ...]:
    """What each place of each axis does to a figure; the first place of an axis is what it is compared with."""
    by_point = [
        {
            record.index: value
            for record in state.days_counted(point)
            if (value := value_of(record, name)) is not None
        }
        for point in state.plan.points
    ]
    found: list[Effect] = []
    for number, axis in enumerate(state.plan.axes):
        sides = [
            [by_point[point.number] for point in state.plan.points if point.places[number] == place]
            for place in range(len(axis.places))
        ]
        for place, side in zip(axis.places[1:], sides[1:], strict=True):
            of_all = [frozenset(days) for days in (*sides[0], *side)]
            common = sorted(index for index in of_all[0] if all(index in days for days in of_all))
            pairs = [(_mean_on(sides[0], index), _mean_on(side, index)) for index in common]
            estimate = difference_of(pairs, state.plan.confidence)
            found.append(Effect(axis.name, place.label, FIGURES[name], estimate))
    return tuple(found)


def _mean_on(side: Sequence[Mapping[int, float]], index: int) -> float:
    return sum(days[index] for days in side) / len(side)


def summary_of(state: SweepProgress, out: Path) -> dict[str, Any]:
    """All of a sweep for JSON; `cpu_s` and `wall_s` are of the days run now, all processes together."""
    plan = state.plan
    return {
        "sweep": plan.table.id,
        "out": str(out),
        "scenario": plan.table.scenario,
        "carrier": state.carriers,
        "confidence": plan.table.confidence,
        "days": state.there,
        "days_before": state.before,
        "days_run": state.run,
        "days_of_others": state.others,
        "refused": [f"{refused.name}: {refused.why}" for refused in state.refused],
        "again_on_sumo": sum(bool(r.again) for p in plan.points for r in state.days_counted(p)),
        "failures": list(state.failures),
        "points": [row.as_dict() for row in point_rows(state)],
        "effects": [
            {"axis": e.axis, "place": e.place, "figure": name, "less_first_place": e.less_first.as_dict()}
            for name in plan.table.watch
            for e in effects(state, name)
        ],
        "cpu_s": round(state.cpu_s, 1),
        "wall_s": round(state.wall_s, 1),
        "peak_bytes": state.peak_bytes,
    }


def days_csv(state: SweepProgress) -> str:
    """A row a day that counts, by point and seed: the same text wherever the days were run."""
    axes = [axis.name for axis in state.plan.axes]
    head = ("point", *axes, "index", "seed", "outcome", *FIGURES, "digest", "again", "why", "replay")

    def rows() -> Iterable[Sequence[object]]:
        for point in state.plan.points:
            places = [axis.places[n].label for axis, n in zip(state.plan.axes, point.places, strict=True)]
            for record in state.days_counted(point):
                figures = [value_of(record, name) for name in FIGURES]
                yield (
                    *(point.number, *places, record.index, record.spec.seed, record.outcome.name.lower()),
                    *figures,
                    *(record.digest, record.again, record.why, replay_command(record.spec)),
                )

    return csv_of(head, rows())


def points_csv(rows: Sequence[PointRow]) -> str:
    """A row a point and figure."""
    quantiles = [f"q{share:g}{end}" for share in QUANTILES for end in ("", "_low", "_high")]
    head = ("point", "label", "days", "figure", "mean", "mean_low", "mean_high", *quantiles)
    head = (*head, "less_first", "less_first_low", "less_first_high")

    def cells() -> Iterable[Sequence[object]]:
        for row in rows:
            for name, figure in row.figures.items():
                found = [x for e in figure.quantiles.values() for x in (e.value, e.low, e.high)]
                less = figure.less_first
                mean = figure.mean
                yield (
                    *(row.point.number, row.point.label, mean.days, name, mean.value, mean.low, mean.high),
                    *found,
                    *(less.value, less.low, less.high),
                )

    return csv_of(head, cells())


def csv_of(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table with commas between cells."""
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return stream.getvalue()
