"""The day by driving laws: what counts as punctual, by hand; and a slice of it, where a law that saves must show it."""

from dataclasses import replace
from typing import Final

import pytest

from papers import line_driving
from papers.line_driving import (
    BEST,
    EARLY_S,
    LATE_S,
    PRESENT,
    SLICE,
    WITHIN_S,
    LawDay,
    bound_rows,
    day_of,
    later_than,
    punctual_day,
    punctuality_rows,
)
from papers.reproduction import Options
from scenario.scenario import load_scenario
from study.measures.least_energy import Allowed, HopLeast, LeastEnergy
from study.record.driving import DrivenHop
from study.runner.run import FinishedRun
from study.wording.phrase import Phrase


@pytest.fixture(scope="module")
def present() -> LawDay:
    return punctual_day(load_scenario(SLICE), PRESENT)


@pytest.fixture(scope="module")
def best() -> LawDay:
    return punctual_day(load_scenario(SLICE), BEST)


def later_by(day: LawDay, late_s: float, hops: int = 1000) -> LawDay:
    """The same day, its first arrivals later by so much."""
    moved = [
        replace(hop, late_s=hop.late_s + late_s) if hop.late_s is not None and i < hops else hop
        for i, hop in enumerate(day.hops)
    ]
    return replace(day, hops=tuple(moved))


def missed(days: tuple[LawDay, ...]) -> list[str]:
    """Which of the rows about punctuality fail."""
    return [row.case for row in punctuality_rows(days) if not row.passed]


def test_a_day_is_driven_to_the_common_punctuality(present: LawDay, best: LawDay) -> None:
    for day in (present, best):
        assert abs(day.mean_early_s - EARLY_S) <= WITHIN_S
    hasty = day_of(load_scenario(SLICE), PRESENT, present.time_margin_s + 8.0)
    assert hasty.mean_early_s > EARLY_S + 4.0
    assert missed((hasty,)) == [f"{PRESENT}: the day, equally punctual in the mean"]


def test_a_law_that_comes_later_is_found_out(present: LawDay) -> None:
    assert missed((present, present)) == []
    assert missed((present, replace(later_by(present, 2.0 * WITHIN_S), law=BEST))) == [
        f"{BEST}: the day, equally punctual in the mean"
    ]
    late = later_by(present, 60.0, hops=2)  # the first hop is from a portal
    hidden = replace(later_by(late, late.mean_early_s - EARLY_S), law=BEST)
    assert hidden.mean_early_s == pytest.approx(EARLY_S)
    assert missed((present, hidden)) == [f"hops on which a law is late and {PRESENT} is not, s late"]
    assert later_than(hidden, present)
    row = next(row for row in punctuality_rows((present, hidden)) if not row.passed)
    assert "hops, on which a train can run at most" in row.criterion
    assert all(late_s > LATE_S for late_s in later_than(hidden, present).values())


@pytest.mark.parametrize("seconds_a_second", [0.5, 1.0, 4.0])
def test_a_margin_is_found_however_steeply_a_law_answers(
    seconds_a_second: float, present: LawDay, monkeypatch: pytest.MonkeyPatch
) -> None:
    def day_at(_scenario: object, _law: str, margin_s: float) -> LawDay:
        early_s = EARLY_S + seconds_a_second * (margin_s - 12.34)
        return replace(later_by(present, present.mean_early_s - early_s), time_margin_s=margin_s)

    monkeypatch.setattr(line_driving, "day_of", day_at)
    found = punctual_day(load_scenario(SLICE), PRESENT)
    assert abs(found.mean_early_s - EARLY_S) <= WITHIN_S
    assert found.runs <= line_driving.ROUNDS


