import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.graph import routes_from
from network.model import Direction
from network.path import Path, path_of
from tests.network.sample import LINE

PATHS = [
    path_of(LINE, route.piece_ids, direction)
    for direction in Direction
    for section_id in ("P", "A.1", "A.2", "B.1", "B.2")
    for route in routes_from(LINE, section_id, direction)
]


def test_down_coordinates() -> None:
    path = path_of(LINE, ["P", "A.11.stem", "A.11.reverse", "A.2"], Direction.DOWN)
    assert path.length_m == 360.0
    assert path.to_path_m("A.2", 290.0) == 290.0
    assert path.locate(105.0) == ("A.11.stem", 105.0)
    assert path.piece_ids == ("P", "A.11.stem", "A.11.reverse", "A.2")


def test_up_coordinates_grow_against_kilometrage() -> None:
    path = path_of(LINE, ["B.1", "B.11.normal", "B.11.stem", "A-B"], Direction.UP)
    assert path.length_m == 3200.0 - 420.0
    assert path.to_path_m("B.1", 3110.0) == pytest.approx(90.0)
    assert path.kilometrage_m(90.0) == pytest.approx(3110.0)
    assert path.to_path_m("A-B", 1470.0) == pytest.approx(1730.0)


def test_a_joint_belongs_to_the_piece_being_entered() -> None:
    path = path_of(LINE, ["P", "A.11.stem"], Direction.DOWN)
    assert path.locate(100.0) == ("A.11.stem", 100.0)
    assert path.locate(110.0) == ("A.11.stem", 110.0)


def test_coordinates_beyond_the_path_extend_its_ends() -> None:
    path = path_of(LINE, ["P", "A.11.stem"], Direction.DOWN)
    assert path.locate(-5.0) == ("P", -5.0)
    assert path.locate(115.0) == ("A.11.stem", 115.0)


def test_pieces_off_the_path() -> None:
    path = path_of(LINE, ["P", "A.11.stem"], Direction.DOWN)
    assert "A.1" not in path
    with pytest.raises(KeyError):
        path.to_path_m("A.1", 200.0)
    with pytest.raises(KeyError):
        path_of(LINE, ["nowhere"], Direction.DOWN)
    with pytest.raises(ValueError, match=r"A\.1 does not follow P going down"):
        path_of(LINE, ["P", "A.1"], Direction.DOWN)
    with pytest.raises(ValueError, match="at least one"):
        path_of(LINE, [], Direction.DOWN)


@given(st.sampled_from(PATHS), st.floats(0.0, 1.0))
def test_there_and_back(path: Path, share: float) -> None:
    path_m = share * path.length_m
    piece_id, kilometrage_m = path.locate(path_m)
    piece = LINE.pieces[piece_id]
    assert piece.from_m - 1e-6 <= kilometrage_m <= piece.to_m + 1e-6
    assert path.to_path_m(piece_id, kilometrage_m) == pytest.approx(path_m, abs=1e-9)


@given(st.sampled_from(PATHS))
def test_steps_lie_end_to_end(path: Path) -> None:
    at_m = 0.0
    for step in path.steps:
        assert step.start_m == pytest.approx(at_m, abs=1e-6)
        at_m = step.end_m
    assert at_m == pytest.approx(path.length_m, abs=1e-6)
    assert path.length_m == pytest.approx(sum(LINE.pieces[p].length_m for p in path.piece_ids), abs=1e-6)
