"""What a sweep found: one line for each class of outcome, tables of it, and drills that show what is bad."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from scenario.scenario import Scenario
from simulation.setup import STEPS_PER_S
from study.drilling.every_instant import SweepOutcomes, Variation
from study.drilling.outcome_class import OutcomeKind, SweptRun
from study.drilling.replay_file import clock_of, replay_of
from study.drilling.swept_rows import CSV_FILE, MadeOf, SweptRow, SweptRows, write_rows

JSON_FILE: Final = "sweep.json"
REPLAY: Final = "replay_"
RANGES_SHOWN: Final = 6  # for a person; the files have all


@dataclass(frozen=True, slots=True)
class OutcomeClass:
    """All instants of one variation with the same outcome. `replay`: the file of a drill that shows the first one."""

    variation: str
    kind: OutcomeKind
    label: str
    bad: bool
    steps: tuple[int, ...]
    late_s_max: float
    ranges: tuple[str, ...]
    replay: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "variation": self.variation,
            "class": self.label,
            "kind": self.kind.name.lower(),
            "bad": self.bad,
            "instants": len(self.steps),
            "ranges": list(self.ranges),
            "late_s_max": self.late_s_max,
            "replay": self.replay,
        }


def owns_file(name: str) -> bool:
    """Whether a file of that name may stand in the directory of a sweep."""
    return name in (CSV_FILE, JSON_FILE) or (name.startswith(REPLAY) and name.endswith(".toml"))


def classes_of(swept: SweepOutcomes) -> tuple[OutcomeClass, ...]:
    """The classes, by variation, each variation's gravest last."""
    order = list(OutcomeKind)
    found: list[OutcomeClass] = []
    bad = 0
    for name, runs in swept.outcomes.items():
        by_label: dict[str, list[tuple[int, SweptRun]]] = {}
        for step, outcome in runs.items():
            by_label.setdefault(outcome.label, []).append((step, outcome))
        for label, group in sorted(
            by_label.items(), key=lambda item: (order.index(item[1][0][1].kind), item[0])
        ):
            steps, first = tuple(step for step, _ in group), group[0][1]
            bad += first.bad
            found.append(
                OutcomeClass(
                    name,
                    first.kind,
                    label,
                    first.bad,
                    steps,
                    max(outcome.late_s for _, outcome in group),
                    tuple(ranges_of(steps, swept.every_step)),
                    f"{REPLAY}{bad:02d}.toml" if first.bad else "",
                )
            )
    return tuple(found)


def ranges_of(steps: Sequence[int], every: int) -> list[str]:
    """Instants as ranges of times; a range has no gap wider than `every`."""
    ranges: list[list[int]] = []
    for step in steps:
        if ranges and step - ranges[-1][-1] <= every:
            ranges[-1][1:] = [step]
        else:
            ranges.append([step])
    return [" to ".join(clock_of(step) for step in bounds) for bounds in ranges]


def text_of(found: OutcomeClass) -> str:
    """A class in a line."""
    shown = ", ".join(found.ranges[:RANGES_SHOWN])
    if len(found.ranges) > RANGES_SHOWN:
        shown += f" and {len(found.ranges) - RANGES_SHOWN} more"
    late = "" if found.kind is OutcomeKind.CRASH else f"; latest {found.late_s_max:.0f} s after plan"
    verdict = "BAD " if found.bad else "good"
    return f"{verdict}  {found.variation}: {found.label}: {len(found.steps)} at {shown}{late}"


def figures_of(scenario: Scenario, swept: SweepOutcomes, left_out: Sequence[str]) -> dict[str, Any]:
    """All of a sweep for JSON."""
    return {
        "sweep": scenario.id,
        "seed": scenario.setup.seed,
        "every_s": swept.every_step / STEPS_PER_S,
        "runs": sum(len(runs) for runs in swept.outcomes.values()),
        "bad": swept.bad,
        "bad_runs": sum(outcome.bad for runs in swept.outcomes.values() for outcome in runs.values()),
        "left_out": list(left_out),
        "by_kind": table_of(swept),
        "classes": [found.as_dict() for found in classes_of(swept)],
    }


def table_of(swept: SweepOutcomes) -> dict[str, int]:
    """How many runs ended in each kind of outcome, of those that there are."""
    kinds = Counter(outcome.kind for runs in swept.outcomes.values() for outcome in runs.values())
    return {kind.value: kinds[kind] for kind in OutcomeKind if kinds[kind]}


def write_sweep(
    scenario: Scenario,
    swept: SweepOutcomes,
    variations: Sequence[Variation],
    figures: Mapping[str, Any],
    folder: Path,
    *,
    rows: SweptRows | None = None,
    beside: bool = False,
) -> None:
    """Write tables and drills into a new folder; `beside`: what is swept happens beside the scenario's own script.

    `rows` say what each run was made of.
    """
    by_name = {variation.name: variation for variation in variations}
    folder.mkdir()
    (folder / JSON_FILE).write_text(json.dumps(figures, indent=2, ensure_ascii=False) + "\n", "utf-8")
    runs = {(name, step): run for name, of_name in swept.outcomes.items() for step, run in of_name.items()}
    made_of = SweptRows(None, MadeOf(), {}).made_of if rows is None else rows.made_of
    write_rows(folder / CSV_FILE, {key: SweptRow(run, made_of(key)) for key, run in runs.items()})
    for found in classes_of(swept):
        if found.bad:
            script = by_name[found.variation].at(found.steps[0])
            title = f"{found.variation} at {clock_of(found.steps[0])}: {found.label}"
            text = replay_of(scenario, script, found.replay.removesuffix(".toml"), title, beside=beside)
            (folder / found.replay).write_text(text, "utf-8")
