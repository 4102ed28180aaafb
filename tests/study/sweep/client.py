"""A client of a sweep as a process of its own, so that it can be killed: arguments are FILE OUT ADDRESS."""

import sys
from pathlib import Path

from study.sweep import cluster
from study.sweep.cluster import ClusterPump
from study.sweep.go import run_missing, sweep_begun
from study.sweep.local import LocalPump
from study.sweep.plan import load_plan
from study.sweep.store import opened_sweep
from tests.study.sweep.planted import RUNNER

cluster.CONNECT_S = 8.0  # so long it tries to find a scheduler again that the test has killed


def main(file: str, out: Path, address: str) -> None:
    plan = load_plan(file)
    with opened_sweep(plan, out) as store:
        pump = ClusterPump(address, out, store.token) if address else LocalPump(2)
        run_missing(sweep_begun(plan, store, anyway=False), store, pump, runner=RUNNER)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3])
