"""What a comparison says in sentences, writes into files and draws."""

import csv
import json
import re
from pathlib import Path

import polars as pl
import pytest

from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from study.compare.comparison import Comparisons, compare, verdict_of
from study.compare.files import owns_file, write_comparison
from study.compare.graph import draw_both
from study.compare.parts import parts_against
from study.compare.side import ComparedRun, check_same_line
from study.record.directory import labels_of
from study.report.data import ReportedRun
from study.report.style import drawing
from tests.study.compare.sides import side, with_tables


def later(run: ReportedRun, by_s: float, train: str = "321M") -> ReportedRun:
    """One train later at every station, plan and all its samples."""
    own = pl.col("train") == train
    stops = run.tables.stops.with_columns(
        pl.when(own).then(pl.col(c) + by_s).otherwise(pl.col(c)).alias(c)
        for c in ("arrival_s", "departure_s")
    )
    samples = run.tables.trajectory.with_columns(
        pl.when(own).then(pl.col("t_s") + by_s).otherwise(pl.col("t_s")).alias("t_s")
    )
    return with_tables(run, stops=stops, trajectory=samples)


def without(run: ReportedRun, train: str) -> ReportedRun:
    """A run in which one train did not run."""
    kept = {
        name: getattr(run.tables, name).filter(pl.col("train") != train)
        for name in ("stops", "trajectory", "energy")
    }
    return with_tables(run, **kept)


@pytest.fixture
def moved(weekday: ReportedRun) -> Comparisons:
    return compare((side(weekday), side(later(weekday, 25.0), "new")), 1.0)


def verdict(*sides: ComparedRun, over_s: float = 1.0) -> str:
    return " ".join(verdict_of(compare(sides, over_s).pairs[0]))


def test_nothing_moved_is_said_as_plainly_as_that(weekday: ReportedRun) -> None:
    base = side(weekday)
    again = side(weekday, "again", digest="base")
    assert verdict(base, again) == (
        "Nothing differs at all, from the same inputs: the journals of both runs are the same."
    )
    count = sum(weekday.tables.stops[f"{what}_s"].count() for what in ("arrival", "departure"))
    hardly = side(later(weekday, 0.9), "new")
    assert verdict(base, hardly) == (
        f"Nothing moved by more than 1 s: {count} arrivals and departures compared,"
        " the largest difference is 0.9 s. No meet moved."
    )
    told = verdict(base, hardly, over_s=0.5)
    assert told.startswith(
        f"14 of {count} arrivals and departures moved by more than 0.5 s, 14 later and 0 earlier"
    )


def test_the_same_journal_with_other_tables_is_not_the_same_run(weekday: ReportedRun) -> None:
    """The figures of a run may change, with a train's energy data, though it ran the same."""
    energy = weekday.tables.energy.with_columns(pl.col("net_kwh") * 2.0)
    other = side(with_tables(weekday, energy=energy), "new", digest="base")
    same_tables = side(weekday, "new")
    for one in (other, same_tables):
        assert verdict(side(weekday), one).startswith("Nothing moved by more than 1 s")


def test_what_moved_what_is_gone_and_what_is_broken_is_said(weekday: ReportedRun) -> None:
    base = side(weekday, broken=("a points-under-train", "both"))
    told = verdict(base, side(without(weekday, "330M"), "new", broken=("both", "a collision")))
    assert "Nothing moved by more than 1 s" in told
    assert "Only in base: train 330M." in told
    assert "Broken only in new: a collision." in told and "Broken only in base: a points-under-train." in told


def test_json_has_all_of_it_and_only_what_json_knows(moved: Comparisons, weekday: ReportedRun) -> None:
    told = json.loads(json.dumps(moved.as_dict(), allow_nan=False))
    (pair,) = told["comparisons"]
    assert [run["label"] for run in told["runs"]] == ["base", "new"]
    assert {row["train"] for row in pair["times"]["moved"]} == {"321M"}
    assert all(row["by_s"] == 25.0 for row in pair["times"]["moved"])
    assert pair["times"]["compared"] == moved.pairs[0].times.compared
    assert all(len(measure["values"]) == 2 for measure in told["measures"])


