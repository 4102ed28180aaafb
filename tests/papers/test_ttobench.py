import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from network.errors import InputError
from papers.reproduction import Options
from papers.ttobench import (
    CROSS_CHECKS,
    CROSS_TRAIN,
    CrossCheck,
    MeshPair,
    cross_case,
    cross_row,
    pair_of,
    reproduce,
    row_of,
)
from papers.ttobench_files import course_of, read_track, read_tracks, read_train, read_trains
from vehicle.optimum import least_time
from vehicle.optimum.proof import proven_run

SHARED = Path(__file__).resolve().parents[2] / "../shared/data/ttobench"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="TTOBench (../shared/data/ttobench) absent")

TRACK: dict[str, Any] = {
    "metadata": {"id": "made"},
    "stops": {"unit": "m", "values": [0.0, 1000.0, 4000.5]},
    "speed limits": {"units": {"position": "m", "velocity": "km/h"}, "values": [[0.0, 90], [2000.0, 54]]},
    "gradients": {"units": {"position": "m", "slope": "permil"}, "values": [[0.0, 0.0], [1500.0, 10.0]]},
    "tunnels": {
        "units": {"position": "m", "length": "m", "cross section": "m^2"},
        "values": [[1000.0, 500.0, 24]],
    },
}
TRAIN: dict[str, Any] = {
    "metadata": {"id": "train"},
    "mass": {"unit": "kg", "value": 100_000.0},
    "rho": {"unit": "%", "value": 10},
    "length": {"unit": "m", "value": 50.0},
    "max traction power": {"unit": "kW", "value": 2000.0},
    "max reg braking power": {"unit": "kW", "value": 2000.0},
    "max traction force": {"unit": "kN", "value": 100.0},
    "max reg braking force": {"unit": "kN", "value": 100.0},
    "max speed": {"unit": "km/h", "value": 80},
    "rolling resistance r0": {"unit": "kN", "value": 2.0},
    "rolling resistance r1": {"unit": "kN/(km/h)", "value": 0.01},
    "rolling resistance r2": {"unit": "kN/(km/h)^2", "value": 0.001},
    "efficiency traction": {"unit": "%", "value": 90.0},
    "efficiency reg brake": {"unit": "%", "value": 80.0},
    "tunnel resistance": {
        "units": {"cross section": "m^2", "coefficient": "kN/(km/h)^2"},
        "values": [[24, 0.001]],
    },
}


def written(folder: Path, raw: dict[str, Any], **changes: Any) -> Path:  # noqa: ANN401
    file = folder / "file.json"
    file.write_text(json.dumps({key.replace("_", " "): value for key, value in {**raw, **changes}.items()}))
    return file


def test_a_track_and_a_train_become_a_course(tmp_path: Path) -> None:
    track = read_track(written(tmp_path, TRACK))
    train = read_train(written(tmp_path, TRAIN))
    course = course_of(track, train, perfect=False)
    assert (course.start_m, course.stop_m) == (0.0, 4000.5)
    assert course.climb_m[1500] == pytest.approx(0.0)
    assert course.climb_m[2500] == pytest.approx(10.0)
    np.testing.assert_allclose(course.limit_mps[[0, 1999, 2000, 3000]], [25.0, 25.0, 15.0, 15.0])
    drag = course.drag_n_per_mps2
    assert drag is not None
    np.testing.assert_allclose(
        drag[[990, 1024, 1200, 1524, 1560]], [0.0, 12.96 * 0.49, 12.96, 12.96 * 0.51, 0.0]
    )
    row = course.train
    assert row["speed_max_mps"] == pytest.approx(80 / 3.6)
    assert row["efficiency_traction"] == 0.9
    assert course_of(track, train, perfect=True).train["efficiency_regeneration"] == 1.0
    # r0 of 2 kN over the weight in kN comes back as 2 kN
    assert row["resistance"]["motored_constant_n_per_kn"] * 981.0 == pytest.approx(2000.0)


