"""`branchline headway` and `branchline capacity`: what they print and write, and what they refuse."""

import csv
import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from network.clock import clock
from scenario.scenario import load_scenario
from study.capacity.occupation import OccupationCost
from study.feasibility.check import feasibility
from study.report.headways import COLUMNS
from study.runner.run import write_run
from tests.plain import run_on_plain

VALLEY = Path(__file__).parents[1] / "examples/line/valley_day.toml"


def test_headways_are_the_same_in_json_and_csv(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("headway", "karasuyama_weekday", "--theory", "--station", "OGN", "--json", "--out", "out")
    assert ended.code == 0, ended.err
    rows = ended.figures()["headways"]
    assert {row["station"] for row in rows} == {"OGN"}
    assert {row["kind_ja"] for row in rows} == {"続行", "着発", "発着"}
    for row in rows:
        assert sum(row[cost.column] for cost in OccupationCost) == pytest.approx(row["least_s"], abs=0.31)
        assert row["first_train_s"] + row["second_train_s"] == pytest.approx(row["least_s"], abs=0.11)
    with (tmp_path / "out/headways.csv").open(encoding="utf-8") as file:
        assert [row["of"] for row in csv.DictReader(file)] == [row["of"] for row in rows]
    for name in ("headway_matrix", "headway_parts"):
        assert (tmp_path / f"out/{name}.png").read_bytes()[:4] == b"\x89PNG"
    asked = ("headway", str(VALLEY), "--theory", "--station", "MRI")
    told = main(*asked, "--csv")
    assert told.code == 0, told.err
    written = list(csv.DictReader(io.StringIO(told.out)))
    assert {row["station"] for row in written} == {"MRI"}
    left_over = [f"{float(row['buffer_s']):+.0f}" for row in written if row["buffer_s"]]
    assert re.findall(r" ([+-]\d+) ", main(*asked).out) == left_over


def test_one_train_has_no_headway(main: Callable[..., Any], tmp_path: Path) -> None:
    told = main("headway", "rtri_test_line", "--theory", "--out", "out")
    assert (told.code, told.out) == (0, "no headway: no two trains of different sets need the same section\n")
    assert "headways.csv" in told.err and "png" not in told.err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["headways.csv"]
    assert (tmp_path / "out/headways.csv").read_text("utf-8").strip() == ",".join(COLUMNS)


def test_a_run_directory_is_read_back(main: Callable[..., Any], tmp_path: Path) -> None:
    run = run_on_plain(VALLEY)
    write_run(run, tmp_path / "run")
    told = main("headway", "run", "--json")
    assert told.code == 0, told.err
    found = told.figures()
    assert found["of"] == "run"
    assert tuple(found["headways"][0]) == COLUMNS
    meets = [row for row in found["headways"] if row["kind_ja"] == "着発"]
    assert {row["station"] for row in meets} == {"MRI"}
    told = main("capacity", "run", "--json", "--cut", "crossing")
    assert told.code == 0, told.err
    found = told.figures()
    assert found["of"] == "run"
    parts = found["cuts"][0]["parts"]
    assert [(part["period"], part["trains"]) for part in parts] == [("day", 2)] * 2  # no peak in one hour
    for kind in ("headway", "occupation"):
        told = main("plot", "run", kind)
        assert told.code == 0, told.err
        assert (tmp_path / f"{kind}.png").read_bytes()[:4] == b"\x89PNG"
        assert main("plot", "run", kind, "--out", f"{kind}.csv").code == 0
    with (tmp_path / "headway.csv").open(encoding="utf-8-sig") as file:
        assert tuple(csv.DictReader(file).fieldnames or ()) == COLUMNS
    assert main("plot", "run", "headway", "--station", "ASA", "--out", "asa.svg").code == 0


def test_occupancy_by_cut_and_room(main: Callable[..., Any], tmp_path: Path) -> None:
    ended = main("capacity", "karasuyama_weekday", "--theory", "--json", "--out", "out")
    assert ended.code == 0, ended.err
    figures = ended.figures()
    cuts = {cut["cut"]: cut["parts"] for cut in figures["cuts"]}
    assert list(cuts) == ["whole", "crossing", "interval", "section"]
    assert all(cut["how"] for cut in figures["cuts"])
    day = {
        name: max(p["occupancy_percent"] for p in parts if p["period"] == "day" and p["kind"] == "line")
        for name, parts in cuts.items()
    }
    assert day["whole"] > day["crossing"] > day["interval"] == day["section"]
    room = figures["room"]
    assert room["trains"]["day"] == 2 * len(room["paths"]) > 0
    assert room["dropped"] == []
    said = figures["conclusion"]
    assert said.startswith(f"{room['trains']['day']} more trains fit between those of the plan in the day")
    assert f"the fullest part is Hoshakuji - Ogane: it is occupied {day['crossing']:.0f} % of the day" in said
    assert (tmp_path / "out/occupation.png").read_bytes()[:4] == b"\x89PNG"


def test_a_period_of_a_line_without_portals(main: Callable[..., Any]) -> None:
    times = ("--cut", "crossing", "--from", "06:00", "--to", "12:00")
    told = main("capacity", "rtri_test_line", "--theory", *times)
    assert told.code == 0, told.err
    assert "cut: crossing - between stations" in told.out and "chosen" in told.out
    assert "no train of the plan comes from a portal" in told.out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("capacity", "karasuyama_weekday", "--theory", "--cut", "sideways"), "--cut"),
        (("capacity", "karasuyama_weekday", "--theory", "--traffic", "heavy"), "--traffic"),
        (("capacity", "karasuyama_weekday", "--theory", "--stops", "few"), "--stops"),
        (("capacity", "karasuyama_weekday", "--theory", "--from", "12:00", "--to", "11:00"), "--to"),
        (("capacity", "karasuyama_weekday", "--theory", "--from", "01:00", "--to", "02:00"), "--from"),
        (("capacity", "karasuyama_weekday", "--theory", "--buffer", "-1"), "--buffer"),
        (("headway", "karasuyama_weekday", "--theory", "--station", "SHN"), "--station"),
        (("headway", "karasuyama_weekday", "--theory", "--csv", "--json"), "--csv"),
        (("headway", "nowhere", "--theory"), "nowhere"),
        (("blocking", "nowhere", "--theory"), "nowhere"),
        (("blocking", "karasuyama_weekday", "--out", "nowhere/out.csv"), "--out"),
        (("capacity", "karasuyama_without_loop", "--theory", "--cut", "whole"), "321M, 322M"),
    ],
)
def test_bad_input_is_one_line_and_two(
    main: Callable[..., Any], tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    ended = main(*arguments)
    assert (ended.code, len(ended.err.strip().splitlines())) == (2, 1)
    assert said in ended.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "asked",
    [
        ("headway", "karasuyama_weekday", "--theory"),
        ("capacity", "karasuyama_weekday", "--theory"),
        ("running-times", "rtri_test_line"),
        ("duties", "karasuyama_weekday"),
    ],
    ids=lambda asked: asked[0],
)
def test_a_directory_of_somebody_else_is_left_alone(
    main: Callable[..., Any], tmp_path: Path, asked: tuple[str, ...]
) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out/thesis.txt").write_text("mine", "utf-8")
    ended = main(*asked, "--out", "out")
    assert ended.code == 2
    assert "thesis.txt" in ended.err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


