"""Drills: a scenario with faults, acts and expectations, run and judged expectation by expectation.

That nothing unsafe happens and that everyone arrives every drill expects; its file says so only if it expects else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import polars as pl

from network.clock import clock
from network.errors import InputError
from network.files.text_input import existing_file
from network.files.toml_input import one_of, parse_table, read_text
from scenario.scenario import load_scenario
from simulation.faults.script import DEFAULTS, Act, ItemCourse, ScriptedFault
from simulation.loop import Progress
from simulation.setup import STEPS_PER_S
from study.drilling.scores import Scores, score
from study.drilling.verdict import ExpectationVerdict, judge
from study.record.directory import Reserved
from study.record.fault_place import place_of_fault
from study.record.journal_rows import EventInWords
from study.record.marks import DrillShown, Mark, MarkKind, mark_of
from study.record.tables import RunTables, make_table
from study.runner.outcome import unfinished
from study.runner.run import CarrierKind, FinishedRun, PartyLink, UnitsAt, execute, fill_run
from study.wording import outcome as words
from study.wording.phrase import Phrase, joined_phrases
from study.wording.script import item_text


@dataclass(frozen=True, slots=True)
class Drill:
    """A finished drill. Its run's summary and events hold the verdicts, too."""

    run: FinishedRun
    verdicts: tuple[ExpectationVerdict, ...]
    scores: Scores

    @property
    def passed(self) -> bool:
        """Whether every expectation was met."""
        return all(verdict.passed for verdict in self.verdicts)

    @property
    def never_due(self) -> tuple[str, ...]:
        """Faults and acts that never came due, in words: of these the verdicts say nothing."""
        begun = {id(course.item) for course in self.run.result.courses}
        script = self.run.scenario.setup.script
        items: tuple[ScriptedFault | Act, ...] = (*script.faults, *script.acts)
        return tuple(item_text(i).en for i in items if id(i) not in begun)

    def as_dict(self) -> dict[str, Any]:
        """What `branchline drill --json` prints."""
        return {
            "drill": self.run.scenario.id,
            "name": self.run.scenario.name,
            "passed": self.passed,
            "expectations": expectations_dict(self.verdicts),
            "never_due": list(self.never_due),
            "scores": self.scores.as_dict(),
            "summary": self.run.summary,
        }


@cache
def shipped_drills() -> tuple[str, ...]:
    """Names of the drills that come with the program, as folder/file."""
    folder = _folder()
    return tuple(
        sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.toml"))
    )


def drills_in(name: str) -> tuple[str, ...]:
    """The shipped drills of a folder (`rtri`), or the one that is named."""
    return tuple(drill for drill in shipped_drills() if drill.startswith(f"{name}/")) or (name,)


def sentence_of(name: str) -> str:
    """What a drill is about, in the sentence that is its name."""
    path = Path(find_drill(name))
    return str(parse_table(read_text(path), str(path)).get("name", ""))


def find_drill(name: str) -> str:
    """What `load_scenario` takes for a drill: its file. InputError otherwise."""
    shipped = _folder() / f"{name}.toml"
    if name in shipped_drills():
        return str(shipped)
    if name.endswith(".toml") and existing_file(Path(name)):
        return name
    expected = f"an existing file, or a shipped drill: {one_of(shipped_drills(), name)}"
    raise InputError(name, "", None, expected)


def run_drill(
    name: str,
    link: PartyLink,
    seed: int | None = None,
    progress: Progress | None = None,
    units: UnitsAt = UnitsAt.SIMULATOR,
    journal: Path | None = None,
    *,
    failing: bool = True,
    carrier: CarrierKind = CarrierKind.SUMO,
) -> Drill:
    """Run a drill; its journal grows in a file, if there is one. With `failing` off nothing of it fails.

    InputError for a file that is no drill: nothing fails, nobody acts, it expects nothing.
    """
    scenario = load_scenario(find_drill(name), seed)
    script = scenario.setup.script
    if not script.faults and not script.acts and all(e in DEFAULTS for e in script.expectations):
        raise InputError(
            scenario.file, "fault", None, "at least one [[fault]], [[act]] or [[expect]] to make it a drill"
        )
    if not failing:
        calm = replace(script, faults=())
        scenario = replace(scenario, setup=replace(scenario.setup, script=calm))
    run = execute(scenario, link, units=units, carrier=carrier, progress=progress, journal=journal)
    verdicts = judge(script.expectations, run.result, run.tables)
    scores = score(
        run.result.courses,
        run.tables.stops,
        run.summary["late_s_max"],
        all_arrived=not unfinished(run.result),
    )
    end_s = run.result.end_step / STEPS_PER_S
    told = {
        "name": scenario.name,
        "passed": all(verdict.passed for verdict in verdicts),
        "expectations": expectations_dict(verdicts),
        "script": [_course_dict(course) for course in run.result.courses],
        "scores": scores.as_dict(),
    }
    run = replace(
        run, summary=run.summary | {"drill": told}, tables=_with_verdicts(run.tables, verdicts, end_s)
    )
    return Drill(run, verdicts, scores)


