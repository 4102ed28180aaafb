"""Real days of a sweep by the command: the table, the report, a day that is run again, and an interruption."""

import csv
import os
import re
import shlex
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import Ended
from tests.study.sweep.conftest import DRAW, SWEEP, WAIT_S


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_days_and_one_of_them_again(tmp_path: Path, main: Callable[..., Ended]) -> None:
    text = SWEEP.replace("days = 12", "days = 2").replace(
        '"mean_late_s"]', '"mean_late_s"]\nkeep = ["journal"]'
    )
    (tmp_path / "tiny.toml").write_text(text + DRAW, "utf-8")
    ended = main("sweep", "tiny.toml", "--out", "swept", "--jobs", "1", "--json")
    assert ended.code == 0, ended.err
    found: dict[str, Any] = ended.figures()
    assert (found["days"], found["days_run"], found["again_on_sumo"], found["failures"]) == (4, 4, 2, [])
    assert found["outcome"] == "good"
    rows = rows_of(tmp_path / "swept" / "days.csv")
    assert [(row["point"], row["seed"]) for row in rows] == [("0", "1"), ("0", "2"), ("1", "1"), ("1", "2")]
    assert all(row["outcome"] == "good" for row in rows)
    assert [row["again"] == row["digest"] for row in rows] == [True, False, True, False]
    journals = list((tmp_path / "swept" / "runs").glob("*/journal.jsonl"))
    assert len(journals) == 4
    page = (tmp_path / "swept" / "report.html").read_text("utf-8")
    assert page.count("<svg") == 3
    assert not re.search(r"(src|href)\s*=\s*[\"']?(https?:)?//", page)
    commands = re.findall(r"branchline run [^<]+", page)
    assert commands
    seed = re.search(r"--seed (\d+)", commands[0])
    assert seed is not None
    again = main(*shlex.split(commands[0])[1:], "--json")
    assert again.code == 0, again.err
    digest = again.figures()["digest"]
    assert digest in {row["digest"] for row in rows if row["seed"] == seed[1]}
    once_more = main("sweep", "tiny.toml", "--out", "swept", "--json").figures()
    assert (once_more["days_before"], once_more["days_run"]) == (4, 0)
    assert once_more["points"] == found["points"]
    # What is to be kept from now on is kept of the days that are there too: they are run again, and are the same.
    (tmp_path / "tiny.toml").write_text(
        (tmp_path / "tiny.toml").read_text("utf-8").replace('["journal"]', '["journal", "trajectory"]'),
        "utf-8",
    )
    kept = main("sweep", "tiny.toml", "--out", "swept", "--jobs", "1", "--json").figures()
    assert (kept["days_before"], kept["days_run"]) == (0, 4)
    assert kept["points"] == found["points"]
    assert len(list((tmp_path / "swept" / "runs").glob("*/trajectory.parquet"))) == 4


@pytest.mark.nightly
def test_interrupted_sweep_goes_on(
    tmp_path: Path, command: tuple[str, ...], branchline: Callable[..., Ended]
) -> None:
    (tmp_path / "tiny.toml").write_text(SWEEP.replace("days = 12", "days = 60"), "utf-8")
    client = subprocess.Popen(
        [*command, "sweep", "tiny.toml", "--out", "swept", "--jobs", "2", "--json"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert client.stderr is not None
    first = client.stderr.readline()  # told at the first quarter
    assert "of about 120 days" in first
    os.killpg(client.pid, signal.SIGINT)
    out, err = client.communicate(timeout=WAIT_S)
    assert client.returncode == 130, err
    assert '"interrupted"' in out
    before = len(list((tmp_path / "swept" / "days").glob("*.json")))
    assert 30 <= before < 120
    ended = branchline("sweep", "tiny.toml", "--out", "swept", "--json", cwd=tmp_path)
    found = ended.figures()
    assert ended.code == 0, ended.err
    assert (found["days"], found["days_before"], found["days_run"]) == (120, before, 120 - before)
