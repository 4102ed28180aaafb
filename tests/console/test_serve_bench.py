"""What the desk's bench comes to where browsers get nothing, and on a day without a train."""

from dataclasses import replace

import pytest

from branchline.measuring import _print_bench
from console.serve_bench import _figures, busiest_s
from network.errors import InputError
from scenario.scenario import load_scenario


def test_a_browser_that_gets_no_update_keeps_no_budget(capsys: pytest.CaptureFixture[str]) -> None:
    seen = [(0.1, 0.2, [("staff", 0.0, 0.0), ("guest", 12.0, 3.0)])]
    found = _figures("s", 1, 2, seen, same_digest=True)
    assert [(one["found"], one["kept"]) for one in found["budgets"]][-1] == (None, False)
    _print_bench({"part": "serve", **found})
    assert "between updates at most 0.1: nothing to measure, NOT KEPT" in capsys.readouterr().out


def test_a_day_without_a_train_has_no_busiest_time() -> None:
    scenario = load_scenario("rtri_test_line")
    plan = replace(scenario.setup.timetable, trains={}, diagrams=())
    with pytest.raises(InputError, match="a day with trains"):
        busiest_s(replace(scenario, setup=replace(scenario.setup, timetable=plan)))
