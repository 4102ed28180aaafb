"""Plain XML of a passing loop: what is there, what is connected, where it lies."""

import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from network.errors import InputError
from network.model import Alignment, Direction, Gradient, Line, Piece
from sumo_cfg.writer import PlainXml, edge_id, movements, sample_kilometrages, write_plain

Array = NDArray[np.float64]
RADIUS_M = 400.0


@pytest.fixture(scope="module")
def plain(line: Line, positions: Callable[..., Array]) -> PlainXml:
    return write_plain(line, positions)


@pytest.fixture(scope="module")
def shapes(plain: PlainXml) -> dict[str, Array]:
    edges = ET.fromstring(plain.edges)
    return {
        e.attrib["id"]: np.array([[float(c) for c in p.split(",")] for p in e.attrib["shape"].split()])
        for e in edges
    }


def distance_from_centre_m(shape: Array) -> Array:
    return np.hypot(shape[:, 0], shape[:, 1] + RADIUS_M)


def test_every_joint_piece_and_movement_is_there(plain: PlainXml) -> None:
    assert len(ET.fromstring(plain.nodes)) == 10
    assert len(ET.fromstring(plain.edges)) == 2 * 10
    # 8 joints inside, 2 of them points: 6 * 2 + 2 * 4 ways through, and 20 reversals in place.
    assert len(ET.fromstring(plain.connections)) == 20 + 20


def test_points_lead_from_stem_to_leg_and_never_from_leg_to_leg(line: Line) -> None:
    pairs = set(movements(line))
    assert {
        ("stem1+", "normal1+"),
        ("stem1+", "reverse1+"),
        ("normal1-", "stem1-"),
        ("reverse1-", "stem1-"),
    } < pairs
    assert {
        ("normal2+", "stem2+"),
        ("reverse2+", "stem2+"),
        ("stem2-", "normal2-"),
        ("stem2-", "reverse2-"),
    } < pairs
    legs = [{"normal1", "reverse1"}, {"normal2", "reverse2"}]
    assert not [pair for pair in pairs if {pair[0][:-1], pair[1][:-1]} in legs]


def test_every_edge_reverses_in_place_and_nothing_else_turns(line: Line) -> None:
    turning = {(a, b) for a, b in movements(line) if a[-1] != b[-1]}
    assert turning == {(p + d, p + o) for p in line.pieces for d, o in ("+-", "-+")}


def test_edges_carry_length_section_and_piece(line: Line, plain: PlainXml) -> None:
    for edge in ET.fromstring(plain.edges):
        piece = line.pieces[edge.attrib["id"][:-1]]
        marks = {p.attrib["key"]: p.attrib["value"] for p in edge.iterfind("param")}
        assert marks == {"piece": piece.id, "section": piece.section_id}
        assert float(edge.attrib["length"]) == pytest.approx(piece.to_m - piece.from_m, abs=1e-6)
        assert float(edge.attrib["speed"]) > line.max_speed_mps


def test_both_directions_share_one_centre_line(line: Line, shapes: dict[str, Array]) -> None:
    for piece_id in line.pieces:
        down, up = shapes[edge_id(piece_id, Direction.DOWN)], shapes[edge_id(piece_id, Direction.UP)]
        assert np.array_equal(down, up[::-1])


def test_joined_edges_meet_in_one_point(line: Line, shapes: dict[str, Array]) -> None:
    for origin, target in movements(line):
        assert np.array_equal(shapes[origin][-1], shapes[target][0])


def test_tracks_lie_on_their_circles(shapes: dict[str, Array]) -> None:
    for piece_id, radius_m in (("west", 400.0), ("track1", 400.0), ("normal1", 400.0), ("track2", 396.0)):
        assert distance_from_centre_m(shapes[piece_id + "+"]) == pytest.approx(radius_m, abs=1.5e-3)


