"""Random cases by hand: `python -m tests.system.chaos --family test --seeds 0:500 --out found`.

Prints a line for each kind of outcome, and writes the first cases of each kind that fails as drills, made small.
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system.chaos.campaign import campaign
from tests.system.chaos.case import Case
from tests.system.chaos.families import Family
from tests.system.chaos.generator import case_of
from tests.system.chaos.planted import found_by
from tests.system.chaos.replay import shrunk, slug, write
from tests.system.chaos.run_one import Outcome
from tests.system.chaos.sometimes import ALL
from tests.system.chaos.twice import differs
from tests.system.conftest import SWITCHES


def main() -> int:
    """Exit code 1 if any case fails."""
    parser = argparse.ArgumentParser(prog="python -m tests.system.chaos", description=__doc__)
    parser.add_argument("--family", choices=[family.value for family in Family], required=True)
    parser.add_argument("--seeds", required=True, help="from:to, or one seed")
    parser.add_argument("--out", type=Path, help="where failures are written as drills")
    parser.add_argument("--each", type=int, default=2, help="how many of each kind")
    parser.add_argument("--nets", type=Path, help="where nets of drawn lines are kept")
    parser.add_argument(
        "--defect", choices=sorted(SWITCHES), help="a behaviour taken away, of tests/system/conftest.py"
    )
    parser.add_argument("--swarm", action="store_true", help="each seed leaves out half of what could fail")
    parser.add_argument(
        "--twice", action="store_true", help="each is run another way, which must come to the same"
    )
    options = parser.parse_args()
    low, _, high = options.seeds.partition(":")
    seeds = range(int(low), int(high or int(low) + 1))
    written: Counter[str] = Counter()

    def keep(case: Case, outcome: Outcome) -> bool:
        if outcome.fine:
            return True
        sys.stdout.write(f"{case.name}: {outcome.kind}\n")
        if options.out is not None and written[outcome.kind] < options.each:
            written[outcome.kind] += 1
            small, ended = shrunk(case, outcome.kind, nets)
            path = write(small, ended, options.out / slug(outcome.kind))
            sys.stdout.write(f"    {path}: {len(small.faults)} faults, {len(small.acts)} acts\n")
        sys.stdout.flush()
        return True

    began_s = time.process_time()
    with TemporaryDirectory(prefix="chaos-nets-") as folder:
        nets = options.nets or Path(folder)
        nets.mkdir(parents=True, exist_ok=True)
        if options.defect:
            sought = found_by(SWITCHES[options.defect], Family(options.family), seeds, nets)
            sys.stdout.write(f"{options.defect}: {sought or f'not found in {len(seeds)} runs'}\n")
            return 0 if sought else 1
        if options.twice:
            other = [found for seed in seeds if (found := _twice(Family(options.family), seed, nets))]
            sys.stdout.write(f"{len(seeds)} runs, {len(other)} that are others another way\n{''.join(other)}")
            return 1 if other else 0
        figures = campaign(Family(options.family), seeds, nets, keep, swarm=options.swarm)
    cpu_h = (time.process_time() - began_s) / 3600.0
    sys.stdout.write(f"{figures}\n{figures.by_kind()}")
    sys.stdout.write(f"{figures.simulated_s / 3600.0 / cpu_h:.0f} simulated hours an hour of processor\n")
    sys.stdout.writelines(f"{figures.came[name]:6d}  {name}\n" for name in ALL)
    return 1 if figures.failed else 0


def _twice(family: Family, seed: int, nets: Path) -> str:
    found = differs(family, case_of(family, seed, nets), seed, nets)
    return found and f"{seed}: {found}\n"


if __name__ == "__main__":
    sys.exit(main())
