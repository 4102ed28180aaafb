"""What-ifs that cannot go well end in time, without a collision, and say who waits for what."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from network.files.shipped import shipped_timetable

WAITS = re.compile(r"(\w+) \((V\d)\) stands in section (\S+) at km -?\d+\.\d{3} and waits for (.+)")
MEETS = re.compile(r"(\w+) and (\w+) would meet at Ogane at \d\d:\d\d: it has one track; .+")


@pytest.fixture(scope="module")
def without_loop(main_in: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Any:  # noqa: ANN401
    cwd = tmp_path_factory.mktemp("without-loop")
    ended = main_in("run", "karasuyama_without_loop", "--anyway", "--carrier", "plain", "--json", cwd=cwd)
    assert (cwd / "runs" / "karasuyama_without_loop" / "report.html").is_file()
    return ended


def test_without_the_loop_the_day_ends_and_nobody_is_hurt(without_loop: Any) -> None:  # noqa: ANN401
    figures = without_loop.figures()
    assert without_loop.code == 1
    assert "Traceback" not in without_loop.err
    assert (figures["trains_planned"], figures["collisions"]) == (27, 0)
    assert figures["trains_arrived"] < 27
    assert figures["ended_because"] in ("no train can move any more", "the time limit of the run")
    # an hour without any movement ends it, long before the last train of the day
    assert figures["simulated_s"] < 6 * 3600.0
    assert all("everyone-arrives" in text for text in figures["violations"])


def test_it_says_who_waits_for_what(without_loop: Any) -> None:  # noqa: ANN401
    waits = [match for text in without_loop.figures()["broken"] if (match := WAITS.fullmatch(text))]
    stocks = {match[2]: match[4] for match in waits}
    assert len(waits) == len(stocks) >= 2
    # somewhere two trains wait for each other
    holders = {stock: found[1] for stock, why in stocks.items() if (found := re.search(r"of (V\d)\W?$", why))}
    assert any(holders.get(holder) == stock for stock, holder in holders.items())


def test_it_names_the_trains_that_cannot_meet(without_loop: Any, main: Callable[..., Any]) -> None:  # noqa: ANN401
    named = {match[0] for text in without_loop.figures()["broken"] if (match := MEETS.fullmatch(text))}
    assert any(text.startswith("321M and 322M would meet at Ogane at 05:5") for text in named)
    checked = main("check", "karasuyama_without_loop", "--json")
    assert checked.code == 1
    findings = checked.figures()["findings"]
    refused = {f"{f['text']}; {f['remedy']}" for f in findings if f["kind"] == "opposing trains"}
    assert refused == named
    assert all(f"broken: {text}" in without_loop.err for text in named)


def test_a_run_that_cannot_be_in_time_stops_at_its_limit(main: Callable[..., Any], tmp_path: Path) -> None:
    hurried = shipped_timetable("rtri_test_line").read_text("utf-8").replace("10:02:00", "10:00:30")
    (tmp_path / "hurried_times.toml").write_text(hurried, "utf-8")
    scenario = 'extends = "rtri_test_line"\nid = "hurried"\ntimetable = "hurried_times.toml"\n'
    (tmp_path / "hurried.toml").write_text(scenario + "limits = { time_limit_s = 1.0 }\n", "utf-8")
    ended = main("run", "hurried.toml", "--anyway", "--json", "--out", "out")
    figures = ended.figures()
    assert ended.code == 1
    assert figures["ended_because"] == "the time limit of the run"
    # 10 minutes of opening before 10:00:00, and 1 s after the last planned time
    assert figures["simulated_s"] == pytest.approx(631.0)
    assert figures["broken"][0] == "1 train did not arrive: T1"
    assert any(t.startswith("T1 (K1) was on its way in section 6 at km 0.") for t in figures["broken"])


def test_a_radio_that_carries_next_to_nothing_ends_in_a_sentence(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    scenario = 'extends = "rtri_test_line"\nid = "silent"\nair = { loss_good_p = 0.99 }\n'
    (tmp_path / "silent.toml").write_text(scenario + "limits = { time_limit_s = 60.0 }\n", "utf-8")
    ended = main("run", "silent.toml", "--json", "--out", "out")
    assert ended.code == 1
    assert ended.figures()["broken"][-1] == (
        "T1 (K1) stands in section 3 at km 0.440 and waits for signing on: no answer from the block manager"
    )
