"""Predictive fuzzy ATO in the tick: which rule wins when, what is without it, and any train's notches."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from onboard.driving.laws.fuzzy_choice import changed_by, half_way, steps_of
from onboard.driving.laws.fuzzy_notes import fuzzy_run_note
from onboard.driving.laws.fuzzy_records import KEPT_CHANGES, FuzzyRule, PredictiveFuzzy
from onboard.driving.laws.fuzzy_station import choose_at_station
from onboard.driving.laws.settings import LawTables
from onboard.driving_settings import Driving
from papers.parameter_sets import LINE, TABLE_1
from papers.single_hop import HopBench, HopWay
from papers.single_run import Rows, new_hops
from papers.single_train import Bench
from vehicle.records import TrainRow
from vehicle.train_file import load_train, shipped_train

LEVEL = HopWay(1000.0)
ORDER_S = 90.0


@dataclass(frozen=True)
class Driven:
    """One hop: its outcome, its trace, and what the law kept of it."""

    outcome: Any
    trace: Rows
    own: Any

    def seconds(self, rule: FuzzyRule) -> float:
        return float(self.own.rule_s[rule])

    def won(self) -> list[FuzzyRule]:
        return [
            FuzzyRule(int(rule)) for rule in self.own.changed_to[: min(int(self.own.changes), KEPT_CHANGES)]
        ]


Drive = Callable[..., Driven]


def bench(train: str, driving: Driving, **rules: bool | float) -> Bench:
    own = LawTables(predictive_fuzzy=PredictiveFuzzy(**rules))  # type: ignore[call-arg, arg-type]
    chosen = driving.model_copy(update={"law": "predictive_fuzzy"})
    return Bench(load_train(shipped_train(train)), chosen, LINE.unit, law_settings=own)


@pytest.fixture(scope="module")
def drive() -> Drive:
    def run(
        way: HopWay = LEVEL, order_s: float = ORDER_S, train: str = "hitachi_train", **rules: bool | float
    ) -> Driven:
        driving = TABLE_1.driving if train == "hitachi_train" else LINE.driving
        hop = HopBench(bench(train, driving, **rules), way)
        outcomes, trace = hop.run(new_hops([order_s]), 4000)
        row = hop.bench.work.view(np.recarray)[0]
        return Driven(outcomes[0], trace, row.board.laws.predictive_fuzzy)

    return run


def row_of(train: str) -> TrainRow:
    row: TrainRow = load_train(shipped_train(train)).row.view(np.recarray)[0]
    return row


def test_a_hop_is_power_coast_a_slight_brake_and_the_stop(drive: Drive) -> None:
    hop = drive()
    order = hop.won()
    for first, second in (
        (FuzzyRule.C_3, FuzzyRule.C_2),
        (FuzzyRule.C_2, FuzzyRule.T_2_2),
        (FuzzyRule.T_2_2, FuzzyRule.T_3),
    ):
        assert order.index(first) < order.index(second)
    assert FuzzyRule.T_1 in order[order.index(FuzzyRule.T_3) :]
    assert abs(hop.outcome["error_m"]) <= 0.3
    assert hop.outcome["time_s"] == pytest.approx(ORDER_S, abs=2.0)
    assert hop.outcome["intervention"] == 0


def test_the_account_of_a_hop_agrees_with_its_trace(drive: Drive) -> None:
    hop = drive()
    moving = int(hop.outcome["steps"]) - 1  # in the last step it stands
    assert sum(hop.own.rule_s) == pytest.approx(0.1 * moving, abs=0.11)
    notches = hop.trace["notch"][: moving + 1]
    # the first tick forgets what was before; what the last one gives is not yet taken up
    assert int(hop.own.notch_changes) == pytest.approx(int(np.count_nonzero(np.diff(notches))), abs=1)
    kept = int(hop.own.changes)
    assert 0 < kept <= KEPT_CHANGES
    for at in range(kept):
        assert 0.0 < hop.own.changed_grade[at] <= 1.0
        assert hop.own.changed_over_grade[at] <= hop.own.changed_grade[at]
    assert list(hop.own.changed_at_s[:kept]) == sorted(hop.own.changed_at_s[:kept])


def test_the_journal_tells_which_rule_won_and_why(drive: Drive) -> None:
    hop = drive()
    note = fuzzy_run_note(hop.own)
    assert note is not None
    assert note.law == "predictive_fuzzy"
    assert {held.rule for held in note.held} >= {"C-2", "C-3", "T-1", "T-2.2", "T-3"}
    assert sum(held.held_s for held in note.held) == pytest.approx(sum(hop.own.rule_s), abs=0.5)
    first = note.won[0]
    assert (first.rule, first.grade, first.notch) == ("C-3", 1.0, 7.0)
    begins = next(won for won in note.won if won.rule == "T-2.2")
    assert (begins.premise, begins.notch) == ("running time", -1.0)
    assert all(after.rule != before.rule for before, after in pairwise(note.won))
    hop.own.changes = 0
    assert fuzzy_run_note(hop.own) is None


def test_without_c_2_it_holds_its_cruise_and_costs_more(drive: Drive) -> None:
    coasts, holds = drive(), drive(c_2=False)
    assert coasts.seconds(FuzzyRule.C_2) > 30.0
    assert holds.seconds(FuzzyRule.C_2) == 0.0
    assert holds.outcome["energy_traction_j"] > 1.05 * coasts.outcome["energy_traction_j"]
    assert abs(holds.outcome["error_m"]) <= 0.3


def test_without_c_3_it_does_not_start(drive: Drive) -> None:
    """Three steps of power bring it no nearer to its target than none, within four seconds."""
    assert drive().trace["notch"][0] == 7.0
    assert drive(c_3=False).outcome["speed_max_mps"] == 0.0


def test_without_c_4_or_c_5_another_rule_has_to_do(drive: Drive) -> None:
    way = HopWay(2500.0)
    assert drive(way, np.inf).seconds(FuzzyRule.C_4) > 30.0
    assert drive(way, np.inf, c_4=False).seconds(FuzzyRule.C_4) == 0.0
    assert int(drive(way, np.inf, c_4=False).own.notch_changes) > int(drive(way, np.inf).own.notch_changes)
    assert drive(way, np.inf, c_5=False).seconds(FuzzyRule.C_5) == 0.0


def test_without_t_1_the_brake_never_rests(drive: Drive) -> None:
    assert int(drive(t_1=False).own.notch_changes) > 2 * int(drive().own.notch_changes)


def test_without_t_2_2_or_t_3_there_is_no_stop_by_the_law(drive: Drive) -> None:
    assert abs(drive(t_2_2=False).outcome["error_m"]) > 0.3
    assert abs(drive(t_3=False).outcome["error_m"]) > 0.3


def test_without_t_2_1_the_first_brake_is_on_as_soon_as_its_zone_begins(drive: Drive) -> None:
    def first_brake_m(hop: Driven) -> float:
        return float(hop.trace["position_m"][np.argmax(hop.trace["notch"] < 0.0)])

    without = drive(t_2_1=False)
    assert first_brake_m(without) < first_brake_m(drive()) - 3.0


@pytest.mark.parametrize(("t_2_1", "offered"), [(True, FuzzyRule.T_2_1), (False, FuzzyRule.NONE)])
def test_t_2_1_is_offered_before_the_stop_only_where_it_is_on(t_2_1: bool, offered: FuzzyRule) -> None:
    hop = HopBench(bench("hitachi_train", TABLE_1.driving, t_2_1=t_2_1), LEVEL)
    hop.run(new_hops([ORDER_S]), 4000)
    board = hop.bench.work.view(np.recarray)[0].board
    board.unit.position_m, board.unit.speed_mps, board.unit.train_mps = hop.begin_m + 300.0, 15.0, 15.0
    own = board.laws.predictive_fuzzy
    at_most = choose_at_station(
        own, board.cue, board.unit, board.kind, board.behaviour, hop.pattern, hop.mark_m
    )
    assert at_most == row_of("hitachi_train").power_notches
    assert FuzzyRule(int(own.best_rule)) is offered


def test_c_1_brakes_half_way_where_the_speed_is_no_longer_permitted(drive: Drive) -> None:
    """With T_s of 8 s danger comes before the other rules see the lower limit, 4 s ahead."""
    way = HopWay(1500.0, limits_mps=((0.0, 22.0), (700.0, 8.0)))
    hop = drive(way, 60.0, safe_s=8.0, c_5=False)
    assert hop.seconds(FuzzyRule.C_1) > 0.0
    at = hop.won().index(FuzzyRule.C_1)
    assert hop.own.changed_notch[at] == half_way(row_of("hitachi_train"), hop.own.changed_notch[at - 1])
    assert drive(way, 60.0, safe_s=8.0, c_1=False, c_5=False).seconds(FuzzyRule.C_1) == 0.0


def test_what_the_brake_gives_is_estimated_where_a_notch_is_kept(drive: Drive) -> None:
    """A descent of 20 permille under the whole train, of which the unit knows nothing, is 0.18 m/s2."""
    way = HopWay(1000.0, ((0.0, 0.0), (600.0, -20.0)), ((0.0, 0.0),))
    knows, does_not = drive(way), drive(way, estimates=False)
    assert knows.own.braking_off_mps2 == pytest.approx(-0.18, abs=0.03)
    assert does_not.own.braking_off_mps2 == 0.0
    assert abs(knows.outcome["error_m"]) <= 0.3
    assert abs(does_not.outcome["error_m"]) > 2.0 * abs(knows.outcome["error_m"])


@pytest.mark.parametrize("train", ["ev_e301", "br642", "oda_train"])
@pytest.mark.parametrize("gradient", [-20.0, 0.0, 15.0])
def test_other_trains_and_gradients_come_to_their_mark(drive: Drive, train: str, gradient: float) -> None:
    way = HopWay(1500.0, ((0.0, gradient),), limits_mps=((0.0, 18.0), (500.0, 12.0), (700.0, 18.0)))
    hop = drive(way, 170.0, train)
    assert abs(hop.outcome["error_m"]) <= 0.5
    assert hop.outcome["intervention"] == 0
    assert hop.outcome["speed_max_mps"] <= 18.0


def test_a_short_hop_stops_at_its_mark_too(drive: Drive) -> None:
    assert abs(drive(HopWay(60.0), 40.0, "ev_e301").outcome["error_m"]) <= 0.3


@pytest.mark.parametrize("train", ["hitachi_train", "ev_e301", "br642", "oda_train"])
def test_steps_cover_every_notch_and_stay_within_the_train(train: str) -> None:
    row = row_of(train)
    full, strongest = float(row.power_notches), -float(row.brake_notches)
    assert changed_by(row, full, 3) == full
    assert changed_by(row, strongest, -3) == strongest
    assert changed_by(row, 0.0, 1) > 0.0 > changed_by(row, 0.0, -1)
    assert steps_of(row, changed_by(row, 0.0, -2)) == pytest.approx(-2.0)
    assert changed_by(row, changed_by(row, 0.0, -2), 2) == pytest.approx(0.0)
    assert strongest <= half_way(row, 0.0) <= strongest / 2.0


def test_half_way_is_the_papers(drive: Drive) -> None:
    row = row_of("hitachi_train")
    assert [half_way(row, float(notch)) for notch in (7, 0, -5, -9)] == [-1.0, -5.0, -7.0, -9.0]
