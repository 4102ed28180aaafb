"""`branchline best`: what it prints, writes and refuses."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

WEEKDAY = "karasuyama_weekday"


def test_a_proof_is_recounted_and_one_with_a_number_changed_refused(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    found = main("best", "interval", WEEKDAY, "--proof", "proof.json", "--json")
    assert found.code == 0, found.err
    least_s = found.figures()["interval_s"]
    assert found.figures()["excluded_s"] == [[0, least_s - 1]]
    assert main("best", "interval", WEEKDAY, "--check", "proof.json").code == 0
    told = main("best", "interval", WEEKDAY).out
    an_hour = f"{3600 / least_s:.2f} trains an hour each way"
    assert f"least interval {least_s} s ({least_s / 60:.1f} min), {an_hour}\n" in told
    assert re.search(r"^waits: \d+ s of all trains together, least that it can be$", told, re.MULTILINE)
    text = (tmp_path / "proof.json").read_text("utf-8")
    (tmp_path / "proof.json").write_text(text.replace(str(least_s - 1), str(least_s)), "utf-8")
    refused = main("best", "interval", WEEKDAY, "--check", "proof.json")
    assert refused.code == 1
    assert str(least_s) in refused.out
    assert main("best", "interval", WEEKDAY, "--set-late", "--check", "proof.json").code == 1
    (tmp_path / "proof.json").write_text(json.dumps(json.loads(text) | {"excluded": []}), "utf-8")
    nothing = main("best", "interval", WEEKDAY, "--check", "proof.json")
    assert (nothing.code, nothing.out) == (1, "it excludes no interval\n")


def test_the_answer_is_a_scenario(main: Callable[..., Any]) -> None:
    assert main("best", "loops", WEEKDAY, "--at", "NIT", "--out", "loop.toml").code == 0
    checked = main("check", "loop.toml")
    assert checked.code == 0, checked.out
    two = main("best", "trains", WEEKDAY, "--every", "90", "--out", "two.toml")
    assert two.code == 0
    assert two.out.startswith(
        "2 trains each way every 90 min: as many as can be\na train each way has HSK.1 for "
    )
    assert " s of 5400 s\n" in two.out
    assert main("check", "two.toml").code == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("interval", "rtri_test_line"), "from one end to the other"),
        (("interval", WEEKDAY, "--out", f"{WEEKDAY}.toml"), "another name"),
        (("interval", "mine.toml", "--out", "mine.toml"), "another name"),
        (("interval", WEEKDAY, "--out", "mine.toml"), "exists already"),
        (("loops", WEEKDAY, "--out", "day.toml"), "exists already"),
        (("trains", WEEKDAY, "--out", "day.json"), "NAME.toml"),
        (("loops", WEEKDAY, "--at", "OGN"), "a halt"),
        (("trains", "isumi_weekday"), "portals"),
    ],
)
def test_what_cannot_be_asked_is_said(
    main: Callable[..., Any], tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    """Nothing that stands already is written over: `mine` and the timetable that would lie beside `day`."""
    mine = f'extends = "{WEEKDAY}"\nid = "mine"\nname = "mine"\n'
    for name in ("mine.toml", "day_times.toml"):
        (tmp_path / name).write_text(mine, "utf-8")
    ended = main("best", *words)
    assert ended.code == 2
    assert said in ended.err
    assert {path.read_text("utf-8") for path in tmp_path.glob("*.*")} == {mine}
