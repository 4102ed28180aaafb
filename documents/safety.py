"""Writes docs/safety.md, what is claimed of safety and what shows it: `python -m documents.safety [FILE]`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from documents.page import write_page
from documents.safety_case import HAZARDS, NOT_SHOWN
from verify.evidence.inside_runs import load
from verify.evidence.intruders import ATTACKS, THREATS, Intruded, Threat, intruded

FILE: Final = Path("docs/safety.md")
SCENARIO: Final = "rtri_test_line"
SEED: Final = 1
HEAD: Final = """\
# Safety

Made by `make docs` from `documents/safety_case.py` and `verify/evidence/intruders.py`; do not edit. For each hazard
what is claimed, why, and the commands and tests that show it; a test checks that each of them exists. It claims no
safety integrity level.

The goal: with the faults, persons and bounds of this program, no train endangers another, and every train arrives.
"""
THREAT_HEAD: Final = f"""\
## Threats to telegrams, after EN 50159

Counts are of `branchline verify intruders {SCENARIO} --seed {SEED}`, run as this page is made: telegrams that an
intruder sent, all without effect, and why receivers dropped them.

| threat | defence | dropped as | intruder's telegrams, all without effect | shown by |
|---|---|---|---|---|"""


def document() -> str:
    """The whole text."""
    found = {one.attack: one for one in intruded(load(SCENARIO), SEED, tuple(ATTACKS))}
    assert all(one.held for one in found.values()), found
    rows = [_row(threat, [found[attack] for attack in threat.attacks]) for threat in THREATS]
    lacking = ["## What is not shown", "", *(f"- {one}" for one in NOT_SHOWN)]
    return "\n".join([HEAD, *_tree(), THREAT_HEAD, *rows, "", *lacking, ""])


def _tree() -> Iterator[str]:
    for number, hazard in enumerate(HAZARDS, start=1):
        yield f"## H{number}: {hazard.name}\n"
        for letter, claim in zip("abcdefgh", hazard.claims, strict=False):
            yield f"- **{number}{letter}. {claim.says}**: {claim.because}."
            yield from (f"    - `branchline {command}`" for command in claim.commands)
            yield from (f"    - `{test}`" for test in claim.tests)
        yield ""


def _row(threat: Threat, found: list[Intruded]) -> str:
    counts = "; ".join(
        f"{one.attack.value}: {one.sent} ({', '.join(f'{n} {why}' for why, n in sorted(one.dropped.items()))})"
        for one in found
    )
    reasons = ", ".join(reason.value for reason in threat.reasons) or "–"
    tests = "<br>".join(f"`{test}`" for test in threat.tests)
    return f"| {threat.name} | {threat.defence} | {reasons} | {counts or '– (it has an effect: delay)'} | {tests} |"


if __name__ == "__main__":
    write_page(document, FILE)
