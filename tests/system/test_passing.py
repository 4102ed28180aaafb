"""Trains that run through stations, stand there without passengers, and meet where there is no platform."""

from itertools import chain
from pathlib import Path

import polars as pl
import pytest

from exchange.new_line import NewLineOptions, write_line
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.timetable import CallKind
from scenario.scenario import load_scenario
from simulation.world.roster import drawn_up
from study.collect.stops import with_passings
from study.feasibility.check import feasibility
from study.feasibility.finding import FindingKind, Severity
from study.record.spans import rows_by_span
from study.runner.run import FinishedRun
from tests.plain import run_on_plain
from tests.trains import timetable_of


# 1D passes Ogane, where 2U stands for it; 2U arrives there only shortly before where it does so `late`.
def times_of(leaves: str, arrives: str, passes: str, goes_on: str = "07:20:10 operational") -> str:
    return timetable_of(
        "passing",
        "karasuyama",
        f"1D down, portal:HSK.MD to stabled: HSK -/07:00; NIT pass 07:07:20; OGN pass {passes}; KRS 07:30/-",
        f"2U up, stabled to portal:HSK.MU: KRS -/{leaves}; OGN {arrives}/{goes_on}; HSK 07:41/-",
        A="1D",
        B="2U",
    )


SCENARIO = """
id = "passing"
name = "passing"
line = "line.toml"
timetable = "timetable.toml"
[trains]
default = "ev_e301"
"""


def run_of(
    folder: Path, *, leaves: str, arrives: str, passes: str = "07:17:30", platforms: bool = True
) -> FinishedRun:
    text = shipped_line("karasuyama").read_text("utf-8")
    if not platforms:
        for ends in ("platform_from_km = 12.5600, platform_to_km = 12.6400, ",):
            assert text.count(ends) == 2
            text = text.replace(ends, "")
    (folder / "line.toml").write_text(text, "utf-8")
    (folder / "timetable.toml").write_text(times_of(leaves, arrives, passes), "utf-8")
    (folder / "scenario.toml").write_text(SCENARIO, "utf-8")
    return run_on_plain(folder / "scenario.toml")


def rows(run: FinishedRun, train: str) -> dict[str, dict[str, float | None]]:
    found = run.tables.stops.filter(pl.col("train") == train)
    return {row["station"]: row for row in found.iter_rows(named=True)}


def slowest_mps(run: FinishedRun, train: str, from_m: float, to_m: float) -> float:
    there = run.tables.trajectory.filter(
        (pl.col("train") == train) & pl.col("kilometrage_m").is_between(from_m, to_m)
    )
    return min(there["speed_mps"])


@pytest.mark.parametrize("platforms", [True, False])
def test_a_train_passes_at_its_time_and_without_a_stand_where_another_waits_for_it(
    tmp_path: Path, platforms: bool
) -> None:
    run = run_of(tmp_path, leaves="07:00", arrives="07:16", platforms=platforms)
    assert run.broken == ()
    passing = rows(run, "1D")
    assert [row["kind"] for row in passing.values()] == ["stop", "pass", "pass", "stop"]
    for station in ("NIT", "OGN"):
        assert passing[station]["arrival_s"] is None
        assert passing[station]["late_departure_s"] == pytest.approx(0.0, abs=10.0), station
    assert slowest_mps(run, "1D", 200.0, 19_500.0) > 5.0
    stood = rows(run, "2U")["OGN"]
    assert stood["kind"] == "operational"
    assert stood["arrival_s"] < passing["OGN"]["departure_s"] < stood["departure_s"]  # type: ignore[operator]
    # A train that is sent another way, or ended, somewhere between has two spans.
    spans = [
        cut for span, trace in rows_by_span(run.result) for cut in ((span, trace[:600]), (span, trace[600:]))
    ]
    setup = run.scenario.setup
    calls = with_passings(run.result.stops, chain.from_iterable(drawn_up(setup, setup.line).values()), spans)
    passed_s = [call.departure_s for call in calls if call.kind is CallKind.PASS]
    assert passed_s == [passing[station]["departure_s"] for station in ("NIT", "OGN")]


