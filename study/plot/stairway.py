"""The plot of blocking times: those of the run, with the conflicts that theory finds in its plan."""

from __future__ import annotations

import polars as pl
from matplotlib.figure import Figure

from study.capacity.blocking_table import read_blocking
from study.capacity.occupation import Occupation, conflicts_of
from study.capacity.table import blocking_times
from study.capacity.theory import occupations
from study.plot.choice import ChosenRun
from study.record.setup_back import setup_of
from study.report.stairway import draw_stairway


def _shown(run: ChosenRun) -> tuple[Occupation, ...]:
    found = read_blocking(run.tables.blocking)
    return tuple(one for one in found if run.choice.train in (None, one.number))


def stairway_table(run: ChosenRun) -> pl.DataFrame:
    """A row an occupation, a column a part."""
    return run.within(blocking_times(_shown(run)), "begin_s", "end_s")


def draw_stairway_of(run: ChosenRun) -> Figure | None:
    """The stairway of the choice."""
    conflicts = conflicts_of(occupations(setup_of(run.read)))
    number = run.choice.train
    own = [c for c in conflicts if number is None or number in (c.first.number, c.second.number)]
    return draw_stairway(run, _shown(run), own, language=run.choice.language)
