"""A run directory read back: the same inputs, tables and report as the run had, or one error that names the file."""

import errno
import json
import shutil
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st
from polars.testing import assert_frame_equal

import study.runner.run
from network.errors import InputError
from scenario.inputs import read_inputs
from scenario.scenario import load_scenario, shipped_scenarios
from study.drilling.drill import drill_shown, run_drill
from study.outcome import CutShortError
from study.record.directory import INCOMPLETE_FILE, SHOWN_FILE, TABLE_FILES, digests_of_tables
from study.record.parts import PagePart, TextTable
from study.record.read_back import parsed_inputs, read_run
from study.record.tables import RunTables
from study.report.report import report_again
from study.runner.run import FinishedRun, PartyLink, write_run
from tests.plain import run_on_plain

WHAT_IF = """
extends = "karasuyama_weekday"
id = "what_if"
name = "Slower points, heavier trains, a slack of 25 km/h"
seed = 3

[patch.line.set]
"points.OGN.11.throw_time_s" = 20.0
[[patch.line.add.limits]]
from_km = 3.0
to_km = 3.4
speed_kmh = 25.0
directions = ["down", "up"]
[patch.timetable.set]
"trains.323M.calls.OGN.departure" = "06:58"
[patch.train.ev_e301.times]
mass_empty_t = 1.1
[patch.air.times]
delay_mean_s = 2.0
"""


@pytest.fixture(scope="module")
def done() -> FinishedRun:
    return run_on_plain("rtri_test_line")


