"""The recipe "a paper" of docs/make-a.md, followed: a specification and its name make a reproduction."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

PLACE = "papers/one_beacon.py"


def test_two_files_make_a_reproduction_that_fails_without_its_idea(clone: Callable[[], Any]) -> None:
    made = clone()
    made.follow("paper")
    assert made.is_what_is_told("paper")
    assert len(made.touched) == 2
    made.holds("tests/papers/test_reproduction.py", "tests/documents/test_reproductions.py")
    assert "| `one-beacon` | never run" in (made.root / "docs/reproductions.md").read_text("utf-8")
    code, rows = reproduced(made)
    assert (code, [row["passed"] for row in rows]) == (0, [True, True])
    with_beacon, without = rows
    assert with_beacon["ours"] <= 0.5
    # up to 1 % of the kilometre since the last beacon
    assert 2.0 < without["ours"] < 10.0
    text = (made.root / PLACE).read_text("utf-8")
    for was, switched, passed in (
        ("beacons=1", "beacons=0", [False, True]),  # the method without its idea
        ("beacons=0", "beacons=1", [True, False]),  # a null method that has the idea
    ):
        assert text.count(was) == 1
        (made.root / PLACE).write_text(text.replace(was, switched), "utf-8")
        code, rows = reproduced(made)
        assert (code, [row["passed"] for row in rows]) == (1, passed)


def reproduced(made: Any) -> tuple[int, list[dict[str, Any]]]:  # noqa: ANN401 - the clone of conftest
    """Exit code and rows of its slice."""
    done = made.python("-m", "branchline.cli", "reproduce", "one-beacon", "--quick", "--json")
    assert done.stdout, done.stderr
    return done.returncode, json.loads(done.stdout)["rows"]
