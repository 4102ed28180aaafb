"""A train has left, its unit is not told so and says that it is in its portal still; then the unit loses its power.
Found by `branchline verify explore`, `0/1/1/0` and `0/0/2/0`: the portal was held for ever.
"""

from collections import deque

import pytest

from verify.composition import HEARS, Composition, Following
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
LEFT_UNCOUNTED = (
    *("manager power fails", "u1 passes the boundary", "manager power is back", "manager asks the units"),
    *("u1 ClaimQuery", "u1 power fails"),
)
CASES = (  # counted out or not, and what it is then held for ever without
    (LEFT_UNTOLD, Budgets(delay=1, power=1), ("silent-off-the-line",)),
    (LEFT_UNTOLD, Budgets(delay=1, power=1), ("counted-out-forgotten", "booted-leaver-unheard")),
    (LEFT_UNCOUNTED, Budgets(power=2), ("booted-leaver-unheard",)),
)


def what(composition: Composition, found: Following) -> str:
    """Who, and what it hears or does."""
    if found.what != HEARS:
        return f"{found.who} {found.what}"
    return f"{found.who} {type(composition.parties.telegrams.things[found.telegram].message).__name__}"


def portal_is_free_some_time(then: tuple[str, ...], budgets: Budgets) -> bool:
    """Whether events without trouble lead from there to where the next train could be let in."""
    composition = Composition(ExploredParties(ExploredLine(trains=1, budgets=budgets)))
    begin = composition.start()
    for event in (*AT_ITS_PORTAL, *then):
        begin = next(f.state for f in composition.following(begin) if what(composition, f) == event)
    queue, seen = deque([begin]), {begin}
    while queue:
        state = queue.popleft()
        if composition.finished(state):
            return True
        for found in composition.following(state):
            if found.trouble is UnwishedFor.NONE and found.state not in seen:
                seen.add(found.state)
                queue.append(found.state)
    return False


@pytest.mark.parametrize(("then", "budgets", "needed"), CASES)
def test_a_unit_that_boots_after_its_train_has_left_frees_its_portal(
    then: tuple[str, ...], budgets: Budgets, needed: tuple[str, ...]
) -> None:
    assert portal_is_free_some_time(then, budgets)
    with restored(*needed):
        assert not portal_is_free_some_time(then, budgets)
