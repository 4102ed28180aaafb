"""Pieces of track put together: nothing is lost or made up, however they were cut and turned."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.layout import LayoutPoints, LayoutTrack
from exchange.layout_draft import JoinedEnds, carried_kilometrage, km_rows, merged_pieces

Cuts = st.lists(st.tuples(st.integers(1, 500), st.booleans()), min_size=1, max_size=12)


def piece(
    name: str, low: str, high: str, length_m: float, rows: tuple[tuple[float, float], ...] = ()
) -> LayoutTrack:
    return LayoutTrack(name, "1", "main", low, high, length_m, (), rows)


@given(cuts=Cuts, jump_at=st.integers(0, 12), order=st.randoms(use_true_random=False))
def test_a_track_cut_anywhere_and_turned_is_whole_again(
    cuts: list[tuple[int, bool]], jump_at: int, order: object
) -> None:
    """Lengths add up, and each place of each piece keeps its kilometrage; a jump stays where it was."""
    pieces: list[LayoutTrack] = []
    km_m = 3000.0
    truth: list[tuple[str, bool, float, float]] = []
    for number, (length_m, turned) in enumerate(cuts):
        km_m += 70.0 if number == jump_at else 0.0
        low, high = f"n{number}", f"n{number + 1}"
        rows = ((0.0, km_m), (float(length_m), km_m + length_m))
        if turned:
            low, high = high, low
            rows = ((0.0, km_m + length_m), (float(length_m), km_m))
        pieces.append(piece(f"p{number}", low, high, float(length_m), rows))
        truth.append((f"p{number}", turned, km_m, float(length_m)))
        km_m += length_m
    order.shuffle(pieces)  # type: ignore[attr-defined]
    done = merged_pieces(pieces, frozenset())
    (track,) = done.tracks
    assert track.length_m == sum(length_m for length_m, _ in cuts)
    assert {track.low_node, track.high_node} == {"n0", f"n{len(cuts)}"}
    assert len(track.kilometrage) == (4 if 0 < jump_at < len(cuts) else 2)
    for name, turned, from_km_m, length_m in truth:
        inside_m = length_m / 2.0
        expected = from_km_m + (length_m - inside_m if turned else inside_m)
        assert track.km_m(done.moved[name].offset_m(inside_m)) == pytest.approx(expected, abs=1e-3)


def test_tracks_stay_apart_at_fixed_nodes_other_names_and_where_three_meet() -> None:
    line = [piece("a", "x", "y", 10), piece("b", "y", "z", 20)]
    assert len(merged_pieces(line, frozenset()).tracks) == 1
    assert len(merged_pieces(line, frozenset({"y"})).tracks) == 2
    named = LayoutTrack("b", "2", "main", "y", "z", 20)
    assert len(merged_pieces([line[0], named], frozenset()).tracks) == 2
    assert len(merged_pieces([*line, piece("c", "y", "w", 30)], frozenset()).tracks) == 3


def test_a_ring_is_walked_once() -> None:
    ring = [piece("a", "x", "y", 10), piece("b", "y", "z", 20), piece("c", "z", "x", 30)]
    (track,) = merged_pieces(ring, frozenset()).tracks
    assert (track.length_m, track.low_node) == (60.0, track.high_node)
    loop = [piece("a", "x", "x", 10)]
    assert merged_pieces(loop, frozenset()).tracks == loop


def test_kilometrage_without_a_change_keeps_its_sense() -> None:
    assert km_rows(100.0, [(100.0, 5000.0)], ()) == ((0.0, 4900.0), (100.0, 5000.0))
    falling = km_rows(100.0, [(20.0, 5000.0), (80.0, 4940.0)], ())
    assert falling == ((0.0, 5020.0), (100.0, 4920.0))
    assert km_rows(100.0, (), ()) == ()


def test_a_jump_has_two_kilometrages_at_its_place() -> None:
    rows = km_rows(180.0, [(0.0, 2800.0)], [(150.0, 2950.0, 2970.0)])
    assert rows == ((0.0, 2800.0), (150.0, 2950.0), (150.0, 2970.0), (180.0, 3000.0))
    track = piece("a", "x", "y", 180.0, rows)
    assert (track.km_m(149.0), track.km_m(151.0)) == (2949.0, 2971.0)


def test_posts_that_are_not_metre_for_metre_are_kept() -> None:
    posts = [(0.0, 0.0), (100.0, 90.0), (200.0, 180.0), (300.0, 300.0)]
    track = piece("a", "x", "y", 300.0, km_rows(300.0, posts, ()))
    assert [track.km_m(offset_m) for offset_m, _ in posts] == [km_m for _, km_m in posts]
    assert len(km_rows(300.0, [(m, m) for m in (0.0, 100.0, 200.0, 300.0)], ())) == 2


def test_a_post_on_the_way_to_one_that_is_off_is_kept() -> None:
    """Two posts 100 m apart say 300: what lies before them on the straight line from end to end is still so."""
    posts = [(0.0, 0.0), (5000.0, 5000.0), (5100.0, 5300.0), (10000.0, 10000.0)]
    track = piece("a", "x", "y", 10000.0, km_rows(10000.0, posts, ()))
    assert [track.km_m(offset_m) for offset_m, _ in posts] == [km_m for _, km_m in posts]
    assert track.km_m(4900.0) == 4900.0


def test_kilometrage_is_carried_over_points_in_its_sense() -> None:
    """Onto the legs it goes on growing, and from one leg onto the other it grows away from the toe as well."""
    stem = piece("stem", "a", "toe", 100.0)
    normal = piece("normal", "toe", "b", 200.0, ((0.0, 1000.0), (200.0, 1200.0)))
    reverse = piece("reverse", "c", "toe", 210.0)
    points = [LayoutPoints("P", "P", "toe", "stem", "normal", "reverse")]
    tracks, given_to = carried_kilometrage([stem, normal, reverse], points)
    assert sorted(given_to) == ["reverse", "stem"]
    rows = {track.id: track.kilometrage for track in tracks}
    assert rows["stem"] == ((0.0, 900.0), (100.0, 1000.0))
    assert rows["reverse"] == ((0.0, 1210.0), (210.0, 1000.0))


def test_a_loop_is_stretched_between_its_ends() -> None:
    rows = ((0.0, 0.0), (100.0, 100.0))
    tracks = [
        piece("in", "a", "p", 100.0, rows),
        piece("one", "p", "q", 400.0, ((0.0, 100.0), (400.0, 500.0))),
        piece("two", "p", "q", 404.0),
        piece("out", "q", "b", 100.0, ((0.0, 500.0), (100.0, 600.0))),
    ]
    points = [LayoutPoints("P", "", "p", "in", "one", "two"), LayoutPoints("Q", "", "q", "out", "one", "two")]
    found = {track.id: track.kilometrage for track in carried_kilometrage(tracks, points)[0]}
    assert found["two"] == ((0.0, 100.0), (404.0, 500.0))


def test_one_lines_kilometrage_goes_to_no_other_line() -> None:
    known = LayoutTrack("a", "7", "main", "x", "y", 10.0, (), ((0.0, 0.0), (10.0, 10.0)))
    yard = LayoutTrack("b", "", "yard", "y", "z", 10.0)
    other = LayoutTrack("c", "8", "branch", "z", "w", 10.0)
    assert carried_kilometrage([known, yard, other], [], names_are_lines=True)[1] == ["b"]
    assert carried_kilometrage([known, yard, other], [])[1] == ["b", "c"]


def test_no_kilometrage_crosses_a_crossing() -> None:
    known = piece("a", "x", "k", 10.0, ((0.0, 0.0), (10.0, 10.0)))
    assert (
        carried_kilometrage(
            [known, piece("b", "k", "y", 10), piece("c", "k", "z", 10), piece("d", "k", "w", 5)], []
        )[1]
        == []
    )


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=30))
def test_ends_joined_are_one_node(pairs: list[tuple[int, int]]) -> None:
    joined = JoinedEnds()
    groups = {n: {n} for n in range(10)}
    for one, other in pairs:
        joined.join((f"t{one}", 0), (f"t{other}", 0))
        whole = groups[one] | groups[other]
        for member in whole:
            groups[member] = whole
    for a in range(10):
        for b in range(10):
            assert (joined.node_end((f"t{a}", 0)) == joined.node_end((f"t{b}", 0))) == (b in groups[a])
