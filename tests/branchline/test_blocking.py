"""`branchline blocking`: theory and run of a scenario, a run directory read back, the two compared."""

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from study.capacity.compared import theory_and_run
from study.runner.run import write_run
from tests.plain import run_on_plain
from tests.study.capacity.hand_made import held


def test_theory_needs_no_run(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("blocking", "karasuyama_weekday", "--theory", "--json", "--out", "out.csv")
    assert ended.code == 0, ended.err
    figures = ended.figures()
    assert (figures["of"], figures["conflicts"]) == ("theory", [])
    with (tmp_path / "out.csv").open(encoding="utf-8-sig") as file:
        written = list(csv.DictReader(file))
    assert len(written) == len(figures["occupations"]) == 224
    for row in figures["occupations"]:
        parts = [v for k, v in row.items() if k.startswith("cost_")]
        assert sum(parts) == pytest.approx(row["whole_s"], abs=1e-6)
    assert not (tmp_path / "runs").exists()


def test_a_run_directory_is_read_back_and_compared(
    main: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = run_on_plain("rtri_test_line")
    write_run(run, tmp_path / "run")
    alone = main("blocking", str(tmp_path / "run"), "--json").figures()
    assert (alone["of"], len(alone["occupations"])) == ("run", 5)
    both = main("blocking", str(tmp_path / "run"), "--theory", "--json").figures()
    assert both["compared"]["pairs"] == 3  # it stood where it begins, and stays where it ends
    assert {one["part"] for one in both["compared"]["parts"]} >= {"air", "throw", "run", "release"}
    made = [[held("S", "1", 0.0, end_s), held("T", "1", 0.0, end_s)] for end_s in (100.0, 101.0)]
    made[1][1] = held("T", "1", 0.0, 109.0)  # 1 s and 9 s longer
    monkeypatch.setattr("study.capacity.compared.theory_and_run", lambda *_: theory_and_run(*made))
    told = main("blocking", str(tmp_path / "run"), "--theory")
    assert "0 conflicts" in told.out
    assert "run alone; whole: mean +5.0 s, greatest +9.0 s\n" in told.out
    made_up = main("blocking", str(tmp_path / "run"), "--theory", "--json").figures()["compared"]
    assert (made_up["whole_mean_s"], made_up["whole_worst_s"]) == (5.0, 9.0)
    assert re.search(r"^run +100\.00 +105\.00 +\+5\.00 +\+9\.00  1 in T: ", told.out, re.MULTILINE)


def test_what_does_not_fit_is_told(main: Callable[..., Any]) -> None:
    told = main("blocking", "isumi_weekday", "--theory")
    assert (told.code, "6D wants it" in told.out) == (0, True)
