"""`branchline check`: what cannot work, said before it runs."""

from __future__ import annotations

import sys

from branchline.ending import end, judged, print_json
from branchline.options import Json, ScenarioName


def check(
    scenario: ScenarioName,
    as_json: Json = False,
) -> None:
    """Read a scenario with all that it names and say whether its trains can meet; runs nothing."""
    from network.meets import meet_text, planned_meets, unresolvable_meets
    from study.evaluate.release import CONFIRMED_BY_EYE, confirmed_by_eye
    from study.scenario.scenario import load_scenario

    loaded = load_scenario(scenario)
    line, timetable = loaded.setup.line, loaded.setup.timetable
    impossible = [meet_text(meet, line) for meet in unresolvable_meets(line, timetable)]
    weaker = confirmed_by_eye(loaded.setup)
    figures = {
        "scenario": loaded.id,
        "line": line.id,
        "trains": len(timetable.trains),
        "stocks": len(timetable.diagrams),
        "meets": len(planned_meets(line, timetable)),
        "impossible_meets": impossible,
        "confirmed_by_eye": weaker,
    }
    outcome = judged(not impossible)
    if as_json:
        print_json(figures, outcome)
    else:
        for key, value in figures.items():
            if key not in ("impossible_meets", "confirmed_by_eye"):
                sys.stdout.write(f"{key}: {value}\n")
        for text in impossible:
            sys.stdout.write(f"impossible: {text}\n")
        for place, trains in weaker.items():
            sys.stdout.write(f"weaker: {place}: {CONFIRMED_BY_EYE} ({', '.join(trains)})\n")
    end(outcome)
