"""The committed error model of LiDARs against scans made anew, within what samples differ by."""

import math
from dataclasses import replace

import numpy as np
import pytest

from documents.scans import PASSAGES, READINGS
from onboard.localisation.lidar import NOISE_WITHIN_MPS, ROW_WITHIN_M
from onboard.localisation.lidar_points import FILLED
from papers.marker_passages import USES, pass_markers
from simulation.sensors.lidar_model import fit_model
from simulation.sensors.line_scans import COLUMNS, PLACES_M, SMEARS_M, SPEEDS_MPS, Scans, line_scans
from vehicle.compiled import INTERPRETED

FRESH_MPS = (10.0, 20.0)
COUNT = 10
LEAST = 60
SIGMAS = 4.0

scans = pytest.mark.skipif(INTERPRETED, reason="it scans: interpreted, a passage takes minutes")


def objections(kept: Scans, fresh: Scans, speed_mps: float, index: int) -> list[str]:
    """Which committed figures fresh scans contradict by more than four standard errors of both samples."""
    at = SPEEDS_MPS.index(speed_mps)
    found: list[str] = []
    for place, place_m in enumerate(PLACES_M):
        sigma_m = float(kept.sigma_m[at, place])
        # cycles of a passage hang together: a passage counts as few independent ones
        apart = math.sqrt(1.0 / (2.0 * PASSAGES) + 1.0 / (2.0 * COUNT))
        if abs(kept.bias_m[at, place] - fresh.bias_m[index, place]) > SIGMAS * sigma_m * apart:
            found.append(f"bias at {place_m:g} m")
        if abs(math.log(sigma_m / float(fresh.sigma_m[index, place]))) > SIGMAS * apart:
            found.append(f"sigma at {place_m:g} m")
        if abs(kept.none_share[at, place] - fresh.none_share[index, place]) > 0.05:
            found.append(f"none at {place_m:g} m")
    for smear, smear_m in enumerate(SMEARS_M):
        share = float(kept.read_share[at, smear])
        spread = math.sqrt(max(share * (1.0 - share), 0.02) * (1.0 / READINGS + 1.0 / LEAST))
        if abs(share - fresh.read_share[index, smear]) > SIGMAS * spread:
            found.append(f"read at {smear_m:g} m")
    if abs(kept.row_bias_m[at] - fresh.row_bias_m[index]) > SIGMAS * float(kept.row_sigma_m[at]) * 0.5:
        found.append("first row")
    return found


@pytest.fixture(scope="module")
def fresh() -> Scans:
    found, wrong = fit_model(FRESH_MPS, COUNT, 8, LEAST)
    assert wrong == 0
    return found


@scans
@pytest.mark.parametrize("index", range(len(FRESH_MPS)))
def test_the_figures_are_what_scans_give(fresh: Scans, index: int) -> None:
    assert objections(line_scans(), fresh, FRESH_MPS[index], index) == []


@scans
def test_figures_of_another_speed_are_noticed(fresh: Scans) -> None:
    kept = line_scans()
    slow = SPEEDS_MPS.index(1.4)
    other = replace(kept, sigma_m=np.tile(kept.sigma_m[slow], (len(SPEEDS_MPS), 1)))
    assert objections(other, fresh, FRESH_MPS[1], 1)
    misread = replace(kept, read_share=kept.read_share[:, ::-1])
    assert objections(misread, fresh, FRESH_MPS[1], 1)


@scans
@pytest.mark.parametrize("speed_mps", [6.0, 10.0, 20.0])
def test_a_filled_mean_is_no_more_wrong_than_units_take_it_for(speed_mps: float) -> None:
    """Of scanned passages, after 49 cycles in a row with points: half of what units reckon with, with room."""
    worst_mps, judged = 0.0, 0
    for number in range(10):
        seen = pass_markers("speed bound", number, 3, speed_mps).readings_by(USES["every point's own time"])
        filled = 0
        for mean_m, speed, true in zip(seen.mean_m, seen.speed_mps, seen.true_mps, strict=True):
            filled = filled + 1 if mean_m > 0.0 else 0
            if filled > FILLED:
                judged += 1
                worst_mps = max(worst_mps, abs(speed - true))
    assert judged > 50
    assert 0.02 < worst_mps < 0.75 * NOISE_WITHIN_MPS


def test_every_figure_is_there_and_sensible() -> None:
    kept = line_scans()
    for column in COLUMNS:
        assert np.isfinite(getattr(kept, column)).all()
    assert (
        kept.none_share.shape == kept.bias_m.shape == kept.sigma_m.shape == (len(SPEEDS_MPS), len(PLACES_M))
    )
    assert kept.read_share.shape == (len(SPEEDS_MPS), len(SMEARS_M))
    assert (np.diff(kept.read_share, axis=1) <= 0.0).all()
    assert (kept.read_share[:, 0] >= 0.9).all()
    assert (np.diff(kept.sigma_m[:, 3]) > 0.0).all()  # the faster, the more a cycle's points lie apart
    assert float(np.max(np.abs(kept.row_bias_m) + 5.0 * kept.row_sigma_m)) < ROW_WITHIN_M
