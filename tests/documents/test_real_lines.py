"""The Kururi and Isumi lines: nobody had a hand in their files, and their days run as published."""

import re
from pathlib import Path
from typing import Final

import numpy as np
import pytest

from documents.real_lines import DAYS, LINES, CalendarDay, RealLine, new_line, scenarios, timetable_text
from exchange.curve_fit import LOST_M
from network.alignment import positions
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Line
from scenario.part_of_day import part_of_day
from scenario.scenario import Scenario, load_scenario
from study.feasibility.check import feasibility
from study.runner.run import PartyLink, execute
from sumo_cfg.build import net_digest, shipped_net
from sumo_cfg.writer import write_plain

DATA: Final = Path(__file__).resolve().parents[2] / "../shared/data"
needs_data = pytest.mark.skipif(
    not (DATA / "geometry").exists(), reason="the geometry and timetable data is not beside this checkout"
)
# Where opposing trains pass, by the published times alone and by articles on the lines.
MEETS: Final = {"kururi": {"Yokota", "Kururi"}, "isumi": {"Otaki", "Kuniyoshi"}}
LENGTH_KM: Final = {"kururi": 32.2, "isumi": 26.8}  # official
TRAINS: Final = {"kururi": (40, 40), "isumi": (29, 25)}  # of the source, weekday and holiday
FIT: Final = re.compile(r"rms ([\d.]+) m, worst ([\d.]+) m at km [\d.]+")
each_line = pytest.mark.parametrize("real", LINES, ids=lambda real: real.id)
each_day = pytest.mark.parametrize("day", DAYS, ids=lambda day: day.id)


def _fit_told(line: Line) -> tuple[tuple[str, ...], tuple[float, float]]:
    """What a line assumes without its fit's figures, and these: rms and worst, m."""
    ((rms, worst),) = (found.groups() for text in line.assumed if (found := FIT.search(text)))
    return tuple(FIT.sub("", text) for text in line.assumed), (float(rms), float(worst))


@pytest.mark.parametrize("path", scenarios(), ids=lambda path: path.stem)
def test_the_committed_scenario_is_what_is_written(path: Path) -> None:
    assert path.read_text("utf-8") == scenarios()[path]


@each_line
def test_the_committed_net_is_this_lines(real: RealLine) -> None:
    line = load_line(shipped_line(real.id))
    assert net_digest(shipped_net(real.id)) == write_plain(line).digest


@pytest.mark.nightly
@needs_data
@each_line
def test_the_committed_line_is_what_the_list_and_the_geometry_make(real: RealLine) -> None:
    pytest.importorskip("pyproj")
    committed, made = load_line(shipped_line(real.id)), new_line(real, DATA).line
    (said, (ours_rms_m, ours_worst_m)), (again_said, (rms_m, worst_m)) = map(_fit_told, (committed, made))
    assert said == again_said
    # Which of two fits that are as good is found hangs on the last digits of the processor's linear algebra.
    assert rms_m == pytest.approx(ours_rms_m, abs=1.0)
    assert max(ours_worst_m, worst_m) < LOST_M
    for ours, theirs in zip(committed.stations.values(), made.stations.values(), strict=True):
        assert (ours.id, ours.name, ours.name_ja, len(ours.tracks)) == (
            theirs.id,
            theirs.name,
            theirs.name_ja,
            len(theirs.tracks),
        )
        assert ours.position_m == pytest.approx(theirs.position_m, abs=5.0)
    assert list(committed.sections) == list(made.sections)
    assert [p.normal_piece for p in committed.points.values()] == [
        p.normal_piece for p in made.points.values()
    ]
    assert [t.purpose for t in committed.tags.values()] == [t.purpose for t in made.tags.values()]
    main, again = committed.alignments["main"], made.alignments["main"]
    at_m = np.arange(main.from_m + 5.0, min(main.to_m, again.to_m), 25.0)
    apart_m = np.hypot(*(positions(main, at_m) - positions(again, at_m))[:, :2].T)
    assert np.sqrt(np.mean(apart_m**2)) < 2.0 * (ours_rms_m + rms_m)
    assert apart_m.max() < ours_worst_m + worst_m


@needs_data
@each_day
@each_line
def test_the_committed_timetable_is_what_the_source_makes(real: RealLine, day: CalendarDay) -> None:
    line = load_line(shipped_line(real.id))
    assert shipped_timetable(f"{real.id}_{day.id}").read_text("utf-8") == timetable_text(
        real, day, line, DATA
    )


@each_line
def test_the_line_is_as_long_as_it_officially_is(real: RealLine) -> None:
    stations = list(load_line(shipped_line(real.id)).stations.values())
    assert len(stations) == 14
    length_km = (stations[-1].position_m - stations[0].position_m) / 1000.0
    assert length_km == pytest.approx(LENGTH_KM[real.id], rel=0.01)


@each_day
@each_line
def test_trains_meet_where_the_published_times_have_them_meet(real: RealLine, day: CalendarDay) -> None:
    setup = load_scenario(f"{real.id}_{day.id}").setup
    assert len(setup.timetable.trains) == TRAINS[real.id][DAYS.index(day)]
    found = feasibility(setup)
    assert found.impossible == ()
    places = {meet.station for meet in found.meets}
    assert {place and setup.line.stations[place].name for place in places} == MEETS[real.id]


@each_line
def test_it_says_what_is_assumed_and_whose_the_data_is(real: RealLine) -> None:
    scenario = load_scenario(f"{real.id}_weekday")
    text = shipped_line(real.id).read_text("utf-8")
    assert "station_database, CC BY-SA 4.0" in text
    assert "nagix/mini-tokyo-3d, data from ODPT" in shipped_timetable(f"{real.id}_weekday").read_text("utf-8")
    said = " ".join(
        (*scenario.setup.line.assumed, *scenario.inputs.assumed, *scenario.setup.timetable.head.assumed)
    )
    for what in (
        "tracks: two at",
        "gradients: level",
        "sides: ",
        "BR 642 as a stand-in",
        "limits of curves",
        "sets",
    ):
        assert what in said


def _trains_run_to_plan(scenario: Scenario) -> int:
    run = execute(scenario, PartyLink.SIMULATED)
    assert run.broken == ()
    assert run.summary["invariants_broken"] == run.summary["collisions"] == 0
    assert run.summary["trains_arrived"] == run.summary["trains_planned"]
    assert run.summary["late_s_max"] <= 60.0
    return int(run.summary["trains_planned"])


def test_the_first_trains_of_a_weekday_run_and_none_is_a_minute_late() -> None:
    assert _trains_run_to_plan(part_of_day(load_scenario("isumi_weekday"), None, "07:00")) == 2


@pytest.mark.nightly
@each_day
@each_line
def test_so_does_every_train_of_the_day(real: RealLine, day: CalendarDay) -> None:
    assert _trains_run_to_plan(load_scenario(f"{real.id}_{day.id}")) == TRAINS[real.id][DAYS.index(day)]
