"""`branchline blocking`: theory and run of a scenario, a run directory read back, the two compared."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from study.runner.run import write_run
from tests.plain import run_on_plain


def test_theory_needs_no_run(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("blocking", "karasuyama_weekday", "--theory", "--json", "--out", "out.csv")
    assert ended.code == 0, ended.err
    figures = ended.figures()
    assert figures["of"] == "theory"
    assert figures["conflicts"] == []
    with (tmp_path / "out.csv").open(encoding="utf-8-sig") as file:
        written = list(csv.DictReader(file))
    assert len(written) == len(figures["occupations"]) == 224
    for row in figures["occupations"]:
        parts = [v for k, v in row.items() if k.startswith("cost_")]
        assert sum(parts) == pytest.approx(row["whole_s"], abs=1e-6)
    assert not (tmp_path / "runs").exists()


def test_a_run_directory_is_read_back_and_compared(main: Callable[..., Any], tmp_path: Path) -> None:
    run = run_on_plain("rtri_test_line")
    write_run(run, tmp_path / "run")
    alone = main("blocking", str(tmp_path / "run"), "--json").figures()
    assert (alone["of"], len(alone["occupations"])) == ("run", 5)
    both = main("blocking", str(tmp_path / "run"), "--theory", "--json").figures()
    assert both["compared"]["pairs"] == 3  # it stood where it begins, and stays where it ends
    assert {one["part"] for one in both["compared"]["parts"]} >= {"air", "throw", "run", "release"}
    told = main("blocking", str(tmp_path / "run"), "--theory")
    mean_s, worst_s = (both["compared"][f"whole_{name}_s"] for name in ("mean", "worst"))
    assert f"whole: mean {mean_s:+.1f} s, greatest {worst_s:+.1f} s" in told.out
    assert "0 conflicts" in told.out


def test_what_does_not_fit_is_told(main: Callable[..., Any]) -> None:
    told = main("blocking", "isumi_weekday", "--theory")
    assert told.code == 0
    assert "6D wants it" in told.out


def test_an_unknown_source_is_bad_input(main: Callable[..., Any]) -> None:
    assert main("blocking", "nowhere", "--theory").code == 2
