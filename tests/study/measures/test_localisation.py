"""Figures of localisation, from tables made by hand."""

import math
from dataclasses import replace
from typing import Any

import polars as pl
import pytest

from study.measures.localisation import FOUND, LOST, known_positions, localisation_summary, lost_between
from study.record.figure import schema_of
from study.record.tables import ROWS, RunTables, make_table


def tables(events: list[tuple[float, str, str]]) -> RunTables:
    """A train of ten seconds whose bounds grow by a metre a second either way, and its error by 0.1 m."""
    empty = RunTables(**{name: make_table(name) for name in ROWS})
    rows: dict[str, Any] = {name: [0.0] * 10 for name in schema_of(ROWS["trajectory"])}
    rows |= {"t_s": [float(t) for t in range(10)], "unit": ["V1"] * 10, "train": ["321M"] * 10}
    rows |= {"direction": [1] * 10, "piece": ["P"] * 10, "intervention": [0] * 10}
    rows["bound_ahead_m"] = rows["bound_behind_m"] = [float(t) for t in range(10)]
    rows["estimate_error_m"] = [-0.1 * t for t in range(10)]
    told = {
        "t_s": [e[0] for e in events],
        "source": [e[1] for e in events],
        "kind": [e[2] for e in events],
        "text": [""] * len(events),
        "text_ja": [""] * len(events),
    }
    return replace(empty, trajectory=make_table("trajectory", rows), events=make_table("events", told))


def test_half_widths_and_the_largest_error() -> None:
    summary = localisation_summary(tables([]), {"V1": {"gnss": 7, "curvature": 0}})
    assert summary["half_width_m_median"] == pytest.approx(4.5)
    assert summary["error_m_max"] == pytest.approx(0.9)
    assert summary["trains"]["321M"]["half_width_m_p95"] == pytest.approx(8.55)
    assert summary["fixes"] == {"V1": {"gnss": 7}}
    assert summary["lost_s"] == {"V1": 0.0}


def test_while_it_does_not_know_where_it_is_nothing_counts() -> None:
    run = tables([(5.0, "V1", LOST), (8.0, "V1", FOUND), (2.0, "world", LOST)])
    assert known_positions(run)["t_s"].to_list() == [0.0, 1.0, 2.0, 3.0, 4.0, 9.0]
    assert localisation_summary(run, {})["lost_s"] == {"V1": 3.0}


def test_one_that_never_finds_it_has_lost_it_to_the_end() -> None:
    run = tables([(5.0, "V1", LOST), (6.0, "V1", LOST)])
    assert lost_between(run.events, "V1") == [(5.0, math.inf)]
    assert localisation_summary(run, {})["lost_s"] == {"V1": 4.0}


def test_a_run_without_a_train_that_moved_has_no_figures() -> None:
    run = tables([])
    summary = localisation_summary(replace(run, trajectory=run.trajectory.filter(pl.lit(value=False))), {})
    assert summary["half_width_m_median"] is None
    assert summary["trains"] == {}
