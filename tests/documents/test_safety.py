"""docs/safety.md: each leaf of the tree is a command that there is, or a test that there is."""

import ast
import shlex
from functools import cache
from pathlib import Path

import pytest

from branchline.cli import whole_command
from documents.safety_case import HAZARDS
from study.drilling.drill import shipped_drills
from tests.planted.defects import planted
from verify.evidence.intruders import ATTACKS, THREATS, Threat

ROOT = Path(__file__).resolve().parents[2]
CLAIMS = [claim for hazard in HAZARDS for claim in hazard.claims]
COMMANDS = sorted({command for claim in CLAIMS for command in claim.commands})
TESTS = sorted(
    {test for claim in CLAIMS for test in claim.tests} | {t for threat in THREATS for t in threat.tests}
)


@cache
def _functions(file: str) -> frozenset[str]:
    tree = ast.parse((ROOT / file).read_text("utf-8"))
    return frozenset(node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))


@pytest.mark.parametrize("test", TESTS)
def test_there_is_this_test(test: str) -> None:
    file, _, name = test.partition("::")
    assert name in _functions(file)


@pytest.mark.parametrize("command", COMMANDS)
def test_there_is_this_command(command: str) -> None:
    words = shlex.split(command)
    found = whole_command()
    while hasattr(found, "commands"):
        assert words and words[0] in found.commands, command
        found = found.commands[words.pop(0)]
    found.make_context(command, list(words)).close()
    assert not command.startswith("drill") or words[0] in shipped_drills(), command


def test_a_command_or_test_that_is_none_is_noticed() -> None:
    assert "test_that_nobody_wrote" not in _functions("tests/radio/test_envelope.py")
    assert "verify-all" not in getattr(whole_command(), "commands", {})


def test_every_claim_has_a_command_and_a_test() -> None:
    assert all(claim.commands and claim.tests for claim in CLAIMS)


def test_every_attack_belongs_to_a_threat_and_every_threat_of_the_standard_has_its_row() -> None:
    assert {attack for threat in THREATS for attack in threat.attacks} == set(ATTACKS)
    assert [threat.name for threat in THREATS] == [
        *("repetition", "deletion", "insertion", "re-sequencing", "corruption", "delay", "masquerade")
    ]


@pytest.mark.parametrize("threat", THREATS, ids=lambda threat: threat.name)
def test_without_its_defence_each_test_of_a_threat_fails(threat: Threat) -> None:
    """`python -m tests.planted` takes the defence away and runs that test alone, which must notice it."""
    alone = {defect.tests[0] for defect in planted() if len(defect.tests) == 1}
    assert set(threat.tests) <= alone
