"""One hop of one train as several runs drove it: a law each (運転制御の比較)."""

from __future__ import annotations

from collections import Counter

import polars as pl
from matplotlib.figure import Figure

from study.plot.choice import ChosenRun
from study.record.directory import labels_of
from study.record.read_back import RunRead
from study.report.data import ReportedRun
from study.report.hop import draw_hop, driving_of


def _runs_shown(run: ChosenRun) -> list[tuple[str, RunRead]]:
    """All runs by the ids of their scenarios, by their directories where two have the same."""
    reads = (run.read, *run.choice.beside)
    names = tuple(str(read.settings.id) for read in reads)
    if len(set(names)) < len(names):
        names = labels_of([read.directory for read in reads])
    return list(zip(names, reads, strict=True))


def hops_table(run: ChosenRun) -> pl.DataFrame:
    """The table `driving` of all runs shown, of the train and the station where the hop begins, with the run's name."""
    choice = run.choice
    tables = [
        read.tables.driving.select(pl.lit(name).alias("run"), pl.all()) for name, read in _runs_shown(run)
    ]
    table = pl.concat(tables)
    if choice.train is not None:
        table = table.filter(pl.col("train") == choice.train)
    return table if choice.station is None else table.filter(pl.col("from_station") == choice.station)


def draw_laws(run: ChosenRun) -> Figure | None:
    """The hop that begins at the station chosen, else the train's first; None where no run has it.

    A run goes by its law, by its own name where several were driven by the same.
    """
    train = run.choice.train
    if train is None:
        return None
    found = [
        (name, driving_of(ReportedRun(read.line, read.timetable, read.tables), train, run.choice.station))
        for name, read in _runs_shown(run)
    ]
    known = [(name, one) for name, one in found if one is not None]
    laws = Counter(one.label for _, one in known)
    named = [one if laws[one.label] == 1 else one.called(f"{one.label}, {name}") for name, one in known]
    return draw_hop(run, named) if named else None
