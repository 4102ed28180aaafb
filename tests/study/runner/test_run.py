"""Running a scenario: what makes a run a failure, and the run directory, whole or not at all."""

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import study.runner.run
from host.party import PartySpec
from network.errors import InputError
from radio.noted import TelegramDropped
from scenario.scenario import load_scenario
from simulation.events import WORLD, Danger, Unsafe
from simulation.journal import Journal
from simulation.judge.checkers import Violation
from simulation.judge.rail import LowAdhesion
from simulation.result import Ending, RunResult, Waiting
from simulation.setup import Setup
from simulation.world.records import TRACE
from study.record.directory import RUN_FILES, check_out
from study.record.tables import RunTables
from study.runner.devices import specs_of
from study.runner.outcome import outside_design
from study.runner.run import (
    CarrierKind,
    FinishedRun,
    PartyLink,
    UnitsAt,
    broken_said,
    execute,
    link_of,
    terminals_of,
    write_run,
)

TABLES = (
    *("trajectory", "stops", "blocks", "blocking", "telegrams", "events"),
    *("energy", "energy_legs", "energy_hours", "layovers", "margins", "comparisons", "waits"),
    *("driving", "battery", "charges", "road", "crossings", "warnings"),
)
TEXTS = ("summary.json", "inputs.json", "shown.json", "journal.jsonl", "report.html")
WRITTEN = {*TEXTS, *(f"{name}.parquet" for name in TABLES)}


def broken_by(run: RunResult, setup: Setup) -> tuple[str, ...]:
    return tuple(said.en for said in broken_said(run, setup))


@pytest.fixture(scope="module")
def done() -> FinishedRun:
    return execute(load_scenario("rtri_test_line"), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)


def result(
    *,
    arrived: tuple[str, ...] = ("T1",),
    waiting: list[Waiting] | None = None,
    violations: tuple[Violation, ...] = (),
    collisions: tuple[str, ...] = (),
    unsafe: str = "",
    unfinished: tuple[str, ...] = (),
    ended_because: Ending = Ending.FINISHED,
) -> RunResult:
    journal = Journal()
    if unsafe:
        journal.write(5.0, WORLD, Unsafe(unit_id="K1", danger=Danger.SET_AGAINST, points_id=unsafe))
    return RunResult(
        name="made up",
        seed=1,
        link="simulated",
        stock_ids=("K1",),
        begin_step=0,
        end_step=10,
        trains_planned=("T1",),
        trains_arrived=arrived,
        empty_planned=(),
        empty_arrived=(),
        stops=[],
        energy=[],
        waiting=waiting or [],
        violations=violations,
        collisions=collisions,
        telegrams={("K1", "B-W", "PointsCommand"): Counter()},
        trace=np.zeros(0, dtype=TRACE),
        spans=[],
        journal=journal,
        ended_because=ended_because,
        unfinished=unfinished,
    )


def test_a_good_run_breaks_nothing(done: FinishedRun) -> None:
    assert done.broken == ()
    assert done.summary["trains_arrived"] == 1
    assert done.summary["carrier"] == "plain"


def test_what_makes_a_run_a_failure() -> None:
    setup = load_scenario("rtri_test_line").setup
    assert broken_by(result(), setup) == ()
    assert broken_by(result(collisions=("a frontal collision",)), setup) == ("a frontal collision",)
    seen = Violation(1.0, "points-under-train", "P5 moves under K1")
    assert broken_by(result(violations=(seen,)), setup) == ("points-under-train: P5 moves under K1",)
    forced = "ran through points P5 set against it"
    assert broken_by(result(unsafe="P5"), setup) == (f"K1 {forced}",)
    stays = "K1 has not left the line and does not stand where its last duty ends"
    assert broken_by(result(unfinished=("K1",)), setup) == (stays,)


CUT_SHORT = [ending for ending in Ending if ending is not Ending.FINISHED and not ending.of_part]


