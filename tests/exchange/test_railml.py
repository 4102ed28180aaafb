"""railML 2.4 and 3.2: one layout from both, and what is no layout of ordinary points is said."""

from itertools import combinations
from pathlib import Path

import pytest

from exchange.layout import ForeignLayout, NodeKind, TurnoutSide
from exchange.railml import read_railml
from network.errors import InputError
from tests.exchange.layouts import RAILML_2, RAILML_3, leave_out_each_line

SHARED = Path(__file__).resolve().parents[2] / "../shared/data/railml"
needs_shared = pytest.mark.skipif(
    not SHARED.is_dir(), reason="railML examples (../shared/data/railml) absent"
)
EXAMPLES = ("Simple Example+RTC", "Simplest Example")


def read(tmp_path: Path, text: str) -> ForeignLayout:
    path = tmp_path / "layout.xml"
    path.write_text(text, "utf-8")
    return read_railml(path)


def refused(tmp_path: Path, text: str) -> str:
    with pytest.raises(InputError) as refusal:
        read(tmp_path, text)
    return str(refusal.value)


def tracks(layout: ForeignLayout) -> list[object]:
    """Tracks without the ids of the file."""
    return sorted((t.name, t.length_m, t.kilometrage) for t in layout.tracks)


def stations(layout: ForeignLayout) -> list[object]:
    return sorted(
        (
            s.code,
            s.name,
            s.position_m,
            tuple(sorted((x.track_name, x.offset_m) for x in s.spots)),
            tuple(sorted((layout.track_of[p.track_id].name, p.from_m, p.to_m) for p in s.platforms)),
        )
        for s in layout.stations
    )


def points(layout: ForeignLayout) -> list[object]:
    def end(track_id: str) -> object:
        track = layout.track_of[track_id]
        return track.name, track.length_m

    return sorted(
        (p.name, end(p.stem), end(p.normal), end(p.reverse), p.side, p.diverging_kmh) for p in layout.points
    )


def signals(layout: ForeignLayout) -> list[object]:
    return sorted(
        (s.name, layout.km_of(s.track_id, s.offset_m), layout.track_of[s.track_id].name, s.forward)
        for s in layout.signals
    )


def ends(layout: ForeignLayout) -> list[str]:
    return sorted(node.kind.value for node in layout.nodes)


def test_both_versions_of_the_small_layout_are_as_drawn(tmp_path: Path) -> None:
    for text in (RAILML_2, RAILML_3):
        layout = read(tmp_path, text)
        assert sorted((t.name, t.length_m) for t in layout.tracks) == [
            ("1", 400.0),
            ("1", 600.0),
            ("1", 1000.0),
            ("2", 404.0),
        ]
        assert points(layout) == [
            ("P1", ("1", 1000.0), ("1", 400.0), ("2", 404.0), TurnoutSide.RIGHT, 35.0),
            ("P2", ("1", 600.0), ("1", 400.0), ("2", 404.0), TurnoutSide.LEFT, 35.0),
        ]
        assert [(s.code, s.name, s.position_m) for s in layout.stations] == [
            ("BIR", "Birch", 1200.0),
            ("", "Cedar", 1900.0),
        ]
        assert signals(layout) == [("A", 900.0, "1", True), ("B", 1500.0, "1", False)]
        assert ends(layout) == ["buffer stop", "open end", "points", "points"]
        # The loop is 4 m longer than its kilometrage: stretched between its ends.
        (loop,) = (t for t in layout.tracks if t.name == "2")
        assert loop.km_m(202.0) == pytest.approx(1200.0)
        assert "1 derailer" in layout.left


def test_both_versions_give_the_same(tmp_path: Path) -> None:
    one, other = read(tmp_path, RAILML_2), read(tmp_path, RAILML_3)
    for of in (tracks, stations, points, signals, ends):
        assert of(one) == of(other)


@needs_shared
@pytest.mark.parametrize("example", EXAMPLES)
def test_both_versions_of_the_published_layouts_give_the_same(example: str) -> None:
    one, other = (read_railml(SHARED / f"{example}-{version}.xml") for version in ("2.4", "3.2"))
    for of in (tracks, stations, points, signals, ends):
        assert of(one) == of(other)
    # The double slip that 2.4 writes as a crossing is points in neither.
    for layout in (one, other):
        assert any("doubleSwitchCrossing" in text and "4 tracks" in text for text in layout.left)
        assert sum(node.kind is NodeKind.CROSSING for node in layout.nodes) == 1
        assert any("derailer" in text for text in layout.left)
        assert any("jump of the kilometrage" in text for text in layout.used)


@needs_shared
def test_the_published_layout_is_as_its_file_says() -> None:
    layout = read_railml(SHARED / "Simple Example+RTC-3.2.xml")
    assert [(s.code, s.position_m) for s in layout.stations] == [("ARN", 200.0), ("CST", 4850.0)]
    assert layout.length_m == pytest.approx(6900.0)
    (line,) = (track for track in layout.tracks if track.name == "H")
    # The kilometrage jumps from 2.8 to 2.85 km.
    assert (line.length_m, line.km_m(1849.0), line.km_m(1851.0)) == (3300.0, 2799.0, 2851.0)


def test_a_crossing_is_said_and_left_out(tmp_path: Path) -> None:
    crossing = RAILML_2.replace('<switch id="s1"', '<crossing id="s1"').replace("</switch>", "</crossing>", 1)
    layout = read(tmp_path, crossing)
    assert [entry.name for entry in layout.points] == ["P2"]
    assert any(text.startswith("not among points: crossing P1") for text in layout.left)
    slip = RAILML_3.replace('id="s1" type="ordinarySwitch"', 'id="s1" type="doubleSwitchCrossing"')
    layout = read(tmp_path, slip)
    assert [entry.name for entry in layout.points] == ["P2"]
    assert any("doubleSwitchCrossing P1" in text for text in layout.left)


