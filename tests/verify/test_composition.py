"""Two ways of composing the parties, one for many states at once and one state at a time, lead to the same; and states
that count as one take the same way.
"""

from collections import Counter, deque

import numpy as np
import pytest

from tests.nightly import others_nightly
from verify.composition import Composition, StateOfLine, TrainCell
from verify.expansion import Expansion
from verify.explored_line import Budgets, ExploredLine
from verify.parties import ExploredParties
from verify.promela import walked
from verify.search import search
from verify.story import StoryTeller

ALL_TROUBLES = Budgets(1, 1, 1, 1, 1, 1, 1)
FEW, MANY = 500, 40_000


@pytest.mark.parametrize("states_max", others_nightly((FEW, MANY), [FEW]))
@pytest.mark.parametrize(("trains", "budgets"), [(2, Budgets()), (2, ALL_TROUBLES), (3, ALL_TROUBLES)])
def test_both_ways_give_the_same_successors(trains: int, budgets: Budgets, states_max: int) -> None:
    parties = ExploredParties(ExploredLine(trains=trains, budgets=budgets))
    expansion = Expansion(parties)
    states = search(expansion, states_max, lambda _: None, expansion.broken).states[:states_max]
    teller = StoryTeller(parties, expansion)
    source, after, trouble = expansion.following(states)
    found: dict[int, Counter[tuple[StateOfLine, int]]] = {index: Counter() for index in range(len(states))}
    for index, key, cost in zip(source.tolist(), after.tolist(), trouble.tolist(), strict=True):
        found[index][teller.line_state(key), cost] += 1
    broken, finished = expansion.broken(states), expansion.finished(states)
    for index, key in enumerate(states.tolist()):
        state = teller.line_state(key)
        one_by_one = Counter((f.state, int(f.trouble)) for f in teller.composition.following(state))
        assert found[index] == one_by_one
        assert bool(teller.composition.broken(state)) == broken[index]
        assert teller.composition.finished(state) == finished[index]


def test_the_search_finds_what_a_plain_one_finds() -> None:
    line = ExploredLine(budgets=Budgets())
    _, seen = walked(line)
    expansion = Expansion(ExploredParties(line))
    assert len(search(expansion, 10**6, lambda _: None, expansion.broken).states) == len(seen)


class AsTheyAre(Composition):
    """Every state by itself, with the numbers and the words that it has."""

    def __init__(self, line: ExploredLine) -> None:
        super().__init__(ExploredParties(line))
        for model in self.parties.train_models:
            model.told_apart = lambda state: state  # type: ignore[method-assign]

    def _settled(self, state: StateOfLine) -> StateOfLine:
        return state


def as_one(raw: AsTheyAre, state: StateOfLine, settled: Composition) -> StateOfLine:
    """The state that it counts as."""
    theirs, ours = raw.parties, settled.parties
    cells = tuple(
        TrainCell(
            ours.trains[unit].number(
                ours.train_models[unit].told_apart(theirs.trains[unit].things[cell.train])
            ),
            tuple(
                tuple(ours.telegrams.number(theirs.telegrams.things[t]) for t in queue) for queue in cell.air
            ),
            cell.granted,
        )
        for unit, cell in enumerate(state.cells)
    )
    terminals = tuple(
        mine.number(their.things[t])
        for mine, their, t in zip(ours.terminals, theirs.terminals, state.terminals, strict=True)
    )
    manager = ours.managers.number(theirs.managers.things[state.manager])
    return settled._settled(StateOfLine(manager, terminals, state.left, cells))


@pytest.mark.parametrize("states_max", others_nightly((FEW, MANY), [FEW]))
@pytest.mark.parametrize("trains", [1, 2])
@pytest.mark.parametrize("budgets", [Budgets(1, 1, 0, 0), ALL_TROUBLES])
def test_states_that_count_as_one_take_the_same_way(budgets: Budgets, trains: int, states_max: int) -> None:
    """A bisimulation, on the first states that a search without any reduction comes to."""
    line = ExploredLine(trains, budgets=budgets)
    raw, settled = AsTheyAre(line), Composition(ExploredParties(line))
    queue = deque([raw.start()])
    seen, counted = set(queue), dict[StateOfLine, set[tuple[str, str, StateOfLine]]]()
    while queue and len(seen) < states_max:
        state = queue.popleft()
        following = list(raw.following(state))
        one = as_one(raw, state, settled)
        if one not in counted:
            counted[one] = {(f.who, f.what, f.state) for f in settled.following(one)}
        assert {(f.who, f.what, as_one(raw, f.state, settled)) for f in following} == counted[one]
        assert raw.broken(state) == settled.broken(one)
        assert raw.finished(state) == settled.finished(one)
        for found in following:
            if found.state not in seen:
                seen.add(found.state)
                queue.append(found.state)
    assert len(counted) < len(seen), "some count as one"


def test_a_state_of_numbers_is_small() -> None:
    expansion = Expansion(ExploredParties(ExploredLine()))
    assert expansion.start().dtype == np.uint64
