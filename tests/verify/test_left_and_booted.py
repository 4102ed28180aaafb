"""A train has left, its unit is not told so and says that it is in its portal still; then the unit loses its power.
Found by `branchline verify explore 0/1/1/0`: the portal was held for ever.
"""

from collections import deque

import pytest

from verify.composition import HEARS, Composition, Following, StateOfLine
from verify.explored_line import Budgets, ExploredLine, UnwishedFor
from verify.parties import ExploredParties
from verify.restored import restored

AT_ITS_PORTAL = (
    *(
        "u1 Begin",
        "block-manager SignOn",
        "u1 SignOnAccepted",
        "block-manager RouteRequest",
        "u1 RouteGranted",
    ),
    *("t2 PointsCommand", "t1 PointsCommand", "u1 PointsProof", "u1 PointsProof", "u1 enters"),
    *("u1 WheelsTurning", *("u1 Looked",) * 6, "u1 TagBelieved", "block-manager HoldingReport"),
    *("u1 HoldingConfirmed", "u1 Stopped", "u1 ChangeEnds", "block-manager RouteRequest", "u1 RouteGranted"),
    *("t2 PointsCommand", "t1 PointsCommand", "u1 PointsProof", "u1 PointsProof"),
    *("u1 WheelsTurning", *("u1 Looked",) * 6, "u1 TagBelieved", "block-manager HoldingReport"),
    *("u1 HoldingConfirmed", "u1 Stopped", "u1 Leave", "block-manager SignOff", "u1 SignOffAccepted"),
)
LEFT_UNTOLD = (
    *("manager asks the units", "u1 ClaimQuery", "u1 passes the boundary", "block-manager LeavingClaim"),
    *("u1 ClaimQuery", "block-manager LeavingClaim", "u1 power fails"),
)


def what(composition: Composition, found: Following) -> str:
    """Who, and what it hears or does."""
    if found.what != HEARS:
        return f"{found.who} {found.what}"
    return f"{found.who} {type(composition.parties.telegrams.things[found.telegram].message).__name__}"


def is_free_some_time(composition: Composition, begin: StateOfLine) -> bool:
    """Whether events without trouble lead to where no unit holds anything by the register."""
    queue, seen = deque([begin]), {begin}
    while queue:
        state = queue.popleft()
        if not any(composition.parties.held_by_register(state.manager)):
            return True
        for found in composition.following(state):
            of_them = found.trouble is UnwishedFor.NONE and found.who in ("u1", "manager", "block-manager")
            if of_them and found.state not in seen:
                seen.add(found.state)
                queue.append(found.state)
    return False


def portal_is_free_some_time() -> bool:
    composition = Composition(ExploredParties(ExploredLine(budgets=Budgets(delay=1, power=1))))
    state = composition.start()
    for event in (*AT_ITS_PORTAL, *LEFT_UNTOLD):
        state = next(f.state for f in composition.following(state) if what(composition, f) == event)
    assert any(composition.parties.held_by_register(state.manager))
    return is_free_some_time(composition, state)


def test_a_unit_that_boots_after_its_train_has_left_frees_its_portal() -> None:
    assert portal_is_free_some_time()


@pytest.mark.parametrize("name", ["counted-out-forgotten", "silent-off-the-line"])
def test_without_either_the_portal_is_held_for_ever(name: str) -> None:
    with restored(name):
        assert not portal_is_free_some_time()
