"""The budget of a certificate, and that the days of its bench are days: everybody gets to the end."""

import pytest

from study.evaluate import certificate, manager_day
from study.evaluate.certificate import bench, report, row_of
from study.evaluate.manager_day import config_of
from study.evaluate.parts import part_of
from wayside.order_question import OrderAnswer, OrderQuestion, without_solver


@pytest.mark.parametrize(("us", "kept"), [(900.0, True), (1100.0, False)])
def test_a_grant_that_costs_too_much_is_said_to(us: float, kept: bool) -> None:
    budget, *_ = report("x", 1, [{"day": "a day", "us_a_grant": us}], [0.0])["budgets"]
    assert (budget["limit"], budget["found"], budget["kept"]) == (1000.0, us, kept)


@pytest.mark.parametrize(("s", "kept"), [(0.9, True), (1.1, False)])
def test_a_decision_that_takes_more_than_a_second_is_said_to(s: float, kept: bool) -> None:
    median, slowest = report("x", 1, [], [2e3, 1e3, 1e6 * s])["budgets"]
    assert (slowest["found"], slowest["kept"]) == (1e6 * s, kept)
    assert (median["found"], median["kept"]) == (2e3, True)


def test_decisions_by_the_order_of_all_ask_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[OrderQuestion] = []

    def answered(question: OrderQuestion) -> OrderAnswer:
        asked.append(question)
        return without_solver(question)

    monkeypatch.setattr(manager_day, "order_solver", lambda: answered)
    decided_us = certificate.decisions_us()
    assert asked
    assert len(decided_us) == len(asked)


def test_the_part_is_listed_and_its_days_end() -> None:
    assert part_of("certificate") is bench
    row = row_of("planned", config_of("karasuyama_weekday"), late=False)
    assert (row["moves_left"], row["moves_left_without"], row["us_refused_max"]) == (0, 0, 0.0)
    assert row["grants"] == 78


def test_twenty_trains_go_round_and_are_home_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certificate, "ROUNDS", 1)
    day = certificate.day_of(certificate.of_twenty(), certificate=True, late=True)
    assert day.played.at == [len(journey.moves) for journey in day.played.journeys]
    assert len(day.played.journeys) == certificate.TRAINS
