"""Where any of two networks reaches, and the line with the first alone."""

from dataclasses import replace
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Coverage
from network.networks import has_second, reached, with_first_alone

PLACES = st.integers(0, 60)
STRETCHES = st.lists(
    st.tuples(PLACES, st.integers(1, 20)).map(lambda at: Coverage(at[0], at[0] + at[1])), max_size=6
)


@given(STRETCHES)
def test_any_network_reaches_where_one_does_and_stretches_do_not_overlap(stretches: list[Coverage]) -> None:
    found = reached(stretches)
    for at_m in [half / 2 for half in range(170)]:
        said, so = (any(one.from_m <= at_m <= one.to_m for one in every) for every in (found, stretches))
        assert said is so
    assert all(before.to_m <= after.from_m for before, after in pairwise(found))


def test_trains_with_one_radio_have_the_first_network_alone() -> None:
    karasuyama_line = load_line(shipped_line("karasuyama"))
    name, axis = next(iter(karasuyama_line.alignments.items()))
    first, second = axis.coverage[:1], (Coverage(axis.from_m, axis.to_m),)
    both = replace(axis, coverage=reached(first + second), of_networks=(first, second))
    line = replace(karasuyama_line, alignments={name: both})
    assert has_second(line)
    assert with_first_alone(line).alignments[name].coverage == first
    assert not has_second(with_first_alone(line))
    assert with_first_alone(karasuyama_line) is karasuyama_line