@pytest.mark.parametrize("edge", ["reverse1+", "reverse2-"])
def test_diverging_leg_bends_smoothly_from_toe_to_loop(shapes: dict[str, Array], edge: str) -> None:
    offset_m = RADIUS_M - distance_from_centre_m(shapes[edge])
    assert offset_m[0] == pytest.approx(0.0, abs=1.5e-3)
    assert offset_m[-1] == pytest.approx(4.0, abs=1.5e-3)
    assert np.all(np.diff(offset_m) > 0.0)
    # Parallel to both tracks at its ends: the first and last 2.5 m move less than a quarter of the mean.
    assert max(offset_m[1], 4.0 - offset_m[-2]) < 0.25 * 4.0 * 2.5 / 30.0
    assert offset_m[len(offset_m) // 2] == pytest.approx(2.0, abs=1.5e-3)


def test_elevation_follows_the_gradient_table_and_no_gap_exceeds_ten_metres(
    line: Line, shapes: dict[str, Array], elevation: Callable[[Alignment, float], float]
) -> None:
    alignment = line.alignments["a"]
    for piece in line.pieces.values():
        shape = shapes[piece.id + "+"]
        at_m = piece.from_m + sampled_distance_m(shape, piece)
        for m, z in zip(at_m, shape[:, 2], strict=True):
            assert z == pytest.approx(elevation(alignment, float(m)), abs=1.1e-3)
        assert np.max(np.diff(at_m)) <= 10.0 + 2e-3


def sampled_distance_m(shape: Array, piece: Piece) -> Array:
    """Distance from the piece's start (m) along its circle, from the angle about the centre."""
    angle = np.unwrap(np.arctan2(shape[:, 0], shape[:, 1] + RADIUS_M))
    along_m: Array = (angle - angle[0]) * RADIUS_M
    return along_m


def test_a_change_of_gradient_is_a_shape_point(line: Line) -> None:
    kilometrage_m = sample_kilometrages(line.pieces["east"], line.alignments["a"], 10.0)
    assert 700.0 in kilometrage_m


@given(
    from_m=st.floats(0.0, 50_000.0),
    length_m=st.floats(0.5, 9_000.0),
    breaks=st.lists(st.floats(0.0, 1.0), max_size=20, unique=True),
    spacing_m=st.sampled_from([2.5, 10.0]),
)
def test_samples_cover_a_piece(from_m: float, length_m: float, breaks: list[float], spacing_m: float) -> None:
    piece = Piece("p", "s", "a", from_m, from_m + length_m, "x", "y")
    at_m = [from_m, *(from_m + b * length_m for b in sorted(breaks)), from_m + length_m]
    gradients = tuple(Gradient(a, b, 1.0) for a, b in pairwise(at_m))
    alignment = Alignment("a", from_m, from_m + length_m, 0.0, 0.0, 0.0, 0.0, gradients, (), (), ())
    kilometrage_m = sample_kilometrages(piece, alignment, spacing_m)
    steps_m = np.diff(kilometrage_m)
    assert (kilometrage_m[0], kilometrage_m[-1]) == (piece.from_m, piece.to_m)
    # netconvert drops a shape point within 0.1 m of the one before.
    assert np.all(steps_m > 0.1)
    assert np.all(steps_m <= spacing_m + 1e-6)


def test_a_track_that_divides_without_points_is_refused(line: Line) -> None:
    with pytest.raises(InputError, match="joint t1"):
        movements(replace(line, points={"2": line.points["2"]}))


def test_points_that_do_not_fit_their_joint_are_refused(line: Line) -> None:
    facing_wrong_way = replace(line.points["1"], faces=Direction.UP)
    with pytest.raises(InputError, match="points 1"):
        movements(replace(line, points={**line.points, "1": facing_wrong_way}))


def test_alignments_that_do_not_meet_are_refused(line: Line, positions: Callable[..., Array]) -> None:
    elsewhere = replace(line.alignments["a"], id="b", elevation_m=90.0)
    east = replace(line.pieces["east"], alignment_id="b")
    split = replace(
        line, alignments={**line.alignments, "b": elsewhere}, pieces={**line.pieces, "east": east}
    )
    with pytest.raises(InputError, match=r"joint j2.*40\.0 m apart"):
        write_plain(split, positions)


def test_digest_follows_the_track_and_nothing_else(
    line: Line, plain: PlainXml, positions: Callable[..., Array], with_gradient: Callable[[Line, float], Line]
) -> None:
    faster = replace(line, max_speed_mps=40.0, name="Another name")
    assert write_plain(faster, positions).digest == plain.digest
    assert write_plain(with_gradient(line, 12.0), positions).digest != plain.digest
