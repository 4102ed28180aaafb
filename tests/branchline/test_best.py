"""`branchline best`: what it prints, writes and refuses."""

from __future__ import annotations

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
    text = (tmp_path / "proof.json").read_text("utf-8")
    (tmp_path / "proof.json").write_text(text.replace(str(least_s - 1), str(least_s)), "utf-8")
    refused = main("best", "interval", WEEKDAY, "--check", "proof.json")
    assert refused.code == 1
    assert str(least_s) in refused.out
    assert main("best", "interval", WEEKDAY, "--set-late", "--check", "proof.json").code == 1


def test_the_answer_is_a_scenario(main: Callable[..., Any]) -> None:
    assert main("best", "loops", WEEKDAY, "--at", "NIT", "--out", "loop.toml").code == 0
    checked = main("check", "loop.toml")
    assert checked.code == 0, checked.out
    assert main("best", "trains", WEEKDAY, "--every", "90", "--out", "two.toml").code == 0
    assert main("check", "two.toml").code == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("interval", "rtri_test_line"), "from one end to the other"),
        (("interval", WEEKDAY, "--out", f"{WEEKDAY}.toml"), "another name"),
        (("loops", WEEKDAY, "--at", "OGN"), "a halt"),
        (("trains", "isumi_weekday"), "portals"),
    ],
)
def test_what_cannot_be_asked_is_said(main: Callable[..., Any], words: tuple[str, ...], said: str) -> None:
    ended = main("best", *words)
    assert ended.code == 2
    assert said in ended.err
