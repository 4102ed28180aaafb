"""`branchline plot` and `branchline new`, as a person types them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from study.runner.run import write_run
from tests.plain import run_on_plain


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("plotted") / "run"
    write_run(run_on_plain("rtri_test_line"), out)
    return out


def test_every_kind_is_listed(main: Callable[..., Any]) -> None:
    from study.plot.kinds import KINDS

    ended = main("plot", "list")
    assert ended.code == 0
    assert [line.split()[0] for line in ended.out.splitlines()] == list(KINDS)
    kinds = main("plot", "list", "--json").figures()["kinds"]
    assert [kind["name"] for kind in kinds] == list(KINDS)


def test_a_plot_is_written_where_it_is_asked_for(
    main: Callable[..., Any], folder: Path, tmp_path: Path
) -> None:
    ended = main("plot", str(folder), "run-curve", "--train", "T1", "--lang", "ja", "--format", "svg")
    assert (ended.code, ended.out) == (0, "")
    assert (tmp_path / "run-curve-T1.svg").read_text("utf-8").startswith("<?xml")
    ended = main("plot", str(folder), "waits", "--out", "w.csv", "--json")
    assert json.loads(ended.out) | {"outcome": None} == {
        "kind": "waits",
        "format": "csv",
        "file": "w.csv",
        "outcome": None,
    }
    assert "T1 stands at A until its departure time, 10:00." in (tmp_path / "w.csv").read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("nowhere", "waits"), "nowhere"),
        (("RUN", "wait"), "KIND is 'wait'; expected one of "),
        (("RUN",), "KIND"),
        (("RUN", "waits", "--lang", "de"), "--lang is 'de'; expected one of en, ja"),
        (("RUN", "waits", "--from", "25 o'clock"), "--from"),
        (("RUN", "waits", "--format", "pdf"), "--format is 'pdf'; expected one of png, svg, csv"),
        (("RUN", "run-curve"), "--train"),
        (("RUN", "waits", "--out", "no/such/folder/w.png"), "w.png"),
    ],
)
def test_what_cannot_be_plotted_is_one_line(
    main: Callable[..., Any], folder: Path, tmp_path: Path, arguments: tuple[str, ...], told: str
) -> None:
    ended = main("plot", *(str(folder) if a == "RUN" else a for a in arguments))
    assert ended.code == 2
    assert ended.err.count("\n") == 1
    assert told in ended.err
    assert not list(tmp_path.iterdir())


def test_new_files_are_made_checked_and_run(main: Callable[..., Any], tmp_path: Path) -> None:
    assert main("new", "train", "railbus.toml", "--like", "br642", "--mass-t", "45").code == 0
    made = main(
        *("new", "timetable", "times.toml", "--line", "rtri_test_line", "--every", "30", "--from", "06:00"),
        *("--to", "06:40", "--train", "railbus.toml", "--scenario", "day.toml"),
    )
    assert made.code == 0, made.err
    assert main("new", "scenario", "what.toml", "--extends", "day.toml").code == 0
    assert main("check", "what.toml").code == 0
    ran = main("run", "what.toml", "--out", "run", "--json")
    assert ran.code == 0, ran.err
    figures = ran.figures()
    assert figures["trains_arrived"] == figures["trains_planned"] > 0
    assert figures["late_s_max"] < 60.0


def test_a_new_file_never_takes_the_place_of_another(main: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("mine", "utf-8")
    for arguments in (
        ("scenario", "mine.toml"),
        ("drill", "mine.toml"),
        ("train", "mine.toml"),
        ("timetable", "mine.toml", "--line", "karasuyama"),
    ):
        ended = main("new", *arguments)
        assert ended.code == 2
        assert "a new file" in ended.err
    assert (tmp_path / "mine.toml").read_text("utf-8") == "mine"
