"""What becomes of the explored set where a behaviour of the machines is taken away: a table for documents.

python -m tests.verify.switched_off [--first N] [NAMES ...]: each defect is a switch of `tests.system.switchboard`,
what the machines once did, or a mistake of `tests/planted` in a copy of the tree; the line is explored with it, at
the smallest budgets first, until the set is another one.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from hashlib import blake2b
from pathlib import Path
from typing import Final

import pytest

from tests.planted.__main__ import copied, with_planted
from tests.planted.defects import Planted, planted
from tests.system import switches_on_board, switches_radio, switches_wayside
from tests.system.switchboard import SWITCHES
from verify.explore import ExploredSpace, explored
from verify.explored_line import Budgets, ExploredLine
from verify.restored import RESTORED, restored

BUDGETS: Final = (
    Budgets(),
    Budgets(loss=1),
    Budgets(delay=1),
    Budgets(points=1),
    Budgets(sensor=1),
    Budgets(power=1),
    Budgets(word=1),
)
MODULES: Final = (switches_on_board, switches_radio, switches_wayside)
STATES_MAX: Final = 2_000_000
OF_MACHINES: Final = ("wayside/", "onboard/authority/", "onboard/duty/", "radio/envelope.py")
AS_IT_IS: Final = "--as-it-is"  # of a tree: the verdict at the first budgets, held against these digests
FIRST: Final = "--first"  # how many of the budgets


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


def mistakes() -> dict[str, Planted]:
    """Those of `tests/planted` that lie in what is explored, by what they are."""
    return {defect.what: defect for defect in planted() if defect.file.startswith(OF_MACHINES)}


def digest(found: ExploredSpace) -> str:
    """Of the set, by local states and their numbers."""
    return blake2b(found.space.states.tobytes() + found.parties.digest().encode(), digest_size=16).hexdigest()


@contextmanager
def without(name: str) -> Iterator[None]:
    """With what has this name taken away, or brought back; with nothing changed where it is empty."""
    with pytest.MonkeyPatch.context() as patch, restored(*({name} & RESTORED.keys())):
        if name in SWITCHES:
            SWITCHES[name](patch)
        yield


def judged(name: str, budgets: Budgets, sound: str) -> Verdict:
    """The line explored with one defect."""
    try:
        with without(name):
            found = explored(ExploredLine(budgets=budgets), STATES_MAX)
    except Exception:
        return Verdict.FAILS
    if found.broken:
        return Verdict.BROKEN
    if found.dead:
        return Verdict.DEAD
    return Verdict.SAME if digest(found) == sound else Verdict.OTHER


def first_other(name: str, sound: list[str]) -> str:
    """What becomes of the set, and at which budgets, as cells of a table."""
    for budgets, known in zip(BUDGETS, sound, strict=False):
        verdict = judged(name, budgets, known)
        if verdict is not Verdict.SAME:
            return f"{verdict.value} | `{'/'.join(map(str, budgets)).removesuffix('/0/0')}`"
    return f"{Verdict.SAME.value} |"


def first_other_planted(mistake: Planted, tree: Path, sound: list[str]) -> str:
    """The same of a mistake that is planted in a tree."""
    command = [sys.executable, "-m", "tests.verify.switched_off", AS_IT_IS, *sound]
    with with_planted(mistake, tree):
        ended = subprocess.run(
            command, cwd=tree, env={"PYTHONPATH": str(tree)}, capture_output=True, text=True, check=False
        )
    return ended.stdout.strip() or f"{Verdict.FAILS.value} |"


def main(names: list[str]) -> None:
    """Print the table."""
    if names[:1] == [AS_IT_IS]:
        sys.stdout.write(first_other("", names[1:]))
        return
    first = int(names[1]) if names[:1] == [FIRST] else len(BUDGETS)
    names = names[2:] if names[:1] == [FIRST] else names
    sound = [digest(explored(ExploredLine(budgets=budgets))) for budgets in BUDGETS[:first]]
    planted_ = mistakes()
    with tempfile.TemporaryDirectory() as folder:
        tree = copied(Path(folder))
        for name in names or [*defects(), *planted_]:
            at = planted_.get(name)
            cells = first_other(name, sound) if at is None else first_other_planted(at, tree, sound)
            said = f"`{name}`" if at is None else name
            sys.stdout.write(f"| {said} | {cells} |\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