def test_points_with_a_branch_to_nowhere_are_said(tmp_path: Path) -> None:
    layout = read(tmp_path, RAILML_2.replace('ref="k1" course', 'ref="lost" course'))
    assert [entry.name for entry in layout.points] == ["P2"]
    assert any(text.startswith("not among points: P1") for text in layout.left)


def test_a_branch_that_goes_straight_on_turns_the_side(tmp_path: Path) -> None:
    straight = RAILML_2.replace(
        'pos="1000" trackContinueCourse="straight"', 'pos="1000" trackContinueCourse="left"'
    )
    straight = straight.replace('ref="k1" course="right"', 'ref="k1" course="straight"')
    (p1, _) = read(tmp_path, straight).points
    assert p1.side is TurnoutSide.RIGHT


def test_kilometrage_that_is_only_known_somewhere_runs_on(tmp_path: Path) -> None:
    only_end = RAILML_2.replace('pos="0" absPos="0"', 'pos="0"').replace(
        'pos="404" absPos="1400"', 'pos="404"'
    )
    only_end = only_end.replace('id="b2" pos="0" absPos="1000"', 'id="b2" pos="0"')
    layout = read(tmp_path, only_end)
    assert [s.position_m for s in layout.stations] == [1200.0, 1900.0]
    assert any("kilometrage of 1 track carried over" in text for text in layout.assumed)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('version="2.4"', 'version="2.2"', "version"),
        ('version="2.4"', 'version="3.2"', "xmlns"),
        ("https://www.railml.org/schemas/2018", "https://www.railml.org/schemas/2013", "xmlns"),
        ("railml ", "gpx ", "outermost element is gpx"),
        ('pos="1000" track', 'pos="9000" track', "switch s1: pos"),
        ('pos="2000"', 'pos="-3"', "track tm"),
        ('pos="2000"', 'pos="nan"', "trackEnd e1: pos"),
        ('<track id="ts"', '<track id="tm"', "id of its own"),
        ('<track id="ts"', "<track", "track: id"),
    ],
)
def test_a_wrong_file_gets_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    damaged = RAILML_2.replace(old, new).replace("</railml>", "</gpx>" if new == "gpx " else "</railml>")
    text = refused(tmp_path, damaged)
    assert said in text
    assert "\n" not in text


def test_a_file_without_tracks_is_refused(tmp_path: Path) -> None:
    empty = (
        '<railML xmlns="https://www.railml.org/schemas/3.2" version="3.2"><infrastructure id="i"/></railML>'
    )
    assert "that has tracks" in refused(tmp_path, empty)
    assert "infrastructure" in refused(
        tmp_path, '<railML xmlns="https://www.railml.org/schemas/3.2" version="3.2"/>'
    )


def test_places_of_coarser_levels_are_left_and_those_of_no_level_refused(tmp_path: Path) -> None:
    """A file of all levels has each place on each of them: `meso` is made of tracks, and a node has no length."""
    node = RAILML_3.replace("</netElements>", '<netElement id="macro"/></netElements>')
    as_drawn = read(tmp_path, RAILML_3)
    for level in ("meso", "macro"):
        spot = f'<spotLocation id="c{level}" netElementRef="{level}" pos="0"/>'
        many = node.replace("<leftBranch", f"{spot}<leftBranch").replace("</signalIS>", f"{spot}</signalIS>")
        many = many.replace('<designator register="R"', f'{spot}<designator register="R"')
        layout = read(tmp_path, many)
        assert (signals(layout), stations(layout)) == (signals(as_drawn), stations(as_drawn))
    assert "netElementRef" in refused(tmp_path, many.replace('netElementRef="macro"', 'netElementRef="none"'))
    alone = '<netElements><netElement id="macro"/></netElements>'
    head, rest = RAILML_3.split("<netElements>", 1)
    coarse = head + alone + rest.split("</netElements>", 1)[1]
    coarse = coarse.split("<functionalInfrastructure>", 1)[0] + "</infrastructure></railML>"
    coarse = coarse.split("<netRelations>", 1)[0] + "</topology></infrastructure></railML>"
    assert "microscopic" in refused(tmp_path, coarse)


@pytest.mark.parametrize("text", [RAILML_2, RAILML_3], ids=["2.4", "3.2"])
def test_a_truncated_file_gets_one_line(tmp_path: Path, text: str) -> None:
    for share in (0.1, 0.5, 0.9):
        assert "whole and valid XML" in refused(tmp_path, text[: int(len(text) * share)])


@pytest.mark.parametrize("text", [RAILML_2, RAILML_3], ids=["2.4", "3.2"])
def test_a_line_left_out_is_bad_input_or_said(tmp_path: Path, text: str) -> None:
    leave_out_each_line(text, tmp_path / "layout.xml", read_railml)


def test_references_to_what_is_not_there_are_bad_input_or_left(tmp_path: Path) -> None:
    words = ("netElementRef", "netRelationRef", "ref", "ocpRef")
    for word, other in combinations(words, 2):
        for text in (RAILML_2, RAILML_3):
            path = tmp_path / "layout.xml"
            path.write_text(
                text.replace(f'{word}="', f'{word}="no').replace(f'{other}="', f'{other}="un'), "utf-8"
            )
            try:
                read_railml(path)
            except InputError as error:
                assert "\n" not in str(error)