def test_of_a_law_that_leaps_over_the_mean_the_nearest_day_counts(
    present: LawDay, monkeypatch: pytest.MonkeyPatch
) -> None:
    def day_at(_scenario: object, _law: str, margin_s: float) -> LawDay:
        early_s = EARLY_S - 0.4 if margin_s < 10.7 else EARLY_S + 0.5
        return replace(later_by(present, present.mean_early_s - early_s), time_margin_s=margin_s)

    monkeypatch.setattr(line_driving, "day_of", day_at)
    found = punctual_day(load_scenario(SLICE), PRESENT)
    assert found.mean_early_s == pytest.approx(EARLY_S - 0.4)
    assert found.runs == line_driving.ROUNDS


def test_a_day_that_breaks_something_is_no_day(present: LawDay) -> None:
    broken: FinishedRun = replace(present.run, failures=(Phrase("a collision"),))
    assert missed((present, replace(present, run=broken))) == ["everyone arrived and no invariant broken"]


@pytest.mark.parametrize(("kwh", "passed"), [(102.9, True), (103.1, False)])
def test_three_percent_above_the_bound_is_the_most(
    kwh: float, passed: bool, present: LawDay, best: LawDay
) -> None:
    least = {PRESENT: LeastEnergy(1, 120.0, 100.0, 100.0), BEST: LeastEnergy(1, kwh, 100.5, 100.0)}
    above, cheapest = bound_rows((present, best), least)
    assert above.passed is passed
    assert cheapest.passed
    assert not bound_rows((present, replace(best, hops=present.hops + best.hops)), least)[1].passed
    assert bound_rows((present,), {PRESENT: least[PRESENT]}) == ()


HOP: Final = HopLeast("T1", "A", "B", 100.0, 5.0, 4.1, 4.0, False)


def test_hops_beside_their_bounds_by_hand() -> None:
    both = LeastEnergy.sum_of((HOP, replace(HOP, running_kwh=-1.0, least_kwh=-1.5, bound_kwh=-1.5)))
    assert (both.hops, both.running_kwh, both.bound_kwh) == (2, 4.0, 2.5)
    assert both.above_bound_percent == pytest.approx(60.0)


def test_no_run_of_the_slice_is_below_its_bound(present: LawDay, best: LawDay) -> None:
    """Every hop as driven takes more than the bound of anything a train here may do."""
    for day in (present, best):
        found = day.least_of_hops(Allowed.anything(day.run.scenario.setup))
        assert len(found) == sum(hop.late_s is not None for hop in day.hops) > 10
        assert [hop for hop in found if hop.running_kwh < hop.bound_kwh] == []
        assert all(hop.bound_kwh <= hop.least_kwh + 1e-6 for hop in found)


def test_less_time_costs_more_and_lower_limits_too(present: LawDay) -> None:
    setup = present.run.scenario.setup
    same = LeastEnergy.sum_of(present.least_of_hops(Allowed.as_units_drive(setup)))
    more_s = {hop.key: hop.time_s * 1.1 for hop in present.least_of_hops(Allowed.as_units_drive(setup))}
    assert (
        LeastEnergy.sum_of(present.least_of_hops(Allowed.as_units_drive(setup), more_s)).bound_kwh
        < same.bound_kwh
    )
    assert LeastEnergy.sum_of(present.least_of_hops(Allowed.anything(setup))).bound_kwh < same.bound_kwh


@pytest.mark.nightly
def test_the_slice_by_every_law(monkeypatch: pytest.MonkeyPatch) -> None:
    result = line_driving.reproduce(Options(quick=True))
    assert f"{PRESENT}: the day, equally punctual in the mean" in [
        row.case for row in result.rows if row.passed
    ]
    assert all(parameter.origin for parameter in result.parameters)
    assert any("short slice" in remark for remark in result.remarks)
    monkeypatch.setattr(line_driving, "LAW_NAMES", (PRESENT,))
    assert not any(row.case.startswith(BEST) for row in line_driving.reproduce(Options(quick=True)).rows)


def ran(hops: tuple[DrivenHop, ...]) -> float:
    return sum(hop.running_kwh for hop in hops)


def test_the_law_of_least_energy_takes_less_at_equal_punctuality(present: LawDay, best: LawDay) -> None:
    assert ran(best.hops) < 0.97 * ran(present.hops)
