"""The plots of headways and of occupation by part of the line, from the blocking times of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import polars as pl
from matplotlib.figure import Figure

from study.capacity.blocking_table import read_blocking
from study.capacity.cut import WAYS, cut_of
from study.capacity.headway import HeadwayCase, line_cases
from study.capacity.legs import legs_of, places_of
from study.capacity.line_capacity import PEAK_S, CompressionTerms, Period, Rate, day_of, peak_of, rates_of
from study.plot.choice import ChosenRun
from study.record.setup_back import setup_of
from study.report.capacity import draw_occupation
from study.report.headways import draw_matrix, headway_table


def _cases(run: ChosenRun) -> tuple[HeadwayCase, ...]:
    found = line_cases(run.line, read_blocking(run.tables.blocking), setup_of(run.read).unit.dwell_min_s)
    return tuple(case for case in found if run.choice.station in (None, case.station_id))


def headways_table(run: ChosenRun) -> pl.DataFrame:
    """A row two kinds of trains at a station."""
    return headway_table(_cases(run))


def draw_headways(run: ChosenRun) -> Figure | None:
    """A matrix a station; none where no two trains need one section."""
    return draw_matrix(run.line, _cases(run))


def _rates(run: ChosenRun) -> dict[str, Sequence[Rate]]:
    """Occupancy by way of cutting: of the day and its peak, or of the time chosen."""
    legs = legs_of(read_blocking(run.tables.blocking), places_of(run.line))
    if not legs:
        return {}
    periods: Iterable[Period]
    if run.choice.from_s is None and run.choice.to_s is None:
        day = day_of(legs)
        periods = (day, peak_of(legs, day)) if day.length_s > PEAK_S else (day,)
    else:
        periods = (Period("chosen", *run.window_s, peak=False),)
    terms = CompressionTerms(dwell_min_s=setup_of(run.read).unit.dwell_min_s)
    return {name: rates_of(legs, cut_of(run.line, name), tuple(periods), terms) for name in WAYS}


def occupation_table(run: ChosenRun) -> pl.DataFrame:
    """A row a part of the line, period and way of cutting."""
    rows: list[dict[str, Any]] = [
        {"cut": name, **rate.as_dict()} for name, rates in _rates(run).items() for rate in rates
    ]
    return pl.DataFrame(rows, infer_schema_length=None)


def draw_occupations(run: ChosenRun) -> Figure | None:
    """A panel a way of cutting, beside the limits of UIC 406."""
    return draw_occupation(_rates(run))
