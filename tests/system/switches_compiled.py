"""Behaviours of compiled laws that can be taken away, by name: an edit of the source, in a copy of the project.

Compiled code keeps the constants and functions that it was made with, so nothing can be patched in this process. The
copy compiles anew and runs the scenario in a process of its own; what its edit takes away must be there exactly once.
"""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from study.sweep.digest import CODE

ROOT: Final = Path(__file__).resolve().parents[2]
PACKAGES: Final = (*(part for part in CODE if "/" not in part), "study")


@dataclass(frozen=True)
class Edit:
    """What stands in a file, and what stands there instead."""

    file: str
    there: str
    instead: str


_FIX: Final = "onboard/localisation/fix.py"
_SIGHTING: Final = "onboard/localisation/sighting.py"
COMPILED_SWITCHES: Final[dict[str, Edit]] = {
    "sightings_move_nothing": Edit(
        _FIX,
        "    estimate_m = min(max(estimate_m, least_m), most_m)\n    row.position_m = estimate_m\n",
        "    estimate_m = before_m\n",
    ),
    "pattern_is_not_drawn_anew": Edit(
        _FIX,
        "    row.fix_correction_m += estimate_m - before_m\n    return float",
        "    return float",
    ),
    "weight_is_inverted": Edit(
        _FIX, "weight = slack_m * slack_m / both_m2 if", "weight = within_m * within_m / both_m2 if"
    ),
    "picture_is_of_its_start": Edit(
        _SIGHTING, "EXPOSED_WITHIN_S: Final = 0.02 ", "EXPOSED_WITHIN_S: Final = 0.0 "
    ),
    "limits_end_at_the_estimate": Edit(
        "onboard/driving/supervision.py",
        "    return float(position_m - unit.bound_behind_m)\n",
        "    return float(position_m)\n",
    ),
    "sightings_cut_the_bounds": Edit(
        _SIGHTING,
        "    own.slack_m = move_estimate(unit, own.slack_m, front_m, within_m)\n",
        "    own.slack_m = move_estimate(unit, own.slack_m, front_m, within_m)\n"
        "    unit.bound_ahead_m = min(unit.bound_ahead_m, own.slack_m)\n"
        "    unit.bound_behind_m = min(unit.bound_behind_m, own.slack_m)\n",
    ),
}


@dataclass(frozen=True)
class Stops:
    """A run's stops (m past the mark), what broke, and the estimate's error over the speed while stopping (s)."""

    errors_m: tuple[float, ...]
    broken: tuple[str, ...]
    ahead_s: float
    sightings: int

    def share_within(self, limit_m: float) -> float:
        """Share of the stops that are this near."""
        return sum(abs(error) <= limit_m for error in self.errors_m) / len(self.errors_m)


def run_with(name: str | None, scenario: str, seed: int, folder: Path) -> Stops:
    """The scenario's run with a switch thrown, or without any, in a process of its own."""
    root = ROOT
    if name is not None:
        root = folder / name
        edit = COMPILED_SWITCHES[name]
        for package in PACKAGES:
            shutil.copytree(ROOT / package, root / package, ignore=shutil.ignore_patterns("__pycache__"))
        text = (root / edit.file).read_text("utf-8")
        assert text.count(edit.there) == 1, (name, text.count(edit.there))
        (root / edit.file).write_text(text.replace(edit.there, edit.instead), "utf-8")
    done = subprocess.run(
        [sys.executable, str(Path(__file__).parent / "stops_of.py"), scenario, str(seed)],
        cwd=root,
        env={**os.environ, "PYTHONPATH": f"{root}{os.pathsep}{ROOT}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["root"] == str(root)
    return Stops(tuple(found["errors_m"]), tuple(found["broken"]), found["ahead_s"], found["sightings"])
