"""A whole weekday of the Karasuyama line through the command: what the line's operator would look at first."""

import json
import re
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil
import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Line
from network.timetable import AtPortal, Timetable, load_timetable
from scenario.scenario import load_scenario
from simulation.journal import encode_entry, read_journal
from study.capacity.blocking_table import read_blocking
from study.capacity.compared import theory_and_run
from study.capacity.occupation import OccupationPart, conflicts_of
from study.capacity.theory import occupations
from study.record.tables import RunTables

LATE_S_MAX = 60.0
STOP_ERROR_M_MAX = 1.0
PROMISED = {
    *("digest", "trains_planned", "trains_arrived", "late_s_max", "early_departure_s_max", "stops"),
    *("stop_error_m_mean", "stop_error_m_sigma", "stop_error_m_max_abs", "invariants_broken", "energy_kwh"),
    *("telegrams", "wall_s", "out"),
}


@dataclass(frozen=True)
class Day:
    """One run of the weekday; `processes` are the wayside devices seen while it ran."""

    figures: dict[str, Any]
    err: str
    folder: Path
    processes: tuple[tuple[str, str], ...] = ()
    left_over: int = 0

    def tables(self) -> RunTables:
        return RunTables.read(self.folder)

    def journal(self) -> list[dict[str, Any]]:
        text = (self.folder / "journal.jsonl").read_text("utf-8")
        return [json.loads(line) for line in text.splitlines()]


@pytest.fixture(scope="module")
def line() -> Line:
    return load_line(shipped_line("karasuyama"))


@pytest.fixture(scope="module")
def timetable(line: Line) -> Timetable:
    return load_timetable(shipped_timetable("karasuyama_weekday"), line)


@pytest.fixture(scope="module")
def run_day(main_in: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Day]:
    def run(*options: str) -> Day:
        cwd = tmp_path_factory.mktemp("day")
        ended = main_in("run", "karasuyama_weekday", "--json", *options, cwd=cwd)
        assert ended.code == 0, ended.err
        figures = ended.figures()
        return Day(figures, ended.err, Path(figures["out"]))

    return run


@pytest.fixture(scope="module")
def simulated(run_day: Callable[..., Day]) -> Day:
    return run_day("--link", "simulated")


@pytest.fixture(scope="module")
def other_seed(run_day: Callable[..., Day]) -> Day:
    return run_day("--seed", "2")


@pytest.fixture(scope="module")
def zenoh(command: tuple[str, ...], tmp_path_factory: pytest.TempPathFactory) -> Day:
    cwd = tmp_path_factory.mktemp("zenoh")
    arguments = ("run", "karasuyama_weekday", "--link", "zenoh", "--json", "--out", "day")
    pipe = subprocess.PIPE
    with subprocess.Popen([*command, *arguments], cwd=cwd, stdout=pipe, stderr=pipe, text=True) as program:
        assert program.stderr is not None
        head = program.stderr.readline()
        children = psutil.Process(program.pid).children(recursive=True)
        lines = [child.cmdline() for child in children]
        out, err = program.communicate()
    assert program.returncode == 0, err
    processes = tuple(sorted((c[c.index("host.serve") + 1], c[c.index("--party") + 1]) for c in lines))
    _, alive = psutil.wait_procs(children, timeout=120)
    return Day(json.loads(out), head + err, cwd / "day", processes, len(alive))


def test_the_object_on_stdout_has_all_that_is_promised(simulated: Day) -> None:
    figures = simulated.figures
    assert set(figures) >= PROMISED
    assert set(figures["energy_kwh"]) == {"traction", "regenerated", "auxiliary"}
    assert re.fullmatch("[0-9a-f]{32}", figures["digest"])
    assert figures["wall_s"] > 0.0
    summary = json.loads((simulated.folder / "summary.json").read_text("utf-8"))
    assert {"outcome": "good"} | summary == figures
    assert simulated.folder.is_absolute()


def test_every_train_runs_its_whole_journey(simulated: Day) -> None:
    figures = simulated.figures
    assert (figures["trains_planned"], figures["trains_arrived"]) == (27, 27)
    assert figures["empty_workings_arrived"] == figures["empty_workings_planned"]
    assert (figures["invariants_broken"], figures["collisions"], figures["broken"]) == (0, 0, [])
    assert figures["late_s_max"] <= LATE_S_MAX
    assert figures["early_departure_s_max"] == 0.0
    assert figures["stop_error_m_max_abs"] <= STOP_ERROR_M_MAX
    assert abs(figures["stop_error_m_mean"]) + figures["stop_error_m_sigma"] <= STOP_ERROR_M_MAX


