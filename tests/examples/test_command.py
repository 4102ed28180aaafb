"""The recipe "a command" of docs/make-a.md, followed: a file and an entry, and the command line has it."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest


def test_two_files_make_a_command_that_ends_as_all_others_do(clone: Callable[[], Any]) -> None:
    made = clone()
    made.follow("command")
    assert made.is_what_is_told("command")
    assert len(made.touched) == 2
    made.holds("tests/branchline/test_cli.py")
    assert "train-kilometres" in made.python("-m", "branchline.cli", "--help").stdout
    done = made.python("-m", "branchline.cli", "train-kilometres", "karasuyama_weekday", "--json")
    assert done.returncode == 0, done.stderr
    # 28 trains between Hoshakuji and Karasuyama, 20.4 km each as published
    assert json.loads(done.stdout)["train_km"] == pytest.approx(28 * 20.4, rel=0.01)
    refused = made.python("-m", "branchline.cli", "train-kilometres", "nowhere")
    assert refused.returncode == 2
    assert "nowhere" in refused.stderr