def test_a_limit_holds_until_the_rear_has_left_it(tmp_path: Path) -> None:
    rising = {"units": {"position": "m", "velocity": "km/h"}, "values": [[0.0, 36], [2000.0, 72]]}
    track = read_track(written(tmp_path, TRACK, **{"speed limits": rising}))
    course = course_of(track, read_train(written(tmp_path, TRAIN)), perfect=False)
    np.testing.assert_allclose(course.limit_mps[[2000, 2049, 2050]], [10.0, 10.0, 20.0])


def test_tunnels_cost(tmp_path: Path) -> None:
    train = read_train(written(tmp_path, TRAIN))
    inside = course_of(read_track(written(tmp_path, TRACK)), train, perfect=False)
    open_air = {key: value for key, value in TRACK.items() if key != "tunnels"}
    outside = course_of(read_track(written(tmp_path, open_air)), train, perfect=False)
    time_s = 1.2 * float(least_time(inside).time_s[-1])
    assert proven_run(inside, time_s).bound_j > proven_run(outside, time_s).energy_j


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"stops": {"unit": "km", "values": [0.0, 1.0]}}, "stops.unit"),
        ({"stops": {"unit": "m", "values": [0.0]}}, "stops"),
        ({"stops": {"unit": "m", "values": [5.0, 1000.0]}}, "stops"),
        ({"speed limits": {**TRACK["speed limits"], "values": [[0.0, 0]]}}, "speed limits"),
        ({"speed limits": {**TRACK["speed limits"], "values": [[0.0, 80], [9000.0, 70]]}}, "speed limits"),
        ({"gradients": {**TRACK["gradients"], "values": [[0.0, 900.0]]}}, "gradients"),
        ({"tunnels": {**TRACK["tunnels"], "values": [[3900.0, 500.0, 24]]}}, "tunnels"),
        ({"stops": 3}, "stops"),
    ],
)
def test_a_track_that_cannot_be_used_is_bad_input(tmp_path: Path, changes: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as raised:
        read_track(written(tmp_path, TRACK, **changes))
    assert raised.value.key.startswith(key)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"mass": {"unit": "t", "value": 100.0}}, "mass.unit"),
        ({"mass": {"unit": "kg", "value": -1.0}}, "mass"),
        ({"efficiency traction": {"unit": "%", "value": 120.0}}, "efficiency traction"),
        ({"max speed": {"unit": "km/h", "value": 0.0}}, "max speed"),
    ],
)
def test_a_train_that_cannot_be_used_is_bad_input(tmp_path: Path, changes: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError) as raised:
        read_train(written(tmp_path, TRAIN, **changes))
    assert raised.value.key.startswith(key)


def test_an_unknown_cross_section_and_an_empty_folder_are_bad_input(tmp_path: Path) -> None:
    train = read_train(written(tmp_path, TRAIN))
    tunnels = {**TRACK["tunnels"], "values": [[1000.0, 500.0, 99]]}
    track = read_track(written(tmp_path, TRACK, tunnels=tunnels))
    with pytest.raises(InputError, match="cross-section"):
        course_of(track, train, perfect=False)
    (tmp_path / "none").mkdir()
    with pytest.raises(InputError, match="tracks"):
        read_tracks(tmp_path / "none")


def test_a_fine_run_does_not_make_a_row_pass(tmp_path: Path) -> None:
    """Judged is the run of a unit's mesh; of the fine mesh counts the bound alone, which holds for every run."""
    course = course_of(
        read_track(written(tmp_path, TRACK)), read_train(written(tmp_path, TRAIN)), perfect=False
    )
    time_s = 1.2 * float(least_time(course).time_s[-1])
    pair = pair_of(course, time_s)
    assert (pair.coarse.optimum.position_m.size, pair.fine.optimum.position_m.size) == (300, 900)
    assert pair.judged.energy_j == pair.coarse.energy_j
    assert pair.judged.bound_j == max(pair.coarse.bound_j, pair.fine.bound_j)
    assert row_of("made", time_s, [pair] * 3).passed
    dear = MeshPair(replace(pair.coarse, energy_j=1.03 * pair.coarse.energy_j), pair.fine)
    assert pair.fine.gap < 0.01 < dear.judged.gap
    assert not row_of("made", time_s, [pair, dear, pair]).passed