def test_the_trains_that_fit_are_a_scenario(main: Callable[..., Any], tmp_path: Path) -> None:
    asked = ("karasuyama_weekday", "--theory", "--cut", "whole", "--from", "09:00", "--to", "11:00", "--json")
    found = main("capacity", *asked, "--out", "more.toml")
    assert found.code == 0, found.err
    (path,) = found.figures()["room"]["paths"]
    more, before = (load_scenario(name).setup for name in (str(tmp_path / "more.toml"), asked[0]))
    own = path["trains"].split()
    assert set(more.timetable.trains) - set(before.timetable.trains) == set(own)
    assert feasibility(more).good
    there, back = (more.timetable.trains[number].calls for number in own)
    assert (clock(there[0].last_s), clock(back[-1].first_s)) == (path["departs"], path["arrives"])
    again = main("capacity", str(tmp_path / "more.toml"), *asked[1:], "--out", "even_more.toml")
    assert again.code == 0, again.err
    assert [p["trains"] for p in again.figures()["room"]["paths"]] == []
    assert "even_more.toml is not written" in again.err


@pytest.mark.parametrize("source", ["run", "karasuyama_weekday"])
def test_no_scenario_is_made_of_a_run_or_over_another_file(
    main: Callable[..., Any], tmp_path: Path, source: str
) -> None:
    if source == "run":
        write_run(run_on_plain(VALLEY), tmp_path / "run")
    (tmp_path / "there.toml").touch()
    told = main("capacity", source, "--out", "more.toml" if source == "run" else "there.toml")
    assert told.code == 2
    assert ("SOURCE" if source == "run" else "exists already") in told.err
