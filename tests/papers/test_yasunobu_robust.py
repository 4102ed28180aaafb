"""`branchline reproduce yasunobu-robust`: what the fuzzy law copes with, and what it owes that to."""

from dataclasses import replace

import numpy as np
import pytest

from onboard.driving.laws.fuzzy_records import PredictiveFuzzy
from papers import yasunobu_robust as robust
from papers.reproduction import Options, Reproduction
from papers.single_run import new_hops
from papers.specification import reproduction
from papers.yasunobu_train import ORDERS_S, paper_hops, paper_train


@pytest.fixture(scope="module")
def result() -> Reproduction:
    return robust.reproduce(Options(quick=True))


def test_it_is_known_by_name_and_says_what_it_leaves_out(result: Reproduction) -> None:
    assert reproduction("yasunobu-robust") is robust.reproduce
    assert any("short slice" in remark for remark in result.remarks)


def test_the_train_is_that_of_table_1() -> None:
    row = paper_train().row[0]
    assert float(row["length_m"]) == 83.5
    assert float(row["mass_empty_kg"]) == 129_000.0
    assert (int(row["power_notches"]), int(row["brake_notches"])) == (7, 9)
    assert float(row["brake_deceleration_mps2"][9]) * 3.6 == pytest.approx(5.14)
    assert float(row["brake_dead_time_s"]) == 0.2
    assert float(row["brake_lag_s"]) == 0.6
    assert float(row["resistance"]["motored_constant_n_per_kn"]) == 1.97
    assert float(row["resistance"]["motored_linear_n_per_kn_kmh"]) == 0.016
    assert float(row["resistance"]["air_n_per_kmh2"]) == pytest.approx(0.00084 * 129.0 * 9.81, rel=1e-4)


def test_what_is_fuzzys_own_passes(result: Reproduction) -> None:
    """What is said of the PID is the PID's: its rows may be missed, and then say so."""
    passed = {row.case: row.passed for row in result.rows}
    assert passed["descent before the mark, fuzzy, worst of five orders, m past it"]
    assert passed["changes of the brake notch a stop, fuzzy over PID"]
    assert passed["scattered stops in which supervision had to brake, fuzzy"]
    assert passed[robust.reproduce.null.case(robust.FUZZY_DROP)]


def test_the_rows_on_the_pid_say_what_they_hang_on(result: Reproduction) -> None:
    held = next(row for row in result.rows if row.case.startswith("the same by how long"))
    assert isinstance(held.ours, dict)
    assert held.ours["0.5 s"]["fuzzy_over_it"] > 1.0 > held.ours["1 s"]["fuzzy_over_it"]
    assert held.ours["0.8 s"]["fuzzy_over_it"] > robust.SIGMA_SHARE
    train = paper_train().row[0]
    assert float(train["brake_dead_time_s"] + train["brake_lag_s"]) == pytest.approx(robust.BRAKE_SETTLES_S)


def test_the_unit_knows_nothing_of_the_descent() -> None:
    hop = paper_hops(robust.FUZZY, way=robust.DROP)
    begin, mark = int(hop.begin_m), int(hop.mark_m)
    assert hop.pattern["climb_m"][begin] == hop.pattern["climb_m"][mark]
    assert hop.heights.elevation_m[mark] - hop.heights.elevation_m[begin] == pytest.approx(-1.2, abs=0.05)


def test_without_its_estimate_it_does_not_cope() -> None:
    own = robust.settings(fuzzy=PredictiveFuzzy(estimates=False))
    assert abs(robust.worst_drop_miss_m(own)) > robust.FUZZY_MISS_M
    hops = robust.scattered_hops(1, robust.STOPS_QUICK)
    assert (
        robust.scattered_stops(robust.FUZZY, hops, own).sigma_m
        > 3.0 * robust.scattered_stops(robust.FUZZY, hops).sigma_m
    )


def test_without_t_1_the_row_of_notch_changes_would_be_missed() -> None:
    hops = robust.scattered_hops(1, 20)
    own = robust.settings(fuzzy=PredictiveFuzzy(t_1=False))
    without, pid = robust.scattered_stops(robust.FUZZY, hops, own), robust.scattered_stops(robust.PID, hops)
    fuzzy = robust.scattered_stops(robust.FUZZY, hops)
    assert fuzzy.brake_changes <= robust.CHANGES_SHARE * pid.brake_changes < without.brake_changes


def test_a_train_that_never_stops_makes_the_spread_infinite() -> None:
    own = robust.settings(fuzzy=PredictiveFuzzy(c_2=False, c_3=False, c_4=False, c_5=False))
    assert robust.scattered_stops(robust.FUZZY, new_hops(ORDERS_S[:1]), own).sigma_m == float("inf")


def test_a_pid_that_never_stops_is_no_measure_of_fuzzy() -> None:
    """Its spread is infinite, and whatever is held against that is nothing."""
    fuzzy = robust.ScatteredStops(9, 0.0, 0.1, 0.2, 4.0, 0)
    never = replace(fuzzy, mean_m=np.inf, sigma_m=np.inf, largest_m=np.inf, brake_changes=9.0)
    sigma, *_ = robust.scatter_rows(fuzzy, never)
    assert not sigma.passed
    assert "no PID that stops" in sigma.criterion
    assert robust.scatter_rows(fuzzy, replace(never, sigma_m=0.31))[0].passed


def test_the_draws_are_the_seeds() -> None:
    first, again, other = (robust.scattered_hops(seed, 8) for seed in (1, 1, 2))
    assert (first["brake_factor"] == again["brake_factor"]).all()
    assert (first["brake_factor"] != other["brake_factor"]).all()
    assert abs(first["brake_factor"] - 1.0).max() <= robust.BRAKE_SPREAD
    assert abs(first["gradient_permille"]).max() <= robust.GRADIENT_SPREAD_PERMILLE
