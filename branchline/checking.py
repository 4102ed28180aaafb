"""`branchline check`: what cannot work, said before it runs."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from branchline.ending import end, judged, print_json
from branchline.options import Json, ScenarioName

if TYPE_CHECKING:
    from network.model import Line
    from study.feasibility.finding import Feasibility, PlannedMeet


def check(
    scenario: ScenarioName,
    as_json: Json = False,
) -> None:
    """Read a scenario with all that it names: where its trains meet, what cannot work and what is tight; runs nothing.

    Exit code 1 if the plan cannot work: `branchline run` refuses it.
    """
    from study.evaluate.release import CONFIRMED_BY_EYE, confirmed_by_eye
    from study.feasibility.check import feasibility
    from study.feasibility.finding import Kind
    from study.scenario.scenario import load_scenario

    loaded = load_scenario(scenario)
    line, timetable = loaded.setup.line, loaded.setup.timetable
    found = feasibility(loaded.setup)
    drawn = not any(finding.kind is Kind.NO_WAY for finding in found.impossible)
    weaker = confirmed_by_eye(loaded.setup) if drawn else {}
    figures: dict[str, Any] = {
        "scenario": loaded.id,
        "line": line.id,
        "trains": len(timetable.trains),
        "stocks": len(timetable.diagrams),
    }
    outcome = judged(found.good)
    if as_json:
        listed = {
            "meets": [meet.as_dict() for meet in found.meets],
            "impossible": len(found.impossible),
            "tight": len(found.tight),
            "findings": [finding.as_dict() for finding in found.findings],
            "confirmed_by_eye": weaker,
        }
        print_json(figures | listed, outcome)
    else:
        for key, value in figures.items():
            sys.stdout.write(f"{key}: {value}\n")
        _print_found(found, line)
        for place, trains in weaker.items():
            sys.stdout.write(f"weaker: {place}: {CONFIRMED_BY_EYE} ({', '.join(trains)})\n")
    end(outcome)


def _print_found(found: Feasibility, line: Line) -> None:
    """Meets and findings for a person; of what is tight, one line for a place and a thing."""
    for meet in found.meets:
        sys.stdout.write(f"meet: {_meet(meet, line)}\n")
    sys.stdout.write(f"meets: {len(found.meets)}\n")
    for finding in found.impossible:
        sys.stdout.write(f"impossible: {finding.kind.value}: {finding.sentence}\n")
    tight: dict[tuple[str, str], list[str]] = {}
    for finding in found.tight:
        tight.setdefault((finding.kind.value, finding.place), []).append(finding.sentence)
    for (kind, place), sentences in tight.items():
        more = f" (and {len(sentences) - 1} more like it, {place})" if len(sentences) > 1 else ""
        sys.stdout.write(f"tight: {kind}: {sentences[0]}{more}\n")
    sys.stdout.write(f"impossible: {len(found.impossible)}, tight: {len(found.tight)}\n")


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
