"""Exploring a line whole: the search, the ranks, what is wrong as a story, and the certificate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

from verify.certificate import FORMAT, Certificate, sources_digest
from verify.composition import Following
from verify.expansion import Expansion
from verify.explored_line import ExploredLine
from verify.parties import ExploredParties
from verify.search import Level, SearchedSpace, judged_space
from verify.story import StoryTeller
from verify.tables import Numbers

STATES_MAX: Final = 200_000_000


class ExploredSpace(NamedTuple):
    """What was found. `broken`: the rule that a state breaks, with the shortest story to it; `dead`: from how many
    states not all trains can finish, though faults end and people are truthful, with the shortest story to one.
    """

    line: ExploredLine
    parties: ExploredParties
    expansion: Expansion
    space: SearchedSpace
    ranks: Numbers | None
    broken: str = ""
    dead: int = 0
    story: tuple[str, ...] = ()
    chart: str = ""  # the story as a sequence chart, in Mermaid
    told: tuple[Following, ...] = ()  # the story event by event

    @property
    def holds(self) -> bool:
        """Whether all states were found, none breaks a rule and none is dead."""
        return self.space.complete and not self.broken and not self.dead


def explored(
    line: ExploredLine,
    states_max: int = STATES_MAX,
    watch: Callable[[Level], None] = lambda _: None,
    *,
    collisions_alone: bool = False,
) -> ExploredSpace:
    """Explore a line as far as its budgets go, or `states_max`. The first state that breaks a rule ends it; or only one
    in which two trains stand in one section.
    """
    parties = ExploredParties(line)
    expansion = Expansion(parties)
    breaks = expansion.collided if collisions_alone else expansion.broken
    space, rank, dead, wrong = judged_space(expansion, states_max, watch, breaks)
    if wrong is None:
        return ExploredSpace(line, parties, expansion, space, rank)
    teller = StoryTeller(parties, expansion)
    rule = "" if dead else teller.composition.broken(teller.line_state(wrong))
    told = teller.events(space.levels, wrong)
    return ExploredSpace(
        line, parties, expansion, space, rank, rule, dead, teller.story(told), teller.chart(told), told
    )


def certificate_of(found: ExploredSpace) -> Certificate:
    """The certificate of a line that holds. Raises ValueError for one that does not."""
    if not found.holds or found.ranks is None:
        raise ValueError("no certificate of a line that is not explored whole, safe and alive")
    parties, expansion = found.parties, found.expansion
    lefts = expansion.lefts.things
    grounds = tuple((key[:-1], lefts[key[-1]]) for key in expansion.ground_keys.things)
    return Certificate(
        FORMAT,
        found.line.trains,
        tuple(found.line.budgets),
        sources_digest(),
        parties.digest(),
        expansion.bits,
        tuple(parties.made),
        grounds,
        tuple(cells.named() for cells in expansion.cells),
        found.space.states.astype(">u8").tobytes(),
        found.ranks.astype(">u2").tobytes(),
    )