def fill_drill(drill: Drill, place: Reserved) -> Path:
    """Write a drill into the directory reserved, its report showing it. Returns the path of the report."""
    return fill_run(drill.run, place, drill_shown(drill))


def drill_shown(drill: Drill) -> DrillShown:
    """What the report shows."""
    result, setup = drill.run.result, drill.run.scenario.setup
    end_s = result.end_step / STEPS_PER_S
    marks: list[Mark] = []
    for kind, item in ((MarkKind.FAULT, ScriptedFault), (MarkKind.ACT, Act)):
        mine = [course for course in result.courses if type(course.item) is item]
        for number, course in enumerate(mine, 1):
            over_s = course.begun_s if kind is MarkKind.ACT else course.over_s
            over = words.LASTS if over_s is None else words.AT_ONCE if over_s == course.begun_s else None
            over = Phrase(clock(int(over_s or 0.0))) if over is None else over
            to_s = end_s if over_s is None else over_s
            mark = mark_of(kind, number, item_text(course.item), course.begun_s, to_s, over)
            if isinstance(course.item, ScriptedFault):
                mark = replace(mark, where=place_of_fault(course.item.fault, setup.line, result.stock_ids))
            marks.append(mark)
    for number, verdict in enumerate(drill.verdicts, 1):
        bounded = math.isfinite(verdict.from_s) or math.isfinite(verdict.to_s)
        from_s = max(verdict.from_s, result.begin_step / STEPS_PER_S) if bounded else end_s
        fell = verdict.at_s if verdict.passed else None  # once met, there is nothing more to judge
        to_s = min(verdict.to_s, end_s) if fell is None else fell
        mark = mark_of(MarkKind.EXPECTATION, number, verdict.expected, from_s, to_s, verdict.said)
        marks.append(replace(mark, at_s=verdict.at_s, passed=verdict.passed))
    score = score_text(drill.scores)
    return DrillShown(drill.passed, tuple(marks), score.en, score.in_("ja"))


def score_text(scores: Scores) -> Phrase:
    """The scores in a sentence."""
    late = words.NO_TRAIN
    if scores.late_s_max is not None:
        late = words.LATEST.fill(late_s=scores.late_s_max)
    if scores.normal_after_s is None or scores.healed_s is None:
        return joined_phrases((late, words.NO_NORMAL.fill(why=scores.why)), " ", "")
    normal = words.NORMAL.fill(
        normal_s=scores.normal_after_s, healed=clock(int(scores.healed_s)), tolerance_s=scores.on_time_s
    )
    return joined_phrases((late, normal), " ", "")


def expectations_dict(verdicts: tuple[ExpectationVerdict, ...]) -> list[dict[str, Any]]:
    """Verdicts for JSON."""
    return [{"text": v.text, "passed": v.passed, "happened": v.happened} for v in verdicts]


def _course_dict(course: ItemCourse) -> dict[str, Any]:
    what = "fault" if isinstance(course.item, ScriptedFault) else "act"
    return {what: item_text(course.item).en, "begun_s": course.begun_s, "over_s": course.over_s}


def _with_verdicts(tables: RunTables, verdicts: tuple[ExpectationVerdict, ...], end_s: float) -> RunTables:
    """The tables with a row among the events for each verdict, at the time when it fell."""
    rows: list[EventInWords] = []
    for v in verdicts:
        met = words.MET if v.passed else words.NOT_MET
        said = words.VERDICT.fill(met=met, text=v.expected, happened=v.said)
        at_s = min(v.to_s, end_s) if v.at_s is None else v.at_s
        rows.append(EventInWords(at_s, "drill", "expectation", said.en, said.in_("ja")))
    events = pl.concat([tables.events, make_table("events", rows)]).sort("t_s", maintain_order=True)
    return replace(tables, events=events)


def _folder() -> Path:
    return Path(str(files("study"))) / "drills"
