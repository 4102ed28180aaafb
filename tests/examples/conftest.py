"""A clone of the project in which an example is made: its own files laid in, and rows written into tables."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = (
    "network",
    "vehicle",
    "radio",
    "onboard",
    "wayside",
    "host",
    "simulation",
    "study",
    "sumo_cfg",
    "branchline",
)


def recipe(name: str) -> str:
    """One recipe of docs/make-a.md."""
    text = (ROOT / "docs/make-a.md").read_text("utf-8")
    return text.partition(f"## … {name}\n")[2].partition("\n## ")[0]


@dataclass
class Clone:
    """What a contributor has on disk; its code runs interpreted, as nothing in it has been compiled before."""

    root: Path
    touched: set[str] = field(default_factory=set)

    def add(self, file: Path, place: str) -> None:
        """Lay in a new file; it must not be there."""
        assert not (self.root / place).exists()
        shutil.copy(file, self.root / place)
        self.touched.add(place)

    def write(self, place: str, *pairs: tuple[str, str]) -> None:
        """Put text behind a text that is there once."""
        text = (self.root / place).read_text("utf-8")
        for behind, new in pairs:
            assert text.count(behind) == 1, (place, behind)
            text = text.replace(behind, behind + new)
        (self.root / place).write_text(text, "utf-8")
        self.touched.add(place)

    def python(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run Python there."""
        environment = {**os.environ, "PYTHONPATH": str(self.root), "NUMBA_DISABLE_JIT": "1"}
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=self.root,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def run(self, scenario: Path | str) -> dict[str, Any]:
        """Figures of a run, with the directory that it left under `out`."""
        done = self.python("-m", "branchline.cli", "run", str(scenario), "--json", "--out", "out")
        assert done.stdout, done.stderr
        figures: dict[str, Any] = json.loads(done.stdout)
        return figures

    def is_what_is_told(self, name: str) -> bool:
        """Whether the recipe names what was touched and no other file of the code."""
        folders = "|".join(PACKAGES)
        named = set(re.findall(rf"`((?:{folders})/[\w./<>]+\.py)`", recipe(name)))
        return {_as_named(place, named) for place in self.touched} == named


def _as_named(place: str, named: set[str]) -> str:
    """A file by the pattern `folder/<name>.py` where the recipe says it like that."""
    pattern = f"{Path(place).parent}/<name>.py"
    return pattern if place not in named and pattern in named else place


@pytest.fixture
def clone(tmp_path: Path) -> Callable[[], Clone]:
    def make() -> Clone:
        for package in PACKAGES:
            shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
        return Clone(tmp_path)

    return make
