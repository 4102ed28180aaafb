"""`branchline bench`: the links alone unless others are asked for, and each part's figures as soon as it is done."""

import signal
from collections.abc import Callable
from typing import Any

import pytest

from study.evaluate import parts
from study.outcome import Outcome, StoppedError


def bench_of(name: str) -> Callable[[str, int, Callable[[str], None]], dict[str, Any]]:
    def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
        if name == "sweep":
            raise StoppedError(signal.SIGINT)
        rows = [{"way": f"way of {name}", "wall_s": 1.5}]
        return {"scenario": scenario, "rounds": rounds, "rows": rows, "budgets": [], "same_digest": True}

    return bench


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "part_of", bench_of)


def test_the_links_alone_are_measured_unless_others_are_asked_for(main: Callable[..., Any]) -> None:
    ended = main("bench", "rtri_test_line", "--json")
    assert [found["part"] for found in ended.figures()["scenarios"]] == ["links"]
    ended = main("bench", "rtri_test_line", "--part", "laws", "--part", "certificate")
    assert (
        "way of laws" in ended.out and "way of certificate" in ended.out and "way of links" not in ended.out
    )


def test_what_was_measured_before_it_was_stopped_is_there(main: Callable[..., Any]) -> None:
    ended = main("bench", "rtri_test_line", "--part", "links", "--part", "sweep")
    assert ended.code == Outcome.INTERRUPTED.code
    assert "way of links" in ended.out