@pytest.mark.parametrize("because", [Ending.PART_OVER, Ending.STOPPED])
def test_who_is_on_its_way_at_the_end_of_a_part_is_not_missing_but_what_is_broken_is(because: Ending) -> None:
    setup = load_scenario("rtri_test_line").setup
    on_its_way = result(arrived=(), unfinished=("K1",), ended_because=because)
    assert broken_by(on_its_way, setup) == ()
    assert broken_by(replace(on_its_way, collisions=("a frontal collision",)), setup) == (
        "a frontal collision",
    )


@pytest.mark.parametrize("because", CUT_SHORT)
def test_a_run_that_was_cut_short_is_a_failure_though_all_have_arrived(because: Ending) -> None:
    setup = load_scenario("rtri_test_line").setup
    told = broken_by(result(ended_because=because), setup)
    assert told == (f"the run was cut short: {because.value}",)


def test_what_is_outside_the_design_is_told_and_makes_no_failure_but_a_collision_does() -> None:
    setup = load_scenario("rtri_test_line").setup
    slid = "ran through points P5 set against it"
    apart = (Violation(5.0, "inside-holding", "K1 is in section 5"), Violation(5.0, "unsafe", f"K1 {slid}"))
    stretch = LowAdhesion("K1", 36_000.0, 0.1, 36_060.0)
    run = replace(result(unsafe="P5"), outside_design=apart, slippery=(stretch, replace(stretch, least=0.05)))
    assert broken_by(run, setup) == ()
    assert outside_design(run) == (
        "K1 had less adhesion than the design counts on 2 times from 10:00:00 to 10:01:00,"
        " at least 0.05 of the dry rail's",
        "00:00:05 inside-holding: K1 is in section 5",
        f"00:00:05 unsafe: K1 {slid}",
    )
    assert broken_by(replace(run, collisions=("a frontal collision",)), setup) == ("a frontal collision",)
    other = replace(run, outside_design=(Violation(4.0, "unsafe", f"K1 {slid}"),))
    assert broken_by(other, setup) == (f"K1 {slid}",)


def test_a_train_that_did_not_arrive_is_told_once_with_what_it_waits_for() -> None:
    setup = load_scenario("rtri_test_line").setup
    late = Violation(9.0, "everyone-arrives", "T1 has not arrived")
    place = "section 6 at km 0.700"
    for stands, waits_for, end in (
        (True, "route 3>8: lost", f"stands in {place} and waits for route 3>8: the proof was lost"),
        (True, "nothing", f"stands in {place} and waits for nothing"),
        (False, "nothing", f"was on its way in {place}"),
    ):
        waiting = [Waiting("K1", "T1", place, waits_for, stands)]
        broken = broken_by(result(arrived=(), waiting=waiting, violations=(late,)), setup)
        assert broken == ("1 train did not arrive: T1", f"T1 (K1) {end}")


def test_impossible_meets_are_told_when_trains_are_missing() -> None:
    setup = load_scenario("karasuyama_without_loop").setup
    assert broken_by(result(), setup) == ()
    told = broken_by(result(arrived=()), setup)
    assert any(text.startswith("321M and 322M would meet at Ogane") for text in told)


