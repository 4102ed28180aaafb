"""A program of its own: run a scenario and print its stops as JSON (see `switches_compiled`)."""

import json
import sys
from pathlib import Path

import onboard
from onboard.notes import SignSeen
from scenario.scenario import load_scenario
from tests.plain import run_on_plain

SLOW_MPS, FAST_MPS, BRAKING_MPS2 = 1.0, 4.0, 0.3  # the last part of a stop, in which sightings have settled


def main(name: str, seed: int) -> None:
    """Run and print."""
    run = run_on_plain(load_scenario(name, seed))
    went = run.tables.trajectory.filter(
        (run.tables.trajectory["speed_mps"] > SLOW_MPS)
        & (run.tables.trajectory["speed_mps"] < FAST_MPS)
        & (run.tables.trajectory["acceleration_mps2"] < -BRAKING_MPS2)
    )
    result = run.result
    print(  # noqa: T201 - a program's output
        json.dumps(
            {
                "root": str(Path(onboard.__file__).resolve().parents[1]),
                "errors_m": [stop.error_m for stop in result.stops if stop.error_m is not None],
                "broken": [*run.broken, *(violation.text for violation in result.outside_design)],
                "ahead_s": (went["estimate_error_m"] / went["speed_mps"]).median(),
                "sightings": sum(isinstance(entry.event, SignSeen) for entry in result.journal.entries),
            }
        )
    )


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
