"""Processes of this machine: a day is run once, whoever dies; what is there is not run again."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import msgspec
import pytest

from network.errors import InputError
from study.sweep.local import GivenUpError, LocalPump
from study.sweep.plan import load_plan
from study.sweep.records import DayOutcome
from study.sweep.store import day_name, opened_sweep, write_day
from study.sweep.table import days_csv
from study.sweep.worker import RETRIES, Task, task_done
from tests.study.sweep.conftest import WAIT_S, Held
from tests.study.sweep.here import swept, table
from tests.study.sweep.planted import RUNNER, begun_counts, control_of

ROOT = Path(__file__).resolve().parents[3]


def test_killed_worker_loses_its_day_alone(sweep_file: Path, out: Path, held: Held, expected: str) -> None:
    """The other process is held until another has taken the dead one's place: it could run the rest alone."""
    held.hold(5, 6, 7)

    def kill() -> None:
        pids = dict((held.next_day(), held.next_day()))
        os.kill(pids[5], signal.SIGKILL)
        day, pid = held.next_day()
        assert day == 7
        assert pid not in pids.values()
        held.let_go(6, 7)

    pump = LocalPump(2)
    with ThreadPoolExecutor(1) as killer:
        killed = killer.submit(kill)
        state = swept(sweep_file, out, pump)
        killed.result(WAIT_S)
    assert table(sweep_file, out) == expected
    counts = begun_counts(out)
    # Two points have each day once: the one that was lost was begun three times in all.
    assert counts.pop(5) == 3
    assert set(counts.values()) == {2}
    assert pump.spawned == 3
    tries = sorted(record.tries for record in state.records.values())
    assert tries == [1] * 23 + [2]


@pytest.mark.nightly
def test_day_that_kills_its_worker_is_filed_as_crashed(sweep_file: Path, out: Path) -> None:
    (control_of(out) / "die-1").touch()
    (control_of(out) / "fail-2").touch()
    state = swept(sweep_file, out, LocalPump(2), days=4)
    records = [record for point in state.plan.points for record in state.days_counted(point)]
    assert len(records) == 8
    crashed = {record.index: record for record in records if record.outcome is DayOutcome.CRASHED}
    assert set(crashed) == {1, 2}
    assert "SIGKILL" in crashed[1].why
    assert crashed[2].why == "ValueError: planted"
    assert {record.tries for record in crashed.values()} == {RETRIES + 1}
    assert begun_counts(out) == {0: 2, 1: 2 * (RETRIES + 1), 2: 2 * (RETRIES + 1), 3: 2}
    assert len(state.failures) == 1
    assert "4 days: the program crashed" in state.failures[0]


@pytest.mark.nightly
def test_killed_client_leaves_what_was_filed(sweep_file: Path, out: Path, held: Held, expected: str) -> None:
    held.hold(6, 7)
    client = subprocess.Popen(
        [sys.executable, "-m", "tests.study.sweep.client", str(sweep_file), str(out), ""], cwd=ROOT
    )
    pids = {held.next_pid(), held.next_pid()}
    with pytest.raises(InputError, match="no other client"):
        swept(sweep_file, out)
    client.kill()
    client.wait(WAIT_S)
    for pid in pids:  # they would end by themselves once their day is over
        os.kill(pid, signal.SIGKILL)
    before = len(list((out / "days").glob("*.json")))
    assert 12 <= before <= 14
    state = swept(sweep_file, out)
    assert state.before == before
    assert state.run == 24 - before
    assert table(sweep_file, out) == expected
    assert max(begun_counts(out).values()) == 3


def test_processes_that_never_live_end_the_sweep(
    sweep_file: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("study.sweep.local.serve", int)  # ends at once, with an error
    with pytest.raises(GivenUpError, match="end as they begin"):
        swept(sweep_file, out, LocalPump(2))


@pytest.mark.nightly
def test_order_of_days_changes_nothing(sweep_file: Path, out: Path, expected: str) -> None:
    state = swept(sweep_file, out, days=3)
    assert state.run == 6
    state = swept(sweep_file, out)
    assert (state.before, state.run) == (6, 18)
    assert days_csv(state) == expected


def test_day_that_was_filed_before_its_worker_died_is_not_begun_again(sweep_file: Path, out: Path) -> None:
    plan = load_plan(str(sweep_file))
    with opened_sweep(plan, out) as store:
        spec = plan.spec(plan.points[0], 0)
        task = Task(str(out), store.token, spec, 0, again=False, runner=RUNNER)
        first = task_done(task)
        assert task_done(task).record == first.record
        assert begun_counts(out)[0] == 1
        day = out / "days" / day_name(spec, 0)
        day.write_bytes(day.read_bytes()[:-9])  # torn: it is run
        assert task_done(task).record == first.record
        write_day(out, msgspec.structs.replace(first.record, code="other"))
        assert task_done(task).record == first.record
    assert begun_counts(out)[0] == 3
