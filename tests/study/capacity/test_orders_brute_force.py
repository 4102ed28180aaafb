"""The search over orders against all orders of two trains on small random lines, one by one, with no leg left out.

Places in a row, of one or two tracks, a section between each two of them. A train asks for a leg so long before it
starts; the track it leaves and the section are free so long after it has come to the next place.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from unittest import mock

from hypothesis import Phase, example, find, given, settings
from hypothesis import strategies as st

from network.model import Direction
from study.capacity import orders
from study.capacity.legs import SetLeg, legs_of
from study.capacity.occupation import Occupation, OccupationPart, Slice
from study.capacity.orders import DayOfLegs, Orders

STAND_S = 30.0
ASKS_S = 10.0
FREES_S = 15.0


@dataclass(frozen=True)
class Way:
    """The tracks to which a train comes, one after another; each is (place, track), places are neighbours."""

    tracks: tuple[tuple[int, int], ...]

    def track(self, at: int) -> str:
        """The one to which it comes by so many legs."""
        return "{}.{}".format(*self.tracks[at])

    def section(self, leg: int) -> str:
        return f"S{min(self.tracks[leg][0], self.tracks[leg + 1][0])}"

    @property
    def legs(self) -> int:
        return len(self.tracks) - 1


@dataclass(frozen=True)
class SmallLine:
    """How long each section takes, s, and the ways of the first and the second train."""

    runs_s: tuple[float, ...]
    first: Way
    second: Way

    def takes_s(self, way: Way, leg: int) -> float:
        return self.runs_s[int(way.section(leg)[1:])]


@st.composite
def small_lines(draw: st.DrawFn) -> SmallLine:
    places = draw(st.integers(2, 4))
    tracks = [draw(st.integers(1, 2)) for _ in range(places)]
    runs_s = tuple(float(draw(st.integers(50, 300))) for _ in range(places - 1))
    return SmallLine(runs_s, draw(ways(tracks)), draw(ways(tracks)))


@st.composite
def ways(draw: st.DrawFn, tracks: Sequence[int]) -> Way:
    at = draw(st.integers(0, len(tracks) - 1))
    found = [(at, draw(st.integers(1, tracks[at])))]
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.sampled_from([to for to in (at - 1, at + 1) if 0 <= to < len(tracks)]))
        found.append((at, draw(st.integers(1, tracks[at]))))
    return Way(tuple(found))


# the search -------------------------------------------------------------------------------------------------


def legs_made(line: SmallLine, way: Way, stock_id: str) -> tuple[SetLeg, ...]:
    """The legs of a train that sets out at 0 and stands no longer than it must."""
    leaves_s = [0.0]
    for leg in range(way.legs):
        leaves_s.append(leaves_s[-1] + line.takes_s(way, leg) + STAND_S)
    comes_s = [-math.inf, *(s - STAND_S for s in leaves_s[1:])]
    leaves_s[-1] = math.inf
    found: list[Occupation] = []

    def occupied(
        section_id: str, enters_s: float, gone_s: float, *slices: tuple[OccupationPart, float]
    ) -> None:
        cut = [Slice(part, a, b) for (part, a), (_, b) in pairwise(slices)]
        found.append(Occupation(section_id, stock_id, stock_id, Direction.DOWN, tuple(cut), enters_s, gone_s))

    for at in range(way.legs + 1):
        asked_s = leaves_s[at - 1] - ASKS_S if at else -1e6
        stood_s = comes_s[at] if at else -1e6
        over_s = comes_s[at + 1] + FREES_S if at < way.legs else math.inf
        left_s = leaves_s[at]
        parts = [(OccupationPart.APPROACH, asked_s), (OccupationPart.DWELL, stood_s)]
        after = [(OccupationPart.RELEASE, left_s), (OccupationPart.RELEASE, over_s)]
        place_id = way.track(at)
        if at == way.legs:
            after = [(OccupationPart.DWELL, math.inf)]
        occupied(place_id, comes_s[at], left_s, *(parts if at else parts[1:]), *after)
        if at < way.legs:
            moves = [(OccupationPart.APPROACH, left_s - ASKS_S), (OccupationPart.RUN, left_s)]
            frees = [(OccupationPart.RELEASE, comes_s[at + 1]), (OccupationPart.RELEASE, over_s)]
            occupied(way.section(at), left_s, comes_s[at + 1], *moves, *frees)
    return legs_of(found, lambda section_id: not section_id.startswith("S"))


def searched_s(line: SmallLine) -> float:
    """From when the first sets out until the second sets out on its last leg, by the search; infinite: never."""
    ahead, behind = legs_made(line, line.first, "one"), legs_made(line, line.second, "other")[::-1]
    found = Orders(ahead, 0, behind, DayOfLegs()).least()
    return math.inf if found is None else behind[0].departs_s + found.later_s[-1]


# all orders -------------------------------------------------------------------------------------------------


def tried_s(line: SmallLine) -> float:
    """The same by trying everything: every place at which the second may begin, every order of all legs from there."""
    best_s = math.inf
    for begins in range(line.second.legs):
        if line.second.track(begins) == line.first.track(0):
            continue
        own = line.second.legs - begins
        for gone in range(1, line.first.legs + 1):
            for places in combinations(range(gone + own), gone):
                order = [at not in places for at in range(gone + own)]
                if order[-1]:
                    best_s = min(best_s, played_s(line, begins, order))
    return best_s


def played_s(line: SmallLine, begins: int, order: Sequence[bool]) -> float:
    """When the second sets out on its last leg where the trains go in this order (True: the second); infinite: it
    does not work.
    """
    at = {False: 0, True: begins}
    way = {False: line.first, True: line.second}
    ready_s = {False: 0.0, True: -math.inf}
    gone: list[tuple[bool, frozenset[str], float]] = []  # whose, what it holds, until when
    sets_out_s = -math.inf
    for second in order:
        own, leg, other = way[second], at[second], not second
        if own.track(leg + 1) == way[other].track(at[other]):
            return math.inf
        needs = {own.section(leg), own.track(leg + 1)}
        free_s = max((s for who, held, s in gone if who is other and held & needs), default=-math.inf)
        sets_out_s = max(ready_s[second], free_s + ASKS_S)
        if not second and leg == 0:
            sets_out_s = 0.0
        comes_s = sets_out_s + line.takes_s(own, leg)
        gone.append((second, frozenset({own.section(leg), own.track(leg)}), comes_s + FREES_S))
        ready_s[second], at[second] = comes_s + STAND_S, leg + 1
    return sets_out_s


# A passing place in the middle, at which the first has to wait for the second.
MEETS = SmallLine(
    (100.0, 200.0), Way(((1, 1), (2, 1), (1, 1), (0, 1))), Way(((0, 1), (1, 2), (0, 1), (1, 2)))
)


@given(small_lines())
@example(MEETS)
def test_the_search_finds_what_trying_everything_finds(line: SmallLine) -> None:
    assert math.isclose(searched_s(line), tried_s(line), abs_tol=1e-6)


def test_small_lines_are_of_every_sort() -> None:
    """On some the second never comes, on some it has to come from elsewhere, on some the first waits for it."""
    any_will_do = settings(phases=[Phase.generate], max_examples=2000)  # the smallest is of no use
    find(small_lines(), lambda line: math.isinf(tried_s(line)), settings=any_will_do)
    for name, off in (("FIRST_WAITS", False), ("BACK_MAX", 0)):
        with mock.patch.object(orders, name, off):
            find(
                small_lines(),
                lambda line: not math.isclose(searched_s(line), tried_s(line), abs_tol=1e-6),
                settings=any_will_do,
            )
