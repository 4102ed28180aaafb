"""A second tool explores a model made from the tables of steps, without any reduction, and finds the same states."""

import shutil
import subprocess
from pathlib import Path

import pytest

from verify.explored_line import Budgets, ExploredLine
from verify.promela import STATE, model, state_words, walked

SPIN = shutil.which("spin")
CC = shutil.which("cc")


@pytest.mark.nightly
@pytest.mark.skipif(SPIN is None or CC is None, reason="spin or a C compiler is not installed")
def test_spin_finds_the_same_states(tmp_path: Path) -> None:
    assert SPIN
    assert CC
    composition, states = walked(ExploredLine())
    (tmp_path / "line.pml").write_text(model(composition), "utf-8")
    for command in (
        [SPIN, "-a", "line.pml"],
        [CC, "-O0", "-w", "-DNOREDUCE", "-DSAFETY", "-DVECTORSZ=2048", "-o", "pan", "pan.c"],
    ):
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    ran = subprocess.run([tmp_path / "pan", "-E", "-m1000000"], check=True, capture_output=True, text=True)
    assert "errors: 0" in ran.stdout
    assert f"{len(states)} states, stored" in ran.stdout
    # The first state is printed by no step that leads to it.
    printed = {line.removeprefix(STATE) for line in ran.stdout.splitlines() if line.startswith(STATE)}
    assert printed | {state_words(composition.start())} == {state_words(state) for state in states}


def test_a_line_with_troubles_has_no_such_model() -> None:
    with pytest.raises(ValueError, match="no troubles"):
        walked(ExploredLine(budgets=Budgets(loss=1)))


def test_every_state_is_written_apart() -> None:
    composition, states = walked(ExploredLine())
    assert len({state_words(state) for state in states}) == len(states)
    assert model(composition).endswith("settled() } od }\n")
