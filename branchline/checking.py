"""`branchline check`: what cannot work, said before it runs."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Final

from branchline.ending import end, judged_outcome, print_json
from branchline.options import Json, ScenarioName

if TYPE_CHECKING:
    from collections.abc import Sequence

    from network.model import Line
    from study.feasibility.finding import Feasibility, Finding, PlannedMeet

NAMED: Final = 4  # of findings that are alike, how many are named; --json has all


def check(
    scenario: ScenarioName,
    as_json: Json = False,
) -> None:
    """Check a plan without running it: impossible (never goes on), late or tight, where and why, and all meets.

    Exit code 1 if it is impossible: `branchline run` refuses it.
    """
    from scenario.scenario import load_scenario
    from study.evaluate.release import CONFIRMED_BY_EYE, confirmed_by_eye
    from study.feasibility.check import feasibility
    from study.feasibility.early import early_text
    from study.feasibility.finding import FindingKind, Severity

    loaded = load_scenario(scenario)
    line, timetable = loaded.setup.line, loaded.setup.timetable
    found = feasibility(loaded.setup)
    drawn = not any(finding.kind is FindingKind.NO_WAY for finding in found.impossible)
    weaker, early = (confirmed_by_eye(loaded.setup), early_text(loaded.setup)) if drawn else ({}, "")
    figures: dict[str, Any] = {
        "scenario": loaded.id,
        "line": line.id,
        "trains": len(timetable.trains),
        "stocks": len(timetable.diagrams),
    }
    outcome = judged_outcome(found.good)
    if as_json:
        listed = {
            "meets": [meet.as_dict() for meet in found.meets],
            "verdict": found.verdict,
            **{severity.value: len(found.of_severity(severity)) for severity in Severity},
            "findings": [finding.as_dict() for finding in found.findings],
            "confirmed_by_eye": weaker,
            "early": early,
        }
        print_json(figures | listed, outcome)
    else:
        counts = ", ".join(f"{severity.value}: {len(found.of_severity(severity))}" for severity in Severity)
        sys.stdout.write(f"{found.verdict}\n{counts}\n")
        for key, value in figures.items():
            sys.stdout.write(f"{key}: {value}\n")
        _print_found(found, line)
        for place, trains in weaker.items():
            sys.stdout.write(f"weaker: {place}: {CONFIRMED_BY_EYE} ({', '.join(trains)})\n")
        sys.stdout.write(f"early: {early}\n" if early else "")
    end(outcome)


def _print_found(found: Feasibility, line: Line) -> None:
    """Findings, then meets, for a person; one line for a cause, however often it tells."""
    from study.feasibility.finding import Severity

    for severity in Severity:
        alike: dict[tuple[str, ...], list[Finding]] = {}
        for finding in found.of_severity(severity):
            alike.setdefault(_cause(finding), []).append(finding)
        for first, *more in alike.values():
            rest = f" (and {len(more)} more like it, {first.place}: {_named(more)})" if more else ""
            sys.stdout.write(f"{severity.value}: {first.kind.value}: {first.sentence}{rest}\n")
    for meet in found.meets:
        sys.stdout.write(f"meet: {_meet(meet, line)}\n")
    sys.stdout.write(f"meets: {len(found.meets)}\n")


def _cause(finding: Finding) -> tuple[str, ...]:
    """What findings that are told once have in common: kind and place, and where that may be several causes, more."""
    from study.feasibility.finding import FindingKind

    match finding.kind:
        case FindingKind.CIRCLE:
            more = finding.trains
        case FindingKind.TAG | FindingKind.COVERAGE:
            more = (finding.remedy,)
        case FindingKind.NO_WAY:
            more = (finding.text.partition(": ")[2],)
        case _:  # where no waiting helps, by who is in the way
            more = finding.trains[:1] if finding.short_s is None and len(finding.trains) > 1 else ()
    return (finding.kind.value, finding.place, *more)


def _named(findings: Sequence[Finding]) -> str:
    """Of whom and when, the first of them."""
    shown = [f"{' and '.join(finding.trains)} at {finding.minute}" for finding in findings[:NAMED]]
    return ", ".join(shown) + (", …" if len(findings) > NAMED else "")


def _meet(meet: PlannedMeet, line: Line) -> str:
    trains = f"{meet.down_train} and {meet.up_train}"
    minute = meet.as_dict()["minute"]
    if meet.station is None:
        where = (
            f"between {meet.low or 'the end'} and {meet.high or 'the end'}, km {meet.position_m / 1000.0:.1f}"
        )
    else:
        on = f" on tracks {meet.down_track} and {meet.up_track}" if meet.down_track and meet.up_track else ""
        where = f"at {line.stations[meet.station].name}{on}"
    return f"{minute} {trains} {where}{'' if meet.possible else ': they cannot pass'}"
