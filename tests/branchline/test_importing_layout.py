"""`branchline import railml|osm|sumo` and `branchline export sumo` as a person calls them."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import Ended
from tests.exchange.layouts import OSM, RAILML_2, RAILML_3


@pytest.mark.parametrize("text", [RAILML_2, RAILML_3], ids=["2.4", "3.2"])
def test_railml_is_told_and_listed(text: str, main: Callable[..., Ended], tmp_path: Path) -> None:
    (tmp_path / "in.xml").write_text(text, "utf-8")
    ended = main("import", "railml", "in.xml", "out.toml")
    assert ended.code == 0
    for word in (
        "taken: 4 tracks of 2.404 km",
        "assumed: ",
        "left: 1 derailer",
        "station: Birch, km 1.200, 2 tracks",
    ):
        assert word in ended.out
    assert "in the way" not in ended.out
    assert len(tomllib.loads((tmp_path / "out.toml").read_text("utf-8"))["stations"]) == 2


def test_json_is_one_object(main: Callable[..., Ended], tmp_path: Path) -> None:
    (tmp_path / "in.xml").write_text(RAILML_2, "utf-8")
    figures = main("import", "railml", "in.xml", "--json").figures()
    assert figures["outcome"] == "good"
    assert {"taken", "assumed", "left", "obstacles", "tracks", "points", "stations"} <= figures.keys()


def test_a_map_becomes_a_net_that_comes_back(main: Callable[..., Ended], tmp_path: Path) -> None:
    pytest.importorskip("sumo", reason="the extra net is not installed")
    (tmp_path / "in.osm").write_text(OSM, "utf-8")
    assert main("import", "osm", "in.osm", "out.toml", "--net", "out.net.xml").code == 0
    ended = main("import", "sumo", "out.net.xml", "--json")
    assert len(ended.figures()["points"]) == 2
    assert ended.figures()["outcome"] == "good"


@pytest.mark.parametrize("kind", ["railml", "osm", "sumo"])
@pytest.mark.parametrize("content", ["", "{}", "<a/>", "<railML version='3.2'/>"])
def test_a_foreign_file_leaves_nothing_and_one_line(
    kind: str, content: str, main: Callable[..., Ended], tmp_path: Path
) -> None:
    (tmp_path / "in.xml").write_text(content, "utf-8")
    ended = main("import", kind, "in.xml", "out.toml")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err.count("\n") == 1
    assert not (tmp_path / "out.toml").exists()


def test_an_export_says_where_it_is(main: Callable[..., Ended], tmp_path: Path) -> None:
    figures = main("export", "sumo", "rtri_test_line", "out", "--json").figures()
    assert (figures["trains"], figures["vehicles"], figures["outcome"]) == (1, 1, "good")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "rtri_test_line.add.xml",
        "rtri_test_line.net.xml",
        "rtri_test_line.rou.xml",
        "rtri_test_line.sumocfg",
    ]
    assert "sumo-gui -c" in main("export", "sumo", "rtri_test_line", "out").out


def test_an_export_of_a_plan_that_cannot_work_says_so(
    main: Callable[..., Ended], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("branchline.exporting_sumo.SAID_MAX", 1)
    ended = main("export", "sumo", "karasuyama_without_loop", "out")
    assert ended.code == 0
    assert "cannot work, and will not in SUMO: " in ended.err
    assert "and 1 more; branchline check has them all" in ended.err


def test_an_export_of_nothing_is_one_line(main: Callable[..., Ended], tmp_path: Path) -> None:
    ended = main("export", "sumo", "no_such_scenario", "out")
    assert ended.code == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        *(("import", kind, "in.xml", "out.toml") for kind in ("railml", "osm", "sumo", "gtfs", "oudia")),
        ("import", "mini-tokyo", "in.json", "out.toml", "--line", "karasuyama"),
        ("import", "geometry", "polyline.json", "stations.json", "out.toml"),
        ("new", "line", "list.csv", "out.toml"),
        ("new", "line", "list.csv", "line.toml", "--scenario", "out.toml"),
        ("new", "line", "list.csv", "line.toml", "--scenario", "day.toml"),
    ],
    ids=" ".join,
)
def test_what_a_person_may_have_edited_is_not_replaced(
    arguments: tuple[str, ...], main: Callable[..., Ended], tmp_path: Path
) -> None:
    """Nothing of it is read before: of what is asked here, only the files that are in the way are there."""
    for name in ("out.toml", "day_times.toml"):
        (tmp_path / name).write_text("mine", "utf-8")
    (tmp_path / "list.csv").write_text("name,km\nA,0\nB,3\n", "utf-8")
    ended = main(*arguments)
    assert (ended.code, ended.out) == (2, "")
    assert ended.err.endswith(".toml'; expected a new file: this one exists already\n")
    assert sorted(p.name for p in tmp_path.glob("*.toml")) == ["day_times.toml", "out.toml"]
    assert {p.read_text("utf-8") for p in tmp_path.glob("*.toml")} == {"mine"}
