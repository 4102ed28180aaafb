"""What becomes of the explored set where a behaviour of the machines is taken away: a table for documents and a test.

Each defect is a switch of `tests.system.switchboard`, thrown while the line is explored at small budgets, the smallest
first, until the set is another one.
"""

from __future__ import annotations

import sys
from enum import Enum
from hashlib import blake2b
from itertools import chain

import pytest

from tests.system import switches_on_board, switches_radio, switches_wayside
from tests.system.switchboard import SWITCHES
from verify.explore import ExploredSpace, explored
from verify.explored_line import Budgets, ExploredLine
from verify.restored import RESTORED, restored

BUDGETS = (Budgets(), Budgets(loss=1))
MODULES = (switches_on_board, switches_radio, switches_wayside)


class Verdict(Enum):
    """What the exploration says of a defect."""

    BROKEN = "a rule is broken"
    DEAD = "not all trains can finish"
    OTHER = "other states, all safe and live"
    FAILS = "the machine itself fails"
    SAME = "the same states"


def defects() -> list[str]:
    """All that can be switched off in machines, and what they once did, by name."""
    names = {module.__name__ for module in MODULES}
    return [*(name for name, switch in SWITCHES.items() if switch.__module__ in names), *RESTORED]


def digest(found: ExploredSpace) -> str:
    """Of the set, by local states and their numbers."""
    return blake2b(found.space.states.tobytes() + found.parties.digest().encode(), digest_size=16).hexdigest()


def judged(name: str, budgets: Budgets, sound: str) -> Verdict:
    """The line explored with one defect."""
    line = ExploredLine(budgets=budgets)
    try:
        if name in RESTORED:
            with restored(name):
                found = explored(line, 2_000_000)
        else:
            with pytest.MonkeyPatch.context() as patch:
                SWITCHES[name](patch)
                found = explored(line, 2_000_000)
    except Exception:
        return Verdict.FAILS
    if found.broken:
        return Verdict.BROKEN
    if found.dead:
        return Verdict.DEAD
    return Verdict.SAME if digest(found) == sound else Verdict.OTHER


def main(names: list[str]) -> None:
    """Print the table."""
    sound = {budgets: digest(explored(ExploredLine(budgets=budgets))) for budgets in BUDGETS}
    for name in names or defects():
        verdict, at = Verdict.SAME, ""
        for budgets in BUDGETS:
            now = judged(name, budgets, sound[budgets])
            if now is not Verdict.SAME and (verdict in (Verdict.SAME, Verdict.OTHER)) and now is not verdict:
                verdict, at = now, "/".join(map(str, budgets[:4]))
            if verdict not in (Verdict.SAME, Verdict.OTHER):
                break
        sys.stdout.write(f"| `{name}` | {verdict.value} | {at} |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main(list(chain(sys.argv[1:])))
