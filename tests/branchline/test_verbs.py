"""`import branchline`: the verbs give what the commands give, and refuse what they refuse."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

import branchline
from branchline.verbs import OpenedRun
from tests.study.sweep.here import OneByOne

VALLEY = Path(__file__).parents[1] / "examples/line/valley_day.toml"
PNG = b"\x89PNG"
EXTENDED = """
extends = "karasuyama_weekday"
people.react = false
[air]
delay_mean_s = 0.5
[patch.line]
set."points.*.throw_time_s" = 3.0
[patch.limits]
set.stall_limit_s = 7200.0
"""
KEYWORDS: dict[str, Any] = {
    "people": {"react": False},
    "air": {"delay_mean_s": 0.5},
    "patch": {
        "line": {"set": {"points.*.throw_time_s": 3.0}},
        "limits": {"set": {"stall_limit_s": 7200.0}},
    },
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[OpenedRun, OpenedRun]:
    """A short day, and the same with points that take a minute."""
    folder = tmp_path_factory.mktemp("verbs")
    base = branchline.run(VALLEY, folder / "base", carrier="plain")
    slow = branchline.load(VALLEY, patch={"line": {"set": {"points.*.throw_time_s": 60.0}}})
    return base, branchline.run(slow, folder / "slow points", carrier="plain")


def test_keywords_are_a_file_that_extends(tmp_path: Path) -> None:
    (tmp_path / "changed.toml").write_text(EXTENDED, "utf-8")
    by_file = branchline.load(tmp_path / "changed.toml", seed=3)
    by_keyword = branchline.load("karasuyama_weekday", seed=3, **KEYWORDS)
    assert by_keyword.setup == by_file.setup
    assert by_keyword.setup != branchline.load("karasuyama_weekday", seed=3).setup
    assert [c.key for c in by_keyword.inputs.changes] == [c.key for c in by_file.inputs.changes]


@pytest.mark.parametrize(
    ("tables", "told"),
    [
        ({"peple": {}}, "keywords: peple is a table; expected no such key, but one of people"),
        ({"people": {"react": 3}}, "keywords: people.react is 3; expected a valid boolean"),
        ({"air": {"delay_s": {1: 2}}}, "keywords: air.delay_s.1 is a table; expected no such key"),
        ({"patch": {"line": {"bogus": 1}}}, "keywords: patch.line.bogus is 1; expected no such key"),
        ({"trains": {"stock": {"V1": "tram"}}}, "keywords: trains.stock.V1 is 'tram'; expected one of"),
        ({"extends": "busy_line"}, "keywords: extends is 'busy_line'; expected no such keyword"),
        ({"seed": -1}, "command line: --seed is -1; expected 0 to"),
    ],
)
def test_a_keyword_that_is_wrong_is_named(tables: dict[str, Any], told: str) -> None:
    with pytest.raises(branchline.InputError) as error:
        branchline.load("karasuyama_weekday", **tables)
    assert str(error.value).startswith(told)


@pytest.mark.parametrize(
    ("verb", "arguments", "told"),
    [
        (
            branchline.load,
            {"name": VALLEY, "seed": 1.5},
            "load: seed is 1.5; expected a whole number or None",
        ),
        (
            branchline.load,
            {"name": VALLEY, "seed": True},
            "load: seed is true; expected a whole number or None",
        ),
        (branchline.check, {"scenario": 5}, "check: scenario is 5; expected a text or a path or Scenario"),
        (branchline.run, {"scenario": VALLEY, "anyway": "no"}, "run: anyway is 'no'; expected True or False"),
        (branchline.sweep, {"file": "x", "days": 1.5}, "sweep: days is 1.5; expected a whole number or None"),
        (
            branchline.capacity,
            {"source": VALLEY, "from_time": 9},
            "capacity: from_time is 9; expected a text or",
        ),
    ],
)
def test_an_argument_of_another_type_is_named(verb: Any, arguments: dict[str, Any], told: str) -> None:  # noqa: ANN401
    with pytest.raises(branchline.InputError) as error:
        verb(**arguments)
    assert str(error.value).startswith(f"branchline.{told}")


def test_whole_numbers_of_other_libraries_are_whole_numbers() -> None:
    assert branchline.load(VALLEY, seed=np.int64(4)).setup.seed == 4


def test_a_wrong_key_of_the_file_is_not_put_down_to_a_keyword(tmp_path: Path) -> None:
    file = tmp_path / "wrong.toml"
    file.write_text('extends = "karasuyama_weekday"\nair.delay_mean_s = -1.0\n', "utf-8")
    with pytest.raises(branchline.InputError, match=r"wrong\.toml: air\.delay_mean_s is -1\.0"):
        branchline.load(file, air={"loss_good_p": 0.0})
    (tmp_path / "top.toml").write_text('extends = "wrong.toml"\nair.loss_good_p = 0.1\n', "utf-8")
    with pytest.raises(branchline.InputError, match=r"wrong\.toml: air\.delay_mean_s is -1\.0"):
        branchline.load(tmp_path / "top.toml")
    (tmp_path / "top.toml").write_text('extends = "wrong.toml"\nair.delay_mean_s = -2.0\n', "utf-8")
    with pytest.raises(branchline.InputError, match=r"top\.toml: air\.delay_mean_s is -2\.0"):
        branchline.load(tmp_path / "top.toml")


def test_a_run_is_the_run_of_the_command(
    runs: tuple[OpenedRun, OpenedRun], main: Callable[..., Any], tmp_path: Path
) -> None:
    run, _ = runs
    ended = main("run", str(VALLEY), "--carrier", "plain", "--out", "out", "--json")
    assert ended.code == 0, ended.err
    assert run.summary["digest"] == ended.figures()["digest"]
    assert run.good and run.report.is_file()
    again = branchline.open(tmp_path / "out")
    assert again.tables.stops.drop("stop_error_m").equals(run.tables.stops.drop("stop_error_m"))
    picture = run.picture("train-graph", language="ja")
    assert picture._repr_png_().startswith(PNG)
    assert main("plot", "out", "train-graph", "--lang", "ja", "--out", "graph.svg").code == 0
    wrong: Any = "fr"
    with pytest.raises(branchline.InputError, match="picture: language is 'fr'; expected one of en, ja"):
        run.picture("train-graph", language=wrong)
    assert picture.save(tmp_path / "same.svg").read_bytes() == (tmp_path / "graph.svg").read_bytes()


def test_what_changed_between_two_runs(
    runs: tuple[OpenedRun, OpenedRun], main: Callable[..., Any], tmp_path: Path
) -> None:
    base, slow = runs
    found = branchline.compare(base, slow)
    told = main("compare", str(base.directory), str(slow.directory))
    assert found.verdict[0] in " ".join(told.out.split())
    assert found.times.height > 0
    assert set(found.figures.columns) == {"group", "figure", "unit", "base", "slow points"}
    assert found.picture()._repr_png_().startswith(PNG)
    with pytest.raises(branchline.InputError, match="number is 2; expected 1 to 1"):
        found.picture(2)
    assert branchline.compare(base, base).times.is_empty()


def test_questions_are_answered_as_by_the_commands(
    runs: tuple[OpenedRun, OpenedRun], main: Callable[..., Any]
) -> None:
    run, _ = runs
    told = main("headway", str(run.directory), "--station", "MRI", "--json").figures()["headways"]
    for station in ("MRI", "Mori", "mori"):
        found = branchline.headway(run, station)
        assert [row["of"] for row in found.table.to_dicts()] == [row["of"] for row in told]
    assert found.matrix()._repr_png_().startswith(PNG)
    full = branchline.capacity(run, cut="crossing")
    told = main("capacity", str(run.directory), "--cut", "crossing", "--json").figures()
    (cut,) = told["cuts"]
    assert full.table["occupancy_percent"].to_list() == [part["occupancy_percent"] for part in cut["parts"]]
    assert full.picture()._repr_png_().startswith(PNG)
    plan = branchline.check(VALLEY)
    shown = (run, plan, full, found, branchline.load(VALLEY), branchline.compare(run, run))
    assert all(len(repr(one)) < 500 for one in shown), "a notebook shows what a cell ends with"
    assert repr(plan) == f"<plan of valley_day: {plan.found.verdict}>"
    assert plan.good and plan.meets["station"].to_list() == ["MRI"]


def test_days_of_a_sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def in_this_process(_jobs: int, _recycle: int) -> OneByOne:
        return OneByOne()

    monkeypatch.setattr("branchline.whole_sweep.LocalPump", in_this_process)
    file = tmp_path / "two.toml"
    axis = '[[axis]]\nname = "delay"\nkey = "air.delay_mean_s"\nvalues = [0.1, 1.0]\n'
    head = 'id = "two"\nname = "Two delays"\nscenario = "rtri_test_line"\ncarrier = "plain"\n'
    file.write_text(head + 'watch = ["mean_late_s"]\n[seeds]\nfirst = 1\ndays = 2\n' + axis, "utf-8")
    swept = branchline.sweep(file, tmp_path / "out", jobs=1)
    assert swept.good and swept.report.is_file()
    assert swept.days.height == 4
    assert set(swept.days["seed"].to_list()) == {1, 2}
    assert swept.points.filter(pl.col("figure") == "mean_late_s").height == 2


def test_a_line_with_what_a_patch_changes() -> None:
    line = branchline.line("karasuyama", set={"points.*.throw_time_s": 3.0})
    assert {points.throw_time_s for points in line.points.values()} == {3.0}
    assert {points.throw_time_s for points in branchline.line("karasuyama").points.values()} != {3.0}


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda: branchline.open("nowhere"), "nowhere; expected the directory of a finished run"),
        (lambda: branchline.line("karasuyama", bogus=1), "keywords: patch.line.bogus is 1"),
        (lambda: branchline.run(VALLEY, link="string"), "--link is 'string'; expected simulated or zenoh"),
        (lambda: branchline.run(VALLEY, carrier="horse"), "--carrier is 'horse'; expected sumo or plain"),
        (lambda: branchline.headway(VALLEY, "Ogane"), "--station is 'Ogane'; expected one of ASA"),
        (lambda: branchline.capacity(VALLEY, cut="sideways"), "--cut is 'sideways'; expected one of"),
        (
            lambda: branchline.capacity(VALLEY, from_time="12:00", to_time="11:00"),
            "--to is '11:00:00'; expected a time after 12:00:00",
        ),
        (
            lambda: branchline.sweep("no_such_sweep"),
            "no_such_sweep; expected a .toml file or a shipped sweep",
        ),
        (lambda: branchline.reproduce("no_such_paper"), "name is 'no_such_paper'; expected one of"),
    ],
)
def test_what_is_wrong_is_told_before_anything_runs(
    ask: Callable[[], object], told: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("branchline.sources.execute", None)
    monkeypatch.setattr("branchline.whole_run.execute", None)
    with pytest.raises(branchline.InputError) as error:
        ask()
    assert told in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_every_verb_is_there_and_nothing_else() -> None:
    assert set(dir(branchline)) == set(branchline.__all__)
    assert all(callable(getattr(branchline, name)) for name in branchline.__all__)
    with pytest.raises(AttributeError, match="no attribute 'dance'"):
        branchline.dance  # noqa: B018
