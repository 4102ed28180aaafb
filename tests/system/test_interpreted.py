"""NUMBA_DISABLE_JIT=1: the laws as Python runs them give the same run, journal and positions to the byte."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.system


@pytest.mark.parametrize(
    "arguments",
    [
        pytest.param(("run", "rtri_test_line"), id="rtri_test_line"),
        pytest.param(
            ("drill", "rtri/27_slippery_rail"), id="rtri/27_slippery_rail", marks=pytest.mark.nightly
        ),
        pytest.param(("drill", "rtri/45_tags_by_bits"), id="rtri/45_tags_by_bits", marks=pytest.mark.nightly),
    ],
)
def test_interpreted_is_compiled(
    command: tuple[str, ...], tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    """With noise of sensors, sliding wheels and tags read bit by bit among them."""
    digests = []
    for disabled in ("0", "1"):
        done = subprocess.run(
            [*command, *arguments, "--json"],
            cwd=tmp_path,
            env={**os.environ, "NUMBA_DISABLE_JIT": disabled},
            capture_output=True,
            check=True,
        )
        found: dict[str, Any] = json.loads(done.stdout)
        summary = found.get("summary", found)
        digests.append((summary["digest"], summary["motion_digest"]))
    assert digests[0] == digests[1]
