"""What exploring a crossing whole finds: one train, and every state of device, unit, air, equipment and driver."""

import re
from collections import Counter, deque
from pathlib import Path

import pytest

from tests.nightly import others_nightly
from tests.system.conftest import SWITCHES
from verify.crossing.composition import CrossingComposition
from verify.crossing.expansion import CrossingExpansion
from verify.crossing.explore import explore_crossing, same
from verify.crossing.explored_crossing import CrossingBudgets, ExploredCrossing
from verify.crossing.gate import BROKEN, RoadRule
from verify.search import search

PAGE = Path(__file__).parents[2] / "docs" / "signal-engineer.md"
NOTHING_FAILS = (True, CrossingBudgets())
AT_NIGHT = (
    *((barriers, CrossingBudgets(loss=1)) for barriers in (True, False)),
    *((barriers, CrossingBudgets(power=1)) for barriers in (True, False)),
    *((barriers, CrossingBudgets(carriers=1)) for barriers in (True, False)),
    *((barriers, CrossingBudgets(store=1)) for barriers in (True, False)),
    *((barriers, CrossingBudgets(equipment=1)) for barriers in (True, False)),
    *((barriers, CrossingBudgets(position=1)) for barriers in (True, False)),
    (False, CrossingBudgets(loss=1, equipment=1)),
)


@pytest.mark.parametrize(
    ("barriers", "budgets"), others_nightly((NOTHING_FAILS, *AT_NIGHT), [NOTHING_FAILS], columns=True)
)
def test_no_train_comes_onto_an_open_road_and_each_passes(barriers: bool, budgets: CrossingBudgets) -> None:
    found = explore_crossing(ExploredCrossing(barriers, budgets))
    assert found.holds, (found.broken, found.dead, found.story)
    assert told(barriers, budgets) == f"{found.space.states.size:,}"


def told(barriers: bool, budgets: CrossingBudgets) -> str:
    """How many states the page says that there are."""
    text = "/".join(str(number) for number in budgets)
    while text.count("/") > 2 and text.endswith("/0"):
        text = text.removesuffix("/0")
    page = PAGE.read_text("utf-8").partition("## Every state of a level crossing")[2]
    before = "^" if barriers else r"\| "
    rows = re.findall(rf"{before}\| `{text}` \| ([\d,]+) \|", page, re.MULTILINE)
    return "".join(rows)


@pytest.mark.nightly
def test_with_a_loss_a_power_cut_and_both_networks_lost() -> None:
    budgets = CrossingBudgets(loss=1, power=1, carriers=1)
    found = explore_crossing(ExploredCrossing(budgets=budgets))
    assert found.holds, (found.broken, found.dead, found.story)
    assert told(True, budgets) == f"{found.space.states.size:,}"


OPEN, TOO_SOON, OPENS = (BROKEN[rule] for rule in (RoadRule.OPEN, RoadRule.TOO_SOON, RoadRule.OPENS))
NOTICED = {  # what breaks which rule, and within which budgets it does
    "passes_unproven_crossings": (True, CrossingBudgets(), OPEN),
    "proves_lamps_alone": (True, CrossingBudgets(), TOO_SOON),  # or open: neither story is longer
    "proves_what_it_commands": (True, CrossingBudgets(), TOO_SOON),
    "keeps_no_least_time": (True, CrossingBudgets(), TOO_SOON),
    "gives_up_where_its_front_may_stand": (True, CrossingBudgets(power=1), OPENS),
    "passes_by_having_been_on_it": (True, CrossingBudgets(position=1), OPEN),
    "proves_lamps_that_shine_again_at_once": (False, CrossingBudgets(loss=1, equipment=1), TOO_SOON),
}


@pytest.mark.parametrize(
    "name",
    others_nightly(NOTICED, ["passes_unproven_crossings", "proves_lamps_alone", "keeps_no_least_time"]),
)
def test_a_rule_that_is_switched_off_is_noticed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    barriers, budgets, rule = NOTICED[name]
    SWITCHES[name](monkeypatch)
    found = explore_crossing(ExploredCrossing(barriers, budgets))
    assert found.broken == rule
    assert found.story


@pytest.mark.parametrize("barriers", [True, False])
def test_both_ways_of_composing_give_the_same_successors(barriers: bool) -> None:
    explored = ExploredCrossing(barriers, CrossingBudgets(1, 1, 1, 1, 1, 1))
    expansion, composition = CrossingExpansion(explored), CrossingComposition(explored)
    states = search(expansion, 2_000, lambda _: None, expansion.broken).states[:2_000]
    source, after, trouble = expansion.following(states)
    found: dict[int, Counter[tuple[object, int]]] = {index: Counter() for index in range(len(states))}
    for index, key, cost in zip(source.tolist(), after.tolist(), trouble.tolist(), strict=True):
        found[index][same(expansion.whole(key)), cost] += 1
    finished = expansion.finished(states)
    for index, key in enumerate(states.tolist()):
        whole = expansion.whole(key)
        one_by_one = Counter((same(f.state), int(f.trouble)) for f in composition.following(whole))
        assert found[index] == one_by_one
        assert composition.finished(whole) == finished[index]


@pytest.mark.nightly
def test_the_search_finds_what_a_plain_one_finds() -> None:
    """One state after the other, each step composed by itself."""
    explored = ExploredCrossing(barriers=False)
    composition = CrossingComposition(explored)
    queue = deque([composition.start()])
    seen = {same(queue[0])}
    while queue:
        for found in composition.following(queue.popleft()):
            if same(found.state) not in seen:
                seen.add(same(found.state))
                queue.append(found.state)
    expansion = CrossingExpansion(explored)
    states = search(expansion, 10**6, lambda _: None, expansion.broken).states
    assert {same(expansion.whole(key)) for key in states.tolist()} == seen