@pytest.fixture(scope="module")
def directory(done: FinishedRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_run(done, tmp_path_factory.mktemp("runs") / "run").parent


@pytest.fixture
def copy(directory: Path, tmp_path: Path) -> Path:
    return shutil.copytree(directory, tmp_path / "copy")


def test_a_run_is_read_back_as_it_was(done: FinishedRun, directory: Path) -> None:
    read, setup = read_run(directory), done.scenario.setup
    assert (read.line, read.timetable) == (setup.line, setup.timetable)
    assert {stock: kind.id for stock, kind in read.trains.items()} == {"K1": setup.trains["K1"].id}
    assert read.trains["K1"].row.tobytes() == setup.trains["K1"].row.tobytes()
    assert (read.name, read.settings.seed, read.inputs.changes) == (done.scenario.name, setup.seed, [])
    assert (read.settings.tables.air, read.settings.tables.driving) == (setup.air, setup.driving)
    assert read.inputs == done.scenario.inputs
    assert read.summary == {**done.summary, "out": str(directory)}
    for table in fields(RunTables):
        assert_frame_equal(getattr(read.tables, table.name), getattr(done.tables, table.name))


def test_the_report_made_again_from_the_directory_alone_is_the_same(directory: Path, tmp_path: Path) -> None:
    again = report_again(read_run(directory), tmp_path / "again")
    assert again.read_bytes() == (directory / "report.html").read_bytes()


def test_so_is_that_of_a_drill_with_its_marks_and_of_trains_that_learn(tmp_path: Path) -> None:
    drill = run_drill("rtri/09_manager_power", PartyLink.SIMULATED)
    first = write_run(drill.run, tmp_path / "drill", drill_shown(drill))
    read = read_run(first.parent)
    assert read.shown.drill == drill_shown(drill)
    assert report_again(read, tmp_path / "again").read_bytes() == first.read_bytes()

    file = tmp_path / "learns.toml"
    file.write_text('extends = "rtri_test_line"\nid = "learns"\nname = "x"\n[tuning]\ndays = 2\n', "utf-8")
    learns = run_on_plain(file)
    assert learns.result.learned_from
    first = write_run(learns, tmp_path / "learns")
    read = read_run(first.parent)
    assert read.learned == learns.result.learned
    assert report_again(read, tmp_path / "again2").read_bytes() == first.read_bytes()


@pytest.mark.parametrize("name", [*shipped_scenarios(), "what_if"])
def test_the_inputs_of_every_scenario_say_what_it_runs(name: str, tmp_path: Path) -> None:
    if name == "what_if":
        (tmp_path / "s.toml").write_text(WHAT_IF, "utf-8")
        name = str(tmp_path / "s.toml")
    scenario = load_scenario(name, seed=17)
    (tmp_path / "inputs.json").write_text(scenario.inputs.as_json(), "utf-8")
    inputs = read_inputs(tmp_path / "inputs.json")
    line, timetable, trains, settings = parsed_inputs(inputs, "inputs.json")
    assert (line, timetable) == (scenario.setup.line, scenario.setup.timetable)
    assert {stock: kind.row.tobytes() for stock, kind in trains.items()} == {
        stock: kind.row.tobytes() for stock, kind in scenario.setup.trains.items()
    }
    assert (settings.id, settings.name, settings.seed) == (scenario.id, scenario.name, 17)
    for table in ("air", "driving", "sensors", "scatter", "tuning", "vision", "limits", "operation"):
        assert getattr(settings, table) == getattr(scenario.setup, table)
    assert inputs == scenario.inputs


def test_inputs_hold_what_patches_made_of_the_files(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(WHAT_IF, "utf-8")
    inputs = load_scenario(str(tmp_path / "s.toml")).inputs
    assert next(p for p in inputs.line["points"] if p["id"] == "OGN.11")["throw_time_s"] == 20.0
    slack = next(limit for limit in inputs.line["alignments"][0]["limits"] if limit["from_km"] == 3.0)
    assert slack["speed_kmh"] == 25.0
    assert inputs.scenario["seed"] == 3
    assert "extends" not in inputs.scenario and "patch" not in inputs.scenario
    plain = load_scenario("karasuyama_weekday").inputs
    weights = [i.trains["ev_e301"]["body"]["mass_empty_t"] for i in (inputs, plain)]
    assert weights[0] == pytest.approx(1.1 * weights[1])


def rewritten(path: Path, change: Callable[[dict[str, Any]], object]) -> None:
    data = json.loads(path.read_text("utf-8"))
    change(data)
    path.write_text(json.dumps(data), "utf-8")


def error_of(directory: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_run(directory)
    text = str(caught.value)
    assert "\n" not in text and str(directory) in text
    return text


@pytest.mark.parametrize(
    "change, expected",
    [
        (lambda d: d.pop("line"), "line; expected this key, which is missing"),
        (lambda d: d.update(format=2), "format is 2; expected 1, the format of this version"),
        (lambda d: d["line"]["sections"].pop(0), "line."),
        (lambda d: d["line"]["line"].update(max_speed_kmh="fast"), "line.line.max_speed_kmh is 'fast'"),
        (lambda d: d["timetable"]["timetable"].update(line="other"), "timetable.timetable.line is 'other'"),
        (lambda d: d["stock"].clear(), "stock.K1"),
        (lambda d: d["stock"].update(K1="nothing"), "stock.K1 is 'nothing'"),
        (lambda d: d["scenario"].update(seed=-1), "scenario.seed is -1"),
        (lambda d: next(iter(d["trains"].values())).pop("body"), "trains."),
        (lambda d: d.update(more=1), "more is 1"),
    ],
)
def test_damaged_inputs_are_named_by_their_key(
    copy: Path, change: Callable[[dict[str, Any]], object], expected: str
) -> None:
    rewritten(copy / "inputs.json", change)
    assert f"inputs.json: {expected}" in error_of(copy)


@pytest.mark.parametrize("name", ["inputs.json", "summary.json", "stops.parquet", "trajectory.parquet"])
@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"PAR1 and what not", b'{"a": 1}', b"\xff\xfe"])
def test_files_of_another_kind_are_refused(copy: Path, name: str, content: bytes) -> None:
    (copy / name).write_bytes(content)
    assert name in error_of(copy)


@pytest.mark.parametrize("content", [b"", b"[]", b'{"broken": 1}', b'{"drill": {}}'])
def test_what_the_report_shows_is_refused_when_it_is_something_else(copy: Path, content: bytes) -> None:
    (copy / "shown.json").write_bytes(content)
    assert "shown.json" in error_of(copy)


def test_what_is_no_directory_of_a_finished_run_says_what_it_is(copy: Path, tmp_path: Path) -> None:
    assert "No such file or directory" in error_of(tmp_path / "nowhere")
    assert "Not a directory" in error_of(copy / "summary.json")
    (tmp_path / "empty").mkdir()
    assert "it has no summary.json" in error_of(tmp_path / "empty")
    (copy / "incomplete.txt").write_text("x")
    (copy / "shown.json").unlink()
    assert "this one was cut short" in error_of(copy)
    (copy / "incomplete.txt").unlink()
    (copy / "inputs.json").unlink()
    assert "it is of an older version" in error_of(copy)


def test_a_table_of_another_run_is_refused(copy: Path, directory: Path) -> None:
    stops = pl.read_parquet(copy / "stops.parquet")
    stops.head(1).write_parquet(copy / "stops.parquet")
    assert "stops.parquet; expected the table that this run has written" in error_of(copy)
    stops.with_columns(pl.lit("ELSEWHERE").alias("station")).write_parquet(copy / "stops.parquet")
    rewritten(copy / "shown.json", lambda d: d.update(tables=digests_of_tables(copy)))
    assert "stops.parquet: station is 'ELSEWHERE'" in error_of(copy)
    rewritten(copy / "summary.json", lambda d: d.update(scenario="another"))
    assert "summary.json: scenario is 'another'; expected rtri_test_line" in error_of(copy)


@given(st.sampled_from(sorted(TABLE_FILES)), st.data())
def test_a_table_with_any_byte_changed_is_refused(directory: Path, name: str, data: st.DataObject) -> None:
    """The decoder trusts what it reads: one wrong length in it ends the process."""
    whole = (directory / name).read_bytes()
    place = data.draw(st.integers(0, len(whole) - 1))
    other = data.draw(st.integers(0, 255).filter(lambda byte: byte != whole[place]))
    try:
        (directory / name).write_bytes(whole[:place] + bytes([other]) + whole[place + 1 :])
        assert name in error_of(directory)
    finally:
        (directory / name).write_bytes(whole)


def test_a_run_of_before_there_was_a_table_is_told_as_such(copy: Path) -> None:
    """What needs no such table reads the run; what does gets one error, that names the table and what to do."""
    written = json.loads((copy / SHOWN_FILE).read_text("utf-8"))
    for name in ("battery.parquet", "charges.parquet"):
        (copy / name).unlink()
        del written["tables"][name]
    (copy / SHOWN_FILE).write_text(json.dumps(written), "utf-8")
    run = read_run(copy)
    assert run.tables.stops.height > 0
    with pytest.raises(InputError, match="earlier version") as error:
        assert run.tables.battery
    assert error.value.file.endswith("battery.parquet") and "run the scenario again" in str(error.value)


def test_a_run_that_lost_its_report_alone_is_whole_again(done: FinishedRun, tmp_path: Path) -> None:
    """Its disk was full as the report was written: all else stays, can be read, and the report is made of it."""
    first = write_run(done, tmp_path / "first").read_bytes()
    with pytest.MonkeyPatch.context() as patch, pytest.raises(CutShortError) as cut:
        patch.setattr(study.runner.run, "write_report", no_room)
        write_run(done, tmp_path / "run")
    kept = tmp_path / "run-incomplete"
    assert str(kept) in str(cut.value)
    assert "branchline report" in (kept / INCOMPLETE_FILE).read_text("utf-8")
    assert not (kept / "report.html").exists()
    assert report_again(read_run(kept), kept).read_bytes() == first
    assert {path.name for path in kept.iterdir()} == {path.name for path in (tmp_path / "first").iterdir()}


def test_what_was_drawn_for_a_late_day_is_in_the_report_made_again(done: FinishedRun, tmp_path: Path) -> None:
    drawn = PagePart(
        "What was drawn for this day",
        "Seed 1",
        grids=(TextTable(("when", "seconds"), (("06:00", "3.0"),), 1),),
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study.runner.run, "late_part", lambda _setup: drawn)
        first = write_run(done, tmp_path / "run")
    assert report_again(read_run(first.parent), tmp_path / "again").read_bytes() == first.read_bytes()
    assert "What was drawn for this day" in first.read_text("utf-8")


def no_room(directory: Path, *_rest: object) -> Path:
    (directory / ".report.html.part").write_bytes(b"<ht")
    raise OSError(errno.ENOSPC, "No space left on device", str(directory))
