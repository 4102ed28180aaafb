"""`branchline reproduce yasunobu-energy`: rows say what was found, and what they rest on can be taken away."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from papers import yasunobu_cells
from papers.reproduction import Options, Reproduction
from papers.single_hop import TimedHop
from papers.yasunobu_cells import PUNCTUAL_S, DrivingWay, EnergyCell, is_kept, run_cells, settings_of
from papers.yasunobu_energy import (
    BALANCED_KMH,
    PAPER_SAVES_PERCENT,
    SAVING_SHARE,
    gradient_row,
    judged_claims,
    missed_by,
    percent,
    reproduce,
    row_of,
    saved_percent,
    saving_rows,
)
from papers.yasunobu_train import NOMINAL_S


@pytest.fixture(scope="module")
def level() -> list[EnergyCell]:
    return run_cells(0.0, (NOMINAL_S, 95.0))


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> tuple[Reproduction, Path]:
    out = tmp_path_factory.mktemp("out")
    return reproduce(Options(quick=True, out=str(out))), out


def test_every_law_keeps_the_time_and_none_is_below_the_bound(level: list[EnergyCell]) -> None:
    for cell in level:
        assert cell.bound_j is not None
        assert cell.optimum_j is not None
        assert 0.99 < cell.bound_j / cell.optimum_j <= 1.0
        for way in DrivingWay:
            assert abs(cell.hops[way].off_s) <= PUNCTUAL_S
            assert cell.over_bound[way] > 0.0
        assert row_of(cell).passed


def test_fuzzy_saves_and_without_c_2_it_does_not(
    level: list[EnergyCell], monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = {row.case: row for row in judged_claims(level, level[0])}
    worse = rows["without C-2 fuzzy needs more at level, 85 s, %"]
    assert worse.passed
    assert level[0].saving() > 0.05
    monkeypatch.setattr(
        yasunobu_cells,
        "settings_of",
        lambda way: settings_of(DrivingWay.WITHOUT) if way is DrivingWay.FUZZY else None,
    )
    swapped = run_cells(0.0, (NOMINAL_S,))
    rows = {row.case: row for row in judged_claims(swapped, swapped[0])}
    assert not rows["without C-2 fuzzy needs more at level, 85 s, %"].passed
    assert not rows["fuzzy saves on average, %"].passed


@pytest.mark.parametrize("way", list(DrivingWay))
def test_whichever_way_is_late_its_row_is_missed(level: list[EnergyCell], way: DrivingWay) -> None:
    cell = level[0]
    late = replace(cell.hops[way], asked_s=cell.asked_s - PUNCTUAL_S - 1.0)
    assert row_of(cell).passed
    assert not row_of(replace(cell, hops={**cell.hops, way: late})).passed


@pytest.mark.parametrize(
    ("off_s", "error_m", "kept"), [(0.5, -0.5, True), (-1.5, 0, False), (0, -1.5, False)]
)
def test_too_soon_and_short_of_the_mark_is_not_kept_either(off_s: float, error_m: float, kept: bool) -> None:
    hop: Any = SimpleNamespace(off_s=off_s, outcome={"error_m": error_m})
    assert is_kept(hop) is kept


@pytest.mark.parametrize(("pid_off_s", "saved"), [(0.0, 0.2), (1.5, 0.0)])
def test_what_is_saved_is_a_share_of_pids_and_nothing_where_that_is_late(
    pid_off_s: float, saved: float
) -> None:
    pid = SimpleNamespace(traction_kwh=10.0, off_s=pid_off_s, outcome={"error_m": 0.0})
    fuzzy = SimpleNamespace(traction_kwh=8.0, off_s=0.0, outcome={"error_m": 0.0})
    hops: Any = {DrivingWay.PID: pid, DrivingWay.FUZZY: fuzzy}
    cell = EnergyCell(0.0, 100.0, hops, {}, 0.0, 0.0, None, None, 0.0)
    assert cell.saving_in_time() == pytest.approx(saved)


def test_a_hop_is_set_against_the_bound_of_its_own_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """80 s where 100 s are asked for, with 150 J; no train needs less than 8,000 J s over its time."""
    hop = SimpleNamespace(outcome={"time_s": 80.0, "energy_traction_j": 150.0})
    train = SimpleNamespace(traction_dead_time_s=0.0, traction_lag_s=0.0)
    monkeypatch.setattr(
        yasunobu_cells, "hops_of", lambda *_: SimpleNamespace(timed=lambda _: hop, train=train)
    )
    monkeypatch.setattr(yasunobu_cells, "course_of", lambda *_: None)
    monkeypatch.setattr(yasunobu_cells, "strongest_mps2", lambda _: 0.0)
    monkeypatch.setattr(yasunobu_cells, "least_energy", lambda *_: SimpleNamespace(energy_j=0.0))
    monkeypatch.setattr(yasunobu_cells, "lower_bound_j", lambda *asked: 8000.0 / asked[-1])
    (cell,) = run_cells(0.0, (100.0,), (DrivingWay.PID,))
    assert cell.over_bound[DrivingWay.PID] == pytest.approx(0.5)


def test_a_hop_off_its_time_saves_nothing(level: list[EnergyCell]) -> None:
    """Neither by coming late nor by being left out of the mean."""
    first, second = level
    hop = second.hops[DrivingWay.FUZZY]
    off = {**second.hops, DrivingWay.FUZZY: replace(hop, asked_s=second.asked_s - PUNCTUAL_S - 1.0)}
    mean, _ = saving_rows([first, replace(second, hops=off)], first)
    assert mean.ours == percent(first.saving() / 2.0)
    half = first.hops[DrivingWay.FUZZY].outcome.copy()
    half["energy_traction_j"] /= 2.0
    half["time_s"] += 10.0
    late = replace(first, hops={**first.hops, DrivingWay.FUZZY: TimedHop(NOMINAL_S, NOMINAL_S, half)})
    assert late.saving() > SAVING_SHARE
    assert not any(row.passed for row in saving_rows([late], late))


@pytest.mark.parametrize(
    ("saved", "passed"),
    [
        ((0.2, 0.1, 0.05), True),
        ((0.2, 0.1, 0.15), False),
        ((0.1, 0.2, 0.05), False),
        ((0.2, 0.1, 0.1), False),
    ],
)
def test_most_is_saved_uphill_and_least_downhill_as_6_2_has_it(
    level: list[EnergyCell], saved: tuple[float, float, float], passed: bool
) -> None:
    def cell(permille: float, share: float) -> EnergyCell:
        hops = dict(level[0].hops)
        hop = hops[DrivingWay.PID].outcome.copy()
        hop["energy_traction_j"] *= 1.0 - share
        hops[DrivingWay.FUZZY] = TimedHop(NOMINAL_S, NOMINAL_S, hop)
        return replace(level[0], gradient_permille=permille, hops=hops)

    row = gradient_row(
        [cell(permille, share) for permille, share in zip((10.0, 0.0, -10.0), saved, strict=True)]
    )
    assert row.passed is passed
    assert ("missed" in row.criterion) is not passed


def test_on_the_descent_table_1_balances_at_no_speed_of_the_hop() -> None:
    """Resistance is as much as 10 permille at 89 km/h, by kg/ton as printed; the hop is run at 40 to 60 km/h."""
    kmh = BALANCED_KMH
    assert 1.97 + 0.016 * kmh + 0.00084 * kmh**2 == pytest.approx(10.0, abs=0.1)


def test_what_c_2_is_worth_does_not_depend_on_who_took_longer(level: list[EnergyCell]) -> None:
    """A second less costs some percent: the law that took it is held against the bound of its own time."""
    cell = level[0]
    over = {**cell.over_bound, DrivingWay.WITHOUT: cell.over_bound[DrivingWay.FUZZY]}
    assert replace(cell, over_bound=over).without_costs == pytest.approx(0.0)
    rows = {row.case: row for row in judged_claims([cell], replace(cell, over_bound=over))}
    assert not rows["without C-2 fuzzy needs more at level, 85 s, %"].passed


@pytest.mark.nightly
def test_what_is_saved_hangs_on_the_stop_of_each_law_and_the_row_says_so(
    quick: tuple[Reproduction, Path],
) -> None:
    rows = {row.case: row for row in quick[0].rows}
    (shared, _), (own, _) = saved_percent(0.8, 0.8), saved_percent(0.7, 0.8)
    assert own > shared + 2.0
    assert (
        saved_percent(0.8, 0.8, 700.0)[0] < shared < saved_percent(0.8, 0.8, 1100.0)[0] < PAPER_SAVES_PERCENT
    )
    # fuzzy stops 8 m past the mark: no hop of the paper's
    assert np.isnan(saved_percent(0.8, 0.8, 2000.0)[0])
    told = rows["the same by the stop's deceleration at level, 85 s, %"].ours
    assert isinstance(told, dict)
    assert told["PID 0.7, fuzzy 0.8 m/s^2"].startswith(f"{own:g}, net")


@pytest.mark.nightly
def test_without_c_2_the_rows_of_savings_fail(
    level: list[EnergyCell], quick: tuple[Reproduction, Path]
) -> None:
    rows = {row.case: row for row in quick[0].rows}
    null = reproduce.null
    assert all(rows[null.case(case)].passed for case in null.fails)
    assert level[0].saving(DrivingWay.WITHOUT) < level[0].saving()


def test_a_missed_row_says_by_how_much(level: list[EnergyCell]) -> None:
    for row in judged_claims(level, level[0]):
        assert row.passed != ("missed by" in row.criterion)
    assert missed_by("at least 10 %", 0.10, 0.072) == "at least 10 %; missed by 2.8 points"
    assert missed_by("at least 10 %", 0.10, 0.2) == "at least 10 %"


def test_a_time_that_is_impossible_says_the_least() -> None:
    cell = run_cells(10.0, (65.0,))[0]
    row = row_of(cell)
    assert cell.optimum_j is None
    assert not row.passed
    assert str(row.ours) == f"impossible: at least {cell.least_s:.1f} s"
    assert 70.0 < cell.least_s < 80.0  # the paper's shortest is possible


@pytest.mark.nightly
def test_the_reproduction_draws_and_names_what_the_paper_does_not(quick: tuple[Reproduction, Path]) -> None:
    found, out = quick
    assert {path.name for path in out.iterdir()} == {
        f"{name}.{kind}" for name in ("yasunobu_energy", "yasunobu_running_curves") for kind in ("svg", "png")
    }
    assert any("a short slice" in remark.lower() for remark in found.remarks)
    missed = [row.case for row in found.rows if not row.passed]
    assert missed == ["fuzzy saves at level, 85 s, %", "fuzzy over the lower bound at level, 85 s, %"]
    kwh = next(figure for figure in found.figures if figure.name.startswith("PID, level"))
    assert "efficiency" in kwh.meaning
    assert np.isfinite(kwh.value[1])  # type: ignore[index]
    assert any(parameter.origin.startswith("assumed") for parameter in found.parameters)
