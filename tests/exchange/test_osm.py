"""OpenStreetMap: what is on the map becomes tracks and points, and what is not so is said."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.layout import ForeignLayout, NodeKind, TurnoutSide
from exchange.layout_geometry import stem_and_legs
from exchange.osm import read_osm
from network.errors import InputError
from network.model import CrossingClass
from tests.exchange.layouts import OSM, leave_out_each_line, osm_node, osm_way

SHARED = Path(__file__).resolve().parents[2] / "../shared/data/osm/bad_hersfeld_rail.osm.xml"
needs_shared = pytest.mark.skipif(not SHARED.is_file(), reason="OSM cut (../shared/data/osm) absent")


def read(tmp_path: Path, text: str) -> ForeignLayout:
    path = tmp_path / "cut.osm"
    path.write_text(text, "utf-8")
    return read_osm(path)


def refused(tmp_path: Path, text: str) -> str:
    with pytest.raises(InputError) as refusal:
        read(tmp_path, text)
    assert "\n" not in str(refusal.value)
    return str(refusal.value)


def test_the_small_map_is_as_drawn(tmp_path: Path) -> None:
    layout = read(tmp_path, OSM)
    # Ways 1 and 2 are cut at a milestone for no reason: one track. Way 3 runs against the line.
    lengths = sorted((t.name, round(t.length_m)) for t in layout.tracks)
    assert lengths == [("", 400), ("7", 400), ("7", 600), ("7", 1000)]
    by_node = {entry.node_id: entry for entry in layout.points}
    length = {t.id: round(t.length_m) for t in layout.tracks}
    assert {node: (length[p.stem], p.side) for node, p in by_node.items()} == {
        "4": (1000, TurnoutSide.RIGHT),
        "6": (600, TurnoutSide.LEFT),
    }
    assert all(layout.track_of[p.normal].name == "7" for p in layout.points)
    assert all(layout.track_of[p.reverse].kind == "siding" for p in layout.points)
    assert [(s.code, s.name) for s in layout.stations] == [("BIR", "Birch"), ("", "Cedar")]
    assert sorted(spot.track_name for spot in layout.stations[0].spots) == ["1", "2"]
    kinds = sorted(node.kind.value for node in layout.nodes)
    assert kinds == ["buffer stop", "open end", "points", "points"]
    for text in ("1 way of railway=abandoned", "1 speed limit of a way"):
        assert text in layout.left


@pytest.mark.parametrize(
    ("tags", "kind"),
    [
        ({}, None),
        ({"crossing__saltire": "yes"}, None),  # it stands at nearly all of them
        ({"crossing__barrier": "full"}, CrossingClass.BARRIERS),
        ({"crossing__barrier": "half", "crossing__light": "yes"}, CrossingClass.BARRIERS),
        ({"crossing__barrier": "no", "crossing__light": "yes"}, CrossingClass.WARNING),
        ({"crossing__bell": "yes"}, CrossingClass.WARNING),
        ({"crossing__barrier": "no"}, CrossingClass.NO_DEVICE),
        ({"crossing__light": "no", "crossing__bell": "no"}, CrossingClass.NO_DEVICE),
        ({"crossing": "uncontrolled"}, CrossingClass.NO_DEVICE),
    ],
)
@pytest.mark.parametrize("railway", ["level_crossing", "crossing"])
def test_a_node_of_road_and_track_is_a_level_crossing(
    tmp_path: Path, railway: str, tags: dict[str, str], kind: CrossingClass | None
) -> None:
    """Drawn at 600 m of the track that runs with the kilometrage; that of the milestones at 500 and 700 m."""
    drawn, given = (
        osm_node(14, 600, 0, railway=value, **more)
        for value, more in (("level_crossing", {}), (railway, tags))
    )
    layout = read(tmp_path, OSM.replace(drawn, given))
    (crossing,) = layout.crossings
    assert crossing.kind is kind
    assert layout.km_of(crossing.track_id, crossing.offset_m) == pytest.approx(600.0, abs=1.0)
    assert any(text.startswith("1 level crossing: barriers") for text in layout.assumed) is (kind is None)
    assert not any("railway=level_crossing" in text for text in layout.left)


def test_one_beside_the_tracks_is_left(tmp_path: Path) -> None:
    layout = read(
        tmp_path, OSM.replace("<way ", osm_node(99, 600, 30, railway="level_crossing") + "<way ", 1)
    )
    assert len(layout.crossings) == 1
    assert "1 level crossing beside the tracks" in layout.left


def test_milestones_give_the_kilometrage_beyond_them_and_beside_them(tmp_path: Path) -> None:
    layout = read(tmp_path, OSM)
    assert [m.position_m for m in layout.milestones] == [500.0, 700.0]
    exact = OSM.replace('railway:position" v="0.5"', 'railway:position:exact" v="0.000"')
    assert [m.position_m for m in read(tmp_path, exact).milestones] == [0.0, 700.0]
    where = {s.name: s.position_m for s in layout.stations}
    assert where["Birch"] == pytest.approx(1200.0, abs=1.0)
    assert where["Cedar"] == pytest.approx(1900.0, abs=1.0)
    signals = {s.name: (layout.km_of(s.track_id, s.offset_m), s.forward) for s in layout.signals}
    km_a, km_b = signals["A"][0], signals["B"][0]
    assert km_a == pytest.approx(900.0, abs=1.0)
    assert km_b == pytest.approx(1500.0, abs=1.0)

    def speaks_down(name: str) -> bool:
        signal = next(s for s in layout.signals if s.name == name)
        rows = layout.track_of[signal.track_id].kilometrage
        return signal.forward == (rows[-1][1] > rows[0][1])

    # A is forward on a way that runs with the kilometrage, B backward on one that runs against it.
    assert speaks_down("A")
    assert speaks_down("B")


def test_a_way_without_some_of_its_nodes_is_cut_there(tmp_path: Path) -> None:
    cut = OSM.replace(osm_node(14, 600, 0, railway="level_crossing"), "")
    layout = read(tmp_path, cut)
    assert sorted(round(t.length_m) for t in layout.tracks if t.name == "7") == [300, 400, 500, 600]
    assert "1 way reached beyond the file: cut there" in layout.assumed


def test_two_nodes_at_one_place_are_one_and_a_way_of_two_extracts_is_one(tmp_path: Path) -> None:
    drawn = read(tmp_path, OSM)
    upon = OSM.replace("<way ", osm_node(33, 700, 0) + "<way ", 1)
    upon = upon.replace('<nd ref="14"/><nd ref="3"/>', '<nd ref="14"/><nd ref="3"/><nd ref="33"/>')
    upon = upon.replace('<nd ref="3"/><nd ref="12"/>', '<nd ref="33"/><nd ref="12"/>')
    again = osm_way(1, [1, 2, 14, 3], ref="7", usage="branch")
    for text in (upon, OSM.replace("</osm>", again + "</osm>")):
        assert read(tmp_path, text).tracks == drawn.tracks
        assert read(tmp_path, text).stations == drawn.stations
    other = osm_way(1, [1, 2], ref="7", usage="branch")
    assert "way 1; expected an id of its own" in refused(tmp_path, OSM.replace("</osm>", other + "</osm>"))


def test_stops_of_one_name_far_apart_have_no_mean_kilometrage(tmp_path: Path) -> None:
    """Two stations of a name, or tracks of another line: what lies in the middle is neither."""
    far = OSM.replace(osm_node(1, 0, 0), osm_node(1, 0, 0, railway="stop", name="Birch"))
    layout = read(tmp_path, far)
    assert {s.name: s.position_m is None for s in layout.stations} == {"Birch": True, "Cedar": False}
    assert any("Birch, whose stops lie at km 0.000 to 1.2" in text for text in layout.left)


def test_three_tracks_that_form_no_points_and_four_are_crossings(tmp_path: Path) -> None:
    star = "\n".join(
        (
            '<osm version="0.6">',
            osm_node(1, 0, 0, railway="switch"),
            *(osm_node(2 + i, 100 * math.cos(a), 100 * math.sin(a)) for i, a in enumerate((0, 2.094, 4.189))),
            osm_node(10, 1000, 0),
            *(
                osm_node(11 + i, 1000 + x, y)
                for i, (x, y) in enumerate(((99, 9), (-99, -9), (99, -9), (-99, 9)))
            ),
            *(osm_way(i, [1, 1 + i]) for i in (1, 2, 3)),
            osm_way(8, [12, 10, 11]),
            osm_way(9, [14, 10, 13]),
            "</osm>",
        )
    )
    layout = read(tmp_path, star)
    assert layout.points == ()
    assert sum(node.kind is NodeKind.CROSSING for node in layout.nodes) == 2
    assert any("node 1," in text and "three tracks" in text for text in layout.left)
    assert any("node 10," in text and "4 tracks" in text for text in layout.left)


def test_a_switch_of_the_map_where_two_tracks_meet_is_said(tmp_path: Path) -> None:
    layout = read(tmp_path, OSM.replace("level_crossing", "switch"))
    assert any("node 14, called a switch, but 2 track ends" in text for text in layout.left)


def test_points_that_the_map_does_not_call_so_are_assumed(tmp_path: Path) -> None:
    layout = read(tmp_path, OSM.replace('v="switch"', 'v="vacancy_detection"', 1))
    assert len(layout.points) == 2
    assert any(text.startswith("1 set of points: three tracks meet there") for text in layout.assumed)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<osm version="0.6">', '<gpx version="0.6">', "outermost element is gpx"),
        ('v="rail"', 'v="tram"', "railway=light_rail"),
        ('lat="0.000000000"', 'lat="100"', "longitude and latitude"),
        ('lat="0.000000000"', 'lat="north"', "lat"),
        ('<node id="1"', '<node id=""', "node: id"),
        ('lon="10.017', 'lon="19.017', "a cut of at most"),
    ],
)
def test_a_wrong_file_gets_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = OSM.replace(old, new)
    text = text.replace("</osm>", "</gpx>") if "gpx" in new else text
    assert said in refused(tmp_path, text)


def test_a_truncated_file_gets_one_line(tmp_path: Path) -> None:
    for share in (0.2, 0.5, 0.95):
        assert "whole and valid XML" in refused(tmp_path, OSM[: int(len(OSM) * share)])


def test_a_line_left_out_is_bad_input_or_said(tmp_path: Path) -> None:
    leave_out_each_line(OSM, tmp_path / "cut.osm", read_osm)


@given(
    turn=st.floats(0, 2 * math.pi),
    leads_off=st.floats(0.02, 0.7),
    left=st.booleans(),
    bend=st.floats(-0.01, 0.01),
    order=st.permutations([0, 1, 2]),
)
def test_stem_and_legs_are_found_however_points_lie(
    turn: float, leads_off: float, left: bool, bend: float, order: list[int]
) -> None:
    sign = 1 if left else -1
    angles = [turn + math.pi, turn + bend, turn + sign * leads_off]  # stem, straight leg, branch
    found = stem_and_legs([(math.cos(angles[i]), math.sin(angles[i])) for i in order])
    assert found is not None
    assert [order[i] for i in (found.stem, found.straight, found.branch)] == [0, 1, 2]
    assert found.side is (TurnoutSide.LEFT if left else TurnoutSide.RIGHT)


@needs_shared
def test_the_cut_of_bad_hersfeld() -> None:
    layout = read_osm(SHARED)
    assert any(text.startswith("49 ways as ") for text in layout.used)
    assert any("10 yard" in text for text in layout.used)
    # Every node that the map calls a switch is among the points: 23, counted in the file by its tags.
    tagged = SHARED.read_text("utf-8").count('k="railway" v="switch"')
    unsaid = next(int(text.split()[0]) for text in layout.assumed if "no railway=switch" in text)
    assert tagged == 23
    assert len(layout.points) == tagged + unsaid
    assert len(layout.milestones) == 29
    places = {s.code: s.position_m for s in layout.stations}
    # Milestones beside the platforms read 153.2 and 156.8.
    assert places["FBHF"] == pytest.approx(153_200, abs=60)
    assert places["FFL"] == pytest.approx(156_800, abs=60)


def test_a_signal_on_a_way_drawn_against_its_track_is_turned(tmp_path: Path) -> None:
    """The last 600 m in two ways, from either end: one track in the sense of the first, the signal on the other."""
    two = OSM.replace(
        osm_way(3, [8, 7, 15, 6], ref="7", usage="branch"),
        osm_way(3, [8, 7], ref="7", usage="branch") + osm_way(6, [6, 15, 7], ref="7", usage="branch"),
    )
    layout = read(tmp_path, two)
    (signal,) = (s for s in layout.signals if s.name == "B")
    rows = layout.track_of[signal.track_id].kilometrage
    grows = rows[-1][1] > rows[0][1]
    # Backward on a way that runs with the kilometrage: to trains that run against it.
    assert signal.forward != grows
    assert layout.km_of(signal.track_id, signal.offset_m) == pytest.approx(1500.0, abs=1.0)


def test_a_line_that_bends_off_at_points_is_their_normal_leg(tmp_path: Path) -> None:
    """The siding goes straight on, the line to its left: the line is the normal leg all the same."""
    bend = "\n".join(
        (
            '<osm version="0.6">',
            osm_node(1, 0, 0),
            osm_node(2, 500, 0, railway="switch"),
            osm_node(3, 900, 60),
            osm_node(4, 900, 0, railway="buffer_stop"),
            osm_way(1, [1, 2], ref="7"),
            osm_way(2, [2, 3], ref="7"),
            osm_way(3, [2, 4], service="siding"),
            "</osm>",
        )
    )
    (points,) = read(tmp_path, bend).points
    assert (points.stem, points.normal, points.reverse, points.side) == ("1", "2", "3", TurnoutSide.RIGHT)
