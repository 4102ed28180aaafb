"""Stops at the mark in line runs: impossible ones are told and stay within the authority; signs; what is learned.

On the paper's test line: limit of the run at km 1.050, mark of station B at km 1.020, tags 801 to 803 before it.
"""

from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import pytest

from onboard.notes import Intervention, SignSeen, StopImpossible
from radio.noted import Noted
from study.record.directory import LEARNED_FILE
from study.runner.run import FinishedRun, write_run
from tests.plain import run_on_plain
from tests.scenario.own import own_scenario
from tests.study.report.page import payload_of, table_in

MARK_M, LIMIT_M = 1020.0, 1050.0
MISSED = "".join(
    f'[[fault]]\nkind = "miss"\ntarget = "{tag}"\nstart = "09:51:00"\n' for tag in (801, 802, 803)
)
FAR_MARK = """
[patch.line]
set = { "stations.B.tracks.1.platform_to_km" = 1.05, "stations.B.tracks.1.mark_down_km" = 1.05 }
"""


def run_of(tmp_path: Path, text: str) -> FinishedRun:
    return run_on_plain(own_scenario(tmp_path, text, "rtri_test_line"))


T = TypeVar("T", bound=Noted)


def noted(run: FinishedRun, kind: type[T]) -> list[T]:
    return [entry.event for entry in run.result.journal.entries if isinstance(entry.event, kind)]


@pytest.mark.parametrize(
    ("text", "why", "mark_m"),
    [
        ("[scatter.stock.K1]\nbrake_factor = 0.3\n", "brake too weak", MARK_M),
        (MISSED, "target not seen", MARK_M),
        (FAR_MARK, "sign beyond limit", LIMIT_M),
    ],
)
def test_an_impossible_stop_is_told_and_ends_within_the_authority(
    tmp_path: Path, text: str, why: str, mark_m: float
) -> None:
    run = run_of(tmp_path, text)
    assert run.broken == ()
    assert run.result.violations == ()
    assert [note.why for note in noted(run, StopImpossible)] == [why]
    told = run.tables.events.filter(run.tables.events["kind"] == "stop")["text"].to_list()
    assert any(why in line for line in told)
    stop = run.result.stops[-1]
    assert stop.error_m is not None
    assert mark_m + stop.error_m < LIMIT_M
    assert run.result.trains_arrived == ("T1",)


def test_a_weak_brake_is_stopped_by_the_emergency_brake(tmp_path: Path) -> None:
    run = run_of(tmp_path, "[scatter.stock.K1]\nbrake_factor = 0.3\n")
    assert [note.level for note in noted(run, Intervention)] == [2]


def test_a_sign_takes_the_place_of_the_tags(tmp_path: Path) -> None:
    text = '[patch.line]\nremove_tags = { purpose = "position", near_marks_m = 120.0 }\n[vision]\nstations = "all"\n'
    run = run_of(tmp_path, text)
    assert [note.station for note in noted(run, SignSeen)] == ["B"]
    error_m = run.result.stops[-1].error_m
    assert error_m is not None
    assert abs(error_m) < 0.5
    assert run.broken == ()


def test_a_sign_that_is_never_seen_is_told(tmp_path: Path) -> None:
    run = run_of(tmp_path, '[vision]\nstations = "all"\nhidden_beyond_m = 0.0\n')
    assert [note.why for note in noted(run, StopImpossible)] == ["target not seen"]
    error_m = run.result.stops[-1].error_m
    assert error_m is not None
    assert abs(error_m) < 0.5  # the tags suffice all the same


def test_what_is_learned_is_kept_between_days_and_left_in_the_run_directory(tmp_path: Path) -> None:
    run = run_of(tmp_path, "[scatter.stock.K1]\nbrake_factor = 0.85\n[tuning]\ndays = 3\n")
    learned = run.result.learned["K1"]
    assert learned.stops == 3  # one stop a day
    # 0.85 * (c) = 0.6 at c = 0.706: about -0.1 m/s^2 at the pattern, to a step and a half of the grid
    assert learned.offset_mps2 == pytest.approx(-0.1, abs=0.042)
    write_run(run, tmp_path / "out")
    assert (tmp_path / "out" / LEARNED_FILE).is_file()
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    payload = payload_of(page)
    assert payload["tuning"] is not None
    assert table_in(payload, "learned")["unit"]


def test_days_differ_in_what_passes_and_not_in_the_train(tmp_path: Path) -> None:
    scatter = "[scatter]\nbrake_sigma = 0.1\nbrake_leg_sigma = 0.02\n"
    setup = own_scenario(tmp_path, scatter, "rtri_test_line").setup
    from simulation.carriers.plain_track import PlainTrack
    from simulation.setup import STEP_S
    from simulation.world.trains import Trains

    def factors(day: int) -> tuple[float, float]:
        trains = Trains(replace(setup, day=day), PlainTrack({}, STEP_S))
        trains.begin_leg(0, 0.0)
        return float(setup.scatter.body(setup.seed, "K1", trains.kinds[0])[1]), float(
            trains.plants[0].brake_factor
        )

    (own, first), (same, second) = factors(1), factors(2)
    assert own == same
    assert first != second
    assert first / own == pytest.approx(1.0, abs=0.06)
    assert second / own == pytest.approx(1.0, abs=0.06)