def test_every_call_of_the_timetable_was_kept(simulated: Day, timetable: Timetable) -> None:
    """Not by the summary: each call of each train, looked up in the table of stops."""
    rows = {(r["train"], r["station"]): r for r in simulated.tables().stops.iter_rows(named=True)}
    calls = 0
    for train in timetable.trains.values():
        for index, call in enumerate(train.calls):
            row = rows.pop((train.number, call.station_id))
            calls += 1
            if call.departure_s is not None and index + 1 < len(train.calls):
                assert 0.0 <= row["departure_s"] - call.departure_s <= LATE_S_MAX, row
            if index == 0:
                continue
            assert row["arrival_s"] - (call.arrival_s or call.first_s) <= LATE_S_MAX, row
            assert abs(row["stop_error_m"]) <= STOP_ERROR_M_MAX, row
    assert not rows
    # A train that does not come in by a portal stands at its first call already: no stop of its own.
    standing = sum(not isinstance(train.begins, AtPortal) for train in timetable.trains.values())
    assert simulated.figures["stops"] == calls - standing


def test_the_summary_follows_from_the_tables(simulated: Day) -> None:
    figures, tables = simulated.figures, simulated.tables()
    late = [*tables.stops["late_arrival_s"].drop_nulls(), *tables.stops["late_departure_s"].drop_nulls()]
    assert figures["late_s_max"] == pytest.approx(max(0.0, *late), abs=0.051)
    for name, total in figures["energy_kwh"].items():
        booked = (tables.energy, tables.layovers)
        assert total == pytest.approx(sum(table[f"{name}_kwh"].sum() for table in booked))
        assert total > 0.0
    assert figures["energy_kwh"]["regenerated"] < figures["energy_kwh"]["traction"]
    assert figures["telegrams"]["sent"] == tables.telegrams["sent"].sum()
    # 20.4 km from Hoshakuji to Karasuyama, the published length of the line, and up to 1 km from or to a portal
    for distance_km in tables.energy.filter(tables.energy["revenue"])["distance_km"]:
        assert 20.1 < distance_km < 21.5


def test_no_train_runs_faster_than_the_least_running_time(simulated: Day) -> None:
    """Its load may be less than the mean that is reckoned with: 3 s, or 2 %, at most."""
    margins = simulated.tables().margins
    assert len(margins) == len(margins.filter(margins["run_s"].is_not_null())) > 180
    for row in margins.iter_rows(named=True):
        assert row["run_s"] >= min(row["least_s"] - 3.0, 0.98 * row["least_s"]), row
        assert row["attainable_s"] >= row["least_s"], row


def test_another_way_to_work_out_the_day_s_traction_agrees(simulated: Day) -> None:
    rows = {row["figure"]: row for row in simulated.figures["comparisons"]}
    assert abs(rows["traction of the day as booked"]["difference_percent"]) < 2.0
    sources = " ".join(row["source"] for row in rows.values())
    for source in ("Toyo Keizai online, article 50307", "livedoor news 16541981", "Sankei, 26 October 2015"):
        assert source in sources


def test_a_section_has_one_holder_at_every_time(simulated: Day) -> None:
    """By the manager's own words in the journal, read without the checkers."""
    holder: dict[str, str] = {}
    grants = 0
    for entry in simulated.journal():
        if entry["who"] != "block-manager" or entry["what"] not in ("granted", "accepted", "freed"):
            continue
        for section in entry["sections"]:
            if entry["what"] == "freed":
                assert holder.pop(section) == entry["unit"]
            else:
                assert holder.setdefault(section, entry["unit"]) == entry["unit"], entry
                grants += 1
    assert grants > 27 * 4


def test_the_journal_is_one_readable_object_a_line(simulated: Day) -> None:
    entries = simulated.journal()
    assert all(set(entry) >= {"t", "who", "what"} for entry in entries)
    typed = read_journal(simulated.folder / "journal.jsonl")
    assert len(typed) == len(entries)
    lines = (simulated.folder / "journal.jsonl").read_bytes().splitlines()
    assert [encode_entry(entry) for entry in typed] == lines
    times_s = [entry["t"] for entry in entries]
    assert times_s == sorted(times_s)


