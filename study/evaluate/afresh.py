"""Figures of one run in a process of its own, which do not depend on what ran before it, and what they may be."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any


def figures_afresh(module: str, called: str, *words: str) -> dict[str, Any]:
    """The JSON object that `python -m module words` prints. RuntimeError, `called` so, where it fails."""
    command = [sys.executable, "-m", module, *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{called} failed: {done.stderr.strip()[-500:]}")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def budget_of(what: str, limit: float, found: float | None) -> dict[str, Any]:
    """A budget, with whether it is kept; None: nothing was there to be measured, which is not."""
    return {"what": what, "limit": limit, "found": found, "kept": found is not None and found <= limit}
