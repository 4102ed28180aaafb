"""Meets as run: fronts that pass on the true courses, and what became of each in another run."""

from dataclasses import replace

import polars as pl
import pytest

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.meets import Trajectory
from network.meets import meets_of as network_meets_of
from study.compare.meets import MeetFate, compare_meets, meets_of, place_at
from study.record.tables import make_table
from study.report.data import ReportedRun
from tests.study.compare.sides import with_tables


def course(train: str, unit: str, direction: int, samples: list[tuple[float, float]]) -> pl.DataFrame:
    """A trajectory through (time s, kilometrage m)."""
    n = len(samples)
    columns = {name: [0.0] * n for name in make_table("trajectory").columns}
    columns |= {
        "t_s": [t for t, _ in samples],
        "unit": [unit] * n,
        "train": [train] * n,
        "direction": [direction] * n,
        "kilometrage_m": [at for _, at in samples],
        "piece": ["OGN.1"] * n,
        "speed_mps": [10.0] * n,
        "intervention": [0] * n,
    }
    return make_table("trajectory", columns)


def run_of(weekday: ReportedRun, *courses: pl.DataFrame) -> ReportedRun:
    return with_tables(weekday, trajectory=pl.concat(courses))


DOWN = [(100.0, 0.0), (200.0, 4000.0)]
UP = [(120.0, 5000.0), (220.0, 1000.0)]


def test_two_fronts_pass_where_their_courses_cross(weekday: ReportedRun) -> None:
    """Down is at 40 (t - 100), up at 5000 - 40 (t - 120): they are level at t = 172.5 s, 2900 m."""
    (meet,) = meets_of(run_of(weekday, course("D", "V1", 1, DOWN), course("U", "V2", -1, UP)))
    assert (meet.down_train, meet.up_train, meet.time_s) == ("D", "U", 172.5)
    assert meet.position_m == pytest.approx(2900.0)
    assert meet.at == ("HSK", "SHN")


@pytest.mark.parametrize(
    "up",
    [
        [(300.0, 5000.0), (400.0, 1000.0)],  # when the other has ended
        [(120.0, 9000.0), (220.0, 5000.0)],  # ahead of the other all the time
        [(150.0, 1000.0), (220.0, 0.0)],  # behind it from the beginning
    ],
)
def test_trains_that_never_are_side_by_side_do_not_meet(
    weekday: ReportedRun, up: list[tuple[float, float]]
) -> None:
    assert meets_of(run_of(weekday, course("D", "V1", 1, DOWN), course("U", "V2", -1, up))) == ()


def test_one_that_stands_is_met_where_it_stands(weekday: ReportedRun) -> None:
    line = weekday.line
    mark_m = line.stations["OGN"].tracks[0].marks_m
    at_m = next(iter(mark_m.values()))
    standing = [(0.0, at_m - 500.0), (50.0, at_m), (300.0, at_m), (350.0, at_m + 500.0)]
    passing = [(100.0, at_m + 2000.0), (200.0, at_m), (300.0, at_m - 2000.0)]
    (meet,) = meets_of(run_of(weekday, course("D", "V1", 1, standing), course("U", "V2", -1, passing)))
    assert (meet.time_s, meet.at) == (200.0, ("OGN",))


def test_the_trains_of_a_day_meet_as_straight_lines_between_their_samples_do(weekday: ReportedRun) -> None:
    """The other computation of meets, meant for plans, on the same courses."""
    lines = [
        Trajectory(number, weekday.directions[number], tuple(part["t_s"]), tuple(part["kilometrage_m"]))
        for (_, number), part in weekday.courses.items()
    ]
    other = {(m.down_train, m.up_train): m.time_s for m in network_meets_of(weekday.line, lines)}
    ran = {(meet.down_train, meet.up_train): meet.time_s for meet in meets_of(weekday)}
    assert ran == {pair: pytest.approx(time_s, abs=0.06) for pair, time_s in other.items()}
    assert len(ran) == 10


def test_trains_on_two_branches_do_not_meet_though_their_kilometrages_are_the_same(
    weekday: ReportedRun,
) -> None:
    line = weekday.line
    here = line.pieces["OGN.1"]
    there = replace(here, id="BRANCH", section_id="BRANCH", alignment_id="branch")
    sections = {**line.sections, "BRANCH": replace(line.sections["OGN.1"], id="BRANCH", station_id=None)}
    forked = replace(line, pieces={**line.pieces, "BRANCH": there}, sections=sections)
    up = course("U", "V2", -1, UP).with_columns(piece=pl.lit("BRANCH"))
    tables = with_tables(weekday, trajectory=pl.concat([course("D", "V1", 1, DOWN), up])).tables
    assert meets_of(ReportedRun(forked, weekday.timetable, tables)) == ()
    # In a station that both branches have they do.
    joined = replace(forked, sections={**sections, "BRANCH": replace(sections["BRANCH"], station_id="OGN")})
    assert len(meets_of(ReportedRun(joined, weekday.timetable, tables))) == 1


def test_a_meet_moves_in_time_goes_and_comes(weekday: ReportedRun) -> None:
    down, up = course("D", "V1", 1, DOWN), course("U", "V2", -1, UP)
    base = run_of(weekday, down, up)
    assert compare_meets(base, base, 0.0) == ()

    later = run_of(weekday, *(part.with_columns(pl.col("t_s") + 3.0) for part in (down, up)))
    assert compare_meets(base, later, 3.0) == ()
    (moved,) = compare_meets(base, later, 1.0)
    assert (moved.fate, moved.by_s, moved.why.en) == (MeetFate.OTHER_TIME, 3.0, "")

    far = run_of(weekday, down, course("U", "V2", -1, [(110.0, 12000.0), (195.0, 3800.0)]))
    (elsewhere,) = compare_meets(base, far, 1000.0)
    assert elsewhere.fate is MeetFate.ELSEWHERE
    assert elsewhere.old is not None and elsewhere.old.at == ("HSK", "SHN")
    assert elsewhere.new is not None and elsewhere.new.at == ("SHN", "NIT")

    alone = run_of(weekday, down)
    (gone,) = compare_meets(base, alone, 1.0)
    assert (gone.fate, gone.new, gone.by_s) == (MeetFate.GONE, None, None)
    assert gone.why.en == "U did not run in the new run"
    (new,) = compare_meets(alone, base, 1.0)
    assert (new.fate, new.old, new.why.en) == (MeetFate.NEW, None, "U did not run in the base run")

    apart = run_of(weekday, down, course("U", "V2", -1, [(120.0, 9000.0), (220.0, 5000.0)]))
    (parted,) = compare_meets(base, apart, 1.0)
    assert (parted.fate, parted.why.en) == (MeetFate.GONE, "")


def test_a_place_is_a_station_with_tracks_or_what_it_is_between() -> None:
    line = load_line(shipped_line("karasuyama"))
    track = line.pieces[line.stations["OGN"].tracks[0].piece_id]
    assert place_at(line, (track.from_m + track.to_m) / 2) == ("OGN",)
    # a halt has no track of its own
    assert place_at(line, line.stations["NIT"].position_m + 10.0) == ("NIT", "KNY")
    assert place_at(line, -10_000.0) == ("HSK",)
    assert place_at(line, 99_000.0) == ("KRS",)
