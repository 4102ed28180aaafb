"""What becomes of the explored set where a behaviour of the machines is taken away: a table for documents.

python -m tests.verify.switched_off [--first N] [NAMES ...]: each defect is a switch of `tests.system.switchboard`,
what the machines once did, or a mistake of `tests/planted` in a copy of the tree; the line is explored with it, at
the smallest budgets first, until the set is another one.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from enum import Enum
from hashlib import blake2b
from pathlib import Path
from typing import Final, Protocol, TypeVar

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
    Budgets(delay=1, set_back=1),
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


class Explored(Protocol):
    """What an exploration has found: the rule that is broken, and how many states lead nowhere."""

    @property
    def broken(self) -> str: ...

    @property
    def dead(self) -> int: ...


Found = TypeVar("Found", bound=Explored)


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


def verdict_of(explore: Callable[[], Found], digest_of: Callable[[Found], str], sound: str) -> Verdict:
    """What is explored now, against the digest of the same as it is."""
    try:
        found = explore()
    except Exception:
        return Verdict.FAILS
    if found.broken:
        return Verdict.BROKEN
    if found.dead:
        return Verdict.DEAD
    return Verdict.SAME if digest_of(found) == sound else Verdict.OTHER


def first_other(tried: Iterable[tuple[str, Verdict]]) -> str:
    """The first that is not the same, and at which budgets, as cells of a table."""
    others = (f"{verdict.value} | {at}" for at, verdict in tried if verdict is not Verdict.SAME)
    return next(others, f"{Verdict.SAME.value} |")


def judged(name: str, sound: list[str]) -> Iterator[tuple[str, Verdict]]:
    """The line explored with one defect, at each of the budgets."""
    for budgets, known in zip(BUDGETS, sound, strict=False):
        with without(name):
            line = ExploredLine(budgets=budgets)
            verdict = verdict_of(lambda line=line: explored(line, STATES_MAX), digest, known)
        yield f"`{'/'.join(map(str, budgets)).removesuffix('/0/0/0')}`", verdict


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
        sys.stdout.write(first_other(judged("", names[1:])))
        return
    first = int(names[1]) if names[:1] == [FIRST] else len(BUDGETS)
    names = names[2:] if names[:1] == [FIRST] else names
    sound = [digest(explored(ExploredLine(budgets=budgets))) for budgets in BUDGETS[:first]]
    planted_ = mistakes()
    with tempfile.TemporaryDirectory() as folder:
        tree = copied(Path(folder))
        for name in names or [*defects(), *planted_]:
            at = planted_.get(name)
            cells = first_other(judged(name, sound)) if at is None else first_other_planted(at, tree, sound)
            said = f"`{name}`" if at is None else name
            sys.stdout.write(f"| {said} | {cells} |\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