def test_without_the_library_it_says_so(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="ttobench"):
        reproduce(Options(data=str(tmp_path), quick=True))


@needs_shared
def test_the_slice_is_proven_and_our_bound_is_below_every_run_of_the_authors() -> None:
    found = reproduce(Options(data=str(SHARED.parent), quick=True))
    rows = {row.case: row for row in found.rows}
    instances = [row for row in found.rows if row.criterion.startswith("gap")]
    assert len(instances) == 6
    assert all(row.passed for row in instances)
    crosses = [row for row in found.rows if row.case.startswith("cross-check")]
    assert len(crosses) == len(CROSS_CHECKS)
    for row in crosses:
        assert isinstance(row.ours, dict)
        assert isinstance(row.paper, float)
        assert row.ours["bound_kwh"] <= row.ours["energy_kwh"] <= row.paper
        assert row.paper < row.ours["theirs_on_300_kwh"]  # the coarser mesh is the dearer one
        assert row.criterion.startswith("within 1 %")
        assert row.passed
    simpler = {case: row for case, row in rows.items() if "simpler" in case}
    assert [row.passed for row in simpler.values()] == [True, False]
    (energy,) = (row for row in simpler.values() if not row.passed)
    assert "missed by" in energy.criterion and "another problem" in energy.criterion


@needs_shared
@pytest.mark.parametrize("check", CROSS_CHECKS, ids=cross_case)
def test_cruising_meets_the_cross_checks_without_losses_alone(check: CrossCheck) -> None:
    """What resistance takes grows with speed alone: without losses no run is better than one speed. So say the rows."""
    tracks, trains = read_tracks(SHARED / "tracks"), read_trains(SHARED / "trains")
    row = cross_row(tracks[check.track], trains[CROSS_TRAIN], check, cruising=True)
    assert row.passed is check.perfect
    assert ("shows nothing" in row.criterion) is check.perfect


@pytest.mark.parametrize("check", CROSS_CHECKS, ids=cross_case)
def test_where_there_are_losses_the_null_method_has_a_row_of_each_cross_check(check: CrossCheck) -> None:
    assert (cross_case(check) in reproduce.null.fails) is not check.perfect


@needs_shared
def test_a_run_below_our_bound_fails_its_cross_check() -> None:
    """Half a percent below ours is within the tolerance, but no run is below a bound."""
    tracks, trains = read_tracks(SHARED / "tracks"), read_trains(SHARED / "trains")
    check = CROSS_CHECKS[0]
    track, train = tracks[check.track], trains[CROSS_TRAIN]
    assert cross_row(track, train, check).passed
    dear = cross_row(track, train, replace(check, energy_kwh=1.015 * 306.06))
    assert not dear.passed
    assert "missed by 0.48 points: ours is less" in dear.criterion
    below = cross_row(track, train, replace(check, energy_kwh=0.995 * 306.06))
    assert not below.passed
    assert "missed" not in below.criterion


@needs_shared
@pytest.mark.parametrize(
    ("case", "theirs_kwh"),
    # The authors' own code on 300 intervals, 1 m/s at both ends, NL_Intercity_VIRM6 (decision 028).
    [
        (("00_var_speed_limit_100", True), 307.55),
        (("00_var_speed_limit_100", False), 374.68),
        (("CH_Fribourg_Bern", True), 31.25),
        (("CH_Fribourg_Bern", False), 61.36),
    ],
)
def test_on_300_intervals_our_run_is_below_theirs_and_near(case: tuple[str, bool], theirs_kwh: float) -> None:
    """Theirs holds the force on an interval: up to 1.5 % dearer on the short track; no run is below our bound."""
    (check,) = (each for each in CROSS_CHECKS if (each.track, each.perfect) == case)
    assert check.coarse_kwh == theirs_kwh
    course = course_of(
        read_tracks(SHARED / "tracks")[check.track],
        read_trains(SHARED / "trains")[CROSS_TRAIN],
        perfect=check.perfect,
        end_mps=1.0,
        friction=False,
    )
    ours = proven_run(course, check.time_s, 301)
    assert ours.bound_j <= ours.energy_j <= theirs_kwh * 3.6e6 <= 1.015 * ours.energy_j
