"""Days by a Dask scheduler on loopback: the same table as anywhere, whoever of the cluster dies on the way."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack
from pathlib import Path
from typing import Final

import pytest

from network.errors import InputError
from study.sweep import cluster as cluster_pump
from study.sweep.cluster import AHEAD, ClusterPump, run_there
from study.sweep.go import SweepProgress, run_missing, sweep_begun
from study.sweep.local import GivenUpError
from study.sweep.plan import load_plan
from study.sweep.store import opened_sweep
from tests.study.sweep.conftest import WAIT_S, Held
from tests.study.sweep.here import swept, table
from tests.study.sweep.planted import RUNNER, begun_counts

pytest.importorskip("distributed")
ROOT: Final = Path(__file__).resolve().parents[3]
DASK: Final = (sys.executable, "-m", "dask.__main__")
ALONE: Final = ("--no-nanny", "--no-dashboard", "--nthreads", "1")


class Cluster:
    """A scheduler and its workers, each a process of ours."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._stack = ExitStack()
        file = folder / "scheduler.json"
        self.scheduler = self._start(
            *("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show"),
            *("--scheduler-file", str(file)),
        )
        self.address = _address_in(self.scheduler)
        self.workers = [
            self._start("worker", self.address, *ALONE, "--local-directory", str(folder / f"worker-{number}"))
            for number in range(2)
        ]

    def _start(self, *arguments: str) -> subprocess.Popen[str]:
        process = subprocess.Popen([*DASK, *arguments], cwd=ROOT, stderr=subprocess.PIPE, text=True)
        self._stack.callback(_end, process)
        return process

    def close(self) -> None:
        self._stack.close()

    def client(self, file: Path, out: Path) -> subprocess.Popen[str]:
        arguments = ("-m", "tests.study.sweep.client", str(file), str(out), self.address)
        process = subprocess.Popen([sys.executable, *arguments], cwd=ROOT, stderr=subprocess.PIPE, text=True)
        self._stack.callback(_end, process)
        return process


def _address_in(scheduler: subprocess.Popen[str]) -> str:
    """Where it listens, as it says itself."""
    assert scheduler.stderr is not None
    for line in scheduler.stderr:
        if "Scheduler at:" in line:
            return line.split()[-1]
    raise AssertionError("the scheduler has ended")


def _end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate(timeout=WAIT_S)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    found = Cluster(tmp_path)
    yield found
    found.close()


def test_same_table_by_a_scheduler(sweep_file: Path, out: Path, expected: str) -> None:
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None) as cluster:
        plan = load_plan(str(sweep_file))
        with opened_sweep(plan, out) as store:
            state = sweep_begun(plan, store, anyway=False)
            run_missing(state, store, ClusterPump(cluster.scheduler_address, out, store.token), runner=RUNNER)
    assert state.run == 24
    assert table(sweep_file, out) == expected


def test_workers_of_two_threads_are_refused(sweep_file: Path, out: Path) -> None:
    from distributed import LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None) as cluster:
        pump = ClusterPump(cluster.scheduler_address, out, "no token")
        with pytest.raises(InputError, match="workers of one thread"):
            next(pump.run(iter(())))


class Ended:
    """A day that a worker has run as soon as it was given."""

    status = "finished"

    def __init__(self, key: str, packed: bytes) -> None:
        self.key = key
        self._result = run_there(packed)

    def add_done_callback(self, call: Callable[[Ended], None]) -> None:
        call(self)

    def result(self) -> bytes:
        if self.status == "cancelled":
            raise CancelledError
        return self._result


class Growing:
    """A scheduler with one worker; after some days `more` join. `at_once`: the most days that it had at a time."""

    status = "running"

    def __init__(self, more: int, threads: int = 1) -> None:
        self._more, self._threads = more, threads
        self.given = self.taken = self.at_once = 0

    def wait_for_workers(self, *_: object, timeout: float) -> None:
        assert timeout > 0.0

    def nthreads(self) -> dict[str, int]:
        late = {f"late-{number}": self._threads for number in range(self._more if self.taken >= 6 else 0)}
        return {"first": 1} | late

    def run(self, *_: object, workers: list[str], on_error: str) -> dict[str, str]:
        assert on_error == "return"
        return dict.fromkeys(workers, "")

    def submit(self, _run: object, packed: bytes, key: str, **_: object) -> Ended:
        self.given += 1
        self.at_once = max(self.at_once, self.given - self.taken)
        return Ended(key, packed)

    def close(self, timeout: float) -> None:
        assert timeout > 0.0