def test_a_train_that_may_not_pass_yet_stands_and_goes_on_when_the_way_is_free(tmp_path: Path) -> None:
    run = run_of(tmp_path, leaves="07:07", arrives="07:18", passes="07:14")
    assert run.broken == ()
    passing, stood = rows(run, "1D")["OGN"], rows(run, "2U")["OGN"]
    assert slowest_mps(run, "1D", 12_000.0, 13_000.0) < 5.0
    assert passing["late_departure_s"] > 10.0  # type: ignore[operator]
    assert stood["arrival_s"] < rows(run, "1D")["KRS"]["arrival_s"]  # type: ignore[operator]


def test_who_serves_nobody_needs_no_dwell(tmp_path: Path) -> None:
    """2U, late at Ogane, leaves at once there; with passengers it would stay for the shortest dwell."""
    stays_s: dict[str, float] = {}
    for name, word in (("operational", " operational"), ("stop", "")):
        folder = tmp_path / name
        folder.mkdir()
        times = times_of("07:07:10", "07:18", "07:17:30", f"07:18:05{word}")
        (folder / "timetable.toml").write_text(times, "utf-8")
        (folder / "scenario.toml").write_text(SCENARIO.replace("line.toml", "karasuyama"), "utf-8")
        run = run_on_plain(folder / "scenario.toml")
        assert run.broken == ()
        stood = rows(run, "2U")["OGN"]
        stays_s[name] = stood["departure_s"] - stood["arrival_s"]  # type: ignore[operator]
    assert stays_s["stop"] >= 20.0
    assert stays_s["operational"] < 20.0


STATIONS = """name,km,tracks,kind
Asa,0.0,1,station
Mori,4.0,1,station
Hara,8.0,1,halt
Kawa,13.0,1,station
"""


def through(
    folder: Path, *, approach: bool = True, mori_at: str = "07:04:10", hara_at: str = "07:08:30"
) -> Path:
    """A scenario with a train that runs through a station without points, with or without an approach tag before it."""
    (folder / "list.csv").write_text(STATIONS, "utf-8")
    write_line(folder / "list.csv", folder / "through.toml", NewLineOptions(line_id="through"))
    text = (folder / "through.toml").read_text("utf-8")
    assert 'purpose = "approach"' in text
    if not approach:
        rows = [row for row in text.splitlines() if 'purpose = "approach"' not in row]
        (folder / "through.toml").write_text("\n".join(rows) + "\n", "utf-8")
    ids = {s.name.lower(): s.id for s in load_line(folder / "through.toml").stations.values()}
    calls = f"{ids['asa']} -/07:00; {ids['mori']} pass {mori_at}; {ids['hara']} pass {hara_at}; {ids['kawa']} 07:14/-"
    times = timetable_of("through", "through", f"1D down, stabled to stabled: {calls}", A="1D")
    (folder / "timetable.toml").write_text(times, "utf-8")
    words = SCENARIO.replace("line.toml", "through.toml").replace("passing", "through")
    (folder / "scenario.toml").write_text(words, "utf-8")
    return folder / "scenario.toml"


@pytest.mark.parametrize("approach", [True, False])
def test_a_train_runs_through_a_station_without_points_and_keeps_an_even_speed(
    tmp_path: Path, approach: bool
) -> None:
    run = run_on_plain(through(tmp_path, approach=approach))
    assert run.broken == ()
    assert slowest_mps(run, "1D", 1_000.0, 12_000.0) > 10.0
    passed = run.tables.stops.filter(pl.col("kind") == "pass")
    assert passed["late_departure_s"].abs().max() < 10.0  # type: ignore[operator]
    # From Hara on it has 5 min for 5 km: it slows down for that at Hara, and not at the next tag.
    after = run.tables.trajectory.filter(pl.col("kilometrage_m").is_between(8_500.0, 11_000.0))
    assert after["target_mps"].min() == after["target_mps"].max()
    assert run.summary["late_passing_s_max"] == pytest.approx(passed["late_departure_s"].max())


def test_a_time_of_passing_that_is_too_early_is_told(tmp_path: Path) -> None:
    setup = load_scenario(str(through(tmp_path, hara_at="07:05:30"))).setup
    (found,) = feasibility(setup).findings
    assert (found.kind, found.trains, found.severity) == (FindingKind.LEG, ("1D",), Severity.LATE)
    assert "to pass Hara" in found.text
    (tmp_path / "far").mkdir()
    setup = load_scenario(str(through(tmp_path / "far", mori_at="07:02:00", hara_at="07:02:50"))).setup
    assert [f.severity for f in feasibility(setup).findings] == [Severity.LATE, Severity.LATE]
