"""Compiled for this processor or for any, or as Python runs it: the same run, journal and positions to the byte."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.nightly


@pytest.mark.parametrize(
    "arguments",
    [("run", "rtri_test_line"), ("drill", "rtri/27_slippery_rail"), ("drill", "rtri/45_tags_by_bits")],
    ids=lambda arguments: arguments[1],
)
def test_however_it_is_run_it_is_the_same(
    command: tuple[str, ...], tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    """With noise of sensors, sliding wheels and tags read bit by bit among them."""
    digests = []
    for way in ({}, {"NUMBA_CPU_NAME": "generic"}, {"NUMBA_DISABLE_JIT": "1"}):
        done = subprocess.run(
            [*command, *arguments, "--json"],
            cwd=tmp_path,
            env=os.environ | way,
            capture_output=True,
            check=True,
        )
        found: dict[str, Any] = json.loads(done.stdout)
        summary = found.get("summary", found)
        digests.append((summary["digest"], summary["motion_digest"]))
    assert len(set(digests)) == 1