def test_every_run_has_new_keys_which_leave_no_trace_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bits that flip in the air change codes and capabilities too: which ones they are decides nothing."""
    keys = []

    def seen(setup: Setup, master_key: bytes) -> tuple[PartySpec, ...]:
        keys.append(master_key)
        return specs_of(setup, master_key)

    monkeypatch.setattr(study.runner.run, "specs_of", seen)
    scenario = load_scenario("rtri_test_line")
    noisy = replace(scenario.setup, air=scenario.setup.air.model_copy(update={"flip_p": 1e-3}))
    scenario = replace(scenario, setup=noisy)
    runs = [execute(scenario, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN) for _ in range(2)]
    runs.append(execute(scenario, PartyLink.ZENOH, units=UnitsAt.PROCESSES, carrier=CarrierKind.PLAIN))
    assert len(set(keys)) == len(keys) == 3
    dropped = [e for e in runs[0].result.journal.entries if isinstance(e.event, TelegramDropped)]
    assert len(dropped) > 5
    assert len({run.result.digest for run in runs}) == 1
    assert len({run.result.journal.to_bytes() for run in runs}) == 1


def test_what_starts_the_devices_of_a_line() -> None:
    setup = load_scenario("rtri_test_line").setup
    devices = {spec.party_id: spec.role.value for spec in specs_of(setup, b"m" * 32)}
    assert terminals_of(setup.line) == ("A-E", "A-W", "B-E", "B-W")
    assert devices == {"block-manager": "block-manager"} | dict.fromkeys(
        terminals_of(setup.line), "point-terminal"
    )


def test_links_by_name() -> None:
    assert [link_of(link.value) for link in PartyLink] == list(PartyLink)
    with pytest.raises(InputError, match="simulated or zenoh"):
        link_of("Zenoh")


def test_the_directory_holds_all_of_the_run(done: FinishedRun, tmp_path: Path) -> None:
    report = write_run(done, tmp_path / "a" / "run")
    assert report == tmp_path / "a" / "run" / "report.html"
    tables = RunTables.read(report.parent)
    for name in TABLES:
        assert getattr(tables, name).equals(getattr(done.tables, name))
    summary = json.loads((report.parent / "summary.json").read_text("utf-8"))
    assert summary == json.loads(json.dumps(done.summary | {"out": str(report.parent)}))
    assert (report.parent / "journal.jsonl").read_bytes() == done.result.journal.to_bytes()
    assert report.parent.stat().st_mode & 0o055 == 0o055  # to be read by others, as any new folder
    assert [path.name for path in report.parent.parent.iterdir()] == ["run"]


def test_writing_twice_leaves_the_second(done: FinishedRun, tmp_path: Path) -> None:
    write_run(done, tmp_path / "run")
    (tmp_path / "run" / "summary.json").write_text("old", "utf-8")
    (tmp_path / "run" / "events.parquet").unlink()
    write_run(done, tmp_path / "run")
    assert {path.name for path in (tmp_path / "run").iterdir()} == WRITTEN
    assert json.loads((tmp_path / "run" / "summary.json").read_text("utf-8"))["out"] == str(tmp_path / "run")
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


@pytest.mark.parametrize("failing", ["write_report", "_write_files"])
def test_what_fails_while_writing_leaves_the_run_before(
    done: FinishedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: str
) -> None:
    write_run(done, tmp_path / "run")
    before = {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}

    def full(*_: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(study.runner.run, failing, full)
    with pytest.raises(OSError, match="no space left"):
        write_run(done, tmp_path / "run")
    assert {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_what_fails_at_the_last_rename_puts_the_run_before_back(
    done: FinishedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_run(done, tmp_path / "run")
    rename = Path.rename

    def fail_once(self: Path, target: Path) -> Path:
        if self.name == "new":
            raise OSError("power failed")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fail_once)
    with pytest.raises(OSError, match="power failed"):
        write_run(done, tmp_path / "run")
    assert {path.name for path in (tmp_path / "run").iterdir()} == WRITTEN
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_all_that_a_run_writes_may_be_replaced() -> None:
    assert RUN_FILES >= WRITTEN


def test_only_a_run_may_be_replaced(done: FinishedRun, tmp_path: Path) -> None:
    check_out(tmp_path / "new")
    check_out(tmp_path)  # empty
    (tmp_path / "notes.txt").write_text("mine", "utf-8")
    for out in (tmp_path, tmp_path / "notes.txt"):
        with pytest.raises(InputError) as refused:
            write_run(done, out)
        assert (refused.value.key, refused.value.value) == ("--out", out)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
