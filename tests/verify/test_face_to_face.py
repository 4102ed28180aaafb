"""With two power cuts, or one and a person's wrong word, the order of trains can go wrong, which is the dispatcher's:
nothing else is left to be stuck.
"""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from verify.composition import Composition, StateOfLine
from verify.expansion import Expansion
from verify.explored_line import BIT, Budgets, ExploredLine, UnwishedFor
from verify.parties import ExploredParties
from verify.search import Keys, judged_space, parts
from verify.story import StoryTeller
from verify.thirds import PLACES_A_SPAN
from verify.train import TrainPlace


def ends(expansion: Expansion, dead: Keys) -> Keys:
    """Those of the dead states (in order) to which all of them lead without trouble, and out of which no way leads."""
    pairs: list[Keys] = []
    for part in parts(dead):
        source, after, trouble = expansion.following(part)
        free = trouble == UnwishedFor.NONE
        pairs.append(np.stack((part[source[free]], after[free])))
    before, after = np.searchsorted(dead, np.concatenate(pairs, axis=1))
    assert (dead[after] == np.concatenate(pairs, axis=1)[1]).all()
    steps = coo_matrix((np.ones(len(before)), (before, after)), shape=(len(dead), len(dead)))
    _, circle = connected_components(steps, directed=True, connection="strong")
    left = np.unique(circle[before][circle[before] != circle[after]])
    return dead[~np.isin(circle, left)]


def stand_face_to_face(composition: Composition, state: StateOfLine) -> bool:
    """Whether the manager may grant, units know what they hold, and each train has the other in its next section."""
    parties, (one, other) = composition.parties, (composition.view(state, unit) for unit in range(2))
    manager = parties.managers.things[state.manager]
    if not manager.power or not manager.kept.register.defined or one.held is None or other.held is None:
        return False
    for unit, in_the_way in enumerate((other, one)):
        train = parties.trains[unit].things[state.cells[unit].train]
        spans = parties.train_models[unit].plan(train).spans
        ahead = spans[min(train.spot // PLACES_A_SPAN + 1, len(spans) - 1)].section_id
        if train.place is not TrainPlace.ON_LINE or not train.power or not in_the_way.occupied & BIT[ahead]:
            return False
    return True


@pytest.mark.nightly
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("budgets", [Budgets(power=2), Budgets(power=1, word=1)], ids=str)  # 0.8 and 10 GB
def test_whoever_is_stuck_after_two_power_cuts_or_a_wrong_word_stands_face_to_face(budgets: Budgets) -> None:
    parties = ExploredParties(ExploredLine(budgets=budgets))
    expansion = Expansion(parties)
    space, rank, dead, _ = judged_space(expansion, 100_000_000, lambda _: None, expansion.broken)
    assert space.complete
    assert not len(space.broken)
    assert rank is not None
    assert dead > 0
    teller = StoryTeller(parties, expansion)
    stuck = ends(expansion, space.states[rank < 0])
    assert all(stand_face_to_face(teller.composition, teller.line_state(int(key))) for key in stuck)
