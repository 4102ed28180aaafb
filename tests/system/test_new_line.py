"""`branchline new line` from the command line: lines that were never seen before, with real trains on SUMO."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.nightly import others_nightly

DATA = Path(__file__).resolve().parents[2] / "../shared/data"
KURURI = (
    "木更津",
    "祇園",
    "上総清川",
    "東清川",
    "横田",
    "東横田",
    "馬来田",
    "下郡",
    "小櫃",
    "俵田",
    "久留里",
    "平山",
    "上総松丘",
    "上総亀山",
)
TWO_TRACKS = {"木更津", "横田", "久留里", "上総亀山"}
DAY = """
id = "kururi_day"
name = "A weekday"
line = "line.toml"
timetable = "times.toml"
[trains]
default = "br642"
"""
# Loops, ladders of three and four tracks, a bay, a signal station, stations 600 m apart and 36 km, portals, no loop.
LISTS = {
    "mixed": """name,km,tracks,kind,points,normal,end
A,0,3,,,,
B,0.65,2,,,,
C,1.3,1,halt,,,
S,4,2,signal station,,2,
D,6,4,,,,
F,8,3,,low,,
G,11,1,station,,,
H,13,2,,,,portal
""",
    "portals": "name,km,tracks,end\nA,0,3,portal\nB,2.5,1,\nM,5,3,\nZ,9,1,portal\n",
    "no_loop": "name,km,tracks\nA,0,1\nB,1.5,1\nZ,4,1\n",
    "far": "name,km,tracks\nA,0,1\nM,3,2\nZ,39,1\n",
    "near": "name,km,tracks,side\nA,0,1,\nM,0.6,2,left\nN,1.2,2,\nZ,1.8,1,\n",
}


@pytest.mark.parametrize("name", others_nightly(LISTS, ["portals"]))
def test_real_trains_run_on_it(main: Callable[..., Any], tmp_path: Path, name: str) -> None:
    pytest.importorskip("sumo", reason="netconvert makes the net of a line that is not shipped")
    (tmp_path / "list.csv").write_text(LISTS[name], "utf-8")
    made = main(
        "new",
        "line",
        "list.csv",
        "drawn.toml",
        "--max-speed",
        "70",
        "--train-length",
        "42",
        "--scenario",
        "try.toml",
    )
    assert made.code == 0, made.err
    checked = main("check", "try.toml", "--json").figures()
    assert checked["impossible"] == 0
    ended = main("run", "try.toml", "--json", "--out", "out")
    figures = ended.figures()
    assert ended.code == 0, ended.err
    assert figures["trains_arrived"] == figures["trains_planned"] == (2 if name == "no_loop" else 4)
    assert figures["invariants_broken"] == figures["collisions"] == 0
    assert figures["late_s_max"] < 30.0


@pytest.mark.nightly
@pytest.mark.skipif(not DATA.exists(), reason="the geometry and timetable data is not beside this checkout")
def test_from_names_and_tracks_to_the_whole_weekday(main: Callable[..., Any], tmp_path: Path) -> None:
    """Fourteen names with their tracks, a polyline and published times: nothing else, and no hand on the line file."""
    pytest.importorskip("sumo", reason="netconvert makes the net of a line that is not shipped")
    rows = [f"{name},{2 if name in TWO_TRACKS else 1}" for name in KURURI]
    (tmp_path / "list.csv").write_text("name,tracks\n" + "\n".join(rows) + "\n", "utf-8")
    geometry, times = DATA / "geometry", DATA / "timetables/mini_tokyo_3d"
    track = ("--polyline", str(geometry / "polyline_11330.json"))
    stations = ("--stations-geometry", str(geometry / "line_11330.json"))
    made = main("new", "line", "list.csv", "line.toml", *track, *stations, "--max-speed", "65")
    assert made.code == 0, made.err
    assert sum("as the polyline" in row for row in made.err.splitlines()) == 14
    source = (str(times / "jreast-kururi.json"), "times.toml", "--stations", str(times / "stations.json"))
    imported = main("import", "mini-tokyo", *source, "--line", "line.toml", "--calendar", "Weekday")
    assert imported.code == 0, imported.err
    (tmp_path / "day.toml").write_text(DAY, "utf-8")
    ended = main("run", "day.toml", "--json", "--out", "out")
    figures = ended.figures()
    assert ended.code == 0, ended.err
    assert figures["trains_arrived"] == figures["trains_planned"] == 40
    assert figures["invariants_broken"] == figures["collisions"] == 0
    assert figures["late_s_max"] <= 60.0


def test_what_cannot_be_made_is_one_line_and_leaves_nothing(main: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "near.csv").write_text("name,km,tracks\nA,0,4\nB,0.3,4\n", "utf-8")
    (tmp_path / "list.csv").write_text("name,km\nA,0\nB,3\n", "utf-8")
    for arguments, words in (
        (("near.csv", "out.toml"), "at least"),
        (("list.csv", "out.txt"), "a name ending in .toml"),
        (("list.csv", "no/out.toml"), "existing folder"),
        (("none.csv", "out.toml"), "a readable file"),
        (("list.csv", "out.toml", "--max-speed", "0"), "--max-speed"),
        (("list.csv", "out.toml", "--train-length", "nan"), "--train-length"),
        (("list.csv", "out.toml", "--polyline", "p.json"), "--stations-geometry"),
        (("list.csv", "out.toml", "--id", "a b"), "--id"),
        (("list.csv", "out.toml", "--gradients", "none.csv"), "none.csv"),
        (("list.csv", "out.toml", "--scenario", "out.toml"), "--scenario"),
    ):
        ended = main("new", "line", *arguments)
        assert ended.code == 2, arguments
        assert words in ended.err.splitlines()[-1], ended.err
        assert "Traceback" not in ended.err
        assert not (tmp_path / "out.txt").exists()
    assert {p.name for p in tmp_path.iterdir()} <= {"near.csv", "list.csv"}
