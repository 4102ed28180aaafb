"""What a sweep's day costs: ratios of medians against budgets, and a real sweep of a few days."""

from typing import Any

import pytest

from study.evaluate import sweep_bench
from study.evaluate.sweep_bench import EXECUTE, ON_PLAIN, ON_SUMO, SUMO, real_sweep, report


def figures(
    execute_s: float, sumo_day_s: float, plain_day_s: float, sumo_s: float
) -> dict[str, list[dict[str, Any]]]:
    """Three rounds of each way; the median is what is given."""
    seconds = {EXECUTE: execute_s, ON_SUMO: sumo_day_s, ON_PLAIN: plain_day_s, SUMO: sumo_s}
    return {
        way: [
            {"cpu_s": s * share, "peak_mb": 400.0, "digests": [] if way == SUMO else ["one"]}
            for share in (0.5, 1.0, 3.0)
        ]
        for way, s in seconds.items()
    }


RAN = {"share": 0.95, "peak_mb": 450.0, "differ": 0}


def kept(found: dict[str, Any]) -> list[bool]:
    return [budget["kept"] for budget in found["budgets"]]


def test_budgets_are_kept_up_to_their_limit() -> None:
    found = report(figures(2.0, 2.2, 1.0, 1.0), RAN)
    assert [row["of_execute"] for row in found["rows"]] == [1.0, 1.1, 0.5, 0.5]
    assert [row["of_sumo_alone"] for row in found["rows"]] == [2.0, 2.2, 1.0, 1.0]
    assert kept(found) == [True, True, True, True]
    assert [budget["found"] for budget in found["budgets"]] == [1.1, 1.0, 450.0, 0.05]
    assert found["same_digest"]


@pytest.mark.parametrize(
    ("given", "ran", "missed"),
    [
        (figures(2.0, 2.21, 1.0, 1.0), RAN, 0),
        (figures(2.0, 2.0, 1.01, 1.0), RAN, 1),
        (figures(2.0, 2.0, 1.0, 1.0), RAN | {"peak_mb": 501.0}, 2),
        (figures(2.0, 2.0, 1.0, 1.0), RAN | {"share": 0.89}, 3),
    ],
)
def test_each_budget_can_be_missed(given: dict[str, Any], ran: dict[str, Any], missed: int) -> None:
    assert kept(report(given, ran)) == [at != missed for at in range(4)]


def test_another_digest_is_named() -> None:
    given = figures(2.0, 2.0, 1.0, 1.0)
    given[ON_PLAIN][1]["digests"] = ["another"]
    assert not report(given, RAN)["same_digest"]
    assert not report(figures(2.0, 2.0, 1.0, 1.0), RAN | {"differ": 1})["same_digest"]


@pytest.mark.nightly
def test_a_real_sweep_is_counted() -> None:
    found = real_sweep("rtri_test_line", jobs=1, days=2)
    assert (found["days"], found["differ"]) == (2, 0)
    assert 0.0 < found["at_hand"] <= 1.0
    assert 0.0 < found["share"] <= 1.5  # of one core, this process beside it
    assert found["peak_mb"] > 50.0


def test_every_way_runs_the_same_day(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_bench, "DAYS", 1)
    ran = [sweep_bench.run_child(way, "rtri_test_line", "", "") for way in (EXECUTE, ON_SUMO, ON_PLAIN)]
    assert ran[0]["digests"] == ran[1]["digests"] == ran[2]["digests"]
    assert len(ran[0]["digests"]) == 1
