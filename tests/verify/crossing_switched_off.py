"""What becomes of the explored crossing where a behaviour is taken away: a table for documents.

python -m tests.verify.crossing_switched_off [NAMES ...]: each switch of level crossings, at some budgets in turn until
the states are others than those of the crossing as it is.
"""

import sys
from collections.abc import Iterator
from hashlib import blake2b
from typing import Final

import pytest

from tests.system import switches_crossings
from tests.system.conftest import SWITCHES
from tests.verify.switched_off import Verdict, first_other, verdict_of
from verify.crossing.explore import CrossingSpace, explore_crossing
from verify.crossing.explored_crossing import CrossingBudgets, ExploredCrossing

TRIED: Final = (
    ExploredCrossing(),
    ExploredCrossing(budgets=CrossingBudgets(loss=1)),
    ExploredCrossing(budgets=CrossingBudgets(carriers=1)),
    ExploredCrossing(budgets=CrossingBudgets(equipment=1)),
    ExploredCrossing(budgets=CrossingBudgets(power=1)),
    ExploredCrossing(budgets=CrossingBudgets(position=1)),
    ExploredCrossing(barriers=False, budgets=CrossingBudgets(loss=1, equipment=1)),
)


def names() -> list[str]:
    """The switches of level crossings."""
    return [name for name, switch in SWITCHES.items() if switch.__module__ == switches_crossings.__name__]


def digest(found: CrossingSpace) -> str:
    """Of the set, by local states and their numbers."""
    code = blake2b(found.space.states.tobytes(), digest_size=16)
    for things in (found.expansion.rider_states.things, found.expansion.telegrams.things):
        code.update(repr(things).encode())
    return code.hexdigest()


def judged(name: str, sound: dict[ExploredCrossing, str]) -> Iterator[tuple[str, Verdict]]:
    """The crossing with a switch, at each of the budgets; `sound` has digests without one, and gets those it lacks."""
    for explored in TRIED:
        if explored not in sound:
            sound[explored] = digest(explore_crossing(explored))
        with pytest.MonkeyPatch.context() as patch:
            SWITCHES[name](patch)
            verdict = verdict_of(
                lambda explored=explored: explore_crossing(explored), digest, sound[explored]
            )
        kind = "barriers" if explored.barriers else "warning"
        yield f"{kind} `{'/'.join(map(str, explored.budgets))}`", verdict


def main(named: list[str]) -> None:
    """Print the table."""
    sound: dict[ExploredCrossing, str] = {}
    for name in named or names():
        sys.stdout.write(f"| `{name}` | {first_other(judged(name, sound))} |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