def test_the_run_directory_is_whole_and_its_report_opens_offline(simulated: Day) -> None:
    names = {path.name for path in simulated.folder.iterdir()}
    tables = {"trajectory", "stops", "blocks", "blocking", "telegrams", "events"}
    tables |= {"energy", "energy_legs", "energy_hours", "layovers", "margins", "comparisons", "waits"}
    tables |= {"driving", "battery", "charges", "road", "crossings", "warnings"}
    texts = {"summary.json", "inputs.json", "shown.json", "journal.jsonl", "report.html"}
    assert names == texts | {f"{t}.parquet" for t in tables}
    html = (simulated.folder / "report.html").read_text("utf-8")
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!#|data:)""", html)
    assert not re.search(r"@import|url\(\s*['\"]?(?!data:|#)|\bfetch\(|XMLHttpRequest|<link\b", html)
    assert simulated.figures["digest"] in html
    assert {path.name for path in simulated.folder.parent.iterdir()} == {"karasuyama_weekday"}


def test_no_section_is_two_trains(simulated: Day) -> None:
    assert conflicts_of(read_blocking(simulated.tables().blocking)) == ()


@pytest.mark.nightly
def test_theory_says_when_each_section_is_whose(main: Callable[..., Any], tmp_path: Path) -> None:
    """The same sections as in a run in which people take the means of their times, on average within 2 s."""
    text = 'extends = "karasuyama_weekday"\nid = "means"\nname = "People take their means"\n[people]\nsigma = 0.0\n'
    (tmp_path / "means.toml").write_text(text, "utf-8")
    ended = main("run", "means.toml", "--json")
    assert ended.code == 0, ended.err
    run = read_blocking(RunTables.read(Path(ended.figures()["out"])).blocking)
    both = theory_and_run(occupations(load_scenario("karasuyama_weekday").setup), run)
    assert (both.only_theory, both.only_run) == ((), ())
    mean_s, worst_s = both.whole_s()
    assert abs(mean_s) < 2.0
    assert abs(worst_s) < 10.0
    by_part = {one.part: one for one in both.differences()}
    # At a portal the crew's way in hides a part of the throw that goes by how long the air took.
    assert by_part[OccupationPart.THROW].mean_s == pytest.approx(0.0, abs=0.01)
    assert abs(by_part[OccupationPart.THROW].worst_s) < 0.5
    assert by_part[OccupationPart.CHANGE_ENDS].worst_s == pytest.approx(0.0, abs=0.01)
    assert abs(by_part[OccupationPart.AIR].mean_s) < 0.1


@pytest.mark.nightly
def test_devices_as_processes_change_nothing(simulated: Day, zenoh: Day) -> None:
    different = {key for key, value in simulated.figures.items() if zenoh.figures[key] != value}
    assert different <= {"link", "wall_s", "out"}
    journals = [(day.folder / "journal.jsonl").read_bytes() for day in (simulated, zenoh)]
    assert journals[0] == journals[1]


@pytest.mark.nightly
def test_one_process_for_each_device_and_none_afterwards(zenoh: Day, line: Line) -> None:
    terminals = {points.terminal_id for points in line.points.values()}
    expected = [("block-manager", "block-manager"), *(("point-terminal", name) for name in terminals)]
    assert zenoh.processes == tuple(sorted(expected))
    assert zenoh.left_over == 0


@pytest.mark.nightly
def test_another_seed_is_another_day_that_runs_as_well(simulated: Day, other_seed: Day) -> None:
    assert other_seed.figures["digest"] != simulated.figures["digest"]
    assert other_seed.figures["seed"] == 2
    assert other_seed.figures["trains_arrived"] == 27
    assert other_seed.figures["late_s_max"] <= LATE_S_MAX
    assert other_seed.figures["early_departure_s_max"] == 0.0
    assert other_seed.figures["stop_error_m_max_abs"] <= STOP_ERROR_M_MAX
    assert other_seed.figures["invariants_broken"] == 0


def test_progress_is_on_stderr_alone(simulated: Day) -> None:
    assert "karasuyama_weekday: 12:00" in simulated.err
    assert not re.search("Traceback|Warning", simulated.err)