def test_the_directory_is_whole_opens_offline_and_is_replaced_by_the_next(
    weekday: ReportedRun, tmp_path: Path
) -> None:
    """What files call a run cannot leave its place in the page."""
    moved = compare((side(weekday), side(later(weekday, 25.0), "<script>alert(1)</script>")), 1.0)
    page = write_comparison(moved, tmp_path / "out")
    names = {path.name for path in page.parent.iterdir()}
    assert names >= {
        "compare.html",
        "compare.json",
        "times.csv",
        "measures.csv",
        "train_graph_1.svg",
        "train_graph_1.png",
    }
    assert all(owns_file(name) for name in names)
    html = page.read_text("utf-8")
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!#|data:)""", html)
    assert not re.search(r"@import|url\(\s*['\"]?(?!data:|#)|\bfetch\(|XMLHttpRequest|<link\b|<script", html)
    assert "&lt;script&gt;" in html
    assert "What changed against base" in html and "烏山" in html
    with (page.parent / "times.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["by_s"]) for row in rows] == [25.0] * len(moved.pairs[0].times.moved)
    assert json.loads((page.parent / "compare.json").read_text("utf-8")) == json.loads(
        json.dumps(moved.as_dict())
    )
    first = {path.name: path.read_bytes() for path in page.parent.iterdir()}
    write_comparison(moved, tmp_path / "out")
    assert {path.name: path.read_bytes() for path in page.parent.iterdir()} == first


@pytest.mark.nightly
def test_of_three_runs_there_is_a_graph_of_each_pair(weekday: ReportedRun, tmp_path: Path) -> None:
    three = compare((side(weekday), side(weekday, "same"), side(later(weekday, 9.0), "late")), 1.0)
    page = write_comparison(three, tmp_path / "out")
    assert {"train_graph_2.svg"} <= {path.name for path in page.parent.iterdir()}
    html = page.read_text("utf-8")
    assert "All runs" in html and "late: what changed against base" in html


def test_somebodys_work_is_not_replaced(moved: Comparisons, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("mine", "utf-8")
    with pytest.raises(InputError, match=r"a comparison and nothing else; it holds thesis\.txt"):
        write_comparison(moved, tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]
    assert (
        not owns_file("train_graph_x.svg")
        and not owns_file("train_graph_1.pdf")
        and not owns_file("summary.json")
    )


def test_the_graph_shows_what_moved_and_leaves_the_rest_pale(moved: Comparisons) -> None:
    base, new = moved.sides
    with drawing():
        figure = draw_both(base, new, moved.pairs[0])
    first = figure.axes[0]
    dashed = [line for line in first.lines if line.get_linestyle() == "--" and len(line.get_xdata()) > 20]
    thick = [line for line in first.lines if line.get_linewidth() == 2.0 and len(line.get_xdata()) > 20]
    assert (len(dashed), len(thick)) == (1, 1)
    apart = thick[0].get_xdata()[0] - dashed[0].get_xdata()[0]
    assert apart == pytest.approx(25.0)
    numbers = {text.get_text() for text in first.texts}
    assert {"321M", "322M"} <= numbers


def test_every_part_of_a_report_has_its_title_and_what_it_says_of_tables_in_japanese(
    moved: Comparisons,
) -> None:
    parts = parts_against(moved, graphs=False)
    assert len(parts) >= 3
    assert not any(part.title_ja.isascii() for part in parts)
    # the first one's is the verdict
    assert not any(part.caption and part.caption_ja.isascii() for part in parts[1:])


def test_parts_of_runs_that_do_not_differ_are_one(weekday: ReportedRun) -> None:
    same = compare((side(weekday), side(weekday, "again", digest="base")), 1.0)
    with drawing():
        (part,) = parts_against(same)
    assert part.caption.startswith("Nothing differs at all")


@pytest.mark.parametrize(
    ("paths", "labels"),
    [
        (("/a/one", "/a/two"), ("one", "two")),
        (("/a/run", "/b/run", "/b/two"), ("a/run", "b/run", "two")),
        (("/x/a/run", "/y/a/run"), ("x/a/run", "y/a/run")),
        (("/a/run", "/a/run", "/a/../a/run"), ("run", "run (2)", "run (3)")),
        (("/run", "/a/run"), ("/run", "a/run")),
    ],
)
def test_labels_are_as_short_as_tells_runs_apart(paths: tuple[str, ...], labels: tuple[str, ...]) -> None:
    assert labels_of([Path(path) for path in paths]) == labels


def test_runs_of_another_line_are_refused(weekday: ReportedRun) -> None:
    other = load_line(shipped_line("rtri_test_line"))
    with pytest.raises(InputError, match="runs of one line: this one is of RTRI"):
        check_same_line(weekday.line, other, Path("somewhere"))
    check_same_line(weekday.line, weekday.line, Path("somewhere"))
