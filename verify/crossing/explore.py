"""Exploring a crossing whole: the search, the ranks, and what is wrong as a story."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby, pairwise
from typing import NamedTuple

from verify.crossing.composition import CrossingComposition, CrossingWhole, Happened
from verify.crossing.expansion import CrossingExpansion
from verify.crossing.explored_crossing import ExploredCrossing
from verify.crossing.facts import gate_key
from verify.search import Keys, Level, SearchedSpace, judged_space, way_to
from verify.story import telegram_words

STATES_MAX = 100_000_000


class CrossingSpace(NamedTuple):
    """What was found. `broken`: the rule that a state breaks, with the shortest story to it; `dead`: from how many
    states the train cannot pass any more, or the road not open again, with the shortest story to one.
    """

    expansion: CrossingExpansion
    space: SearchedSpace
    broken: str = ""
    dead: int = 0
    story: tuple[str, ...] = ()
    rank_max: int = 0  # steps without trouble that are enough from every state

    @property
    def holds(self) -> bool:
        """Whether all states were found, none breaks a rule and none is dead."""
        return self.space.complete and not self.broken and not self.dead


def explore_crossing(
    explored: ExploredCrossing,
    states_max: int = STATES_MAX,
    watch: Callable[[Level], None] = lambda _: None,
) -> CrossingSpace:
    """Explore it as far as its budgets go, or `states_max`. The first state that breaks a rule ends it."""
    expansion = CrossingExpansion(explored)
    space, rank, dead, wrong = judged_space(expansion, states_max, watch, expansion.broken)
    rank_max = 0 if rank is None else int(rank.max())
    if wrong is None:
        return CrossingSpace(expansion, space, rank_max=rank_max)
    rule = "" if dead else CrossingComposition(explored).broken(expansion.whole(wrong))
    return CrossingSpace(expansion, space, rule, dead, story_to(expansion, space.levels, wrong), rank_max)


def same(state: CrossingWhole) -> tuple[object, ...]:
    """A state, to be told from others."""
    return (*state._replace(gate=None), gate_key(state.gate))  # type: ignore[arg-type]


def story_to(expansion: CrossingExpansion, levels: tuple[Keys, ...], key: int) -> tuple[str, ...]:
    """What happens on a shortest way to a state, a line for each event, or for the same ones after each other."""
    composition = CrossingComposition(expansion.explored)
    way = [expansion.whole(k) for k in way_to(expansion, levels, key)]
    told = [
        _words(next(f for f in composition.following(before) if same(f.state) == same(after)))
        for before, after in pairwise(way)
    ]
    runs = ((line, len(list(each))) for line, each in groupby(told))
    return tuple(f"{line} ({count} times)" if count > 1 else line for line, count in runs)


def _words(found: Happened) -> str:
    said = "" if found.telegram is None else f" {telegram_words(found.telegram.message)}"
    return f"{found.who} {found.what}{said}"