class Lost(Growing):
    """It has been lost and found again before anybody looked: what it had is cancelled."""

    looks = 0

    def nthreads(self) -> dict[str, int]:
        self.looks += 1
        assert self.looks < 4, "nobody will ever run these days"
        return super().nthreads()

    def submit(self, _run: object, packed: bytes, key: str, **_: object) -> Ended:
        found = super().submit(_run, packed, key)
        found.status = "cancelled"
        return found


def run_on(scheduler: Growing, file: Path, out: Path, patch: pytest.MonkeyPatch) -> int:
    """Run the sweep there; how many days were run."""
    patch.setattr(cluster_pump, "_client", lambda _: scheduler)

    def taken(_: SweepProgress) -> None:
        scheduler.taken += 1

    with opened_sweep(load_plan(str(file)), out) as store:
        state = sweep_begun(load_plan(str(file)), store, anyway=False)
        run_missing(state, store, ClusterPump("scheduler", out, store.token), taken, runner=RUNNER)
    return state.run


@pytest.mark.nightly
def test_workers_that_join_late_have_days(
    sweep_file: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scheduler = Growing(3)
    assert run_on(scheduler, sweep_file, out, monkeypatch) == 24
    assert scheduler.at_once == AHEAD * 4


@pytest.mark.nightly
def test_without_a_look_at_them_they_have_none(
    sweep_file: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    look = ClusterPump._look
    monkeypatch.setattr(ClusterPump, "_look", lambda self, client: self._workers or look(self, client))
    scheduler = Growing(3)
    assert run_on(scheduler, sweep_file, out, monkeypatch) == 24
    assert scheduler.at_once == AHEAD


def test_a_late_worker_that_cannot_run_days_is_told(
    sweep_file: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(GivenUpError, match=r"workers of one thread.*late-0 has 2"):
        run_on(Growing(1, threads=2), sweep_file, out, monkeypatch)


def test_days_of_a_scheduler_that_was_lost_are_not_waited_for(
    sweep_file: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster_pump, "LOOK_S", 0.01)
    with pytest.raises(GivenUpError, match="the scheduler at scheduler is gone"):
        run_on(Lost(0), sweep_file, out, monkeypatch)


@pytest.mark.nightly
def test_worker_then_scheduler_killed(
    sweep_file: Path, out: Path, held: Held, cluster: Cluster, expected: str
) -> None:
    held.hold(3, 8)
    client = cluster.client(sweep_file, out)
    first = held.next_pid()
    assert first in {worker.pid for worker in cluster.workers}
    os.kill(first, signal.SIGKILL)
    second = held.next_pid()
    assert second != first
    before = len(list((out / "days").glob("*.json")))
    # Nine were given out by then, of which so many may be at hand: those of the lost worker are run again at any time.
    assert before >= 9 - AHEAD * len(cluster.workers)
    cluster.scheduler.kill()
    _, error = client.communicate(timeout=WAIT_S)
    assert client.returncode == 1
    assert "GivenUpError: the scheduler at" in error, error
    os.kill(second, signal.SIGKILL)
    state = swept(sweep_file, out)
    assert 0 < state.run <= 24 - before
    assert table(sweep_file, out) == expected
    # Of the two that were held one was lost with its worker, one with the second: no other day was begun again.
    assert sum(begun_counts(out).values()) <= 24 + 2


@pytest.mark.nightly
def test_client_killed(sweep_file: Path, out: Path, held: Held, cluster: Cluster, expected: str) -> None:
    held.hold(4)
    client = cluster.client(sweep_file, out)
    pid = held.next_pid()
    client.kill()
    client.wait(WAIT_S)
    os.kill(pid, signal.SIGKILL)
    again = cluster.client(sweep_file, out)
    _, error = again.communicate(timeout=WAIT_S)
    assert again.returncode == 0, error
    assert table(sweep_file, out) == expected
