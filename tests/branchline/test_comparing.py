"""`branchline compare` and `run --against`: what they print, write and refuse, and their exit codes."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from scenario.scenario import load_scenario
from study.outcome import Outcome
from study.runner.run import write_run
from tests.plain import run_on_plain


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run directories one (seed 1), two (seed 2)."""
    folder = tmp_path_factory.mktemp("runs")
    for name, seed in (("one", 1), ("two", 2)):
        run = run_on_plain(load_scenario("rtri_test_line", seed))
        write_run(run, folder / name)
    return folder


def test_differences_are_no_failure(main: Callable[..., Any], runs: Path) -> None:
    ended = main("compare", str(runs / "one"), str(runs / "two"))
    assert (ended.code, ended.err) == (0, "")
    assert "two against one" in ended.out
    assert "Nothing moved by more than 1 s: 2 arrivals and departures compared" in ended.out
    assert "seed" in ended.out and "figures are the same" in ended.out
    nought = main("compare", str(runs / "one"), str(runs / "two"), "--over", "0")
    assert nought.code == 0 and "moved by more than 0 s" in nought.out


def test_json_is_one_object_and_files_are_written(
    main: Callable[..., Any], runs: Path, tmp_path: Path
) -> None:
    ended = main(
        "compare", str(runs / "one"), str(runs / "two"), str(runs / "one"), "--json", "--out", "x/cmp"
    )
    assert ended.code == 0
    figures = ended.figures()
    assert figures["outcome"] == Outcome.GOOD.value
    assert [run["label"] for run in figures["runs"]] == ["one", "two", "one (2)"]
    assert [pair["nothing_differs"] for pair in figures["comparisons"]] == [False, True]
    assert json.loads((tmp_path / "x" / "cmp" / "compare.json").read_text("utf-8"))["runs"] == figures["runs"]
    assert (tmp_path / "x" / "cmp" / "compare.html").is_file()


def test_of_three_runs_the_figures_come_first_and_each_run_has_a_line(
    main: Callable[..., Any], runs: Path
) -> None:
    ended = main("compare", str(runs / "one"), str(runs / "two"), str(runs / "one"))
    assert ended.code == 0
    lines = ended.out.splitlines()
    assert lines[0].startswith("Figures")
    first = next(
        n for n, line in enumerate(lines) if line.startswith("two against one: Nothing moved by more")
    )
    assert lines[first + 1].startswith("one (2) against one: Nothing differs at all, from the same inputs")
    assert lines[first + 2] == "--out or --json has all of each; so has compare of two runs."
    assert len(lines) == first + 3
    assert "Inputs that differ" not in ended.out
    assert "Inputs that differ" in main("compare", str(runs / "one"), str(runs / "two")).out


@pytest.mark.parametrize("over", ["-1", "nan", "inf"])
@pytest.mark.parametrize("command", ["compare", "run"])
def test_a_threshold_that_is_none_is_refused(
    main: Callable[..., Any], runs: Path, tmp_path: Path, command: str, over: str
) -> None:
    given = ("rtri_test_line",) if command == "run" else (str(runs / "one"), str(runs / "two"))
    ended = main(command, *given, "--over", over)
    assert ended.code == Outcome.BAD_INPUT.code
    assert ended.err.startswith("error: command line: --over") and len(ended.err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_run_of_this_line_is_refused_in_one_line(
    main: Callable[..., Any], runs: Path, tmp_path: Path
) -> None:
    copy = shutil.copytree(runs / "one", tmp_path / "copy")
    for given, told in (
        (str(tmp_path / "nowhere"), "No such file or directory"),
        (str(runs), "it has no summary.json"),
        (str(runs / "one" / "summary.json"), "Not a directory"),
    ):
        for order in ((str(runs / "one"), given), (given, str(runs / "one"))):
            ended = main("compare", *order, "--out", "cmp")
            assert (ended.code, ended.out) == (Outcome.BAD_INPUT.code, "")
            assert told in ended.err and len(ended.err.splitlines()) == 1
    (copy / "stops.parquet").write_bytes((copy / "stops.parquet").read_bytes()[:-9])
    ended = main("compare", str(runs / "one"), str(copy), "--json")
    assert ended.code == Outcome.BAD_INPUT.code
    assert ended.figures()["outcome"] == Outcome.BAD_INPUT.value
    assert not (tmp_path / "cmp").exists()


def test_a_run_against_another_says_so_in_its_report(
    main: Callable[..., Any], runs: Path, tmp_path: Path
) -> None:
    arguments = ("run", "rtri_test_line", "--carrier", "plain", "--out", "new")
    ended = main(*arguments, "--seed", "2", "--against", str(runs / "one"))
    assert ended.code == 0
    assert "rtri_test_line against one" in ended.out and "Nothing moved by more than 1 s" in ended.out
    report = (tmp_path / "new" / "report.html").read_text("utf-8")
    assert "What changed against one" in report
    (pair,) = json.loads((tmp_path / "new" / "compare.json").read_text("utf-8"))["comparisons"]
    assert [change["key"] for change in pair["inputs"]] == ["seed"]

    # Against what lies where it is to go: read before that is replaced.
    again = main(*arguments, "--seed", "2", "--against", "new", "--json")
    assert again.code == 0
    (pair,) = again.figures()["against"]["comparisons"]
    assert pair["nothing_differs"] and pair["same_inputs"]
    # And without, nothing of it is left.
    assert main(*arguments).code == 0
    assert not (tmp_path / "new" / "compare.json").exists()


def test_a_run_is_not_begun_against_what_is_none(
    main: Callable[..., Any], runs: Path, tmp_path: Path
) -> None:
    ended = main("run", "karasuyama_weekday", "--against", str(runs / "one"))
    assert ended.code == Outcome.BAD_INPUT.code
    assert "runs of one line" in ended.err
    assert main("run", "rtri_test_line", "--against", "nowhere").code == Outcome.BAD_INPUT.code
    assert list(tmp_path.iterdir()) == []
