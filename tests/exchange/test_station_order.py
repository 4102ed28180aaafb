"""One order of stations from many trains."""

from hypothesis import given
from hypothesis import strategies as st

from exchange.station_order import ordered_stations, runs_down


@given(st.data())
def test_parts_of_one_line_give_its_order(data: st.DataObject) -> None:
    line = tuple("ABCDEFGH")
    runs: list[tuple[tuple[str, ...], bool]] = [(line, True)]
    for _ in range(data.draw(st.integers(0, 8))):
        chosen = data.draw(st.sets(st.sampled_from(line), min_size=2))
        part = tuple(sorted(chosen))
        down = data.draw(st.booleans())
        runs.append((part if down else part[::-1], down))
    order = ordered_stations(data.draw(st.permutations(runs)))
    assert order == line
    places = {station: i for i, station in enumerate(order)}
    assert all(runs_down(run, places, says_down=False) == down for run, down in runs)


def test_a_branch_comes_last_and_stations_between_find_their_place() -> None:
    runs = [("ABDEF", True), ("FDCBA", False), ("ABXY", True)]
    assert "".join(ordered_stations(runs)) == "ABCDEFXY"


def test_what_a_source_calls_down_counts_where_nothing_else_does() -> None:
    assert ordered_stations([("AB", False)]) == ("B", "A")
    assert ordered_stations([]) == ()
